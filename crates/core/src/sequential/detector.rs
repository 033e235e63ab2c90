//! The sequential detector of one cylinder.

mod alarmed;
mod locating;
mod saved;
mod stepping;
mod together;

use super::alarm::{Alarm, Cause};
use super::baseline::{Baseline, Loss, Slow};
use super::clip::Clipping;
use super::coverage::Unknown;
use super::excursions::{ExcursionLimits, Excursions};
use super::noise::Noise;
use super::pair::{Pair, PairDesign};
use super::parameters::{SequentialCycles, SequentialParameters};
use super::rate::Rate;
use super::reference::Reference;
use super::samples::{History, NEWEST};
use super::scale::Proportion;
use super::search::Search;
use super::skew::Skew;
use super::statistic::{Bands, DEAD_BAND, Dependence, Peak, Scales};
use super::thinning::Thinning;
use super::velocity::Velocity;
use super::wild::Outliers;
use super::witness::Witness;
use crate::time::Timestamp;
use crate::verdict::{Jump, Verdict};

/// Parameters of one detector.
#[derive(Clone, Debug)]
pub struct Design {
    pub reference: Reference,
    /// Rate function of the weighted residual.
    pub rate: Rate,
    /// Rate function of the square of the weighted residual.
    pub square_rate: Rate,
    pub dependence: Dependence,
    /// Limits by the excursions of transducers that fluctuate; `None` where they do not, or are too coarse to show it. Then
    /// the rate functions and their dependence decide.
    pub excursions: Option<ExcursionLimits>,
    /// Standard deviation of the healthy residual at any speed, m.
    pub deviation: f64,
    /// Dependence of the scatter on the speed.
    pub noise: Noise,
    /// Resolutions of the readings of C1 and of C2, m; 0 where not known.
    pub resolution: [f64; 2],
    /// Outliers that were expected when the rate functions were made.
    pub outliers: Outliers,
    /// Locator of a fault by the command; `None` where the calibration has no drive.
    pub pair: Option<PairDesign>,
    /// Level h, nats.
    pub level: f64,
    /// Sample time, s.
    pub sample_time: f64,
    /// Cycles without evidence that end an alarm.
    pub clear: u32,
    pub parameters: &'static SequentialParameters,
}

/// Inputs of a cylinder in one cycle.
#[derive(Clone, Copy, Debug, Default)]
pub struct Input {
    /// Readings that passed the plausibility checks, m.
    pub lengths: [Option<f64>; 2],
    /// Velocity by C2 where it is measured, m/s.
    pub velocity: Option<f64>,
    /// Command u(k), m/s.
    pub command: Option<f64>,
    /// Whether the platform is in a monitored state.
    pub monitored: bool,
    /// Opening of the cycle.
    pub at: Timestamp,
}

/// The sequential detector of one cylinder.
#[derive(Clone, Debug)]
pub struct Sequential {
    design: Design,
    cycles: SequentialCycles,
    scales: Scales,
    clipping: Clipping,
    baseline: Baseline,
    slow: Slow,
    loss: Loss,
    thinning: Thinning,
    history: History,
    search: Search,
    excursions: Option<Excursions>,
    /// Present estimate of the noise.
    noise: Noise,
    /// Time by which C2 is now sampled sooner than C1, s.
    sooner: f64,
    /// Whether C1 and C2 are sampled differently than calibrated, and this was reported.
    sampled_anew: bool,
    /// Whether a noise may come from the sampling, by what the other cylinders show.
    may_be_timing: bool,
    witness: Witness,
    skew: Skew,
    proportion: Proportion,
    pair: Option<Pair>,
    velocity: Velocity,
    was_monitored: bool,
    verdict: Verdict,
    /// Why the newest cycle was not judged.
    unknown: Option<Unknown>,
    /// Residual of the newest cycle beyond the baseline, m.
    residual: Option<f64>,
    peaks: [Peak; 2],
    alarm: Option<Alarm>,
}

