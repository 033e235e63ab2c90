//! The sequential detector of one cylinder.

use super::alarm::{Alarm, Cause};
use super::baseline::{Baseline, Slow};
use super::dwell::{Dwell, Dwelling};
use super::history::{Blame, DwellHistory, Moved};
use super::kind::{self, Looks};
use super::motion::Motion;
use super::pair::{Form, Pair, PairDesign};
use super::rate::Rate;
use super::reference::Reference;
use super::statistic::{DEAD_BAND, Dependence, History, Peak, Scales};
use super::velocity::Velocity;
use super::windows::WIDTHS;
use crate::time::{Span, Timestamp};
use crate::verdict::{Fault, Suspect, Verdict};

/// The mean of a minute beyond this is a fault, whatever the baseline has followed, m …
const SLOW: f64 = 6e-4;

/// … and it is over below this, m.
const SLOW_OVER: f64 = 4e-4;

/// The level at which an alarm ends, as a part of that at which it rises.
const CALM: f64 = 0.5;

/// Cycles after an alarm at which it is looked at again: a few samples do not tell what it is. The pair
/// can only tell a step's side while the filter has not followed, …
const LOOKS: [u32; 8] = [5, 10, 16, 25, 50, 100, 200, 400];

/// … which is until so many cycles after the alarm.
const LATEST: usize = 25;

/// As far back as innovations, and residuals at rest, are kept.
const LONGEST: usize = 50;

/// Evidence for one of the transducers that decides, nats.
const DECIDED: f64 = 5.0;

/// So many nats a step must be better than a ramp to be compared as one: a slow drift is nobody's.
const CLEARLY: f64 = 3.0;

/// Alarms of longer windows come too late: the filter, and the machine, have followed.
const LOCATED: usize = 16;

/// A slower drift is followed by the filter, and in the closed loop by the machine, m/s.
const FOLLOWED: f64 = 5e-3;

/// What one detector runs on.
#[derive(Clone, Debug)]
pub struct Design {
    pub reference: Reference,
    /// Of the residual, and of its square.
    pub rate: Rate,
    pub square_rate: Rate,
    pub dependence: Dependence,
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
    scales: Scales,
    baseline: Baseline,
    slow: Slow,
    motion: Motion,
    history: History,
    pair: Option<Pair>,
    velocity: Velocity,
    was_monitored: bool,
    verdict: Verdict,
    /// Of the newest cycle, beyond the baseline, m.
    residual: Option<f64>,
    peaks: [Peak; 2],
    alarm: Option<Alarm>,
    dwelling: Dwelling,
    dwells: DwellHistory,
    /// Of the newest cycle.
    dwelt: Option<(Dwell, Option<Moved>)>,
}

