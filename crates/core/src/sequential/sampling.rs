//! Whether both transducers are sampled as they were when they were calibrated.
//!
//! Another time between the samples of C1 and C2 leaves residuals that go with the velocity, in all
//! cylinders alike. It is a matter of time and of no transducer: what most cylinders show is taken
//! away from the residuals, or expected of them, and told for itself. A fault of one transducer is in
//! one cylinder and moves no median.

use super::parameters::SamplingParameters;
use super::skew::Seen;

const P: &SamplingParameters = &SamplingParameters::DEFAULT;

/// More cylinders than these are not asked.
const MOST: usize = 16;

/// How far apart in time C1 and C2 are sampled, beside what the calibration has seen.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Apart {
    /// C2 sooner than C1, s.
    pub mean: f64,
    /// Standard deviation of what chance adds, s.
    pub spread: f64,
    /// The newest half second is sure that chance adds more, and that is not told yet.
    pub changing: bool,
    /// It is not what the calibration has seen, and that is told.
    pub changed: bool,
}

impl Apart {
    /// The timing that a cylinder is judged with, s, whose own is `known`.
    pub fn timing(&self, known: f64) -> f64 {
        if self.spread > P.more * known { P.margin * self.spread } else { known }
    }
}

/// What one cylinder says.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Said {
    /// In the newest half second, and in the newest half minute ([`super::skew::Skew`]).
    pub seen: [Seen; 2],
    /// The timing that was calibrated, s.
    pub known: f64,
}

/// Follows the cylinders of a machine.
#[derive(Clone, Debug, Default)]
pub struct Sampling {
    changed: bool,
}

impl Sampling {
    /// What the cylinders say together, and whether that is from now on something to tell (`true`) or
    /// nothing any more. `None` where they are too few.
    pub fn judge(
        &mut self,
        cylinders: impl Iterator<Item = Said>,
    ) -> Option<(Apart, Option<bool>)> {
        let (mut said, mut count) = ([Said::default(); MOST], 0);
        for (place, one) in said.iter_mut().zip(cylinders) {
            *place = one;
            count += 1;
        }
        let said = &said[..count];
        if count < P.least_cylinders {
            return None;
        }
        let [fast, slow] = [0, 1].map(|which: usize| Middle {
            mean: middle(said, |one| one.seen[which].mean),
            square: middle(said, |one| one.seen[which].square),
        });
        let known = middle(said, |one| one.known);
        let mean =
            if (fast.mean - slow.mean).abs() > P.least_apart { fast.mean } else { slow.mean };
        let mean = if mean.abs() > P.least_apart { mean } else { 0.0 };
        let told = self.tell(said, slow, known);
        let limit = limit(known);
        let perhaps = !self.changed && fast.may_be_beyond(limit);
        let changing = told == Some(true) || perhaps && surely(said, 0, limit);
        let spread = libm::sqrt(fast.square.max(slow.square).max(0.0));
        Some((Apart { mean, spread, changing, changed: self.changed }, told))
    }

    /// Of what is known for sure.
    fn tell(&mut self, said: &[Said], slow: Middle, known: f64) -> Option<bool> {
        let limit = limit(known);
        let moved = || {
            let error = libm::sqrt(middle(said, |one| one.seen[1].mean_variance));
            slow.mean.abs() - P.sure * error > P.least_apart
        };
        let now = if self.changed {
            let over = slow.mean.abs() < P.over * P.least_apart && slow.square < limit * limit;
            !over
        } else {
            slow.mean.abs() > P.least_apart && moved()
                || slow.may_be_beyond(limit) && surely(said, 1, limit)
        };
        (core::mem::replace(&mut self.changed, now) != now).then_some(now)
    }
}

/// Of the cylinders.
#[derive(Clone, Copy, Debug)]
struct Middle {
    mean: f64,
    square: f64,
}

impl Middle {
    /// What each is sure of is less than what it has seen, and so are their medians: mostly one look tells.
    fn may_be_beyond(&self, limit: f64) -> bool {
        self.square > limit * limit
    }
}

