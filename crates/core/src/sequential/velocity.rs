//! Velocity of the rod, by C2.

use super::parameters::ResidualParameters;
use crate::state::state;

/// The measured velocity, or else one from the differences of successive readings.
#[derive(Clone, Debug)]
pub struct Velocity {
    sample_time: f64,
    /// What the newest difference counts.
    gain: f64,
    /// C2 of the cycle before, m.
    before: Option<f64>,
    /// Velocity by differences, m/s.
    derived: Option<f64>,
}

state! {
    Velocity { before, derived }
    but { sample_time, gain }
}

impl Velocity {
    /// A velocity for samples every `sample_time` seconds.
    pub fn new(parameters: &ResidualParameters, sample_time: f64) -> Self {
        let gain = parameters.cycles(sample_time).velocity_gain;
        Self { sample_time, gain, before: None, derived: None }
    }

    pub fn reset(&mut self) {
        (self.before, self.derived) = (None, None);
    }

    /// Takes a cycle: C2, m, and its velocity where it is `measured`, m/s.
    pub fn step(&mut self, c2: Option<f64>, measured: Option<f64>) -> Option<f64> {
        let before = core::mem::replace(&mut self.before, c2);
        if measured.is_some() {
            return measured;
        }
        self.derived = c2.zip(before).map(|(c2, before)| {
            let newest = (c2 - before) / self.sample_time;
            self.derived.map_or(newest, |derived| derived + self.gain * (newest - derived))
        });
        self.derived
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_a_measured_velocity_it_is_that_of_neighbouring_readings() {
        let mut velocity = Velocity::new(&ResidualParameters::DEFAULT, 0.02);
        let steps = [
            (Some(1.0), None, None),
            (Some(1.01), None, Some(0.5)),
            (Some(1.03), None, Some(0.5 + 0.35 * 0.5)),
            (Some(1.02), Some(7.0), Some(7.0)),
            (None, None, None),
            (Some(9.0), None, None),
        ];
        for (c2, measured, expected) in steps {
            let found = velocity.step(c2, measured);
            let close = |(found, expected): (f64, f64)| (found - expected).abs() < 1e-12;
            assert!(found == expected || found.zip(expected).is_some_and(close), "{found:?}");
        }
    }
}