impl Sequential {
    pub fn new(design: Design) -> Self {
        let Design { rate, square_rate, dependence, deviation, .. } = &design;
        let (rate, square_rate) = (rate.clone(), square_rate.clone());
        let scales = Scales::new(rate, square_rate, *dependence, *deviation, DEAD_BAND);
        Self {
            scales,
            baseline: Baseline::new(design.sample_time, design.deviation),
            slow: Slow::new(design.sample_time),
            motion: Motion::new(design.sample_time),
            history: History::default(),
            pair: design.pair.clone().map(Pair::new),
            velocity: Velocity::new(design.sample_time),
            was_monitored: false,
            verdict: Verdict::Unknown,
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

    /// The residual of the newest cycle beyond its baseline, m, where it was judged.
    pub const fn residual(&self) -> Option<f64> {
        self.residual
    }

    /// The statistics of mean and variance in the newest cycle.
    pub const fn peaks(&self) -> [Peak; 2] {
        self.peaks
    }

    /// The alarm that stands.
    pub const fn alarm(&self) -> Option<&Alarm> {
        self.alarm.as_ref()
    }

    /// What was read on the stop so far.
    pub const fn dwells(&self) -> &DwellHistory {
        &self.dwells
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
        self.residual = None;
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
        self.residual = Some(residual - baseline);
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
        self.history.push(residual, self.scales.farthest(), moving);
        let widest = self.alarm.map_or(WIDTHS[WIDTHS.len() - 1], |alarm| alarm.watched());
        self.peaks = self.scales.peaks(&self.history, widest);
        let [mean, variance] = self.peaks;
        let level = self.design.level;
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
        let noisy = match kind::looks(&self.history, peak.width) {
            Some(Looks::Noisy(size)) => Some((Fault::Noise, size, peak.width)),
            _ => None,
        };
        let (fault, size, cycles) = match cause {
            Cause::Mean | Cause::Variance => noisy.unwrap_or_else(|| {
                let shape = kind::shape(&self.history, self.design.deviation);
                (shape.fault, shape.size, shape.onset)
            }),
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
        if LOOKS.contains(&alarm.age) && matches!(alarm.cause, Cause::Mean | Cause::Variance) {
            self.look(&mut alarm);
        }
        self.alarm = Some(alarm);
        if alarm.calm >= self.design.clear {
            self.end();
        }
    }

    /// What it is, and whose, by what has been read since.
    fn look(&self, alarm: &mut Alarm) {
        let age = alarm.age as usize;
        match kind::looks(&self.history, age.min(LONGEST)) {
            // A mean of many samples that stands out is no noise, however small it is beside them.
            Some(Looks::Noisy(_)) if alarm.cause == Cause::Mean && alarm.peak.width > LOCATED => {}
            Some(Looks::Noisy(size)) => self.tell_noise(alarm, size),
            Some(Looks::Steady) => self.tell_shape(alarm),
            Some(Looks::Neither) | None => {}
        }
    }

    fn tell_shape(&self, alarm: &mut Alarm) {
        let shape = kind::shape(&self.history, self.design.deviation);
        if alarm.fault == Fault::Noise {
            // Whoever was blamed for a noise was so by its innovations: a step has others.
            (alarm.suspect, alarm.evidence) = (Suspect::Undecided, None);
        }
        (alarm.fault, alarm.size) = (shape.fault, shape.size);
        let speed = shape.size.abs() / (shape.onset as f64 * self.design.sample_time);
        let form = match shape.fault {
            Fault::Incipient if speed < FOLLOWED => {
                // So slow a drift may be anybody's, and what seemed a step was its beginning.
                if alarm.age <= LONGEST as u32 {
                    (alarm.suspect, alarm.evidence) = (Suspect::Undecided, None);
                }
                return;
            }
            Fault::Incipient => Form::Ramp,
            _ if shape.advantage < CLEARLY => return,
            _ => Form::Step,
        };
        let age = alarm.age as usize;
        let late = age > LATEST || alarm.peak.width > LOCATED || shape.onset > age + LOCATED;
        if late || alarm.suspect != Suspect::Undecided {
            return;
        }
        let pair = self.pair.as_ref();
        let evidence = pair.and_then(|pair| pair.compare(form, age, age + alarm.peak.width + 1));
        decide(alarm, evidence);
    }

    /// Noise has no onset to compare; its innovations go on.
    fn tell_noise(&self, alarm: &mut Alarm, size: f64) {
        if alarm.fault != Fault::Noise {
            (alarm.suspect, alarm.evidence) = (Suspect::Undecided, None);
        }
        (alarm.fault, alarm.size) = (Fault::Noise, size);
        if alarm.suspect == Suspect::Undecided {
            let span = (alarm.age as usize).min(LONGEST);
            decide(alarm, self.pair.as_ref().and_then(|pair| pair.energy(span)));
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
}

/// Blames whom the evidence is against: the log-likelihood of C1 less that of C2, nats.
fn decide(alarm: &mut Alarm, evidence: Option<f64>) {
    alarm.evidence = evidence;
    alarm.suspect = match evidence {
        Some(nats) if nats > DECIDED => Suspect::C1,
        Some(nats) if nats < -DECIDED => Suspect::C2,
        _ => Suspect::Undecided,
    };
}

#[cfg(test)]
mod tests;
