//! Evidence that a residual has moved, or spreads more, weighed over windows of every width.

use super::parameters::ProcessParameters;
use crate::sequential::statistic::Peak;
use crate::sequential::windows::{Sums, VALUES, WIDTHS};
use crate::state::state;
use core::ops::Range;

const P: &ProcessParameters = &ProcessParameters::DEFAULT;

/// Samples of the widest window.
pub const WIDEST: usize = 1024;

/// After how many times the widest window the sums are restarted.
pub const RESTART: usize = 16;

/// Samples between two turns.
const TURN: usize = 4;

/// No residual is larger than so many standard deviations: beside one that is, others would lose their digits.
const ABSURD: f64 = 1e6;

/// By what evidence is weighed.
#[derive(Clone, Debug, PartialEq)]
pub struct Weighing {
    /// Displacement that is no fault, in the residual's unit.
    pub dead_band: f64,
    /// Number of samples that carry as much as one independent one, for mean and spread, for each of [`WIDTHS`].
    pub dependence: [[f64; WIDTHS.len()]; 2],
    /// Places in [`WIDTHS`] of the shortest window and of that after the longest.
    widths: [usize; 2],
    /// Σ (y/s)² over each of [`WIDTHS`] that is no fault.
    most_squares: [f64; WIDTHS.len()],
}

impl Weighing {
    /// For residuals that are sampled every `sample_time` seconds.
    pub fn new(dead_band: f64, dependence: [[f64; WIDTHS.len()]; 2], sample_time: f64) -> Self {
        let [shortest, longest] = P.widths(sample_time);
        let before = |samples: usize| WIDTHS.iter().take_while(|width| **width < samples).count();
        let widths = [before(shortest), before(longest.min(WIDEST) + 1)];
        let most_squares = WIDTHS.map(|width| P.spread_band * width as f64);
        Self { dead_band, dependence, widths, most_squares }
    }

    /// Whether sums over a window are evidence of anything; of squares they may be `most`.
    #[inline]
    fn is_evidence(&self, most: f64, [sum, weight, square, _]: &[f64; VALUES]) -> bool {
        sum.abs() > self.dead_band * weight || *square > most
    }

    /// Nats of the sums over the window of `index`: of the mean beyond the dead band, (|Σ y/s²| − ε Σ 1/s²)²
    /// over 2 κ Σ 1/s², and of the variance, n/2κ (ρ − 1 − ln ρ), ρ being the mean (y/s)² over the band.
    fn nats(&self, index: usize, [sum, weight, square, _]: [f64; VALUES]) -> [f64; 2] {
        let [of_mean, of_spread] = &self.dependence;
        let beyond = sum.abs() - self.dead_band * weight;
        let mean = if beyond > 0.0 && weight > 0.0 {
            beyond * beyond / (2.0 * of_mean[index] * weight)
        } else {
            0.0
        };
        let width = WIDTHS[index] as f64;
        let ratio = square / (P.spread_band * width);
        let spread = if ratio > 1.0 {
            0.5 * width / of_spread[index] * (ratio - 1.0 - libm::log(ratio))
        } else {
            0.0
        };
        [mean, spread]
    }
}

/// How many widths, from the shortest one on, have their turn after `count` samples.
#[inline]
pub const fn in_turn(count: usize) -> usize {
    2 * (count.trailing_zeros() as usize + 1)
}

/// The newest residuals of one relation.
#[derive(Clone, Debug, Default)]
pub struct EvidenceWindows {
    /// y/s², 1/s² and (y/s)², y being a residual as far as it is evidence; and the whole residual.
    sums: Sums<WIDEST, VALUES, RESTART>,
}

state! { EvidenceWindows { sums } }

impl EvidenceWindows {
    pub const fn clear(&mut self) {
        self.sums.clear();
    }

    /// Takes a residual with its variance; nothing that is not finite, which no sum would ever forget.
    #[inline]
    pub fn push(&mut self, residual: f64, variance: f64) {
        let weight = 1.0 / variance;
        let weighed = residual * weight;
        let square = residual * weighed;
        // Where anything is not finite this is no number, or too large.
        if square <= P.farthest * P.farthest {
            self.sums.push([weighed, weight, square, residual]);
        } else {
            self.push_far(residual, variance);
        }
    }

