//! A threshold with hysteresis in size and time: raised above δ_h, cleared after a while below δ_l.

use super::Verdict;
use crate::state::{state, whole};
use crate::time::{Span, Timestamp};

/// Thresholds of one residual.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Thresholds {
    /// Lower threshold δ_l, m.
    pub low: f64,
    /// Upper threshold δ_h, m.
    pub high: f64,
    /// Time for which the magnitude must stay below δ_l to clear.
    pub clear: Span,
}

/// Times of a raised trigger.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Raise {
    /// Time at which the residual first exceeded δ_h.
    pub at: Timestamp,
    /// Time at which the residual last exceeded δ_h.
    pub last_exceeded: Timestamp,
}

whole! { Raise { at, last_exceeded } }

/// Judges the magnitude of one residual, cycle after cycle.
#[derive(Clone, Debug)]
pub struct Trigger {
    thresholds: Thresholds,
    raised: Option<Raise>,
    /// Time below δ_l, without the times of which nothing is known.
    below: Span,
    /// Time of the last cycle, if its magnitude was below δ_l.
    was_below: Option<Timestamp>,
}

state! {
    Trigger { raised, below, was_below }
    but { thresholds }
}

impl Trigger {
    pub fn new(thresholds: Thresholds) -> Self {
        Self { thresholds, raised: None, below: Span::ZERO, was_below: None }
    }

    pub const fn thresholds(&self) -> &Thresholds {
        &self.thresholds
    }

    pub const fn raised(&self) -> Option<Raise> {
        self.raised
    }

    /// Takes the residual of the cycle at `at`; `None` or not a number where there is nothing to
    /// judge. A raised trigger stays raised until there is evidence for a whole clearing time; a
    /// cycle without evidence counts neither for it nor against it.
    pub fn judge(&mut self, at: Timestamp, residual: Option<f64>) -> Verdict {
        let Some(magnitude) = residual.map(f64::abs).filter(|m| !m.is_nan()) else {
            self.was_below = None;
            return if self.raised.is_some() { Verdict::Faulty } else { Verdict::Unknown };
        };
        if magnitude > self.thresholds.high {
            self.exceeded(at);
        } else if self.raised.is_some() {
            self.calm(at, magnitude < self.thresholds.low);
        }
        if self.raised.is_some() { Verdict::Faulty } else { Verdict::Healthy }
    }

    /// Raises it at `at`, or keeps it raised, by evidence that is more than the residual's magnitude.
    pub fn raise(&mut self, at: Timestamp) -> Verdict {
        self.exceeded(at);
        Verdict::Faulty
    }

    /// Raises it at `at` by a residual that has been beyond it `since`.
    pub fn raise_since(&mut self, since: Timestamp, at: Timestamp) -> Verdict {
        self.interrupt();
        self.raised = Some(Raise { at: since, last_exceeded: at });
        Verdict::Faulty
    }

    /// Takes back what was raised, because it is explained.
    pub fn withdraw(&mut self) {
        self.raised = None;
        self.interrupt();
    }

    /// Restarts the time below the threshold, after a time jump.
    pub fn interrupt(&mut self) {
        self.below = Span::ZERO;
        self.was_below = None;
    }

    fn exceeded(&mut self, at: Timestamp) {
        self.interrupt();
        match &mut self.raised {
            Some(raise) => raise.last_exceeded = at,
            None => self.raised = Some(Raise { at, last_exceeded: at }),
        }
    }

    fn calm(&mut self, at: Timestamp, below: bool) {
        if !below {
            self.interrupt();
            return;
        }
        if let Some(before) = self.was_below.replace(at) {
            let step = at.since(before).as_nanos();
            self.below = Span::from_nanos(self.below.as_nanos().saturating_add(step));
        }
        if self.below >= self.thresholds.clear {
            self.raised = None;
            self.interrupt();
        }
    }
}

/// An FDE as the others see it.
#[derive(Clone, Copy, Debug)]
pub struct FdeState {
    pub verdict: Verdict,
    pub raised: Option<Raise>,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(cycle: i64) -> Timestamp {
        Timestamp::from_nanos(cycle * 20_000_000)
    }

    fn trigger() -> Trigger {
        Trigger::new(Thresholds { low: 0.75e-3, high: 1.0e-3, clear: Span::from_seconds(0.1) })
    }

    #[test]
    fn raises_only_above_the_upper_threshold() {
        let mut trigger = trigger();
        for (cycle, residual) in [0.0, 0.9e-3, 1.0e-3, -1.0e-3].into_iter().enumerate() {
            assert_eq!(trigger.judge(at(cycle as i64), Some(residual)), Verdict::Healthy);
        }
        assert_eq!(trigger.judge(at(4), Some(-1.000_001e-3)), Verdict::Faulty);
        assert_eq!(trigger.raised().map(|raise| raise.at), Some(at(4)));
    }

    #[test]
    fn clears_after_the_whole_time_below_the_lower_threshold() {
        let mut trigger = trigger();
        trigger.judge(at(0), Some(2e-3));
        for cycle in 1..6 {
            assert_eq!(trigger.judge(at(cycle), Some(0.7e-3)), Verdict::Faulty, "{cycle}");
        }
        assert_eq!(trigger.judge(at(6), Some(0.7e-3)), Verdict::Healthy);
    }

    #[test]
    fn between_the_thresholds_the_time_starts_again() {
        let mut trigger = trigger();
        trigger.judge(at(0), Some(2e-3));
        (1..5).for_each(|cycle| _ = trigger.judge(at(cycle), Some(0.0)));
        assert_eq!(trigger.judge(at(5), Some(0.8e-3)), Verdict::Faulty);
        for cycle in 6..11 {
            assert_eq!(trigger.judge(at(cycle), Some(0.0)), Verdict::Faulty, "{cycle}");
        }
        assert_eq!(trigger.judge(at(11), Some(0.0)), Verdict::Healthy);
    }

    #[test]
    fn without_evidence_the_time_stands_still() {
        for nothing in [None, Some(f64::NAN)] {
            let mut trigger = trigger();
            trigger.judge(at(0), Some(2e-3));
            // 40 ms below, then a long time of which nothing is known.
            (1..4).for_each(|cycle| _ = trigger.judge(at(cycle), Some(0.0)));
            (4..90).for_each(|cycle| _ = trigger.judge(at(cycle), nothing));
            for cycle in 90..93 {
                assert_eq!(trigger.judge(at(cycle), Some(0.0)), Verdict::Faulty, "{cycle}");
            }
            assert_eq!(trigger.judge(at(93), Some(0.0)), Verdict::Healthy, "{nothing:?}");
        }
    }

    #[test]
    fn no_evidence_is_never_healthy() {
        let mut trigger = trigger();
        assert_eq!(trigger.judge(at(0), None), Verdict::Unknown);
        assert_eq!(trigger.judge(at(1), Some(f64::NAN)), Verdict::Unknown);
        assert_eq!(trigger.judge(at(2), Some(f64::INFINITY)), Verdict::Faulty);
    }
}
