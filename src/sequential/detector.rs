//! The sequential detector of one cylinder.

use super::alarm::{Alarm, Cause};
use super::baseline::{Baseline, Slow};
use super::dwell::{Dwell, Dwelling};
use super::history::{Blame, DwellHistory, Moved};
use super::kind;
use super::motion::Motion;
use super::pair::{Form, Pair, PairDesign};
use super::rate::Rate;
use super::reference::Reference;
use super::statistic::{History, Peak, peaks};
use super::velocity::Velocity;
use super::windows::WIDTHS;
use crate::time::{Span, Timestamp};
use crate::verdict::{Fault, Suspect, Verdict};

/// What is below this is no fault but a temperature or a bend that the calibration has left, m.
const DEAD_BAND: f64 = 1e-4;

/// The least relative dead band of the variance.
const LEAST_SPREAD_BAND: f64 = 0.25;

/// The mean of a minute beyond this is a fault, whatever the baseline has followed, m …
const SLOW: f64 = 6e-4;

/// … and it is over below this, m.
const SLOW_OVER: f64 = 4e-4;

/// The level at which an alarm ends, as a part of that at which it rises.
const CALM: f64 = 0.5;

/// Cycles after an alarm at which the readings are compared, …
const COMPARE: u32 = 10;

/// … and at which noise is told from a step, and its transducer; twice, as a few draws of noise may
/// have a mean.
const NOISE: [u32; 2] = [25, 50];

/// Evidence for one of the transducers that decides, nats.
const DECIDED: f64 = 5.0;

/// Alarms of longer windows come too late: the filter, and the machine, have followed.
const LOCATED: usize = 16;

/// A slower drift is followed by the filter, and in the closed loop by the machine, m/s.
const FOLLOWED: f64 = 5e-3;

/// A transducer has this much more of the innovations' energy to be blamed for a noise.
const NOISIER: f64 = 0.25;

/// What one detector runs on.
#[derive(Clone, Debug)]
pub struct Design {
    pub reference: Reference,
    pub rate: Rate,
    /// Standard deviation of the healthy residual, m.
    pub deviation: f64,
    /// `None` where the calibration has no drive: then nothing is located.
    pub pair: Option<PairDesign>,
    /// h, nats.
    pub level: f64,
    /// s.
    pub sample_time: f64,
    /// Cycles without evidence that end an alarm.
    pub clear: u32,
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
    spread_band: f64,
    baseline: Baseline,
    slow: Slow,
    motion: Motion,
    history: History,
    pair: Option<Pair>,
    velocity: Velocity,
    was_monitored: bool,
    verdict: Verdict,
    peaks: [Peak; 2],
    alarm: Option<Alarm>,
    dwelling: Dwelling,
    dwells: DwellHistory,
    /// Of the newest cycle.
    dwelt: Option<(Dwell, Option<Moved>)>,
}

impl Sequential {
    pub fn new(design: Design) -> Self {
        let relative = DEAD_BAND / design.deviation;
        Self {
            spread_band: LEAST_SPREAD_BAND.max(relative * relative),
            baseline: Baseline::new(design.sample_time, design.deviation),
            slow: Slow::new(design.sample_time),
            motion: Motion::new(design.sample_time),
            history: History::default(),
            pair: design.pair.clone().map(Pair::new),
            velocity: Velocity::new(design.sample_time),
            was_monitored: false,
            verdict: Verdict::Unknown,
            peaks: [Peak::default(); 2],
            alarm: None,
            dwelling: Dwelling::default(),
            dwells: DwellHistory::default(),
            dwelt: None,
            design,
        }
    }

    /// What is known after the newest cycle.
    pub const fn verdict(&self) -> Verdict {
        self.verdict
    }

    /// The statistics of mean and variance in the newest cycle.
    pub const fn peaks(&self) -> [Peak; 2] {
        self.peaks
    }

    /// The alarm that stands.
    pub const fn alarm(&self) -> Option<&Alarm> {
        self.alarm.as_ref()
    }

    /// What was read on the stop in the newest cycle, once.
    pub fn take_dwell(&mut self) -> Option<(Dwell, Option<Moved>)> {
        self.dwelt.take()
    }

    /// Time jumped or frames were lost.
    pub fn interrupt(&mut self) {
        // As with R3, the side does not outlast a time of which nothing is known.
        if let Some(alarm) = self.alarm.as_mut().filter(|alarm| alarm.cause != Cause::Dwell) {
            alarm.suspect = Suspect::Undecided;
        }
        self.leave();
        self.dwelling = Dwelling::default();
        self.was_monitored = false;
    }

