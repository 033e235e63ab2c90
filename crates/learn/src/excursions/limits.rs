//! The limits of a cylinder: what its residual reaches in health less often than wanted.
//!
//! They follow from what its healthy transducers do: their excursions, their noise and their wild samples. An alarm is
//! a residual beyond any of them, so that at run time a table is all there is to compare with.

use super::law::Law;
use super::noise::CoreNoise;
use super::renewal::MAX_WIDTH;
use super::runs::{RunLimits, boxes};
use super::sums::{SumLimits, clips};
use super::survival::Survival;
use tertius_core::sequential::excursions::{BOXES, STRAYS};

/// Largest deviation and size that are taken, m: longer than any stroke. A larger one is an error of the input.
const MAX_LENGTH: f64 = 10.0;

/// Steps that are tried for the table of the smallest ones: their distance, m, and their number.
const STEP: f64 = 0.05e-3;
const STEPS: u32 = 200;
/// Times within which the table's steps are found, s.
const WITHIN: [f64; 3] = [0.1, 0.3, 1.0];
/// Most samples after the step that are looked at.
const MAX_SAMPLES: f64 = 1e6;
/// Part of a sample that a time may be short of, by rounding.
const ROUNDING: f64 = 1e-6;

/// What the bound of a sum of noise is above the rate that it is seen at, nats: by simulation.
const OF_NOISE: f64 = 3.0;
/// Where two excursions coincide their sum has one level, and the bound is nearly reached: by simulation.
const OF_EXCURSIONS: f64 = 0.5;
/// Two directions, each with boxes of its own, of which neighbours are filled together.
const OF_RUNS: f64 = 1.0;

/// What was learnt of a cylinder in health.
#[derive(Clone, Debug, PartialEq)]
pub struct HealthyCylinder {
    /// Excursions of its transducers.
    pub law: Law,
    /// Size that 95 % of the excursions do not exceed, m.
    pub sizes_95: f64,
    /// Residuals outside of excursions times σ0/σ(v): weighted to the deviation at rest.
    pub weighted: CoreNoise,
    /// Residuals outside of excursions as they are, of the fastest tenth of the time.
    pub fastest: CoreNoise,
    /// Deviation at rest σ0, m.
    pub rest: f64,
    /// Deviation of the time between the readings s, s.
    pub timing: f64,
    /// Mean square of the velocity, m²/s².
    pub mean_square_velocity: f64,
    /// Measured share of wild samples.
    pub wild_share: f64,
}

/// How rarely limits are reached: less than once in e^level samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LimitLevels {
    /// Sums of the first clip, squares and counts, nats.
    pub sums: f64,
    /// Sums of the wider clips where there are excursions, nats. Two excursions at once have one level, so that the bound is
    /// nearly reached; others are seldom near theirs.
    pub wide_clips: f64,
    /// Runs, nats.
    pub runs: f64,
}

impl LimitLevels {
    /// The levels for detectors of this `level`, nats: that of a rate at which a single one of them is exceeded.
    ///
    /// Of a mean of noise neighbouring windows and samples exceed theirs together, so that the bound is never reached. Of runs there are
    /// as many limits as directions.
    pub fn of(level: f64) -> Self {
        Self { sums: level - OF_NOISE, wide_clips: level + OF_EXCURSIONS, runs: level + OF_RUNS }
    }
}

/// The limits of a cylinder, each for both directions. What is beyond a limit is an alarm.
#[derive(Clone, Debug, PartialEq)]
pub struct LimitTable {
    /// Ends of the boxes, m: a residual as it is lies in a box if it is above the first and not above the second.
    pub boxes: [[f64; 2]; BOXES],
    /// Least lengths of a run in each box, samples, with none, one and two samples outside; those do not count for the
    /// length. `None`: no run is an alarm.
    pub runs: [[Option<u16>; STRAYS]; BOXES],
    /// Clips, m: two without excursions, three with.
    pub clips: Vec<f64>,
    /// Limits of the sums of weighted residuals for each clip and width, m.
    pub sums: Vec<Vec<f64>>,
    /// Limits of the sums of squares of weighted residuals, clipped to the first clip, for each width, m².
    pub squares: Vec<f64>,
    /// Limits of the number of samples off and elsewhere than the one before, for each width.
    pub elsewhere: Vec<f64>,
}

/// The smallest step that is found within a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SmallestStep {
    /// Time from the first sample with the step, s.
    pub within: f64,
    /// Size from which on all steps are found, m; `None` where none of those tried is.
    pub size: Option<f64>,
}

