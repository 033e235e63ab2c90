//! What becomes of an alarm: of what kind it is, which transducer, and when it is over.

use super::Sequential;
use crate::sequential::alarm::{Alarm, Cause, decide};
use crate::sequential::kind::{self, Appearance};
use crate::sequential::pair::Form;
use crate::sequential::parameters::{AlarmParameters, PairParameters, SequentialCycles};
use crate::sequential::samples::{Independence, Sample};
use crate::sequential::statistic::Peak;
use crate::sequential::windows::WIDTHS;
use crate::time::{Span, Timestamp};
use crate::verdict::{Fault, Suspect, Testimony, Verdict};

impl Sequential {
    /// By what this sample and those before it are evidence of.
    pub(super) fn judge(&mut self, at: Timestamp, sample: Sample, independence: Independence) {
        if self.alarm.is_none() && independence != Independence::Repeated {
            self.clipping.take(sample.residual * sample.share);
        }
        self.history.push(sample, self.clipping.clip(), independence);
        let AlarmParameters { least_watched, calm, slow, .. } = self.design.parameters.alarm;
        let widest = WIDTHS[WIDTHS.len() - 1];
        let widest = self.alarm.map_or(widest, |alarm| alarm.watched(least_watched));
        self.peaks = match &mut self.excursions {
            Some(excursions) => excursions.step(&sample, widest),
            None => self.search.step(&self.scales, &self.history, widest),
        };
        let [mean, variance] = self.peaks;
        let level = self.design.level;
        if self.alarm.is_some() {
            self.go_on(mean.nats.max(variance.nats) < calm * level);
        } else if mean.nats > level {
            self.raise(at, Cause::Mean, mean);
        } else if variance.nats > level {
            self.raise(at, Cause::Variance, variance);
        } else if let Some(mean) = self.slow.mean().filter(|mean| mean.abs() > slow) {
            self.begin(Alarm::new(Cause::Slow, Fault::Incipient, mean, at));
        }
        self.verdict = if self.alarm.is_some() { Verdict::Faulty } else { Verdict::Healthy };
        self.unknown = None;
    }

    /// By the statistic that is beyond the level.
    pub(super) fn raise(&mut self, at: Timestamp, cause: Cause, peak: Peak) {
        let back = match self.excursions {
            // All samples count.
            Some(_) => peak.width,
            None => self.history.cycles(peak.width),
        };
        let (fault, size, cycles) =
            match kind::appearance(&self.history, back, &self.design.parameters.kind) {
                Some(Appearance::Noisy(size)) => (Fault::Noise, size, back),
                _ => {
                    let shape = kind::shape(
                        &self.history,
                        self.design.deviation,
                        &self.design.parameters.kind,
                    );
                    (shape.fault, shape.size, shape.onset)
                }
            };
        let ago = Span::from_seconds(-(cycles as f64) * self.design.sample_time);
        self.begin(Alarm { peak, back, ..Alarm::new(cause, fault, size, at.after(ago)) });
    }

    pub(super) fn begin(&mut self, mut alarm: Alarm) {
        self.proportion.begin();
        self.locate(&mut alarm);
        self.alarm = Some(alarm);
    }

