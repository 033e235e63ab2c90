//! A difference of C1 and C2 that nobody has calibrated.
//!
//! Two transducers are mounted beside each other as well as a fitter can, and each has a gain of its own. Without a
//! calibration a difference that was there at the first comparison says nothing of either of them. What it grows by
//! afterwards does.

use super::Verdict;
use super::trigger::{FdeState, Raise, Thresholds, Trigger};
use crate::state::state;
use crate::time::Timestamp;

/// The difference of a cylinder without a calibration.
#[derive(Clone, Debug)]
pub struct Unaligned {
    /// The first R3 and the length of C1 with it, m.
    first: Option<[f64; 2]>,
    /// Trigger of what R3 has grown by.
    growth: Trigger,
    verdict: Verdict,
    /// Part of the bound from which on the first R3 is a difference that stands.
    part: f64,
    /// What two gains may differ by, m per m.
    gain: f64,
}

state! {
    Unaligned { first, growth, verdict }
    but { part, gain }
}

impl Unaligned {
    /// By the thresholds of R3. A first R3 above a `part` of the upper one stands; `gain`, m per m, is what it may grow
    /// by with the length.
    pub fn new(thresholds: Thresholds, part: f64, gain: f64) -> Self {
        let growth = Trigger::new(thresholds);
        Self { first: None, growth, verdict: Verdict::Unknown, part, gain }
    }

    /// Takes R3 of the cycle at `at` and the length of C1 with it, m.
    pub fn judge(&mut self, at: Timestamp, difference: Option<f64>, length: Option<f64>) {
        let Some(now) = difference.zip(length) else {
            self.verdict = self.growth.judge(at, None);
            return;
        };
        let [before, there] = *self.first.get_or_insert([now.0, now.1]);
        let by_gain = self.gain * (now.1 - there).abs();
        self.verdict = self.growth.judge(at, Some(((now.0 - before).abs() - by_gain).max(0.0)));
    }

    /// Restarts the clearing time. The first R3 stays: what has changed meanwhile has changed.
    pub fn interrupt(&mut self) {
        self.growth.interrupt();
        self.verdict = Verdict::Unknown;
    }

    /// Whether the first R3 was a difference already.
    pub fn stood(&self) -> bool {
        self.first.is_some_and(|[first, _]| first.abs() > self.part * self.growth.thresholds().high)
    }

    /// When it has grown, if it has.
    pub const fn grown(&self) -> Option<Raise> {
        self.growth.raised()
    }

    /// What counts beside the observers: what it has grown by.
    pub const fn fde(&self) -> FdeState {
        FdeState { verdict: self.verdict, raised: self.growth.raised() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::time::Span;

    /// Difference, mm, and length, m, cycle after cycle; whether it stood at first, and has grown at the end.
    fn judged(cycles: &[[f64; 2]]) -> (bool, bool) {
        let clear = Span::from_seconds(1.0);
        let thresholds = Thresholds { low: 1.125e-3, high: 1.5e-3, clear };
        let mut unaligned = Unaligned::new(thresholds, 0.5, 5e-3);
        for (cycle, [mm, length]) in (0..).zip(cycles) {
            let at = Timestamp::from_nanos(cycle * 20_000_000);
            unaligned.judge(at, Some(mm * 1e-3), Some(*length));
        }
        (unaligned.stood(), unaligned.grown().is_some())
    }

    #[test]
    fn what_grows_beyond_what_two_gains_differ_by_has_grown() {
        assert_eq!(judged(&[[4.9, 0.0], [4.9, 0.0]]), (true, false));
        assert_eq!(judged(&[[-4.9, 0.0], [-1.0, 1.0]]), (true, false), "0.4 % along a metre");
        assert_eq!(judged(&[[4.9, 0.0], [6.5, 0.0]]), (true, true));
        assert_eq!(judged(&[[4.9, 0.0], [3.3, 0.0]]), (true, true), "it goes the other way");
        assert_eq!(judged(&[[4.9, 0.0], [11.5, 1.0]]), (true, true));
        assert!(!judged(&[[0.2, 0.0], [4.9, 0.0]]).0, "it came later");
    }
}
