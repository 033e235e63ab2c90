//! The sequential detector of one cylinder.

mod alarmed;
mod locating;
mod saved;
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
use super::samples::{History, NEWEST, Sample};
use super::scale::Proportion;
use super::search::Search;
use super::skew::Skew;
use super::statistic::{Bands, DEAD_BAND, Dependence, Peak, Scales};
use super::stops::{Blame, Judgement};
use super::thinning::{Independence, Thinning};
use super::velocity::Velocity;
use super::wild::Outliers;
use super::witness::Witness;
use crate::time::Timestamp;
use crate::verdict::{Fault, Jump, Suspect, Testimony, Verdict};

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

    /// Takes one cycle. If the standing alarm has changed or ended, [`Self::alarm`] shows it.
    #[inline(always)]
    pub fn step(&mut self, input: &Input) {
        self.residual = None;
        if !input.monitored {
            if core::mem::take(&mut self.was_monitored) {
                self.leave();
            }
            if let Some(alarm) = &mut self.alarm {
                alarm.stand();
            }
            self.verdict = Verdict::Unknown;
            self.unknown = Some(Unknown::NotMonitored);
            return;
        }
        self.was_monitored = true;
        if self.loss.is_long(input.at) {
            self.forget_baseline();
        }
        let velocity = self.velocity.step(input.lengths[1], input.velocity);
        let [c1, c2] = input.lengths;
        let lengths = c1.zip(c2);
        let reference = &self.design.reference;
        let calibrated = lengths
            .zip(velocity)
            .and_then(|((c1, c2), velocity)| reference.residual(c1, c2, velocity));
        let reason = match lengths.and(velocity) {
            None => Unknown::NoReading,
            Some(_) => Unknown::NotCalibrated,
        };
        let velocity = velocity.unwrap_or(0.0);
        let doubt = calibrated.map_or(0.0, |(_, doubt)| doubt);
        let residual = calibrated.map(|(residual, _)| residual - self.sooner * velocity);
        let baseline = self.baseline.value();
        let of_baseline = self.baseline.doubt();
        self.follow(input, residual.zip(baseline));
        let Some((residual, (c1, c2))) = residual.zip(lengths) else {
            return self.go_without(reason);
        };
        self.slow.push(residual);
        if self.alarm.is_none() {
            self.baseline.follow(residual, doubt);
        }
        let Some(baseline) = baseline else {
            return self.go_without(Unknown::NoBaseline);
        };
        let residual = residual - baseline;
        let doubt = doubt * doubt + of_baseline * of_baseline;
        let sample = Sample { residual, share: self.noise.share(velocity), doubt };
        let independence = self.thinning.step([c1, c2], sample);
        self.witness
            .push(residual, if independence == Independence::InMotion { velocity } else { 0.0 });
        if independence == Independence::InMotion {
            if let Some(alarm) = &self.alarm {
                self.proportion.push(alarm.age, 0.5 * (c1 + c2), residual);
            }
            if self.is_witness() {
                let calibrated = residual + self.sooner * velocity;
                self.skew.take(calibrated, velocity, &self.noise, self.sooner);
            }
        }
        self.residual = Some(residual);
        self.judge(input.at, sample, independence);
    }

    /// Leaves a platform state, in which what was learnt does not apply to another one. An alarm
    /// stands, and its baseline with it; otherwise the fault would become the new baseline.
    fn leave(&mut self) {
        self.stop();
        self.forget_baseline();
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

    /// Judges by the stops which reading has drifted, which nothing else could tell: while the
    /// machine moves, its controller follows a drifting C1. `judgement` is made from all dwells of
    /// the machine up to `at`.
    pub fn judge_stop(&mut self, at: Timestamp, judgement: &Judgement) {
        let (suspect, size) = match (judgement.blame, judgement.moved.c2) {
            (Blame::C1, _) => (Suspect::C1, judgement.moved.c1),
            (Blame::C2, Some(c2)) => (Suspect::C2, c2),
            (Blame::Neither, _) => {
                // What the stop found is over when the stop says so.
                if self.alarm.is_some_and(|alarm| alarm.cause == Cause::Dwell) {
                    self.end();
                }
                return;
            }
            (Blame::C2 | Blame::Both | Blame::Undecided, _) => return,
        };
        match &mut self.alarm {
            // No evidence of innovations decides against it.
            Some(alarm) if alarm.suspect == Suspect::Undecided => {
                (alarm.suspect, alarm.evidence, alarm.by) = (suspect, None, Some(Testimony::Stop));
            }
            Some(_) => {}
            None => {
                let alarm = Alarm::new(Cause::Dwell, Fault::Incipient, size, at);
                self.begin(Alarm { suspect, by: Some(Testimony::Stop), ..alarm });
            }
        }
    }

    /// Notes that there is no evidence in this cycle; an alarm stands.
    const fn go_without(&mut self, reason: Unknown) {
        self.witness.push(0.0, 0.0);
        (self.verdict, self.unknown) = match &mut self.alarm {
            Some(alarm) => {
                alarm.stand();
                (Verdict::Faulty, None)
            }
            None => (Verdict::Unknown, Some(reason)),
        };
    }

    /// Steps the pair's filter, with C2 on the scale of C1: C1 less their difference.
    #[inline(always)]
    fn follow(&mut self, input: &Input, difference: Option<(f64, f64)>) {
        let Some(pair) = &mut self.pair else { return };
        let lengths = input.lengths[0]
            .zip(difference)
            .map(|(c1, (residual, baseline))| [c1, c1 - (residual - baseline)]);
        pair.step(lengths, input.command);
    }
}

#[cfg(test)]
mod tests;
