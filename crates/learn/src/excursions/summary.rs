//! What a report says of the excursions of a machine.

use super::chains::{LEAST_SIZE_RATIO, may_be_two};
use super::population::{Kept, Population};
use super::quantiles::poisson_quantile;
use crate::order_statistics::quantile;

/// Chance that coincidences are not more than expected.
const COINCIDENCE_QUANTILE: f64 = 0.99;

/// Most coincidences that are expected.
const MOST_COINCIDENCES: u32 = 1_000_000;

/// How often a cylinder's difference is off.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frequency {
    /// Number of excursions up.
    pub up: u64,
    /// Number of excursions down.
    pub down: u64,
    /// Number of samples.
    pub judged: u64,
}

impl Frequency {
    /// Excursions per minute of samples every `sample_time`, s.
    pub fn per_minute(&self, sample_time: f64) -> f64 {
        let minutes = self.judged as f64 * sample_time / 60.0;
        if minutes > 0.0 { (self.up + self.down) as f64 / minutes } else { 0.0 }
    }
}

/// Excursions of both transducers of a cylinder at once, which add up in the difference.
///
/// Both up or both down cancel, and are not seen; they are not expected here either. Of those that
/// overlap by a few samples only, or by all but a few, some are not seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coincidences {
    /// Seen: two that overlap, or one of about twice the ordinary size.
    pub seen: u64,
    /// Expected of two transducers that are independent of each other and share alike.
    pub expected: f64,
    /// 99 % quantile of what is expected with the chances of the law. More have a common cause, and
    /// the law does not hold.
    pub most: u64,
}

/// What a report says of the excursions of a machine: sizes in m, lengths in samples, both 0 without
/// excursions.
#[derive(Clone, Debug, PartialEq)]
pub struct Summary {
    /// How often, of each cylinder.
    pub cylinders: Vec<Frequency>,
    /// Median, 95 % quantile and largest, m.
    pub sizes: [f64; 3],
    /// Median, 95 % quantile and longest, samples.
    pub lengths: [f64; 3],
    /// Two at once.
    pub coincidences: Coincidences,
    /// Number of excursions that were taken for wild samples side by side.
    pub dropped: u64,
}

impl Summary {
    /// What a report says of this `population`.
    pub fn new(population: &Population) -> Self {
        let of = |sorted: &[f64]| [0.5, 0.95, 1.0].map(|share| quantile(sorted, share));
        let frequency = |one: &Kept| {
            let [down, up] = one.directions;
            Frequency { up, down, judged: one.judged }
        };
        Self {
            cylinders: population.cylinders.iter().map(frequency).collect(),
            sizes: of(&population.sizes),
            lengths: of(&population.lengths),
            coincidences: Coincidences::new(population),
            dropped: population.cylinders.iter().map(|one| one.dropped).sum(),
        }
    }

    /// Excursions per minute of all cylinders' time, with samples every `sample_time`, s: of one
    /// cylinder in the mean.
    pub fn per_minute(&self, sample_time: f64) -> f64 {
        let none = Frequency { up: 0, down: 0, judged: 0 };
        let all = self.cylinders.iter().fold(none, |sum, one| Frequency {
            up: sum.up + one.up,
            down: sum.down + one.down,
            judged: sum.judged + one.judged,
        });
        all.per_minute(sample_time)
    }
}

impl Coincidences {
    fn new(population: &Population) -> Self {
        let Population { cylinders, sizes, .. } = population;
        let with_law = || cylinders.iter().filter(|one| one.has_law);
        let overlaps: u64 = with_law().map(|one| one.overlaps).sum();
        let doubles = sizes.iter().filter(|size| may_be_two(sizes, **size, LEAST_SIZE_RATIO));
        // One begins with any sample of the other, or the other with any of it.
        let shifts = (2.0 * population.mean_length() - 1.0).max(0.0);
        let of_chances = |one: &Kept, chances: [f64; 2]| {
            let squares: f64 = chances.iter().map(|chance| chance * chance).sum();
            one.judged as f64 * squares * shifts
        };
        // Half of those of one direction are of either transducer.
        let share =
            |one: &Kept| one.directions.map(|count| 0.5 * count as f64 / one.judged.max(1) as f64);
        let expected = with_law().map(|one| of_chances(one, share(one))).sum();
        let chances = population.chances();
        let by_law = cylinders.iter().zip(chances);
        let mean: f64 =
            by_law.filter_map(|(one, chance)| Some(of_chances(one, [chance?; 2]))).sum();
        Self {
            seen: overlaps + doubles.count() as u64,
            expected,
            most: u64::from(poisson_quantile(COINCIDENCE_QUANTILE, mean, MOST_COINCIDENCES)),
        }
    }

    /// Whether more were seen than independent transducers make: both fluctuate from one cause.
    pub const fn are_too_many(&self) -> bool {
        self.seen > self.most
    }
}
