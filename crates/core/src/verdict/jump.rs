//! Joint evidence of a step: one observer sees it, the other one does not, and C1 − C2 has moved with it.
//!
//! A transducer that fluctuates is now and then some tenths of a millimetre off, and the model errs by as much. A limit
//! of R1 and R2 that covers both at once is several millimetres. But an error of the model is in both observers and not in
//! C1 − C2, and one fluctuation is small in C1 − C2: the three together keep the thesis's 1 mm.

use super::parameters::VerdictParameters;

/// How C1 − C2 has moved, beyond what is healthy, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jump {
    /// C1 − C2 now.
    pub apart: f64,
    /// Its change in [`Self::SAMPLES`].
    pub change: f64,
}

impl Jump {
    /// Samples over which the change is taken: the observers have followed half of a step after three.
    pub const SAMPLES: usize = 3;

    /// C2 − C1.
    pub const fn reversed(self) -> Self {
        Self { apart: -self.apart, change: -self.change }
    }

    /// Whether C1 − C2 shows what the observer of C1 does, by its residual `own`, m, while the `other` observer is quiet.
    ///
    /// C1 − C2 has to be off, since a transducer that goes from one fluctuation to the opposite one changes it by twice its
    /// size; and it has to have changed, since it may have been off before.
    pub fn shows(self, own: f64, other: f64, parameters: &VerdictParameters) -> bool {
        let least = parameters.joint_moved * own.abs();
        let along = |it: f64| it * own.signum() >= least;
        other.abs() < parameters.joint_quiet * own.abs() && along(self.apart) && along(self.change)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const P: &VerdictParameters = &VerdictParameters::DEFAULT;

    fn shows(apart: f64, change: f64, own: f64, other: f64) -> bool {
        let jump = Jump { apart, change };
        let is_shown = jump.shows(own, other, P);
        let mirrored = Jump { apart: -apart, change: -change };
        assert_eq!(is_shown, mirrored.shows(-own, -other, P), "either direction is alike");
        assert_eq!(mirrored, jump.reversed());
        is_shown
    }

    #[test]
    fn a_step_of_one_transducer_is_in_its_observer_and_in_the_difference() {
        assert!(shows(1.2e-3, 1.25e-3, 1.3e-3, 0.2e-3));
        // The rod does not do what its command says: both observers see it, and the difference does not.
        assert!(!shows(1.2e-3, 1.25e-3, 1.3e-3, 0.4e-3));
        assert!(!shows(0.4e-3, 0.4e-3, 1.3e-3, 0.2e-3));
        // C2's observer sees its own step with the sign of C2 − C1.
        assert!(!shows(-1.2e-3, -1.25e-3, 1.3e-3, 0.2e-3));
    }

    #[test]
    fn neither_a_leap_between_two_fluctuations_nor_an_old_difference_is_a_step() {
        // From +0.434 to −0.434 mm in one sample.
        assert!(!shows(-0.434e-3, -0.868e-3, -1.05e-3, 0.1e-3));
        // The readings have been 2 mm apart for a while.
        assert!(!shows(2e-3, 0.1e-3, 1.3e-3, 0.1e-3));
    }
}
