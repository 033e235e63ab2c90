//! One cycle of a sequential detector: from readings to a residual, and from it to the evidence.

use super::{Input, Sequential};
use crate::sequential::alarm::{Alarm, Cause};
use crate::sequential::coverage::Unknown;
use crate::sequential::samples::{Independence, Sample};
use crate::sequential::stops::{Blame, Judgement};
use crate::time::Timestamp;
use crate::verdict::{Fault, Suspect, Testimony, Verdict};

impl Sequential {
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
