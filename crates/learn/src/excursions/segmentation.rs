//! Divides the stream of one cylinder's difference into excursions, wild samples and core.
//!
//! Means of short windows mark samples that are off. Marked samples of one sign that follow each
//! other are a candidate, which `candidate` judges as a whole once it has ended. Everything else is
//! core. Only a ring of the last samples is kept, so that results come late by a bounded delay.

use super::candidate::{BESIDE, Candidate, Sample};
use super::segment::Segment;

/// Widths of the windows whose means mark samples, samples.
const WIDTHS: [u64; 3] = [1, 3, 7];

/// The widest of them, samples: with how many samples the mark of one is final.
const WIDEST: u64 = WIDTHS[2];

/// Mean of a window that marks, in its standard errors: one sample in millions, if it is healthy.
const MARKING_ERRORS: f64 = 5.0;

/// Least mean of a window that marks, m: twice the dead band of the detectors.
const LEAST_MEAN: f64 = 0.19e-3;

/// Distance of marked samples that belong together, samples: one in between may be unmarked.
const JOINED: u64 = 2;

/// Longest candidate that may be an excursion, samples: 22 s at 50 Hz.
pub const LONGEST_CANDIDATE: u64 = 1100;

/// Samples that are kept: the longest candidate, what is looked at beside it, and the samples until
/// its end is known.
const RING: u64 = LONGEST_CANDIDATE + 2 * BESIDE as u64 + JOINED + WIDEST;

// A candidate is judged with this many samples after it: enough for its last edge, and one more, so
// that only a gap lets what is looked at end with the newest sample.
const _: () = assert!(1 + (BESIDE as u64) < JOINED + WIDEST);

/// Largest residual and speed that are believed, m and m/s; beyond, sums would not stay finite.
const LARGEST: f64 = 1e3;

/// Marked samples of one sign that follow each other: places of the first and the last one.
#[derive(Clone, Copy, Debug)]
struct Row {
    first: u64,
    last: u64,
}

/// Divides one cylinder's difference into [`Segment`]s, sample by sample, in bounded memory.
#[derive(Clone, Debug)]
pub struct Segmentation {
    /// Deviation of the residual at rest σ0, m.
    rest: f64,
    /// Growth of the deviation with the speed, s.
    timing: f64,
    ring: Vec<Sample>,
    /// Place of the next sample.
    next: u64,
    /// Place of the first sample since the last gap.
    begin: u64,
    /// Place of the first sample whose mark is not final.
    settled: u64,
    /// Open rows: negative, positive.
    rows: [Option<Row>; 2],
    /// Place after the last stretch that was cut out of a candidate: negative, positive.
    ended: [u64; 2],
    /// The candidate that is judged, kept for its memory.
    candidate: Vec<Sample>,
}

/// A number that keeps sums finite.
fn bounded(value: f64) -> f64 {
    if value.is_nan() { 0.0 } else { value.clamp(-LARGEST, LARGEST) }
}

impl Segmentation {
    /// A segmentation of residuals of the deviation σ(v)² = `rest`² + (`timing` v)²; `rest` in m,
    /// `timing` in s.
    pub fn new(rest: f64, timing: f64) -> Self {
        Self {
            rest: bounded(rest.abs()),
            timing: bounded(timing),
            ring: vec![Sample::default(); RING as usize],
            next: 0,
            begin: 0,
            settled: 0,
            rows: [None; 2],
            ended: [0; 2],
            candidate: Vec::new(),
        }
    }

    /// Number of samples taken.
    pub const fn samples(&self) -> u64 {
        self.next
    }

    /// Takes the next sample: its `residual`, m, unweighted, beyond profile and baseline, and the
    /// rod's `velocity`, m/s. One that is not finite is a gap.
    pub fn push(&mut self, residual: f64, velocity: f64, mut found: impl FnMut(Segment)) {
        if !(residual.is_finite() && velocity.is_finite()) {
            return self.interrupt(found);
        }
        let (residual, velocity) = (bounded(residual), bounded(velocity));
        let variance = self.rest.powi(2) + (self.timing * velocity).powi(2);
        let sample = Sample { residual, velocity, variance, marked: false };
        *self.at_mut(self.next) = sample;
        self.next += 1;
        for width in WIDTHS {
            self.mark(width);
        }
        // The window of the widest width that ends here is the last one with its first sample.
        while self.settled + WIDEST <= self.next {
            self.settle(&mut found);
        }
    }

    /// Takes a gap: what was before says nothing of what comes.
    pub fn interrupt(&mut self, mut found: impl FnMut(Segment)) {
        while self.settled < self.next {
            self.settle(&mut found);
        }
        for positive in [false, true] {
            self.close(positive, &mut found);
        }
        if self.begin < self.next {
            self.release(self.next - 1, &mut found);
        }
        self.begin = self.next;
    }

    /// Takes the end of the stream.
    pub fn finish(&mut self, found: impl FnMut(Segment)) {
        self.interrupt(found);
    }

