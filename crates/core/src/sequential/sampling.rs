//! Tests whether both transducers are sampled as they were when they were calibrated.
//!
//! A changed time between the samples of C1 and C2 leaves residuals in proportion to the velocity,
//! in all cylinders alike. No transducer is at fault then: what most cylinders show is subtracted
//! from the residuals, or added to their expected scatter, and reported separately. A fault of one
//! transducer affects one cylinder and moves no median.

use super::parameters::SamplingParameters;
use super::skew::Seen;
use crate::state::whole;

const P: &SamplingParameters = &SamplingParameters::DEFAULT;

/// Time between the samples of C1 and C2 beyond what the calibration has seen.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Apart {
    /// Mean time by which C2 is sampled sooner than C1, s.
    pub mean: f64,
    /// Standard deviation of its random part, s.
    pub spread: f64,
    /// Whether the newest half second surely shows a larger random part, before that is reported.
    pub changing: bool,
    /// Whether the time differs from the calibration, and this was reported.
    pub changed: bool,
}

impl Apart {
    /// The timing with which a cylinder is judged, s, whose own is `known`.
    pub fn timing(&self, known: f64) -> f64 {
        if self.spread > P.more * known { P.margin * self.spread } else { known }
    }
}

/// Observation of one cylinder.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SamplingEvidence {
    /// Observations of the newest half second, and of the newest half minute
    /// ([`super::skew::Skew`]).
    pub seen: [Seen; 2],
    /// Calibrated timing, s.
    pub known: f64,
}

/// Follows the cylinders of a machine.
#[derive(Clone, Debug, Default)]
pub struct Sampling {
    changed: bool,
}

whole! { Sampling { changed } }

impl Sampling {
    /// Most cylinders that are asked.
    pub const MOST_CYLINDERS: usize = 16;

    /// The common result of all cylinders, and whether it begins (`true`) or ends to be reportable.
    /// `None` where there are too few cylinders.
    pub fn judge(
        &mut self,
        cylinders: impl Iterator<Item = SamplingEvidence>,
    ) -> Option<(Apart, Option<bool>)> {
        let (mut evidence, mut count) =
            ([SamplingEvidence::default(); Sampling::MOST_CYLINDERS], 0);
        for (place, one) in evidence.iter_mut().zip(cylinders) {
            *place = one;
            count += 1;
        }
        let evidence = &evidence[..count];
        if count < P.least_cylinders {
            return None;
        }
        let [fast, slow] = [0, 1].map(|which: usize| Middle {
            mean: middle(evidence, |one| one.seen[which].mean),
            square: middle(evidence, |one| one.seen[which].square),
        });
        let known = middle(evidence, |one| one.known);
        let mean =
            if (fast.mean - slow.mean).abs() > P.least_apart { fast.mean } else { slow.mean };
        let mean = if mean.abs() > P.least_apart { mean } else { 0.0 };
        let change = self.judge_change(evidence, slow, known);
        let limit = limit(known);
        let perhaps = !self.changed && fast.may_be_beyond(limit);
        let changing = change == Some(true) || perhaps && surely(evidence, 0, limit);
        let spread = libm::sqrt(fast.square.max(slow.square).max(0.0));
        Some((Apart { mean, spread, changing, changed: self.changed }, change))
    }

    /// Reports what is known for sure.
    fn judge_change(
        &mut self,
        evidence: &[SamplingEvidence],
        slow: Middle,
        known: f64,
    ) -> Option<bool> {
        let limit = limit(known);
        let moved = || {
            let error = libm::sqrt(middle(evidence, |one| one.seen[1].mean_variance));
            slow.mean.abs() - P.sure * error > P.least_apart
        };
        let now = if self.changed {
            let over = slow.mean.abs() < P.over * P.least_apart && slow.square < limit * limit;
            !over
        } else {
            slow.mean.abs() > P.least_apart && moved()
                || slow.may_be_beyond(limit) && surely(evidence, 1, limit)
        };
        (core::mem::replace(&mut self.changed, now) != now).then_some(now)
    }
}

/// Medians over the cylinders.
#[derive(Clone, Copy, Debug)]
struct Middle {
    mean: f64,
    square: f64,
}

impl Middle {
    /// Whether the scatter may exceed `limit`: each value known for sure is less than the one seen,
    /// and so are their medians, so mostly this one comparison is enough.
    fn may_be_beyond(&self, limit: f64) -> bool {
        self.square > limit * limit
    }
}

/// Limit beyond which the scatter exceeds a timing of `known`, s, in s.
fn limit(known: f64) -> f64 {
    P.least_apart.max(P.more * known)
}

