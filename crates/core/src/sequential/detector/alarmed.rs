//! What becomes of an alarm: of what kind it is, which transducer, and when it is over.

use super::Sequential;
use crate::sequential::alarm::{Alarm, Cause};
use crate::sequential::kind::{self, Appearance};
use crate::sequential::pair::Form;
use crate::sequential::samples::Sample;
use crate::sequential::statistic::Peak;
use crate::sequential::thinning::Independence;
use crate::sequential::windows::WIDTHS;
use crate::time::{Span, Timestamp};
use crate::verdict::{Fault, Suspect, Verdict};

/// The mean of a minute beyond this is a fault, whatever the baseline has followed, m.
const SLOW: f64 = 6e-4;

/// The level at which an alarm ends, as a part of that at which it rises.
const CALM: f64 = 0.5;

/// A slow alarm is over below this mean of a minute, m.
const SLOW_OVER: f64 = 4e-4;

/// So often it is looked at whether the fault is a gain, cycles.
const SCALE: u32 = 20;

/// Cycles after an alarm at which it is looked at again: a few samples do not tell what it is. The pair
/// can only tell a step's side while the filter has not followed, …
pub(super) const LOOKS: [u32; 7] = [10, 16, 25, 50, 100, 200, 400];

/// … which is until so many cycles after the alarm.
const LATEST: usize = 25;

/// It takes up to so long until all cylinders together know that they are sampled otherwise, s; one of
/// them may have an alarm first.
const SHARED: f64 = 5.0;

/// So many cycles after the alarm they mostly do, and whose a noise is can be told.
pub(super) const NOISE_TOLD: u32 = 25;

/// A noise has a root mean square of more than so many healthy deviations.
const NOTABLE: f64 = 1.1;

/// As far back as innovations, and residuals at rest, are kept.
const LONGEST: usize = 50;

/// Evidence for one of the transducers that decides, nats.
const DECIDED: f64 = 5.0;

/// So many nats a step must be better than a ramp, or a ramp than a step, to be taken for one instead,
/// and to be compared as one: a slow drift is nobody's.
const CLEARLY: f64 = 3.0;

/// Alarms of longer windows come too late: the filter, and the machine, have followed.
const LOCATED: usize = 24;

/// A slower drift is followed by the filter, and in the closed loop by the machine, m/s.
const FOLLOWED: f64 = 5e-3;

impl Sequential {
    /// By what this sample and those before it are evidence of.
    pub(super) fn judge(&mut self, at: Timestamp, sample: Sample, independence: Independence) {
        if self.alarm.is_none() && independence != Independence::Repeated {
            self.clipping.take(sample.residual * sample.share);
        }
        self.history.push(sample, self.clipping.clip(), independence);
        let widest = self.alarm.map_or(WIDTHS[WIDTHS.len() - 1], |alarm| alarm.watched());
        self.peaks = self.search.step(&self.scales, &self.history, widest);
        let [mean, variance] = self.peaks;
        let level = self.design.level;
        if self.alarm.is_some() {
            self.go_on(mean.nats.max(variance.nats) < CALM * level);
        } else if mean.nats > level {
            self.raise(at, Cause::Mean, mean);
        } else if variance.nats > level {
            self.raise(at, Cause::Variance, variance);
        } else if let Some(mean) = self.slow.mean().filter(|mean| mean.abs() > SLOW) {
            self.begin(Alarm::new(Cause::Slow, Fault::Incipient, mean, at));
        }
        self.verdict = if self.alarm.is_some() { Verdict::Faulty } else { Verdict::Healthy };
        self.unknown = None;
    }

    /// By the statistic that is beyond the level.
    pub(super) fn raise(&mut self, at: Timestamp, cause: Cause, peak: Peak) {
        let back = self.history.cycles(peak.width);
        let (fault, size, cycles) = match kind::appearance(&self.history, back) {
            Some(Appearance::Noisy(size)) => (Fault::Noise, size, back),
            _ => {
                let shape = kind::shape(&self.history, self.design.deviation);
                (shape.fault, shape.size, shape.onset)
            }
        };
        let ago = Span::from_seconds(-(cycles as f64) * self.design.sample_time);
        self.begin(Alarm { peak, back, ..Alarm::new(cause, fault, size, at.after(ago)) });
    }