    /// The cylinders have found that they are sampled otherwise.
    pub(super) fn lay_to_timing(&mut self) {
        let latest = self.cycles.shared;
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
            Cause::Slow => {
                let over = self.design.parameters.alarm.slow_over;
                self.slow.mean().is_some_and(|mean| mean.abs() < over)
            }
            _ => calm,
        };
        alarm.stand();
        alarm.age = alarm.age.saturating_add(1);
        alarm.calm = if calm { alarm.calm + 1 } else { 0 };
        if self.cycles.looks.contains(&alarm.age)
            && matches!(alarm.cause, Cause::Mean | Cause::Variance)
        {
            self.look(&mut alarm);
        }
        self.locate(&mut alarm);
        if alarm.age.is_multiple_of(self.cycles.scale_every) {
            let before = alarm.scale.is_some();
            alarm.scale = self.proportion.scale(before);
            // What seemed a step was a gain, which leaves another signature.
            let signature = alarm.evidence.is_some() && !self.is_certain(&alarm);
            if !before && alarm.scale.is_some() && signature {
                alarm.clear_suspect();
            }
        }
        self.alarm = Some(alarm);
        if alarm.calm >= self.design.clear {
            self.end();
        }
    }

    /// What it is, and whose, by what has been read since.
    fn look(&self, alarm: &mut Alarm) {
        let age = alarm.age as usize;
        let parameters = self.design.parameters;
        let notable = parameters.alarm.notable * self.design.deviation;
        match kind::appearance(&self.history, age.min(self.cycles.looked_at), &parameters.kind) {
            // A mean of many samples that stands out is no noise, however small it is beside them.
            Some(Appearance::Noisy(_))
                if alarm.cause == Cause::Mean && alarm.peak.width > self.cycles.located => {}
            // What healthy residuals do, too: the fault is over, or has left nothing to tell.
            Some(Appearance::Noisy(size)) if size < notable => {}
            Some(Appearance::Noisy(size)) => self.name_noise(alarm, size),
            Some(Appearance::Steady) => self.name_kind(alarm),
            Some(Appearance::Neither) | None => {}
        }
    }

    fn name_kind(&self, alarm: &mut Alarm) {
        let PairParameters { clearly, followed, .. } = self.design.parameters.pair;
        let SequentialCycles { latest, located, looked_at, .. } = self.cycles;
        let shape = kind::shape(&self.history, self.design.deviation, &self.design.parameters.kind);
        if alarm.fault == Fault::Noise {
            // Whoever was blamed for a noise was so by its innovations: a step has others.
            alarm.clear_suspect();
        }
        if alarm.fault == Fault::Noise || shape.advantage > clearly {
            alarm.fault = shape.fault;
        }
        alarm.size = shape.size;
        let speed = shape.size.abs() / (shape.onset as f64 * self.design.sample_time);
        let form = match shape.fault {
            Fault::Incipient if speed < followed => {
                // So slow a drift may be anybody's, and what seemed a step was its beginning; but
                // not a gain's that goes on, or what a stop has told since, or a step's that was certain
                // and only may be a drift.
                let stays = self.is_certain(alarm) && shape.advantage < clearly;
                if alarm.age <= looked_at as u32 && !stays {
                    alarm.clear_suspect();
                }
                return;
            }
            Fault::Incipient => Form::Ramp,
            _ if shape.advantage < clearly => return,
            _ => Form::Step,
        };
        if self.excursions.is_some() {
            // Whose it is was read at its onset.
            return;
        }
        let age = alarm.age as usize;
        let late = age > latest || alarm.back > located || shape.onset > age + located;
        // What was there when the evidence began, as a drift is that the baseline began with, is no step.
        if late || !shape.seen || alarm.of_timing || alarm.suspect != Suspect::Undecided {
            return;
        }
        if let Some(pair) = &self.pair {
            let evidence = pair.compare(form, age, age + alarm.back + 1);
            decide(alarm, Testimony::Innovations, evidence, pair.decided());
        }
    }

    /// Whether the side is told, and better than an explanation that is a little better could undo.
    fn is_certain(&self, alarm: &Alarm) -> bool {
        let certain = self.design.parameters.pair.certain;
        alarm.evidence.is_some_and(|nats| nats.abs() > certain)
    }

    /// Noise has no onset to compare; its innovations go on.
    fn name_noise(&self, alarm: &mut Alarm, size: f64) {
        if alarm.fault != Fault::Noise {
            alarm.clear_suspect();
        }
        (alarm.fault, alarm.size) = (Fault::Noise, size);
        let of_timing = alarm.of_timing || self.may_be_timing;
        if alarm.suspect == Suspect::Undecided && alarm.age >= self.cycles.noise_told && !of_timing
        {
            let span = (alarm.age as usize).min(self.cycles.looked_at);
            let evidence = self.pair.as_ref().and_then(|pair| pair.energy(span));
            decide(alarm, Testimony::Innovations, evidence, self.design.parameters.alarm.decided);
        }
    }

    /// Whether an alarm stands because the readings have moved apart.
    pub fn is_displaced(&self) -> bool {
        self.alarm
            .is_some_and(|it| it.fault != Fault::Noise && !it.of_timing && it.cause != Cause::Dwell)
    }

    /// Whether an alarm stands that looks like a gain that is off.
    pub fn is_gain(&self) -> bool {
        self.alarm.is_some_and(|it| it.scale.is_some())
    }

    /// Takes the evidence of whose reading has moved that something beside the readings and the command gives, nats,
    /// where these alone have not told.
    pub fn take_evidence(&mut self, by: Testimony, nats: f64) {
        let enough = self.design.parameters.alarm.decided_by_the_rod;
        if let Some(alarm) = self.alarm.as_mut().filter(|it| it.suspect == Suspect::Undecided)
            && nats.abs() > enough
        {
            decide(alarm, by, Some(nats), enough);
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