/// Whether the random part surely exceeds `limit`, s, by the newest half second (0) or half minute
/// (1).
#[cold]
fn surely(evidence: &[SamplingEvidence], which: usize, limit: f64) -> bool {
    let least = |one: &SamplingEvidence| {
        let seen = one.seen[which];
        seen.square - P.sure * libm::sqrt(seen.square_variance)
    };
    middle(evidence, least) > limit * limit
}

/// The lower median.
fn middle(evidence: &[SamplingEvidence], of: impl Fn(&SamplingEvidence) -> f64) -> f64 {
    // Integers in the order of the numbers, which are compared at once.
    let key = |bits: i64| bits ^ ((bits >> 63) as u64 >> 1) as i64;
    let mut keys = [0; Sampling::MOST_CYLINDERS];
    for (count, one) in evidence.iter().enumerate().take(Sampling::MOST_CYLINDERS) {
        let one = key(of(one).to_bits() as i64);
        let mut place = count;
        while place > 0 && keys[place - 1] > one {
            keys[place] = keys[place - 1];
            place -= 1;
        }
        keys[place] = one;
    }
    f64::from_bits(key(keys[(evidence.len() - 1) / 2]) as u64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    fn evidence_of(mean: f64, spread: f64) -> SamplingEvidence {
        let (square, square_variance) = (spread * spread, 1e-18);
        let seen = Seen { mean, mean_variance: 1e-10, square, square_variance };
        SamplingEvidence { seen: [seen; 2], known: 1e-4 }
    }

    fn judge(sampling: &mut Sampling, all: &[SamplingEvidence]) -> Option<(Apart, Option<bool>)> {
        sampling.judge(all.iter().copied())
    }

    #[test]
    fn what_most_cylinders_show_is_told_once_and_when_it_is_over() {
        let mut sampling = Sampling::default();
        let (healthy, jitter) = (evidence_of(1e-5, 1e-4), evidence_of(0.0, 5e-4));
        assert_eq!(judge(&mut sampling, &[healthy; 6]).map(|it| it.1), Some(None));
        let (apart, change) = judge(&mut sampling, &[jitter; 6]).expect("they are enough");
        assert_eq!((apart.mean, apart.spread, change), (0.0, 5e-4, Some(true)));
        assert!(apart.changing);
        assert!((apart.timing(2e-4) - 1.15 * 5e-4).abs() < 1e-12 && apart.timing(5e-4) == 5e-4);
        let (apart, change) = judge(&mut sampling, &[jitter; 6]).expect("they are enough");
        assert_eq!((apart.changing, change), (false, None), "it is known by now");
        assert_eq!(judge(&mut sampling, &[healthy; 6]).map(|it| it.1), Some(Some(false)));
        let skew = judge(&mut sampling, &[evidence_of(-3e-4, 1e-4); 6]);
        assert_eq!(skew.map(|(apart, change)| (apart.mean, change)), Some((-3e-4, Some(true))));
    }

    #[test]
    fn what_may_be_chance_is_not_told() {
        for (mean, spread) in [(-3e-4, 1e-4), (3e-4, 1e-4), (0.0, 5e-4)] {
            let sure = evidence_of(mean, spread);
            let vague = Seen { mean_variance: 1e-6, square_variance: 1e-12, ..sure.seen[0] };
            let mut sampling = Sampling::default();
            let change = judge(&mut sampling, &[SamplingEvidence { seen: [vague; 2], ..sure }; 6]);
            assert_eq!(change.map(|(apart, change)| (apart.changing, change)), Some((false, None)));
            assert_eq!(judge(&mut sampling, &[sure; 6]).map(|it| it.1), Some(Some(true)));
        }
    }

    #[test]
    fn the_middle_is_that_of_those_in_order() {
        let mut rng = ChaCha8Rng::seed_from_u64(4);
        for count in 1..=Sampling::MOST_CYLINDERS {
            let evidence: Vec<SamplingEvidence> =
                (0..count).map(|_| evidence_of(rng.random_range(-1.0..1.0), 0.0)).collect();
            let mut means: Vec<f64> = evidence.iter().map(|one| one.seen[0].mean).collect();
            means.sort_unstable_by(f64::total_cmp);
            assert_eq!(
                middle(&evidence, |one| one.seen[0].mean),
                means[(count - 1) / 2],
                "{means:?}"
            );
        }
    }

    #[test]
    fn two_cylinders_of_six_are_no_majority_and_two_alone_have_none() {
        let (healthy, off) = (evidence_of(0.0, 1e-4), evidence_of(2e-3, 2e-3));
        let (apart, change) =
            judge(&mut Sampling::default(), &[off, healthy, healthy, off, healthy, healthy])
                .expect("they are enough");
        assert_eq!((apart, change), (Apart { spread: 1e-4, ..Apart::default() }, None));
        assert_eq!(judge(&mut Sampling::default(), &[off; 2]), None);
    }
}
