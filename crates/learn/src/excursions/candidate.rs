//! What a candidate is: wild samples, excursions, two that overlap, or nothing that counts.
//!
//! A mark reaches up to three samples beyond an edge, since it comes from the mean of a window. The
//! edges of an excursion are therefore where the samples cross half of its size.

use super::excursion::Excursion;
use super::plateaus::{Overlap, overlap};
use super::segment::Segment;
use crate::order_statistics::median;
use std::ops::Range;

/// Samples beside a candidate to which a stretch may extend.
const EXTENSION: usize = 2;

/// Samples before and after a stretch that show its edges. With three, which are low by chance more
/// often, a profile that is 0.2 mm off gave twice as many excursions, and fewer true ones were found.
const EDGE_SAMPLES: usize = 5;

/// Samples beside a candidate that are looked at.
pub(super) const BESIDE: usize = EXTENSION + EDGE_SAMPLES;

/// Part of the size beyond which samples belong to a stretch.
const STRETCH_PART: f64 = 0.5;

/// Successive samples that are not beyond it and end a stretch.
const ENDING_SAMPLES: usize = 2;

/// Differences of quantised readings are often half of the size but for rounding: not beyond it, m.
const ROUNDING: f64 = 1e-9;

/// Least size of an excursion, m: twice the dead band of the detectors.
const LEAST_SIZE: f64 = 0.19e-3;

/// A stretch counts if length × size² is more than this many variances of a sample: then its mean is
/// five standard errors off.
const COUNTING_VARIANCES: f64 = 25.0;

/// Size below which a stretch counts only with edges, m: a profile can be off by as much.
const SIZE_WITHOUT_EDGES: f64 = 0.3e-3;

/// Part of the size below which the samples before and after a stretch are an edge.
const EDGE_PART: f64 = 0.35;

/// Most samples beyond of a stretch that is wild.
const MOST_WILD: u32 = 2;

/// Multiple of the size to which samples are limited in the mean, so that a wild sample within an
/// excursion does not become its size.
const LARGEST_IN_MEAN: f64 = 3.0;

/// A sample of the difference.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sample {
    /// m, unweighted.
    pub residual: f64,
    /// m/s.
    pub velocity: f64,
    /// Variance σ(v)² of a healthy residual, m².
    pub variance: f64,
    /// Whether the mean of a window marked it.
    pub marked: bool,
}

/// A row of marked samples of one sign, and the samples beside it.
pub(super) struct Candidate<'a> {
    /// The row, and up to [`BESIDE`] samples on both sides.
    pub samples: &'a [Sample],
    /// Place of the first of `samples` in the stream.
    pub at: u64,
    /// Which of `samples` are the row, not empty.
    pub row: Range<usize>,
    /// The first of `samples` that is in no stretch of the candidate before.
    pub free: usize,
    pub positive: bool,
    /// Deviation at rest σ0, m.
    pub rest: f64,
    /// Whether `samples` begin with the first one after a gap.
    pub after_gap: bool,
    /// Whether `samples` end with the last one before a gap.
    pub before_gap: bool,
}

/// Samples beyond half of a size, and that size, m.
#[derive(Debug, PartialEq)]
struct Stretch {
    range: Range<usize>,
    /// Number of its samples that are beyond.
    beyond: u32,
    size: f64,
}

