//! Tests whether readings agree with each other while an observer disagrees with one of them.
//!
//! By Figure 5-17 an observer that is raised alone means a fault of its transducer. But where load
//! or valve differ from the model both innovations grow, and one of them crosses its threshold
//! first, or alone. A fault of a reading also appears in C1 − C2, at its onset no less than in the
//! innovation, and the sequential detector's residual shows it to a tenth of a millimetre.
//!
//! This holds at the onset only: noise that began a cycle earlier is already in the observer and
//! may be in the innovation more than twice. A deviation of the machine from the model, however, is
//! in both innovations, since both observers get the same command, while a fault is only in its
//! own.

use super::parameters::BlameParameters;
use crate::sample::Transducer;
use crate::state::whole;

const P: &BlameParameters = &BlameParameters::DEFAULT;

/// Whether the observer of the `other` transducer sees less than [`BlameParameters::alone`] of the residual `own`, m: an error
/// of the model is in both. Where the other one does not judge, nothing is known.
pub fn is_alone(own: f64, other: Option<f64>) -> bool {
    other.is_some_and(|other| other.abs() < P.alone * own.abs())
}

/// Whether the observer with the residual `other`, m, sees more than this `part` of the residual `own`, m, in the same
/// direction.
fn sees(own: f64, other: f64, part: f64) -> bool {
    other * own.signum() > part * own.abs()
}

/// What is known of C1 and C2 beside R1 and R2.
#[derive(Clone, Copy, Debug, Default)]
pub struct PairState {
    /// Their difference, m, where it is known and healthy.
    pub apart: Option<f64>,
    /// Whether they do not agree after all.
    pub contradicted: bool,
    /// Whether they had parted before: what R1 and R2 have in common is then not their difference.
    pub parted: bool,
}

/// Agreement for FDE1 and FDE2.
#[derive(Clone, Copy, Debug, Default)]
pub struct Agreement {
    raised: [bool; 2],
    process: [bool; 2],
    /// Whether R1 and R2 agreed when C1 and C2 had parted already.
    shared: [bool; 2],
}

whole! { Agreement { raised, process, shared } }

impl Agreement {
    /// Takes a cycle: whether FDE1 and FDE2 are raised, or have `exceeded` their thresholds and may yet see a wild reading;
    /// R1 and R2, m; and what is known of C1 and C2.
    pub fn judge(
        &mut self,
        raised: [bool; 2],
        exceeded: [bool; 2],
        residuals: [Option<f64>; 2],
        readings: PairState,
    ) {
        let PairState { apart, contradicted, parted } = readings;
        for i in 0..2 {
            let both = residuals[i].zip(residuals[1 - i]);
            let shared = || both.is_some_and(|(own, other)| sees(own, other, P.alike));
            let agree = || {
                both.zip(apart).is_some_and(|((own, other), apart)| {
                    apart < P.hidden * own.abs() && sees(own, other, P.seen)
                })
            };
            (self.shared[i], self.process[i]) = match (self.raised[i], raised[i]) {
                (true, true) => (self.shared[i], self.process[i] && !contradicted),
                (_, false) if !exceeded[i] => (false, false),
                // From the first sample on: three later R2 may have come back before R1, as where the load has doubled.
                _ => (self.shared[i] || parted && shared(), self.process[i] || agree()),
            };
        }
        self.raised = raised;
    }

    /// Whether the finding of the observer of a transducer is what the controller, or a rod at its stop, makes of a difference
    /// that was there before, and not its transducer.
    pub const fn is_shared(&self, of: Transducer) -> bool {
        self.shared[of as usize]
    }