    /// Takes one cycle. Where the alarm that stands has become another one, or has ended, it shows
    /// in [`Self::alarm`].
    pub fn step(&mut self, input: &Input) {
        if let Some(dwell) = self.dwelling.step(input.at, input.at_stop, input.lengths) {
            let moved = self.dwells.add(dwell);
            self.dwelt = Some((dwell, moved));
            if let Some(moved) = moved {
                self.judge_dwell(input.at, &moved);
            }
        }
        if !input.monitored {
            if std::mem::take(&mut self.was_monitored) {
                self.leave();
            }
            self.verdict = Verdict::Unknown;
            return;
        }
        self.was_monitored = true;
        let velocity = self.velocity.step(input.lengths[1], input.velocity);
        let [c1, c2] = input.lengths;
        let lengths = c1.zip(c2);
        let reference = &self.design.reference;
        let residual = lengths
            .zip(velocity)
            .and_then(|((c1, c2), velocity)| reference.residual(c1, c2, velocity));
        let baseline = self.baseline.value();
        self.follow(input, residual.zip(baseline));
        let Some((residual, (c1, c2))) = residual.zip(lengths) else {
            self.verdict = self.without_evidence();
            return;
        };
        self.slow.push(residual);
        if self.alarm.is_none() {
            self.baseline.follow(residual);
        }
        let Some(baseline) = baseline else {
            self.verdict = self.without_evidence();
            return;
        };
        let moving = self.motion.step([c1, c2]);
        self.judge(input.at, residual - baseline, moving);
    }

    /// What is learnt of a state is void in another one. What was found stands, and its baseline
    /// with it: or else the fault would be the new one.
    fn leave(&mut self) {
        self.history.clear();
        self.motion.reset();
        self.velocity.reset();
        self.peaks = [Peak::default(); 2];
        self.verdict = Verdict::Unknown;
        if let Some(pair) = &mut self.pair {
            pair.reset();
        }
        if self.alarm.is_none() {
            self.baseline.reset();
            self.slow.reset();
        }
    }

    /// The stop tells which reading has drifted, also where nothing else could: while the machine
    /// moves, its controller follows a drifting C1.
    fn judge_dwell(&mut self, at: Timestamp, moved: &Moved) {
        let [one, two] = moved.by;
        let (suspect, size) = match moved.blame() {
            Blame::C1 => (Suspect::C1, one),
            Blame::C2 => (Suspect::C2, two),
            Blame::Neither | Blame::Stop => {
                // What the stop found is over when the stop says so.
                if self.alarm.is_some_and(|alarm| alarm.cause == Cause::Dwell) {
                    self.end();
                }
                return;
            }
            Blame::Both => return,
        };
        match &mut self.alarm {
            Some(alarm) if alarm.suspect == Suspect::Undecided => alarm.suspect = suspect,
            Some(_) => {}
            None if size.abs() > SLOW => {
                self.alarm = Some(Alarm {
                    cause: Cause::Dwell,
                    peak: Peak::default(),
                    fault: Fault::Incipient,
                    suspect,
                    evidence: None,
                    size,
                    onset: at,
                    age: 0,
                    calm: 0,
                });
            }
            None => {}
        }
    }

    fn without_evidence(&self) -> Verdict {
        if self.alarm.is_some() { Verdict::Faulty } else { Verdict::Unknown }
    }

    /// Lets the pair's filter follow: C2 as C1 would have it is C1 less what they differ by.
    fn follow(&mut self, input: &Input, difference: Option<(f64, f64)>) {
        let Some(pair) = &mut self.pair else { return };
        let lengths = input.lengths[0]
            .zip(difference)
            .map(|(c1, (residual, baseline))| [c1, c1 - (residual - baseline)]);
        pair.step(lengths, input.command);
    }

    fn judge(&mut self, at: Timestamp, residual: f64, moving: bool) {
        let Design { rate, deviation, level, .. } = &self.design;
        self.history.push(residual, *deviation, rate.farthest(), moving);
        let widest = self.alarm.map_or(WIDTHS[WIDTHS.len() - 1], |alarm| alarm.watched());
        self.peaks = peaks(&self.history, rate, DEAD_BAND, self.spread_band, widest);
        let [mean, variance] = self.peaks;
        let level = *level;
        if self.alarm.is_some() {
            self.go_on(mean.nats.max(variance.nats) < CALM * level);
        } else if mean.nats > level {
            self.raise(at, Cause::Mean, mean);
        } else if variance.nats > level {
            self.raise(at, Cause::Variance, variance);
        } else if self.slow.mean().is_some_and(|mean| mean.abs() > SLOW) {
            self.raise(at, Cause::Slow, Peak::default());
        }
        self.verdict = if self.alarm.is_some() { Verdict::Faulty } else { Verdict::Healthy };
    }