    #[cold]
    fn push_far(&mut self, residual: f64, variance: f64) {
        let (weight, deviation) = (1.0 / variance, libm::sqrt(variance));
        if !(residual.is_finite() && weight.is_finite()) {
            return;
        }
        let within =
            |deviations: f64| residual.clamp(-deviations * deviation, deviations * deviation);
        let evident = within(P.farthest);
        let weighed = evident * weight;
        self.sums.push([weighed, weight, evident * weighed, within(ABSURD)]);
    }

    /// The sums over the newest `width` samples: y/s², 1/s², (y/s)², each as far as it is evidence, and y; `None` if
    /// there are not so many.
    pub fn sums(&self, width: usize) -> Option<[f64; VALUES]> {
        self.sums.over(width)
    }

    /// The windows of mean and of spread with the most evidence, of all widths.
    pub fn peaks(&self, by: &Weighing) -> [Peak; 2] {
        let [first, end] = by.widths;
        self.among(by, first..end)
    }

    /// The same of the widths up to `most`.
    pub fn peaks_within(&self, by: &Weighing, most: usize) -> [Peak; 2] {
        let [first, end] = by.widths;
        let within = WIDTHS[first..end].iter().take_while(|width| **width <= most).count();
        self.among(by, first..first + within)
    }

    /// The same of the widths whose turn it is: the two shortest at every fourth sample, the next two at every eighth
    /// one, and so on, so that its width is the longest that one waits.
    pub fn peaks_in_turn(&self, by: &Weighing) -> [Peak; 2] {
        self.among(by, self.turn(by))
    }

    /// Whether [`Self::peaks_in_turn`] has anything to weigh, which is soon told.
    #[inline]
    pub fn has_evidence_in_turn(&self, by: &Weighing) -> bool {
        self.sums.count().is_multiple_of(TURN) && self.has_evidence(by, self.turn(by))
    }

    #[inline]
    fn turn(&self, by: &Weighing) -> Range<usize> {
        let ([first, end], count) = (by.widths, self.sums.count());
        let turns = if count.is_multiple_of(TURN) { in_turn(count / TURN) } else { 0 };
        first..end.min(first + turns)
    }

    fn has_evidence(&self, by: &Weighing, indices: Range<usize>) -> bool {
        let held = self.sums.held();
        let widths = WIDTHS[indices.clone()].iter().zip(&by.most_squares[indices]);
        let mut held = widths.take_while(|(width, _)| **width <= held);
        held.any(|(width, most)| by.is_evidence(*most, &self.sums.newest(*width)))
    }

    fn among(&self, by: &Weighing, indices: Range<usize>) -> [Peak; 2] {
        let mut peaks = [Peak::default(); 2];
        let held = self.sums.held();
        for (index, &width) in indices.clone().zip(&WIDTHS[indices]) {
            if width > held {
                break;
            }
            let sums = self.sums.newest(width);
            if by.is_evidence(by.most_squares[index], &sums) {
                for (peak, nats) in peaks.iter_mut().zip(by.nats(index, sums)) {
                    if nats > peak.nats {
                        *peak = Peak { nats, width };
                    }
                }
            }
        }
        peaks
    }