    fn at(&self, place: u64) -> &Sample {
        &self.ring[(place % RING) as usize]
    }

    fn at_mut(&mut self, place: u64) -> &mut Sample {
        &mut self.ring[(place % RING) as usize]
    }

    /// Marks the samples of the window of `width` that ends with the newest sample, if its mean is
    /// off: those that have the sign of the mean.
    fn mark(&mut self, width: u64) {
        if self.next - self.begin < width {
            return;
        }
        let window = self.next - width..self.next;
        let (mut sum, mut variance) = (0.0, 0.0);
        for sample in window.clone().map(|place| self.at(place)) {
            sum += sample.residual;
            variance += sample.variance;
        }
        let least = (LEAST_MEAN * width as f64).max(MARKING_ERRORS * variance.sqrt());
        if sum.abs() <= least {
            return;
        }
        for place in window {
            let sample = self.at_mut(place);
            sample.marked |= sample.residual * sum > 0.0;
        }
    }

    /// Settles the mark of the next sample: continues or closes rows, and releases the sample before.
    fn settle(&mut self, found: &mut impl FnMut(Segment)) {
        let place = self.settled;
        self.settled += 1;
        let Sample { residual, marked, .. } = *self.at(place);
        for positive in [false, true] {
            let row = &mut self.rows[usize::from(positive)];
            if marked && (residual > 0.0) == positive {
                row.get_or_insert(Row { first: place, last: place }).last = place;
            } else if row.is_some_and(|row| place >= row.last + JOINED) {
                self.close(positive, found);
            }
        }
        if place > self.begin {
            self.release(place - 1, found);
        }
    }

    /// Hands out the sample at `place`, the mark of whose neighbours is final. A sample between two
    /// marked ones is beside both, so that the marks of its neighbours decide.
    fn release(&self, place: u64, found: &mut impl FnMut(Segment)) {
        let beside = place.saturating_sub(1).max(self.begin)..(place + 2).min(self.settled);
        let Sample { residual, velocity, .. } = *self.at(place);
        found(if beside.into_iter().any(|place| self.at(place).marked) {
            Segment::Off { residual, velocity }
        } else {
            Segment::Core { residual, velocity }
        });
    }

    /// Judges the open row of a direction, if there is one: it has ended.
    fn close(&mut self, positive: bool, found: &mut impl FnMut(Segment)) {
        let Some(Row { first, last }) = self.rows[usize::from(positive)].take() else { return };
        let samples = last + 1 - first;
        if samples > LONGEST_CANDIDATE {
            return found(Segment::Overlong { samples });
        }
        let beside = BESIDE as u64;
        let from = first.saturating_sub(beside).max(self.begin);
        let to = (last + 1 + beside).min(self.next);
        let mut samples = std::mem::take(&mut self.candidate);
        samples.clear();
        samples.extend((from..to).map(|place| *self.at(place)));
        let ended = &mut self.ended[usize::from(positive)];
        let candidate = Candidate {
            samples: &samples,
            at: from,
            row: (first - from) as usize..(last + 1 - from) as usize,
            free: ended.saturating_sub(from) as usize,
            positive,
            rest: self.rest,
            after_gap: from == self.begin,
            before_gap: to == self.next,
        };
        if let Some(end) = candidate.judge(found) {
            *ended = from + end as u64;
        }
        self.candidate = samples;
    }
}

#[cfg(test)]
mod tests {
    use super::super::excursion::Excursion;
    use super::*;

    /// Samples by which a result is late at most: a candidate is judged when it has ended.
    const MOST_DELAY: u64 = LONGEST_CANDIDATE + JOINED + WIDEST;

    fn segments(residuals: &[f64]) -> Vec<Segment> {
        let mut segmentation = Segmentation::new(5e-5, 0.0);
        let mut found = Vec::new();
        for residual in residuals {
            segmentation.push(*residual, 0.1, |segment| found.push(segment));
        }
        segmentation.finish(|segment| found.push(segment));
        found
    }

    fn is_core(segment: &Segment) -> bool {
        matches!(segment, Segment::Core { .. })
    }

    /// A level between zeros: `before`, then `length` samples of `level`, then `after`.
    fn level(before: usize, length: usize, level: f64, after: usize) -> Vec<f64> {
        [vec![0.0; before], vec![level; length], vec![0.0; after]].concat()
    }

    #[test]
    fn a_level_is_an_excursion_and_its_surroundings_are_core() {
        let found = segments(&level(50, 10, -4e-4, 50));
        let excursions: Vec<_> =
            found.iter().filter(|it| matches!(it, Segment::Excursion(_))).collect();
        let size = 4e-4 - 5e-5 / 10_f64.sqrt();
        let [Segment::Excursion(one)] = excursions[..] else { panic!("{found:?}") };
        assert_eq!((one.at, one.length, one.positive, one.speed), (50, 10, false, 0.1));
        assert!((one.size - size).abs() < 1e-12, "{one:?}");
        // One sample on either side is not part of the core.
        assert_eq!(found.iter().filter(|it| is_core(it)).count(), 98);
    }