impl Candidate<'_> {
    /// Hands out what the candidate is made of, in order; returns the place after its last stretch
    /// that counts, within `samples`.
    pub fn judge(&self, found: &mut impl FnMut(Segment)) -> Option<usize> {
        let mut end = None;
        for stretch in self.counting_stretches() {
            let small = stretch.size < SIZE_WITHOUT_EDGES;
            if small && !self.has_edges(&stretch) {
                continue;
            }
            end = Some(stretch.range.end);
            found(self.segment(&stretch));
        }
        if end.is_none() {
            found(Segment::Unexplained { samples: self.row.len() as u32 });
        }
        end
    }

    /// Residual at `place` in the candidate's direction, m.
    fn value(&self, place: usize) -> f64 {
        let residual = self.samples[place].residual;
        if self.positive { residual } else { -residual }
    }

    fn values(&self, range: Range<usize>) -> impl Iterator<Item = f64> {
        range.map(|place| self.value(place))
    }

    /// Stretches that stand out of the noise: beyond half of the median, or else of the largest.
    fn counting_stretches(&self) -> Vec<Stretch> {
        // Twice, as marks reach beyond the edges: what is there makes the first median too small.
        let values = || self.values(self.row.clone());
        let level = STRETCH_PART * median(values().collect());
        let size = median(values().filter(|value| *value > level).collect());
        let mut stretches = self.stretches(size);
        stretches.retain(|stretch| self.counts(stretch));
        if !stretches.is_empty() {
            return stretches;
        }
        // A spike marks its neighbours, too, whose median is noise: the spike is what is off.
        let largest = self.values(self.row.clone()).fold(0.0, f64::max);
        let mut stretches = self.stretches(largest);
        for stretch in &mut stretches {
            stretch.size = median(self.values(stretch.range.clone()).collect());
        }
        stretches.retain(|stretch| self.counts(stretch));
        stretches
    }

    /// Cuts out what is beyond half of `size`, m.
    fn stretches(&self, size: f64) -> Vec<Stretch> {
        let from = self.row.start.saturating_sub(EXTENSION).max(self.free);
        let to = (self.row.end + EXTENSION).min(self.samples.len());
        let mut stretches: Vec<Stretch> = Vec::new();
        for place in from..to {
            if self.value(place) <= STRETCH_PART * size + ROUNDING {
                continue;
            }
            match stretches.last_mut() {
                Some(Stretch { range, beyond, .. }) if place - range.end < ENDING_SAMPLES => {
                    range.end = place + 1;
                    *beyond += 1;
                }
                _ => stretches.push(Stretch { range: place..place + 1, beyond: 1, size }),
            }
        }
        for stretch in &mut stretches {
            self.trim(stretch, size);
        }
        stretches
    }

    /// Drops samples beyond half of `size`, m, from the ends, each with the one next to it that is
    /// not, unless the mean of both is beyond: least squares put the edge behind such a pair.
    fn trim(&self, stretch: &mut Stretch, size: f64) {
        let level = STRETCH_PART * size + ROUNDING;
        let is_noise = |outer: usize, inner: usize| {
            let (outer, inner) = (self.value(outer), self.value(inner));
            inner <= level && outer + inner <= 2.0 * level
        };
        let Stretch { range, beyond, .. } = stretch;
        // What becomes wild by it was wild samples, all of which are counted.
        while *beyond > MOST_WILD + 1 && is_noise(range.start, range.start + 1) {
            range.start += 2;
            *beyond -= 1;
        }
        while *beyond > MOST_WILD + 1 && is_noise(range.end - 1, range.end - 2) {
            range.end -= 2;
            *beyond -= 1;
        }
    }

    /// Whether the stretch stands out of the noise.
    fn counts(&self, stretch: &Stretch) -> bool {
        let samples = &self.samples[stretch.range.clone()];
        let length = samples.len() as f64;
        let variance = samples.iter().map(|sample| sample.variance).sum::<f64>() / length;
        let level = stretch.size.min(self.mean(stretch));
        level > LEAST_SIZE && length * level * level > COUNTING_VARIANCES * variance
    }

    /// Mean of the stretch, m; samples are limited to a multiple of its size.
    fn mean(&self, stretch: &Stretch) -> f64 {
        // Above 0: it is a median, and more than half of a row is marked, as of a stretch is beyond.
        let limit = LARGEST_IN_MEAN * stretch.size;
        let values = self.values(stretch.range.clone());
        values.map(|value| value.clamp(-limit, limit)).sum::<f64>() / stretch.range.len() as f64
    }

    /// Whether the difference comes from its healthy level, and returns there.
    fn has_edges(&self, stretch: &Stretch) -> bool {
        let Range { start, end } = stretch.range;
        if start < EDGE_SAMPLES || end + EDGE_SAMPLES > self.samples.len() {
            return false;
        }
        [start - EDGE_SAMPLES..start, end..end + EDGE_SAMPLES].into_iter().all(|edge| {
            let mean = self.values(edge).sum::<f64>() / EDGE_SAMPLES as f64;
            mean < EDGE_PART * stretch.size
        })
    }

    fn segment(&self, stretch: &Stretch) -> Segment {
        let Stretch { range, beyond, size } = stretch;
        if *beyond <= MOST_WILD {
            return Segment::Wild { samples: *beyond };
        }
        let begins = self.after_gap && range.start == 0;
        let ends = self.before_gap && range.end == self.samples.len();
        if begins || ends {
            return Segment::Cut { positive: self.positive };
        }
        let values: Vec<f64> = self.values(range.clone()).collect();
        if let Some(Overlap { edges, sizes }) = overlap(&values, *size) {
            let [second, first_end] = edges.map(|edge| range.start + edge);
            return Segment::Overlap([
                self.excursion(range.start..first_end, sizes[0], *size),
                self.excursion(second..range.end, sizes[1], *size),
            ]);
        }
        Segment::Excursion(self.excursion(range.clone(), self.mean(stretch), *size))
    }

    /// The excursion over `range` of the mean `level`, m, which was cut out with `size`, m.
    fn excursion(&self, range: Range<usize>, level: f64, size: f64) -> Excursion {
        let error = self.rest / (range.len() as f64).sqrt();
        let middle = range.start + range.len() / 2;
        Excursion {
            at: self.at + range.start as u64,
            // Its samples are beyond half of that size, whatever is in between.
            size: (level - error).max(STRETCH_PART * size),
            length: range.len() as u32,
            positive: self.positive,
            speed: self.samples[middle].velocity.abs(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const REST: f64 = 8.4e-5;

    /// What is found in these values, m, whose row is all but what is beside it on both sides.
    fn judged(values: &[f64]) -> Vec<Segment> {
        judged_from(values, 0)
    }

    /// The same, where all before `free` is in the stretch of another candidate.
    fn judged_from(values: &[f64], free: usize) -> Vec<Segment> {
        let sample =
            |value: &f64| Sample { residual: *value, variance: REST * REST, ..Sample::default() };
        let samples: Vec<Sample> = values.iter().map(sample).collect();
        let candidate = Candidate {
            samples: &samples,
            at: 100,
            row: BESIDE..samples.len() - BESIDE,
            free,
            positive: true,
            rest: REST,
            after_gap: false,
            before_gap: false,
        };
        let mut found = Vec::new();
        candidate.judge(&mut |segment| found.push(segment));
        found
    }

    /// These values between zeros on both sides.
    fn between_zeros(values: &[f64]) -> Vec<Segment> {
        judged(&[&[0.0; BESIDE], values, &[0.0; BESIDE]].concat())
    }

    /// Lengths of what is found in these values between zeros; 0 for what is not explained.
    fn lengths(values: &[f64]) -> Vec<u32> {
        let length = |segment: &Segment| match segment {
            Segment::Excursion(one) => one.length,
            Segment::Wild { samples } => *samples,
            _ => 0,
        };
        between_zeros(values).iter().map(length).collect()
    }

    #[test]
    fn one_sample_below_half_does_not_end_a_stretch_and_two_do() {
        let off = 4e-4;
        assert_eq!(lengths(&[off, off, off, 1e-4, off, off, off]), [7]);
        assert_eq!(lengths(&[off, off, off, 1e-4, 1e-4, off, off, off]), [3, 3]);
        // Exactly half, as four counts that become two, is below.
        let off = 6e-4;
        let half = 3e-4 + 1e-13;
        assert_eq!(lengths(&[off, off, off, off, half, half, off]), [4, 1]);
    }

    #[test]
    fn edges_are_where_least_squares_put_them() {
        let off = 4e-4;
        // Noise beyond half, behind a sample that is not.
        assert_eq!(lengths(&[off, off, off, off, 1e-5, 2.5e-4]), [4]);
        assert_eq!(lengths(&[2.5e-4, 1e-5, off, off, off, off]), [4]);
        assert_eq!(lengths(&[off, off, off, off, 1e-5, 3.95e-4]), [6]);
        // Marks beyond the edges do not make the size smaller.
        assert_eq!(lengths(&[1e-4, 2.5e-4, 6e-4, 6e-4, 6e-4, 1e-4]), [3]);
    }

    /// What is beyond half now and then only is not off in the mean.
    #[test]
    fn the_mean_has_to_be_off() {
        let off = 4e-4;
        assert_eq!(lengths(&[off, -2e-4, off, -2e-4, off]), [0]);
        assert_eq!(lengths(&[off, 0.0, off, 0.0, off]), [5]);
    }

    #[test]
    fn a_sample_is_in_one_stretch() {
        let values = [&[0.0; BESIDE - 2][..], &[4e-4; 10], &[0.0; BESIDE]].concat();
        for (free, length) in [(0, 10), (BESIDE - 1, 9), (BESIDE, 8)] {
            let [Segment::Excursion(one)] = judged_from(&values, free)[..] else {
                panic!("one excursion")
            };
            assert_eq!(one.length, length);
        }
    }

    #[test]
    fn up_to_two_samples_are_wild_however_large() {
        for size in [5e-4, 1e-3, 5e-3, 1.0] {
            // Neighbours that a window has marked, too.
            for neighbour in [0.0, 3e-5, 8e-5] {
                let values = [neighbour, neighbour, size, neighbour, neighbour, neighbour];
                let found = between_zeros(&values);
                assert_eq!(found, [Segment::Wild { samples: 1 }], "{size} {neighbour}");
            }
            assert_eq!(between_zeros(&[size, size]), [Segment::Wild { samples: 2 }]);
        }
    }

    /// A profile that is off in a thin cell is no excursion.
    #[test]
    fn a_small_one_needs_edges() {
        let of = |level: f64, beside: f64| {
            judged(&[vec![beside; BESIDE], vec![level; 12], vec![0.0; BESIDE]].concat())
        };
        assert!(matches!(of(2.5e-4, 8e-5)[..], [Segment::Excursion(_)]));
        assert_eq!(of(2.5e-4, 9e-5), [Segment::Unexplained { samples: 12 }]);
        // A large one does not: a transducer may drift within an excursion.
        assert!(matches!(of(3.5e-4, 1.5e-4)[..], [Segment::Excursion(_)]));
    }

    #[test]
    fn a_wild_sample_within_an_excursion_is_not_its_size() {
        let mut values = [4e-4; 10];
        values[4] = 0.5;
        let [Segment::Excursion(one)] = between_zeros(&values)[..] else { panic!("one excursion") };
        assert!(one.length == 10 && one.size < 5e-4, "{one:?}");
        values[4] = -0.5;
        let [Segment::Excursion(one)] = between_zeros(&values)[..] else { panic!("one excursion") };
        assert!(one.length == 10 && one.size >= 2e-4, "{one:?}");
    }

    #[test]
    fn two_that_overlap_are_two_entries() {
        let values = [[4e-4; 5], [8e-4; 5], [4e-4; 5]].concat();
        let [Segment::Overlap([one, other])] = between_zeros(&values)[..] else {
            panic!("two excursions")
        };
        let size = 4e-4 - REST / 10_f64.sqrt();
        for (excursion, at) in [(one, 107), (other, 112)] {
            assert_eq!((excursion.at, excursion.length), (at, 10));
            assert!((excursion.size - size).abs() < 1e-9, "{excursion:?}");
        }
    }
}
