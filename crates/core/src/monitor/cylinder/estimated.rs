//! The estimated length of a cylinder.

use crate::estimate::{Estimate, SensorDesign, SensorInput, VirtualSensor};
use crate::state::state;

/// The virtual sensor of a cylinder, and its newest estimate.
#[derive(Clone, Debug)]
pub(super) struct EstimatedLength {
    sensor: VirtualSensor,
    newest: Option<Estimate>,
}

state! {
    EstimatedLength { sensor, newest }
}

impl EstimatedLength {
    pub fn new(design: SensorDesign) -> Self {
        Self { sensor: VirtualSensor::new(design), newest: None }
    }

    /// `None` where the length is not known.
    pub const fn newest(&self) -> Option<&Estimate> {
        self.newest.as_ref()
    }

    /// Takes a cycle.
    #[inline]
    pub fn step(&mut self, input: &SensorInput) {
        self.newest = self.sensor.step(input);
    }

    pub fn interrupt(&mut self) {
        self.sensor.interrupt();
    }
}