    pub(super) fn begin(&mut self, alarm: Alarm) {
        self.proportion.begin();
        self.alarm = Some(alarm);
    }

    /// The cylinders have found that they are sampled otherwise.
    pub(super) fn lay_to_timing(&mut self) {
        let latest = (SHARED / self.design.sample_time) as u32;
        let just = |alarm: &&mut Alarm| alarm.age <= latest && !alarm.of_timing;
        if let Some(alarm) = self.alarm.as_mut().filter(just)
            && matches!(alarm.cause, Cause::Mean | Cause::Variance)
        {
            alarm.lay_to_timing();
        }
    }

    pub(super) fn go_on(&mut self, calm: bool) {
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
        if alarm.age.is_multiple_of(SCALE) {
            alarm.scale = self.proportion.scale(alarm.scale.is_some());
        }
        self.alarm = Some(alarm);
        if alarm.calm >= self.design.clear {
            self.end();
        }
    }

    /// What it is, and whose, by what has been read since.
    fn look(&self, alarm: &mut Alarm) {
        let age = alarm.age as usize;
        match kind::appearance(&self.history, age.min(LONGEST)) {
            // A mean of many samples that stands out is no noise, however small it is beside them.
            Some(Appearance::Noisy(_))
                if alarm.cause == Cause::Mean && alarm.peak.width > LOCATED => {}
            // What healthy residuals do, too: the fault is over, or has left nothing to tell.
            Some(Appearance::Noisy(size)) if size < NOTABLE * self.design.deviation => {}
            Some(Appearance::Noisy(size)) => self.tell_noise(alarm, size),
            Some(Appearance::Steady) => self.tell_shape(alarm),
            Some(Appearance::Neither) | None => {}
        }
    }

    fn tell_shape(&self, alarm: &mut Alarm) {
        let shape = kind::shape(&self.history, self.design.deviation);
        if alarm.fault == Fault::Noise {
            // Whoever was blamed for a noise was so by its innovations: a step has others.
            alarm.clear_suspect();
        }
        if alarm.fault == Fault::Noise || shape.advantage > CLEARLY {
            alarm.fault = shape.fault;
        }
        alarm.size = shape.size;
        let speed = shape.size.abs() / (shape.onset as f64 * self.design.sample_time);
        let form = match shape.fault {
            Fault::Incipient if speed < FOLLOWED => {
                // So slow a drift may be anybody's, and what seemed a step was its beginning; but
                // not a gain's that goes on, or what a stop has told since.
                if alarm.age <= LONGEST as u32 {
                    alarm.clear_suspect();
                }
                return;
            }
            Fault::Incipient => Form::Ramp,
            _ if shape.advantage < CLEARLY => return,
            _ => Form::Step,
        };
        let age = alarm.age as usize;
        let late = age > LATEST || alarm.back > LOCATED || shape.onset > age + LOCATED;
        // What was there when the evidence began, as a drift is that the baseline began with, is no step.
        if late || !shape.seen || alarm.of_timing || alarm.suspect != Suspect::Undecided {
            return;
        }
        let pair = self.pair.as_ref();
        let evidence = pair.and_then(|pair| pair.compare(form, age, age + alarm.back + 1));
        decide(alarm, evidence);
    }

    /// Noise has no onset to compare; its innovations go on.
    fn tell_noise(&self, alarm: &mut Alarm, size: f64) {
        if alarm.fault != Fault::Noise {
            alarm.clear_suspect();
        }
        (alarm.fault, alarm.size) = (Fault::Noise, size);
        let of_timing = alarm.of_timing || self.may_be_timing;
        if alarm.suspect == Suspect::Undecided && alarm.age >= NOISE_TOLD && !of_timing {
            let span = (alarm.age as usize).min(LONGEST);
            decide(alarm, self.pair.as_ref().and_then(|pair| pair.energy(span)));
        }
    }

    /// The alarm is over. A baseline that may have followed the fault begins anew.
    pub(super) fn end(&mut self) {
        let ended = self.alarm.take();
        self.forget();
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