/// The scatter that a timing of `known`, s, is taken to be exceeded by, s.
fn limit(known: f64) -> f64 {
    P.least_apart.max(P.more * known)
}

/// Chance adds more than `limit`, s, for sure, as the newest half second (0) or half minute (1) has it.
#[cold]
fn surely(said: &[Said], which: usize, limit: f64) -> bool {
    let least = |one: &Said| {
        let seen = one.seen[which];
        seen.square - P.sure * libm::sqrt(seen.square_variance)
    };
    middle(said, least) > limit * limit
}

/// The lower median.
fn middle(said: &[Said], of: impl Fn(&Said) -> f64) -> f64 {
    // Integers in the order of the numbers, which are compared at once.
    let key = |bits: i64| bits ^ ((bits >> 63) as u64 >> 1) as i64;
    let mut keys = [0; MOST];
    for (count, one) in said.iter().enumerate().take(MOST) {
        let one = key(of(one).to_bits() as i64);
        let mut place = count;
        while place > 0 && keys[place - 1] > one {
            keys[place] = keys[place - 1];
            place -= 1;
        }
        keys[place] = one;
    }
    f64::from_bits(key(keys[(said.len() - 1) / 2]) as u64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    fn said(mean: f64, spread: f64) -> Said {
        let (square, square_variance) = (spread * spread, 1e-18);
        let seen = Seen { mean, mean_variance: 1e-10, square, square_variance };
        Said { seen: [seen; 2], known: 1e-4 }
    }

    fn judge(sampling: &mut Sampling, all: &[Said]) -> Option<(Apart, Option<bool>)> {
        sampling.judge(all.iter().copied())
    }

    #[test]
    fn what_most_cylinders_show_is_told_once_and_when_it_is_over() {
        let mut sampling = Sampling::default();
        let (healthy, jitter) = (said(1e-5, 1e-4), said(0.0, 5e-4));
        assert_eq!(judge(&mut sampling, &[healthy; 6]).map(|it| it.1), Some(None));
        let (apart, told) = judge(&mut sampling, &[jitter; 6]).expect("they are enough");
        assert_eq!((apart.mean, apart.spread, told), (0.0, 5e-4, Some(true)));
        assert!(apart.changing);
        assert!((apart.timing(2e-4) - 1.15 * 5e-4).abs() < 1e-12 && apart.timing(5e-4) == 5e-4);
        let (apart, told) = judge(&mut sampling, &[jitter; 6]).expect("they are enough");
        assert_eq!((apart.changing, told), (false, None), "it is known by now");
        assert_eq!(judge(&mut sampling, &[healthy; 6]).map(|it| it.1), Some(Some(false)));
        let skew = judge(&mut sampling, &[said(-3e-4, 1e-4); 6]);
        assert_eq!(skew.map(|(apart, told)| (apart.mean, told)), Some((-3e-4, Some(true))));
    }

    #[test]
    fn the_middle_is_that_of_those_in_order() {
        let mut rng = ChaCha8Rng::seed_from_u64(4);
        for count in 1..=MOST {
            let said: Vec<Said> =
                (0..count).map(|_| said(rng.random_range(-1.0..1.0), 0.0)).collect();
            let mut means: Vec<f64> = said.iter().map(|one| one.seen[0].mean).collect();
            means.sort_unstable_by(f64::total_cmp);
            assert_eq!(middle(&said, |one| one.seen[0].mean), means[(count - 1) / 2], "{means:?}");
        }
    }

    #[test]
    fn two_cylinders_of_six_are_no_majority_and_two_alone_have_none() {
        let (healthy, off) = (said(0.0, 1e-4), said(2e-3, 2e-3));
        let (apart, told) =
            judge(&mut Sampling::default(), &[off, healthy, healthy, off, healthy, healthy])
                .expect("they are enough");
        assert_eq!((apart, told), (Apart { spread: 1e-4, ..Apart::default() }, None));
        assert_eq!(judge(&mut Sampling::default(), &[off; 2]), None);
    }
}
