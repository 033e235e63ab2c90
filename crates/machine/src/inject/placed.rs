//! Where on the bus a fault is, or why it can be nowhere.

use super::shape::{Shape, Window};
use tertius_core::decode::SignalPlan;
use tertius_core::frame::{BusNumber, Id};
use tertius_dbc::LookupError;

/// A fault of a signal of a message.
#[derive(Clone, Debug, PartialEq)]
pub struct Placed {
    pub bus: BusNumber,
    pub id: Id,
    pub plan: SignalPlan,
    pub shape: Shape,
    pub window: Window,
}

/// Why a fault cannot be placed on this machine.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PlaceError {
    #[error("there is no cylinder {given}; the configuration has cylinders 1 to {cylinders}")]
    Cylinder { given: u8, cylinders: u8 },
    #[error(
        "the configuration names no signal for {sensor}{}; add signals.cylinder.{sensor}",
        .nearest.map_or(String::new(), |near| format!(" (nearest that it names: {near})"))
    )]
    Sensor { sensor: &'static str, nearest: Option<&'static str> },
    #[error(
        "cylinder {cylinder} has no C2, as its [[cylinder]] table says, so there is no {sensor}"
    )]
    NotFitted { sensor: &'static str, cylinder: u8 },
    #[error("signals.cylinder.{sensor}: {error}")]
    Lookup {
        sensor: &'static str,
        #[source]
        error: LookupError,
    },
    #[error(
        "no device of cylinder {cylinder} has a {sensor}; it takes a [[canopen.device]] of that kind and role, \
         whose EDS does not exclude it"
    )]
    Service { sensor: &'static str, cylinder: u8 },
    #[error("{signal} is in a frame of the gateway itself (0x{id}), which is never changed")]
    OwnFrame { signal: String, id: Id },
    #[error(
        "it is a fault of the machine itself, which only a simulated machine can have; `tertius simulate` takes it"
    )]
    Machine,
    #[error("{signal} has no valid range; give the value out of range as value=… or raw=…")]
    NoRange { signal: String },
    #[error("{signal} would read {reading}, which is within its valid range {valid}")]
    WithinRange { signal: String, reading: String, valid: String },
}