impl LimitTable {
    /// The limits of `healthy` at these levels, for windows of these `widths`, samples. Windows wider than `MAX_WIDTH` have
    /// limits that nothing reaches.
    pub fn of(healthy: &HealthyCylinder, levels: &LimitLevels, widths: &[usize]) -> Self {
        Self::compute(healthy, levels, widths, true)
    }

    /// `overlaps`: whether two excursions at once are counted by themselves ([`SumLimits::with_overlaps`]).
    pub(super) fn compute(
        healthy: &HealthyCylinder,
        levels: &LimitLevels,
        widths: &[usize],
        overlaps: bool,
    ) -> Self {
        let rest = bounded(healthy.rest);
        let widest = widths.iter().copied().max().unwrap_or(1).min(MAX_WIDTH);
        let survival = Survival::of(&healthy.law, widest);
        let excursions = survival.is_some();

        let boxes = boxes(healthy.deviation(), excursions);
        let runs = RunLimits::new(&healthy.law, &healthy.fastest, healthy.wild_share);
        let runs = boxes.map(|ends| runs.limits(ends, levels.runs));

        let clips = clips(rest, excursions.then_some(bounded(healthy.sizes_95)));
        let sums = SumLimits::new(&healthy.weighted, survival, healthy.wild_share);
        let sums = if overlaps { sums.with_overlaps() } else { sums };
        let level = |at| if at > 0 && excursions { levels.wide_clips } else { levels.sums };
        let clipped = |(at, clip): (usize, &f64)| sums.clipped(*clip, level(at), widths);
        Self {
            boxes,
            runs,
            sums: clips.iter().enumerate().map(clipped).collect(),
            squares: sums.squares(clips[0], levels.sums, widths),
            elsewhere: sums.elsewhere(rest, levels.sums, widths),
            clips,
        }
    }

    /// The smallest steps, in steps of 0.05 mm, that these limits find within 0.1, 0.3 and 1 s, where a sample is taken every
    /// `sample_time` seconds and `widths` are those that the limits were computed for.
    ///
    /// The residual is taken to be the step and nothing else, at rest. Noise makes the first sample beyond a limit come
    /// sooner or later, about as often.
    pub fn smallest_step(&self, widths: &[usize], sample_time: f64) -> [SmallestStep; 3] {
        WITHIN.map(|within| {
            // The first sample is at no time.
            let samples = (within / sample_time + ROUNDING).min(MAX_SAMPLES) as usize + 1;
            let size = |steps: u32| f64::from(steps) * STEP;
            let found =
                |steps: &u32| sample_time > 0.0 && self.finds(size(*steps), samples, widths);
            let smallest = (1..=STEPS).rev().take_while(found).last().map(size);
            SmallestStep { within, size: smallest }
        })
    }

    /// Whether `samples` samples of `size`, m, after none are beyond a limit. The count is left out: it does not rise but by
    /// the first of them.
    fn finds(&self, size: f64, samples: usize, widths: &[usize]) -> bool {
        let beyond = |each: f64, limits: &[f64]| {
            let sums = widths.iter().map(|width| each * samples.min(*width) as f64);
            sums.zip(limits).any(|(sum, limit)| sum > *limit)
        };
        let square = self.clips.first().map_or(0.0, |clip| size.min(*clip).powi(2));
        let long = |least: &Option<u16>| least.is_some_and(|least| samples >= usize::from(least));
        self.clips.iter().zip(&self.sums).any(|(clip, limits)| beyond(size.min(*clip), limits))
            || beyond(square, &self.squares)
            || self
                .boxes
                .iter()
                .zip(&self.runs)
                .any(|([low, high], least)| size > *low && size <= *high && least.iter().any(long))
    }
}

impl HealthyCylinder {
    /// Deviation of residuals as they are where the rod is fast, `σ_b`, m: twice the mean square of the velocity is the square
    /// of the peak, as the rod follows the waves.
    fn deviation(&self) -> f64 {
        let (rest, timing) = (bounded(self.rest), bounded(self.timing));
        bounded((rest * rest + 2.0 * timing * timing * self.mean_square_velocity.max(0.0)).sqrt())
    }
}

/// A length that can be computed with, m: not below 0, and not beyond [`MAX_LENGTH`].
const fn bounded(length: f64) -> f64 {
    // The larger of 0 and what is no number is 0.
    length.max(0.0).min(MAX_LENGTH)
}
