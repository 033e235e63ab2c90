//! Excursions of transducers that fluctuate, gathered in the pass over the residuals, and the limits that follow.

use crate::excursions::{
    CoreNoise, CylinderPopulation, Excursion, HealthyCylinder, LimitLevels, LimitTable, MachineLaw,
    Population, Segment, Segmentation, SmallestStep, Summary,
};
use tertius_config::settings::CylinderExcursions;
use tertius_core::sequential::windows::WIDTHS;
use tertius_core::sequential::{ExcursionLimits, Noise};

/// Width of the bins of residuals outside of excursions, m: the run of a sample in a box is known to half of it.
const BIN: f64 = 2e-6;

/// Residuals outside of excursions are counted up to 2 mm; the few beyond it are in the last bin.
const BINS: usize = 1000;

/// Width of the classes of the speed, m/s.
const SPEED: f64 = 0.01;

/// Classes of the speed; the last one has all above.
const SPEEDS: usize = 64;

/// Part of the time that is the fastest.
const FASTEST: f64 = 0.1;

/// A longer stretch is no excursion of a sound transducer, s. One of the thesis's lasts 0.2 s; a step of 1 mm for 4 s that comes again and
/// again is a fault.
const LONGEST: f64 = 1.0;

/// A larger one is none either, m: what the thesis's thresholds find is a fault.
const LARGEST: f64 = 1e-3;

/// Judged time of a cylinder from which its rate of excursions can be learnt, s: 15 of them, where there are 0.05 a second.
const ENOUGH: f64 = 300.0;

/// Readings of a coarser resolution, m, show excursions that are none: where a rod is slow, rounding is alike from sample to sample. It is
/// the size of the smallest excursion.
const COARSE: f64 = 1.9e-4;

/// What the recording shows of one cylinder.
#[derive(Clone, Debug)]
pub(super) struct GatheredExcursions {
    segmentation: Segmentation,
    found: Found,
}

#[derive(Clone, Debug)]
struct Found {
    noise: Noise,
    resolution: f64,
    /// s.
    sample_time: f64,
    population: CylinderPopulation,
    /// Residuals outside of excursions, weighted to the scatter at rest, by bins.
    weighted: Vec<u64>,
    /// The same as they are, by classes of the speed.
    by_speed: Vec<Vec<u32>>,
    /// Squares of the velocity, m²/s².
    squares: f64,
}

/// The learnt excursions of one cylinder, and their limits.
#[derive(Clone, Debug, PartialEq)]
pub struct LearntExcursions {
    pub limits: ExcursionLimits,
    /// Of both transducers together, 1/s.
    pub rate: f64,
    /// Those by which C1 − C2 rises, and those by which it falls.
    pub directions: [u64; 2],
    /// Median, 95 % quantile and largest size of the machine's, m.
    pub sizes: [f64; 3],
    /// The same of their lengths, s.
    pub lengths: [f64; 3],
    /// The smallest steps that the limits find within some times.
    pub smallest: [SmallestStep; 3],
}

impl LearntExcursions {
    /// As the configuration has it.
    pub(super) fn table(&self) -> CylinderExcursions {
        let Self { limits, rate, sizes: [_, size, _], .. } = self;
        let [low, high] = limits.boxes[0];
        let run = |limit: &Option<u16>| u64::from(limit.unwrap_or(0));
        CylinderExcursions {
            level: limits.level,
            rate: *rate,
            size: *size,
            longest: limits.longest.into(),
            first_box: low,
            box_width: high - low,
            runs: limits.runs.iter().flatten().map(run).collect(),
            clips: limits.clips,
            sums: limits.sums.concat(),
            squares: limits.squares.to_vec(),
            elsewhere: limits.elsewhere.to_vec(),
        }
    }
}

impl GatheredExcursions {
    /// For residuals with this `noise`, and readings of these resolutions, m, every `sample_time` seconds.
    pub(super) fn new(noise: Noise, [c1, c2]: [f64; 2], sample_time: f64) -> Self {
        Self {
            segmentation: Segmentation::new(noise.rest, noise.timing),
            found: Found {
                noise,
                resolution: c1.max(c2),
                sample_time,
                population: CylinderPopulation::default(),
                weighted: vec![0; BINS],
                by_speed: vec![vec![0; BINS]; SPEEDS],
                squares: 0.0,
            },
        }
    }

    /// Takes a residual beyond the baseline, m, at this velocity, m/s.
    pub(super) fn take(&mut self, residual: f64, velocity: f64) {
        let Self { segmentation, found } = self;
        segmentation.push(residual, velocity, |segment| found.take(&segment));
    }

    /// Takes a gap: an excursion does not go on across it.
    pub(super) fn interrupt(&mut self) {
        let Self { segmentation, found } = self;
        segmentation.interrupt(|segment| found.take(&segment));
    }
}