    #[test]
    fn a_constant_or_zero_stream_is_core() {
        for constant in [0.0, 1.5e-4, -1.8e-4] {
            assert!(segments(&vec![constant; 3000]).iter().all(is_core), "{constant}");
        }
        assert!(segments(&[]).is_empty());
        assert_eq!(segments(&[0.0]).len(), 1);
    }

    /// A lasting difference is a fault or a wrong profile; its length is not a healthy one.
    #[test]
    fn what_is_longer_than_the_ring_is_overlong() {
        let of = |length| {
            let mut found = segments(&level(20, length, 5e-4, 20));
            found.retain(|it| !matches!(it, Segment::Core { .. } | Segment::Off { .. }));
            found
        };
        let longest = LONGEST_CANDIDATE as usize;
        let [Segment::Excursion(one)] = of(longest)[..] else { panic!("{:?}", of(longest)) };
        assert_eq!(u64::from(one.length), LONGEST_CANDIDATE);
        assert_eq!(of(longest + 1), [Segment::Overlong { samples: LONGEST_CANDIDATE + 1 }]);
        assert_eq!(of(100_000), [Segment::Overlong { samples: 100_000 }]);
    }

    #[test]
    fn every_result_comes_within_the_delay() {
        for length in [1, 5, 40, LONGEST_CANDIDATE as usize] {
            let mut segmentation = Segmentation::new(5e-5, 0.0);
            let (mut pushed, mut handed, mut delay) = (0_u64, 0_u64, None);
            for residual in level(30, length, 5e-4, 60) {
                pushed += 1;
                segmentation.push(residual, 0.0, |segment| match segment {
                    Segment::Core { .. } | Segment::Off { .. } => handed += 1,
                    Segment::Excursion(Excursion { at, .. }) => delay = Some(pushed - at),
                    _ => delay = Some(pushed - 30),
                });
                assert!(pushed - handed <= WIDEST, "samples are handed out at once");
            }
            assert!(delay.is_some_and(|delay| delay <= MOST_DELAY), "{length}: {delay:?}");
        }
    }

    /// An excursion within which the stream begins or ends was not seen whole.
    #[test]
    fn a_gap_cuts_an_excursion() {
        let cut = Segment::Cut { positive: true };
        let of = |residuals: &[f64]| {
            let mut found = segments(residuals);
            found.retain(|it| !matches!(it, Segment::Core { .. } | Segment::Off { .. }));
            found
        };
        assert_eq!(of(&level(50, 8, 5e-4, 0)), [cut]);
        assert_eq!(of(&level(0, 8, 5e-4, 50)), [cut]);
        // Not a number is a gap, too, and both parts are cut.
        let mut broken = level(50, 16, 5e-4, 50);
        broken[58] = f64::NAN;
        assert_eq!(of(&broken), [cut, cut]);
        // Both edges were seen: one sample is enough, but not for a small one.
        assert!(matches!(of(&level(1, 8, 5e-4, 1))[..], [Segment::Excursion(_)]));
        let small = Segment::Unexplained { samples: 10 };
        assert_eq!(of(&level(1, 10, 2.5e-4, 1)), [small]);
        assert!(matches!(of(&level(9, 10, 2.5e-4, 9))[..], [Segment::Excursion(_)]));
    }

    #[test]
    fn nothing_is_marked_across_a_gap() {
        // Three samples of 0.28 mm are off, but not two and one.
        let deviation = 8.4e-5;
        let count = |gap: Option<usize>| {
            let mut segmentation = Segmentation::new(deviation, 0.0);
            let mut off = 0;
            let mut count = |segment| off += u32::from(matches!(segment, Segment::Off { .. }));
            for (place, residual) in level(20, 3, 2.8e-4, 20).into_iter().enumerate() {
                if Some(place) == gap {
                    segmentation.interrupt(&mut count);
                }
                segmentation.push(residual, 0.0, &mut count);
            }
            segmentation.finish(&mut count);
            off
        };
        assert_eq!((count(None), count(Some(22))), (5, 0));
    }

    #[test]
    fn no_number_panics_and_none_that_is_not_finite_comes_out() {
        let odd = [0.0, -0.0, 1e308, -1e308, 5e-324, f64::NAN, f64::INFINITY, 1e-3, -1e-3, 4e-4];
        for rest in odd {
            let mut segmentation = Segmentation::new(rest, rest);
            let mut check = |segment| match segment {
                Segment::Core { residual, velocity } | Segment::Off { residual, velocity } => {
                    assert!(residual.is_finite() && velocity.is_finite());
                }
                Segment::Excursion(Excursion { size, speed, .. }) => {
                    assert!(size > 0.0 && size.is_finite() && speed.is_finite());
                }
                _ => {}
            };
            for k in 0..20_000_usize {
                let (one, other) = (odd[k * k / 7 % 10], odd[k / 3 % 10]);
                segmentation.push(one, other, &mut check);
            }
            segmentation.finish(&mut check);
        }
    }
}