impl Sequential {
    pub fn new(design: Design) -> Self {
        let Design { noise, resolution, outliers, sample_time, deviation, parameters, .. } = design;
        let (residual, cycles) = (&parameters.residual, parameters.cycles(sample_time));
        let bands = Bands::new(noise.rest, DEAD_BAND, resolution, outliers);
        let (rate, square_rate) = (design.rate.clone(), design.square_rate.clone());
        let scales = Scales::new(rate, square_rate, design.dependence, bands);
        let clipping = Clipping::new(&scales);
        let farthest = clipping.usual().farthest;
        Self {
            cycles,
            clipping,
            baseline: Baseline::new(residual, sample_time, deviation),
            slow: Slow::new(residual, sample_time),
            loss: Loss::default(),
            thinning: Thinning::new(residual, sample_time, deviation, farthest),
            scales,
            history: History::holding(if design.excursions.is_some() {
                NEWEST
            } else {
                cycles.newest
            }),
            search: Search::default(),
            excursions: design.excursions.as_ref().map(Excursions::new),
            noise: design.noise.relied_on(),
            sooner: 0.0,
            sampled_anew: false,
            may_be_timing: false,
            witness: Witness::default(),
            skew: Skew::new(sample_time, noise.timing),
            proportion: Proportion::new(deviation, DEAD_BAND, &parameters.scale, &cycles),
            pair: design.pair.clone().map(Pair::new),
            velocity: Velocity::new(residual, sample_time),
            was_monitored: false,
            verdict: Verdict::Unknown,
            unknown: None,
            residual: None,
            peaks: [Peak::default(); 2],
            alarm: None,
            design,
        }
    }

    /// Parameters of the detector.
    pub const fn design(&self) -> &Design {
        &self.design
    }

    /// Verdict of the newest cycle.
    pub const fn verdict(&self) -> Verdict {
        self.verdict
    }

    /// Why the newest cycle was not judged; `None` where it was.
    pub const fn unknown(&self) -> Option<Unknown> {
        self.unknown
    }

    /// Residual of the newest cycle beyond its baseline, m, where it was judged.
    pub const fn residual(&self) -> Option<f64> {
        self.residual
    }

    /// Statistics of mean and variance in the newest cycle.
    pub const fn peaks(&self) -> [Peak; 2] {
        self.peaks
    }

    /// Difference of the readings in the newest cycles, m, beyond what is healthy; `None` where it
    /// is not known, or not healthy.
    pub fn apart(&self) -> Option<f64> {
        self.history.apart().filter(|_| self.verdict == Verdict::Healthy)
    }

    /// How the readings have moved apart in the newest samples; `None` where this cycle was not judged.
    #[inline]
    pub fn jump(&self) -> Option<Jump> {
        self.residual?;
        let [apart, before] = self.history.since(Jump::SAMPLES)?;
        Some(Jump { apart, change: apart - before })
    }

    /// What compares both readings with the command, where a calibration has fitted a drive.
    pub const fn pair(&self) -> Option<&Pair> {
        self.pair.as_ref()
    }

    /// The standing alarm.
    pub const fn alarm(&self) -> Option<&Alarm> {
        self.alarm.as_ref()
    }

    /// Restarts what was learnt of the motion, after a time jump or lost frames.
    pub fn interrupt(&mut self) {
        // As with R3, the side does not outlast a time of which nothing is known.
        if let Some(alarm) = self.alarm.as_mut().filter(|alarm| alarm.cause != Cause::Dwell) {
            alarm.clear_suspect();
        }
        self.stop();
        self.loss.begin();
        self.skew.reset();
    }

    /// Stops judging for a while; later cycles are judged against what was learnt before.
    pub fn pause(&mut self) {
        self.stop();
        self.skew.reset();
    }

    /// Switches to another calibration of the same cylinder.
    pub fn refer(&mut self, reference: &Reference) {
        self.design.reference.clone_from(reference);
    }

    /// Discards what was learnt of the motion.
    fn stop(&mut self) {
        self.forget();
        self.thinning.reset();
        self.velocity.reset();
        self.witness.reset();
        self.peaks = [Peak::default(); 2];
        self.verdict = Verdict::Unknown;
        if let Some(pair) = &mut self.pair {
            pair.reset();
        }
    }

    fn forget_baseline(&mut self) {
        if self.alarm.is_none() {
            self.baseline.reset();
            self.slow.reset();
        }
    }

    /// Discards the evidence.
    fn forget(&mut self) {
        self.history.clear();
        self.search = Search::default();
        if let Some(excursions) = &mut self.excursions {
            excursions.clear();
        }
    }
}

#[cfg(test)]
mod tests;
