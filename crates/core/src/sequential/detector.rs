//! The sequential detector of one cylinder.

mod alarmed;
mod together;

use super::alarm::{Alarm, Cause};
use super::baseline::{Baseline, Loss, Slow};
use super::clip::Clipping;
use super::coverage::Unknown;
use super::dwell::{Dwell, Dwelling};
use super::history::DwellHistory;
use super::noise::Noise;
use super::novelty::{News, Novelty};
use super::pair::{Pair, PairDesign};
use super::parameters::{Cycles, Parameters};
use super::rate::Rate;
use super::reference::Reference;
use super::samples::{History, Sample};
use super::scale::Proportion;
use super::search::Search;
use super::skew::Skew;
use super::statistic::{Bands, DEAD_BAND, Dependence, Peak, Scales};
use super::stops::{Blame, Judgement};
use super::velocity::Velocity;
use super::wild::Outliers;
use super::witness::Witness;
use crate::time::Timestamp;
use crate::verdict::{Fault, Suspect, Verdict};

/// What one detector runs on.
#[derive(Clone, Debug)]
pub struct Design {
    pub reference: Reference,
    /// Of the weighed residual, and of its square.
    pub rate: Rate,
    pub square_rate: Rate,
    pub dependence: Dependence,
    /// Standard deviation of the healthy residual, m, whatever the speed.
    pub deviation: f64,
    /// How it goes with the speed.
    pub noise: Noise,
    /// What the readings of C1 and of C2 move in, m; 0 where that is not known.
    pub resolution: [f64; 2],
    /// What was expected of them when the rates were made.
    pub outliers: Outliers,
    /// `None` where the calibration has no drive: then nothing is located.
    pub pair: Option<PairDesign>,
    /// h, nats.
    pub level: f64,
    /// s.
    pub sample_time: f64,
    /// Cycles without evidence that end an alarm.
    pub clear: u32,
    pub parameters: &'static Parameters,
}

/// One cycle of a cylinder.
#[derive(Clone, Copy, Debug, Default)]
pub struct Input {
    /// Readings that passed the plausibility checks, m.
    pub lengths: [Option<f64>; 2],
    /// By C2 where it is measured, m/s.
    pub velocity: Option<f64>,
    /// u(k), m/s.
    pub command: Option<f64>,
    /// The platform is in a monitored state.
    pub monitored: bool,
    /// The opening of the cycle.
    pub at: Timestamp,
    /// The rods stand on their mechanical stops.
    pub at_stop: bool,
}

