//! Why an incident is the machine's, and which warnings are of that.

use crate::alarm::{Detector, Warning};
use crate::state::choice;
use crate::verdict::Fault;

/// Why an incident is the machine's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Cause {
    /// The supply of all cylinders falls short.
    Supply,
    /// Most cylinders showed something in one moment: the bus, the Sync or the controller is what they have in common.
    Moment,
    /// Most cylinders differ slowly at the same time: the temperature, or a supply, is what their transducers have in common.
    Drift,
}

choice! { Cause { Supply, Moment, Drift } }

impl Cause {
    pub const ALL: [Self; 3] = [Self::Supply, Self::Moment, Self::Drift];
}

/// Whether a warning is of the supply, which is the machine's.
pub(super) fn is_of_supply(warning: &Warning) -> bool {
    warning.detector == Detector::Process && warning.finding.fault == Fault::Supply
}

/// Whether `warning` can belong to an incident that is `shared`: what a process detector has found of the supply is
/// the machine's, and nothing else that it has found is.
pub(super) fn fits(shared: Option<Cause>, warning: &Warning) -> bool {
    let is_supply = shared == Some(Cause::Supply);
    warning.detector != Detector::Process || is_of_supply(warning) == is_supply
}
