//! How the command moves the rod.

use crate::time;

/// Cycles of a step at the most, at 100 Hz.
pub const MOST_PHASES: usize = 2;

/// The numbers of the drive ([`crate::sequential::drive`]). A calibration fits its coefficients to them.
#[derive(Clone, Debug, PartialEq)]
pub struct DriveParameters {
    /// Commands are looked back at in steps of this, s, or of a cycle where that is longer; up to 100 Hz. A
    /// valve answers within some of them.
    pub step: f64,
    /// The command of so long ago has the valve open now, s.
    pub delay: f64,
    /// The lower one of the speeds at which a valve's overlap and friction bend, m/s; the other one is five
    /// times that.
    pub bend: f64,
}

impl DriveParameters {
    pub const DEFAULT: Self = Self { step: 0.02, delay: 0.06, bend: 0.01 };

    /// The counts for a machine with this `sample_time`, s.
    pub fn cycles(&self, sample_time: f64) -> DriveCycles {
        let phases = (time::cycles(self.step, sample_time) as usize).clamp(1, MOST_PHASES);
        let delay = time::cycles(self.delay, sample_time * phases as f64) as usize;
        DriveCycles { phases, delay }
    }
}

/// The times of [`DriveParameters`] in counts of one machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DriveCycles {
    /// Cycles of a step.
    pub phases: usize,
    /// Steps of the delay.
    pub delay: usize,
}
