//! What becomes of an alarm: of what kind it is, which transducer, and when it is over.

use super::Sequential;
use crate::sequential::alarm::{Alarm, Cause};
use crate::sequential::kind;
use crate::sequential::pair::Form;
use crate::sequential::statistic::Peak;
use crate::time::{Span, Timestamp};
use crate::verdict::{Fault, Suspect};

/// A slow alarm is over below this mean of a minute, m.
const SLOW_OVER: f64 = 4e-4;

/// Cycles after an alarm at which the readings are compared, …
const COMPARE: u32 = 10;

/// … and at which noise is told from a step, and its transducer; twice, as a few draws of noise may
/// have a mean.
const NOISE: [u32; 2] = [25, 50];

/// So often it is looked at whether the fault is a gain; not at the cycles above, cycles.
const SCALE: u32 = 20;

/// Evidence for one of the transducers that decides, nats.
const DECIDED: f64 = 5.0;

/// Alarms of longer windows come too late: the filter, and the machine, have followed.
const LOCATED: usize = 16;

/// A slower drift is followed by the filter, and in the closed loop by the machine, m/s.
const FOLLOWED: f64 = 5e-3;

/// A transducer has this much more of the innovations' energy to be blamed for a noise.
const NOISIER: f64 = 0.25;

impl Sequential {
    pub(super) fn raise(&mut self, at: Timestamp, cause: Cause, peak: Peak) {
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
        self.proportion.begin();
        self.alarm = Some(Alarm {
            cause,
            peak,
            fault,
            suspect: Suspect::Undecided,
            evidence: None,
            size,
            scale: None,
            onset: at.after(Span::from_seconds(-(cycles as f64) * self.design.sample_time)),
            age: 0,
            calm: 0,
        });
    }

    fn spread(&self, width: usize) -> f64 {
        let squares = self.history.moving.over(width).or_else(|| self.history.all.over(width));
        squares.map_or(0.0, |[_, _, _, squares]| (squares / width as f64).sqrt())
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
        match alarm.age {
            COMPARE if self.may_have_stepped(&alarm) => self.compare(&mut alarm),
            age if NOISE.contains(&age) && matches!(alarm.cause, Cause::Mean | Cause::Variance) => {
                self.tell_noise(&mut alarm);
            }
            age if age % SCALE == 0 => alarm.scale = self.proportion.scale(alarm.scale.is_some()),
            _ => {}
        }
        self.alarm = Some(alarm);
        if alarm.calm >= self.design.clear {
            self.end();
        }
    }

    /// The alarm is over. A baseline that may have followed the fault begins anew.
    pub(super) fn end(&mut self) {
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