    fn raise(&mut self, at: Timestamp, cause: Cause, peak: Peak) {
        let (fault, size, cycles) = match cause {
            Cause::Mean => {
                let shape = kind::shape(&self.history);
                (shape.fault, shape.size, shape.onset)
            }
            Cause::Variance => (Fault::Noise, self.spread(peak.width), peak.width),
            Cause::Slow | Cause::Dwell => {
                (Fault::Incipient, self.slow.mean().unwrap_or_default(), 0)
            }
        };
        self.alarm = Some(Alarm {
            cause,
            peak,
            fault,
            suspect: Suspect::Undecided,
            evidence: None,
            size,
            onset: at.after(Span::from_seconds(-(cycles as f64) * self.design.sample_time)),
            age: 0,
            calm: 0,
        });
    }

    fn spread(&self, width: usize) -> f64 {
        let squares = self.history.moving.over(width).or_else(|| self.history.all.over(width));
        squares.map_or(0.0, |[_, _, _, squares]| (squares / width as f64).sqrt())
    }

    fn go_on(&mut self, calm: bool) {
        let Some(mut alarm) = self.alarm else { return };
        let calm = match alarm.cause {
            Cause::Dwell => false,
            // The baseline had followed the fault: only the mean without it tells.
            Cause::Slow => self.slow.mean().is_some_and(|mean| mean.abs() < SLOW_OVER),
            _ => calm,
        };
        alarm.age = alarm.age.saturating_add(1);
        alarm.calm = if calm { alarm.calm + 1 } else { 0 };
        match alarm.age {
            COMPARE if self.may_have_stepped(&alarm) => self.compare(&mut alarm),
            age if NOISE.contains(&age) && matches!(alarm.cause, Cause::Mean | Cause::Variance) => {
                self.tell_noise(&mut alarm);
            }
            _ => {}
        }
        self.alarm = Some(alarm);
        if alarm.calm >= self.design.clear {
            self.end();
        }
    }

    /// The alarm is over. A baseline that may have followed the fault begins anew.
    fn end(&mut self) {
        let ended = self.alarm.take();
        self.history.clear();
        self.slow.reset();
        if ended.is_some_and(|alarm| matches!(alarm.cause, Cause::Slow | Cause::Dwell)) {
            self.baseline.reset();
        }
    }

    /// A large step is in the variance, too, and sooner.
    fn may_have_stepped(&self, alarm: &Alarm) -> bool {
        match alarm.cause {
            Cause::Mean => true,
            Cause::Variance => kind::noise(&self.history, COMPARE as usize).is_none(),
            Cause::Slow | Cause::Dwell => false,
        }
    }

    /// Which of the readings has stepped.
    fn compare(&self, alarm: &mut Alarm) {
        let shape = kind::shape(&self.history);
        (alarm.fault, alarm.size) = (shape.fault, shape.size);
        let Some(pair) = &self.pair else { return };
        let form = if shape.fault == Fault::Incipient { Form::Ramp } else { Form::Step };
        let speed = shape.size.abs() / (shape.onset as f64 * self.design.sample_time);
        if alarm.peak.width > LOCATED || (form == Form::Ramp && speed < FOLLOWED) {
            return;
        }
        let age = COMPARE as usize;
        alarm.evidence = pair.compare(form, age, age + alarm.peak.width + 1);
        alarm.suspect = match alarm.evidence {
            Some(nats) if nats > DECIDED => Suspect::C1,
            Some(nats) if nats < -DECIDED => Suspect::C2,
            _ => Suspect::Undecided,
        };
    }

    /// Noise has no onset to compare; its innovations go on.
    fn tell_noise(&self, alarm: &mut Alarm) {
        let span = alarm.age as usize;
        let Some(size) = kind::noise(&self.history, span) else { return };
        (alarm.fault, alarm.size) = (Fault::Noise, size);
        let share = self.pair.as_ref().and_then(|pair| pair.energy(span));
        alarm.suspect = match share {
            Some(share) if share > NOISIER => Suspect::C1,
            Some(share) if share < -NOISIER => Suspect::C2,
            _ => Suspect::Undecided,
        };
    }
}

mod memory;
#[cfg(test)]
mod tests;
