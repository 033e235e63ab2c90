//! The measurements among which the controller may choose, cylinder by cylinder.

use super::Readings;
use crate::hexapod::LEGS;

/// Measurement that the controller takes for the length of a cylinder.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Measurement {
    #[default]
    C1,
    /// C2 as it reads, millimetres beside C1: no frame tells how the two differ where both are sound.
    C2,
    /// The length that another node tells; C2 in cycles for which it tells none.
    Estimated,
}

/// What the controller has heard of the cylinders.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Heard {
    /// Newest lengths by C1 and C2 of each cylinder, m.
    pub lengths: [[f64; 2]; LEGS],
    /// Newest speeds by C1 and C2 of each cylinder, m/s.
    pub speeds: [[f64; 2]; LEGS],
    /// Lengths that another node tells of the cycle before this one, m.
    pub told: [Option<f64>; LEGS],
}

impl Heard {
    /// Puts the length and the speed of each cylinder by its measurement into `readings`; `sample_time` in s.
    pub fn measure(&self, chosen: &[Measurement; LEGS], sample_time: f64, readings: &mut Readings) {
        for (leg, measurement) in chosen.iter().enumerate() {
            let which = usize::from(*measurement != Measurement::C1);
            let (length, speed) = (self.lengths[leg][which], self.speeds[leg][which]);
            // What is told has come a cycle too late, in which the rod went on.
            let told = self.told[leg].filter(|_| *measurement == Measurement::Estimated);
            readings.lengths[leg] = told.map_or(length, |told| told + speed * sample_time);
            readings.speeds[leg] = speed;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_cylinder_is_measured_as_chosen_and_what_is_told_is_brought_up_to_date() {
        let mut heard = Heard {
            lengths: [[0.1, 0.104]; LEGS],
            speeds: [[0.5, 0.4]; LEGS],
            told: [Some(0.08); LEGS],
        };
        heard.told[3] = None;
        let mut chosen = [Measurement::C1; LEGS];
        chosen[1..4].copy_from_slice(&[
            Measurement::C2,
            Measurement::Estimated,
            Measurement::Estimated,
        ]);
        let mut readings = Readings::default();
        heard.measure(&chosen, 0.02, &mut readings);
        assert_eq!(readings.lengths, [0.1, 0.104, 0.088, 0.104, 0.1, 0.1], "C2 where none is told");
        assert_eq!(readings.speeds, [0.5, 0.4, 0.4, 0.4, 0.5, 0.5]);
    }
}
