//! Velocity of the rod, by C2.

/// How much of the newest difference of two readings counts: they move in counts.
const GAIN: f64 = 0.35;

/// The measured velocity, or else one from the differences of successive readings.
#[derive(Clone, Debug)]
pub struct Velocity {
    sample_time: f64,
    /// C2 of the previous cycle, m.
    before: Option<f64>,
    /// Velocity by differences, m/s.
    derived: Option<f64>,
}

impl Velocity {
    /// A velocity for samples every `sample_time` seconds.
    pub const fn new(sample_time: f64) -> Self {
        Self { sample_time, before: None, derived: None }
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
            self.derived.map_or(newest, |derived| derived + GAIN * (newest - derived))
        });
        self.derived
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_a_measured_velocity_it_is_that_of_neighbouring_readings() {
        let mut velocity = Velocity::new(0.5);
        let steps = [
            (Some(1.0), None, None),
            (Some(1.25), None, Some(0.5)),
            (Some(1.75), None, Some(0.5 + 0.35 * 0.5)),
            (Some(1.5), Some(7.0), Some(7.0)),
            (None, None, None),
            (Some(9.0), None, None),
        ];
        for (c2, measured, expected) in steps {
            assert_eq!(velocity.step(c2, measured), expected);
        }
    }
}