    /// Whether the finding of the observer of a transducer is the process, and not its transducer.
    pub const fn is_process(&self, of: Transducer) -> bool {
        self.process[of as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Readings that differ by so much and have not parted.
    fn apart(apart: Option<f64>) -> PairState {
        PairState { apart, ..PairState::default() }
    }

    #[test]
    fn what_both_readings_share_is_the_process_until_they_part() {
        let mut agreement = Agreement::default();
        let r = [Some(1.1e-3), Some(0.9e-3)];
        agreement.judge([true, false], [false; 2], r, apart(Some(2e-4)));
        assert!(agreement.is_process(Transducer::C1) && !agreement.is_process(Transducer::C2));
        // Not known any more, and then contradicted.
        agreement.judge([true, false], [false; 2], r, apart(None));
        assert!(agreement.is_process(Transducer::C1));
        agreement.judge(
            [true, false],
            [false; 2],
            r,
            PairState { contradicted: true, ..apart(None) },
        );
        assert!(!agreement.is_process(Transducer::C1));
    }

    /// The load doubles: R1 exceeds its threshold, and three samples later, when that is a fault, R2 sees less of it.
    #[test]
    fn what_both_shared_when_one_exceeded_its_threshold_is_the_process() {
        let both = [Some(1.6e-3), Some(1.1e-3)];
        let later = [Some(1.2e-3), Some(0.2e-3)];
        let process = |at_first: [Option<f64>; 2]| {
            let mut agreement = Agreement::default();
            agreement.judge([false; 2], [true, false], at_first, apart(Some(1e-4)));
            agreement.judge([true, false], [false; 2], later, apart(Some(1e-4)));
            agreement.is_process(Transducer::C1)
        };
        assert!(process(both));
        assert!(!process(later));
        // And the end of a rod's way, where a drifting C1 has driven it, is none of C2's faults.
        let mut agreement = Agreement::default();
        let parted = PairState { parted: true, ..apart(None) };
        agreement.judge([false; 2], [true, false], [Some(1.6e-3), Some(1.5e-3)], parted);
        agreement.judge([true, false], [false; 2], later, parted);
        assert!(agreement.is_shared(Transducer::C1));
    }

    #[test]
    fn a_fault_is_in_one_observer_and_an_error_of_the_model_in_both() {
        assert!(!is_alone(5e-3, Some(4.6e-3)) && !is_alone(4.6e-3, Some(5e-3)));
        // A step of C1 by 12 mm, by itself and on top of that; and by as much the other way, where nobody can tell.
        assert!(is_alone(12e-3, Some(-1e-4)));
        assert!(is_alone(17e-3, Some(5e-3)) && !is_alone(5e-3, Some(17e-3)));
        assert!(!is_alone(-7e-3, Some(5e-3)) && !is_alone(5e-3, Some(-7e-3)));
        assert!(!is_alone(5e-3, None));
    }

    /// Noise of 0.7 mm, with its second sample opposite to its first, which the observer had
    /// followed.
    #[test]
    fn what_only_one_observer_sees_is_not_the_process() {
        for other in [Some(4e-4), Some(-4e-4), None] {
            let mut agreement = Agreement::default();
            agreement.judge([true, false], [false; 2], [Some(-2e-3), other], apart(Some(9.8e-4)));
            assert!(!agreement.is_process(Transducer::C1), "{other:?}");
        }
    }

    #[test]
    fn a_reading_that_left_the_other_one_is_not_the_process() {
        for difference in [Some(1.1e-3), Some(6e-4), None] {
            let mut agreement = Agreement::default();
            agreement.judge(
                [true, true],
                [false; 2],
                [Some(-1.1e-3), Some(1e-3)],
                apart(difference),
            );
            assert!(
                !agreement.is_process(Transducer::C1) && !agreement.is_process(Transducer::C2),
                "{difference:?}"
            );
            // It was raised then; what comes later is what the observer made of it.
            agreement.judge([true, true], [false; 2], [Some(2e-3), Some(2e-3)], apart(Some(1e-4)));
            assert!(
                !agreement.is_process(Transducer::C1) && !agreement.is_process(Transducer::C2),
                "{difference:?}"
            );
        }
    }

    /// The rod is at its stop, or the controller does what nobody was taught, because C1 has drifted off.
    #[test]
    fn what_both_observers_see_of_readings_that_had_parted_is_shared_until_it_clears() {
        let [c1, c2] = [Transducer::C1, Transducer::C2];
        for (own, other, sign) in [(c1, c2, 1.0), (c1, c2, -1.0), (c2, c1, 1.0), (c2, c1, -1.0)] {
            let i = own as usize;
            let mut agreement = Agreement::default();
            let mut judge = |raised: bool, [of_own, of_other]: [f64; 2], parted| {
                let mut residuals = [Some(sign * of_own); 2];
                residuals[1 - i] = Some(sign * of_other);
                let readings = PairState { apart: None, contradicted: parted, parted };
                let raised = [0, 1].map(|k| raised && k == i);
                agreement.judge(raised, [false; 2], residuals, readings);
                assert!(!agreement.is_shared(other));
                agreement.is_shared(own)
            };
            assert!(!judge(true, [1.7e-3, 1.6e-3], false), "they part with it");
            assert!(!judge(true, [1.7e-3, 1.6e-3], true));
            assert!(!judge(false, [0.0; 2], true));
            assert!(!judge(true, [1.7e-3, 1.2e-3], true) && !judge(false, [0.0; 2], true));
            assert!(!judge(true, [1.7e-3, -1.6e-3], true) && !judge(false, [0.0; 2], true));
            assert!(judge(true, [1.7e-3, 1.6e-3], true) && judge(true, [3e-3, 0.0], true));
            assert!(!judge(false, [0.0; 2], true));
        }
    }
}