impl Found {
    fn take(&mut self, segment: &Segment) {
        match segment {
            Segment::Excursion(one) if !self.is_sound(one) => {
                self.population.take(&Segment::Unexplained { samples: one.length });
            }
            Segment::Overlap(both) if !both.iter().all(|one| self.is_sound(one)) => {
                both.iter().for_each(|one| self.take(&Segment::Excursion(*one)));
            }
            _ => self.population.take(segment),
        }
        if let Segment::Core { residual, velocity } = segment {
            let bin = |residual: f64| ((residual.abs() / BIN) as usize).min(BINS - 1);
            let class = ((velocity.abs() / SPEED) as usize).min(SPEEDS - 1);
            self.weighted[bin(self.noise.share(*velocity) * residual)] += 1;
            self.by_speed[class][bin(*residual)] += 1;
            self.squares += velocity * velocity;
        }
    }

    /// Whether a sound transducer has such an excursion.
    fn is_sound(&self, excursion: &Excursion) -> bool {
        f64::from(excursion.length) * self.sample_time <= LONGEST && excursion.size <= LARGEST
    }

    /// Counts of the residuals of the fastest part of the time.
    fn fastest(&self) -> Vec<u64> {
        let all: u64 = self.weighted.iter().sum();
        let (mut counts, mut taken) = (vec![0; BINS], 0);
        for class in self.by_speed.iter().rev() {
            if taken as f64 >= FASTEST * all as f64 {
                break;
            }
            taken += class.iter().map(|count| u64::from(*count)).sum::<u64>();
            counts.iter_mut().zip(class).for_each(|(sum, count)| *sum += u64::from(*count));
        }
        counts
    }

    fn healthy(&self, law: &MachineLaw, index: usize) -> Option<HealthyCylinder> {
        Some(HealthyCylinder {
            law: law.laws[index].clone()?,
            sizes_95: law.size_95,
            weighted: CoreNoise::of_counts(BIN, &self.weighted)?,
            fastest: CoreNoise::of_counts(BIN, &self.fastest())?,
            rest: self.noise.rest,
            timing: self.noise.timing,
            mean_square_velocity: self.squares / self.population.core().max(1) as f64,
            wild_share: law.wild_shares[index],
        })
    }
}

/// The limits of every cylinder at this `level`, nats; `None` of all of them where no transducer fluctuates, and of one that was judged
/// for too short a time, or is too coarse.
pub(super) fn learn(
    gathered: Vec<Option<&GatheredExcursions>>,
    level: f64,
    sample_time: f64,
) -> Vec<Option<LearntExcursions>> {
    let finished = |one: &GatheredExcursions| {
        let mut one = one.clone();
        one.interrupt();
        Some(one.found).filter(|found| found.resolution < COARSE)
    };
    let all: Vec<Option<Found>> = gathered.into_iter().map(|one| finished(one?)).collect();
    let none = CylinderPopulation::default();
    let populations: Vec<_> =
        all.iter().map(|found| found.as_ref().map_or(&none, |it| &it.population).clone()).collect();
    let population = Population::new(&populations);
    let (law, summary) = (population.law(), Summary::new(&population));
    if summary.coincidences.are_too_many() {
        // Both transducers of a cylinder fluctuate from one cause, and the law does not hold.
        return vec![None; all.len()];
    }
    let [_, _, longest] = summary.lengths;
    let learnt = |(index, found): (usize, &Option<Found>)| {
        let found = found.as_ref()?;
        let judged = found.population.judged() as f64 * sample_time;
        let healthy = found.healthy(&law, index).filter(|_| judged >= ENOUGH && longest > 0.0)?;
        let table = LimitTable::of(&healthy, &LimitLevels::of(level), &WIDTHS);
        Some(LearntExcursions {
            limits: limits(&table, level, found.noise.rest, longest)?,
            rate: summary.cylinders[index].per_minute(sample_time) / 60.0,
            directions: [summary.cylinders[index].up, summary.cylinders[index].down],
            sizes: summary.sizes,
            lengths: summary.lengths.map(|samples| samples * sample_time),
            smallest: table.smallest_step(&WIDTHS, sample_time),
        })
    };
    all.iter().enumerate().map(learnt).collect()
}

/// The limits as a detector takes them.
fn limits(table: &LimitTable, level: f64, rest: f64, longest: f64) -> Option<ExcursionLimits> {
    let widths = |limits: &[f64]| limits.try_into().ok();
    let [first, second, third] = &table.sums[..] else { return None };
    Some(ExcursionLimits {
        level,
        rest,
        longest: longest.clamp(1.0, f64::from(u16::MAX)) as u16,
        boxes: table.boxes,
        runs: table.runs,
        clips: table.clips[..].try_into().ok()?,
        sums: [widths(first)?, widths(second)?, widths(third)?],
        squares: widths(&table.squares)?,
        elsewhere: widths(&table.elsewhere)?,
    })
}
