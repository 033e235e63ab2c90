//! The rod's way by the model alone.

use crate::observe::observer::ObserverDesign;
use crate::state::whole;
use nalgebra::Vector3;

/// The model (4-1) that no reading corrects but in its length, where no drive was learnt.
#[derive(Clone, Copy, Debug)]
pub struct FreeModel {
    x: Vector3<f64>,
    /// Newest command, m/s.
    command: f64,
    /// Cycles until nothing is left of what it began with.
    settling: u32,
}

whole! { FreeModel { x, command, settling } }

impl FreeModel {
    pub fn new(settling: u32) -> Self {
        Self { x: Vector3::zeros(), command: 0.0, settling }
    }

    /// Velocity until the next cycle, m/s, once it has settled.
    pub fn step(&mut self, by: &ObserverDesign, length: f64, command: Option<f64>) -> Option<f64> {
        self.command = command.unwrap_or(self.command);
        self.x[0] = length;
        let velocity = self.x[1];
        self.x = by.a * self.x + by.b * self.command;
        self.settling = self.settling.saturating_sub(1);
        (self.settling == 0 && velocity.is_finite()).then_some(velocity)
    }
}