    /// Mean of the newest `width` residuals; `None` if there are not so many.
    pub fn mean(&self, width: usize) -> Option<f64> {
        let [.., sum] = self.sums.over(width)?;
        Some(sum / width as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ONE: [[f64; WIDTHS.len()]; 2] = [[1.0; WIDTHS.len()]; 2];

    fn peaks(by: &Weighing, residuals: impl Iterator<Item = f64>) -> [Peak; 2] {
        let mut evidence = EvidenceWindows::default();
        residuals.for_each(|residual| evidence.push(residual, 0.25));
        evidence.peaks(by)
    }

    #[test]
    fn the_nats_are_those_of_the_formulae() {
        let by = Weighing::new(0.1, ONE, 0.02);
        // 0.6 beside 0 by a deviation of 0.5, 0.1 of which is no fault, in 64 samples.
        let [mean, spread] = peaks(&by, (0..64).map(|_| 0.6));
        assert_eq!((mean.width, spread.nats), (64, 0.0));
        assert!((mean.nats - 64.0 * 0.5 * 0.5 / (2.0 * 0.25)).abs() < 1e-9, "{mean:?}");
        // Three deviations up and down: a variance of 4.5 times what is no fault.
        let [mean, spread] = peaks(&by, (0..64).map(|k| 1.5 * f64::from(1 - 2 * (k & 1))));
        assert_eq!((mean.nats, spread.width), (0.0, 64));
        assert!((spread.nats - 32.0 * (4.5 - 1.0 - 4.5_f64.ln())).abs() < 1e-9, "{spread:?}");
    }

    #[test]
    fn dependent_samples_and_single_spikes_prove_little() {
        let of = |dependence| Weighing::new(0.0, [[dependence; WIDTHS.len()]; 2], 0.02);
        let [[one, _], [four, _]] = [1.0, 4.0].map(|it| peaks(&of(it), (0..64).map(|_| 0.6)));
        assert!((one.nats / four.nats - 4.0).abs() < 1e-9);
        let spike = peaks(&of(1.0), (0..64).map(|k| if k == 60 { 1e6 } else { 0.0 }));
        assert!(spike.iter().all(|peak| peak.nats < 12.0), "{spike:?}");
    }

    /// One absurd sample: what comes after it counts as before.
    #[test]
    fn nothing_spoils_the_sums_for_good() {
        let by = Weighing::new(0.0, ONE, 0.02);
        let after = |absurd: f64, deviation: f64| {
            let mut evidence = EvidenceWindows::default();
            evidence.push(absurd, deviation * deviation);
            (0..2000).for_each(|_| evidence.push(0.6, 0.25));
            let [mean, _] = evidence.peaks(&by);
            let right = (512.0 * 0.6_f64.powi(2) / (2.0 * 0.25), 0.6);
            let found = (mean.nats, evidence.mean(64).unwrap_or(f64::NAN));
            (found.0 - right.0).abs() < 1e-6 && (found.1 - right.1).abs() < 1e-6
        };
        for absurd in [0.6, f64::NAN, f64::INFINITY, -f64::INFINITY, f64::MAX, -1e300] {
            assert!(after(absurd, 0.5), "{absurd}");
        }
        for deviation in [f64::NAN, 0.0] {
            assert!(after(0.6, deviation), "{deviation}");
        }
    }

    #[test]
    fn each_width_has_its_turn_within_it() {
        let by = Weighing::new(0.1, ONE, 0.02);
        let (mut evidence, mut seen) = (EvidenceWindows::default(), [0; WIDTHS.len()]);
        for k in 1..=3000 {
            evidence.push(0.6, 0.25);
            let [first, end] = by.widths;
            let turns = if k % TURN == 0 { in_turn(k / TURN) } else { 0 };
            for index in first..end.min(first + turns) {
                assert!(k - seen[index] <= WIDTHS[index], "{k}: {}", WIDTHS[index]);
                seen[index] = k;
            }
            let in_turn = evidence.peaks_in_turn(&by)[0].nats;
            assert_eq!(evidence.has_evidence_in_turn(&by), in_turn > 0.0, "{k}");
            let all = evidence.peaks(&by)[0].nats;
            assert!(in_turn <= all && (k % 512 != 0 || in_turn == all), "{k}");
        }
        let [first, end] = by.widths;
        assert!(seen[first..end].iter().all(|seen| *seen > 3000 - 512), "{seen:?}");
    }

    /// Four samples beyond the dead band after healthy ones are in no window but the shortest.
    #[test]
    fn evidence_of_a_single_width_is_seen() {
        let (by, mut evidence) = (Weighing::new(0.5, ONE, 0.02), EvidenceWindows::default());
        for (residual, is_evidence) in [(0.0, false), (0.6, true)] {
            let samples = if is_evidence { 4 } else { 96 };
            (0..samples).for_each(|_| evidence.push(residual, 0.25));
            assert_eq!(evidence.has_evidence_in_turn(&by), is_evidence);
        }
        assert_eq!(evidence.peaks_in_turn(&by)[0].width, 4);
    }

    #[test]
    fn windows_are_as_long_as_their_times_at_any_rate() {
        for (sample_time, widths) in [(0.02, [4, 512]), (0.01, [8, 1024]), (0.1, [4, 512])] {
            let by = Weighing::new(0.1, ONE, sample_time);
            let [first, end] = by.widths;
            assert_eq!([WIDTHS[first], WIDTHS[end - 1]], widths, "{sample_time}");
        }
    }
}
