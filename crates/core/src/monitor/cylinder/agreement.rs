//! Readings that agree with each other while an observer disagrees with one of them.
//!
//! Figure 5-17 takes an observer that is raised alone for its transducer's fault. Where load or valve
//! are not those of the model both innovations grow, and one of them crosses its threshold first, or
//! alone. But a fault of a reading is in C1 − C2, too, and at its onset no less than in the innovation:
//! the sequential detector's residual has it to a tenth of a millimetre.
//!
//! At its onset only: noise that began a cycle earlier is in the observer by then, and may be in the
//! innovation twice and more. But what the machine does differently from the model is in both
//! innovations, since both observers hear of the same command; a fault is in its own.

/// At less than this part of the innovation, C1 − C2 does not have it.
const PART: f64 = 0.5;

/// With at least this part of it the other observer sees it, too. Readings have noise of their own, and
/// one innovation is beyond its threshold first: it is not the whole.
const SHARED: f64 = 0.25;

/// Of FDE1 and FDE2.
#[derive(Clone, Copy, Debug, Default)]
pub struct Agreement {
    raised: [bool; 2],
    process: [bool; 2],
}

impl Agreement {
    /// Takes a cycle: which of FDE1 and FDE2 are raised, R1 and R2, m, and how far the readings are
    /// `apart`, m, where that is known and healthy. `contradicted`: they do not agree after all.
    pub fn judge(
        &mut self,
        raised: [bool; 2],
        residuals: [Option<f64>; 2],
        apart: Option<f64>,
        contradicted: bool,
    ) {
        for i in 0..2 {
            let agree = || {
                let [own, other] = [residuals[i], residuals[1 - i]];
                own.zip(other).zip(apart).is_some_and(|((own, other), apart)| {
                    apart < PART * own.abs() && other * own.signum() > SHARED * own.abs()
                })
            };
            self.process[i] = match (self.raised[i], raised[i]) {
                (_, false) => false,
                (false, true) => agree(),
                (true, true) => self.process[i] && !contradicted,
            };
        }
        self.raised = raised;
    }

    /// For FDE1 (0) or FDE2 (1): what it found is not its transducer's.
    pub const fn is_process(&self, i: usize) -> bool {
        self.process[i]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_both_readings_share_is_the_process_until_they_part() {
        let mut agreement = Agreement::default();
        let r = [Some(1.1e-3), Some(0.9e-3)];
        agreement.judge([true, false], r, Some(2e-4), false);
        assert!(agreement.is_process(0) && !agreement.is_process(1));
        // Not known any more, and then contradicted.
        agreement.judge([true, false], r, None, false);
        assert!(agreement.is_process(0));
        agreement.judge([true, false], r, None, true);
        assert!(!agreement.is_process(0));
    }

    /// Noise of 0.7 mm, its second sample against its first: the observer had followed that one.
    #[test]
    fn what_only_one_observer_sees_is_not_the_process() {
        for other in [Some(4e-4), Some(-4e-4), None] {
            let mut agreement = Agreement::default();
            agreement.judge([true, false], [Some(-2e-3), other], Some(9.8e-4), false);
            assert!(!agreement.is_process(0), "{other:?}");
        }
    }

    #[test]
    fn a_reading_that_left_the_other_one_is_not_the_process() {
        for apart in [Some(1.1e-3), Some(6e-4), None] {
            let mut agreement = Agreement::default();
            agreement.judge([true, true], [Some(-1.1e-3), Some(1e-3)], apart, false);
            assert!(!agreement.is_process(0) && !agreement.is_process(1), "{apart:?}");
            // It was raised then; what comes later is what the observer made of it.
            agreement.judge([true, true], [Some(2e-3), Some(2e-3)], Some(1e-4), false);
            assert!(!agreement.is_process(0) && !agreement.is_process(1), "{apart:?}");
        }
    }
}