/// The detector.
#[derive(Clone, Debug)]
pub struct Sequential {
    design: Design,
    cycles: Cycles,
    scales: Scales,
    clipping: Clipping,
    baseline: Baseline,
    slow: Slow,
    loss: Loss,
    novelty: Novelty,
    history: History,
    search: Search,
    /// What is believed of the noise now, and of what C2 is sampled sooner than C1, s.
    noise: Noise,
    sooner: f64,
    /// They are sampled otherwise than calibrated, and that is told.
    sampled_anew: bool,
    /// As far as the other cylinders know, a noise may be that of the sampling.
    may_be_timing: bool,
    witness: Witness,
    skew: Skew,
    proportion: Proportion,
    pair: Option<Pair>,
    velocity: Velocity,
    was_monitored: bool,
    verdict: Verdict,
    /// Why nothing is known after the newest cycle.
    unknown: Option<Unknown>,
    /// Of the newest cycle, beyond the baseline, m.
    residual: Option<f64>,
    peaks: [Peak; 2],
    alarm: Option<Alarm>,
    dwelling: Dwelling,
    dwells: DwellHistory,
    /// Of the newest cycle.
    dwelt: Option<Dwell>,
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
            novelty: Novelty::new(residual, sample_time, deviation, farthest),
            scales,
            history: History::holding(cycles.newest),
            search: Search::default(),
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
            dwelling: Dwelling::default(),
            dwells: DwellHistory::default(),
            dwelt: None,
            design,
        }
    }

    /// What it runs on.
    pub const fn design(&self) -> &Design {
        &self.design
    }

    /// What is known after the newest cycle.
    pub const fn verdict(&self) -> Verdict {
        self.verdict
    }

    /// Why nothing is known after the newest cycle; `None` where something is.
    pub const fn unknown(&self) -> Option<Unknown> {
        self.unknown
    }

    /// The residual of the newest cycle beyond its baseline, m, where it was judged.
    pub const fn residual(&self) -> Option<f64> {
        self.residual
    }

    /// The statistics of mean and variance in the newest cycle.
    pub const fn peaks(&self) -> [Peak; 2] {
        self.peaks
    }

    /// How far the readings have been apart in the newest cycles, m, beside what is healthy; `None`
    /// where that is not known, or not healthy.
    pub fn apart(&self) -> Option<f64> {
        self.history.apart().filter(|_| self.verdict == Verdict::Healthy)
    }

    /// The alarm that stands.
    pub const fn alarm(&self) -> Option<&Alarm> {
        self.alarm.as_ref()
    }

    /// What was read on the stop in the newest cycle, once.
    pub const fn take_dwell(&mut self) -> Option<Dwell> {
        self.dwelt.take()
    }

    /// Time jumped or frames were lost.
    pub fn interrupt(&mut self) {
        // As with R3, the side does not outlast a time of which nothing is known.
        if let Some(alarm) = self.alarm.as_mut().filter(|alarm| alarm.cause != Cause::Dwell) {
            alarm.clear_suspect();
        }
        self.stop();
        self.loss.begin();
        self.skew.reset();
        self.dwelling = Dwelling::default();
    }

    /// What comes is not to be judged for a while; what follows it is, against what was before.
    pub fn pause(&mut self) {
        self.stop();
        self.skew.reset();
    }

    /// Another calibration of the same cylinder takes over.
    pub fn refer(&mut self, reference: &Reference) {
        self.design.reference.clone_from(reference);
    }

    /// Takes one cycle. Where the alarm that stands has become another one, or has ended, it shows
    /// in [`Self::alarm`].
    #[inline(always)]
    pub fn step(&mut self, input: &Input) {
        if let Some(dwell) = self.dwelling.step(input.at, input.at_stop, input.lengths) {
            self.dwells.add(dwell);
            self.dwelt = Some(dwell);
        }
        self.residual = None;
        if !input.monitored {
            if core::mem::take(&mut self.was_monitored) {
                self.leave();
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
        let news = self.novelty.step([c1, c2], sample);
        self.witness.push(residual, if news == News::InMotion { velocity } else { 0.0 });
        if news == News::InMotion {
            if let Some(alarm) = &self.alarm {
                self.proportion.push(alarm.age, 0.5 * (c1 + c2), residual);
            }
            if self.is_witness() {
                let calibrated = residual + self.sooner * velocity;
                self.skew.take(calibrated, velocity, &self.noise, self.sooner);
            }
        }
        self.residual = Some(residual);
        self.judge(input.at, sample, news);
    }

    /// What is learnt of a state is void in another one. What was found stands, and its baseline
    /// with it: or else the fault would be the new one.
    fn leave(&mut self) {
        self.stop();
        self.forget_baseline();
    }

    /// What was learnt of the motion is void.
    fn stop(&mut self) {
        self.forget();
        self.novelty.reset();
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

    /// What was evidence is none any more.
    fn forget(&mut self) {
        self.history.clear();
        self.search = Search::default();
    }

    /// The stops tell which reading has drifted, also where nothing else could: while the machine
    /// moves, its controller follows a drifting C1. `judgement` is of all dwells of the machine up to `at`.
    pub fn judge_stop(&mut self, at: Timestamp, judgement: &Judgement) {
        let [one, two] = judgement.moved;
        let (suspect, size) = match judgement.blame {
            Blame::C1 => (Suspect::C1, one),
            Blame::C2 => (Suspect::C2, two),
            Blame::Neither => {
                // What the stop found is over when the stop says so.
                if self.alarm.is_some_and(|alarm| alarm.cause == Cause::Dwell) {
                    self.end();
                }
                return;
            }
            Blame::Both | Blame::Undecided => return,
        };
        match &mut self.alarm {
            Some(alarm) if alarm.suspect == Suspect::Undecided => alarm.suspect = suspect,
            Some(_) => {}
            None => {
                let alarm = Alarm::new(Cause::Dwell, Fault::Incipient, size, at);
                self.begin(Alarm { suspect, ..alarm });
            }
        }
    }

    /// There is no evidence in this cycle: what was found stands.
    const fn go_without(&mut self, reason: Unknown) {
        self.witness.push(0.0, 0.0);
        (self.verdict, self.unknown) = match self.alarm {
            Some(_) => (Verdict::Faulty, None),
            None => (Verdict::Unknown, Some(reason)),
        };
    }

    /// Lets the pair's filter follow: C2 as C1 would have it is C1 less what they differ by.
    #[inline(always)]
    fn follow(&mut self, input: &Input, difference: Option<(f64, f64)>) {
        let Some(pair) = &mut self.pair else { return };
        let lengths = input.lengths[0]
            .zip(difference)
            .map(|(c1, (residual, baseline))| [c1, c1 - (residual - baseline)]);
        pair.step(lengths, input.command);
    }
}

mod memory;
#[cfg(test)]
mod tests;
