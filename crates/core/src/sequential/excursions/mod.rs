//! Evidence on transducers that fluctuate.
//!
//! A healthy transducer may now and then be some counts off for a fraction of a second (thesis, Figure 5-9). C1 − C2 is then
//! noise and the excursions of two renewal processes, one on each transducer. Samples within an excursion are alike, so
//! that a window as long as one is worth hardly more than a sample ([`super::dependence`]). But a transducer is in one excursion
//! at a time, and two at once are rare, and an excursion ends. How long C1 − C2 may stand off (`runs`) and how large its sums
//! may become (`sums`) follows from the rate, the sizes and the lengths of the excursions that a recording has shown, by
//! computation. What exceeds such a limit is a fault.

mod filled;
mod limits;
mod onset;
mod runs;
mod sums;

pub use limits::{BOXES, CLIPS, ExcursionLimits, STRAYS};
pub use onset::{AlarmWindow, Beginning, Onset, displaced, find, student};
pub use sums::OFF;

use super::parameters::ExcursionParameters;
use super::samples::Sample;
use super::statistic::{Peak, larger};
use crate::state::state;
use runs::Runs;
use sums::WindowSums;

/// The detector of what no healthy excursions explain.
#[derive(Clone, Debug)]
pub struct Excursions {
    level: f64,
    runs: Runs,
    sums: WindowSums,
}

state! {
    Excursions { runs, sums }
    but { level }
}

const P: &ExcursionParameters = &ExcursionParameters::DEFAULT;

impl Excursions {
    pub fn new(limits: &ExcursionLimits) -> Self {
        Self { level: limits.level, runs: Runs::new(limits), sums: WindowSums::new(limits) }
    }

    /// Discards the evidence.
    pub fn clear(&mut self) {
        self.runs.clear();
        self.sums.clear();
    }

    /// Takes a sample: the largest evidence of a displacement and of noise in windows of at most `widest` samples.
    #[inline]
    pub fn step(&mut self, sample: &Sample, widest: usize) -> [Peak; 2] {
        let residual = known(sample);
        let run = self.runs.step(residual);
        let [sum, noise] = self.sums.step(residual * sample.share, widest);
        [larger(run.peak(self.level), sum.peak(self.level)), noise.peak(self.level)]
    }
}

/// The part of a residual that the uncertainty of its reference does not explain, m.
#[inline]
fn known(sample: &Sample) -> f64 {
    let Sample { residual, doubt, .. } = *sample;
    if doubt <= P.allowed_doubt * P.allowed_doubt {
        return residual;
    }
    let doubt = libm::sqrt(doubt) - P.allowed_doubt;
    if residual.abs() > doubt { residual - doubt.copysign(residual) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::super::windows::WIDTHS;
    use super::*;

    /// Limits of a cylinder with excursions of 0.44 mm and ten samples, in 6 of 10,000 samples and direction.
    pub(super) fn limits() -> ExcursionLimits {
        let run = |limits: [u16; STRAYS]| limits.map(Some);
        let mut runs = [run([5, 5, 5]); BOXES];
        runs[..6].copy_from_slice(&[
            run([31, 41, 42]),
            run([21, 28, 31]),
            run([12, 14, 18]),
            run([12, 13, 20]),
            run([12, 12, 18]),
            run([11, 11, 11]),
        ]);
        // Between the widths that are given the mean falls as a line.
        let between = |given: &[(usize, f64)]| {
            WIDTHS.map(|width| {
                let after = given.iter().position(|(w, _)| *w >= width).expect("1024 is given");
                let (w1, b1) = given[after];
                let (w0, b0) = given[after.saturating_sub(1)];
                let part = if w1 > w0 { (width - w0) as f64 / (w1 - w0) as f64 } else { 0.0 };
                (b0 + part * (b1 - b0)) * 1e-3 * width as f64
            })
        };
        let sums = [
            [0.381, 0.324, 0.316, 0.306, 0.303, 0.216, 0.152, 0.122],
            [0.736, 0.621, 0.610, 0.604, 0.593, 0.421, 0.235, 0.152],
            [1.378, 1.256, 0.938, 0.802, 0.649, 0.430, 0.243, 0.157],
        ]
        .map(|means| {
            let widths = [1, 4, 8, 12, 24, 64, 256, 1024];
            let given: Vec<_> = widths.into_iter().zip(means).collect();
            between(&given)
        });
        ExcursionLimits {
            level: 23.0,
            rest: 0.0838e-3,
            longest: 11,
            boxes: ExcursionLimits::boxes(0.287e-3, 0.503e-3),
            runs,
            clips: [0.277e-3, 0.608e-3, 1.25e-3],
            sums,
            squares: WIDTHS.map(|width| (0.3 + width as f64) * 0.07e-6),
            elsewhere: WIDTHS.map(|width| 5.4 + 0.12 * width as f64),
        }
    }

    #[test]
    fn what_exceeds_a_limit_is_more_than_the_level() {
        let limits = limits();
        let excursions = Excursions::new(&limits);
        let steps = |size: f64| {
            let mut it = excursions.clone();
            (0..200).position(|_| it.step(&Sample::at_rest(size), WIDTHS[19])[0].nats > 23.0)
        };
        // By runs, by sums of a few samples, and at once.
        assert_eq!(
            [0.4e-3, 0.5e-3, 1.0e-3, 1.5e-3].map(steps),
            [Some(30), Some(20), Some(7), Some(4)]
        );
        let peaks = excursions.clone().step(&Sample::at_rest(0.0), WIDTHS[19]);
        assert_eq!(peaks, [Peak::default(); 2]);
    }

    /// A place of which little is known may be off by so much.
    #[test]
    fn an_uncertain_reference_is_no_displacement() {
        let limits = limits();
        let doubtful = |residual: f64| Sample { residual, share: 1.0, doubt: 0.15e-3 * 0.15e-3 };
        let largest = |residual: f64| {
            let mut excursions = Excursions::new(&limits);
            let nats = |_| excursions.step(&doubtful(residual), WIDTHS[19])[0].nats;
            (0..1000).map(nats).fold(0.0, f64::max)
        };
        assert!(largest(0.11e-3) == 0.0 && largest(-0.11e-3) == 0.0);
        assert!(largest(0.6e-3) > 23.0 && largest(-0.6e-3) > 23.0);
        // What is left of 0.5 mm is 0.5 − (0.15 − 0.03) mm.
        let mut excursions = [Excursions::new(&limits), Excursions::new(&limits)];
        for _ in 0..40 {
            let [doubted, sure] = excursions.each_mut();
            let doubted = doubted.step(&doubtful(-0.5e-3), WIDTHS[19])[0];
            let sure = sure.step(&Sample::at_rest(-0.38e-3), WIDTHS[19])[0];
            assert!((doubted.nats - sure.nats).abs() < 1e-9, "{doubted:?} {sure:?}");
        }
    }
}
