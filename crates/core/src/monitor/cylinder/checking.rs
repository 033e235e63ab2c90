//! Plausibility of the readings of a cylinder: what is plain at once, all else out of line.

use super::{Cylinder, Evaluation, TRANSDUCERS};
use crate::blame::Accuser;
use crate::monitor::gate::Opening;
use crate::monitor::implausible::Checked;
use crate::sample::device::DeviceWord;
use crate::sample::plausibility::{Moment, Other, Push};
use crate::sample::{Quality, Reading, Transducer};
use crate::sequential::Sequential;
use crate::time::Timestamp;
use crate::verdict::Suspect;

impl Cylinder {
    /// Reading of a transducer, m, if it was sound when it was last judged.
    #[inline(always)]
    fn relied_on(&self, i: usize, readings: &[Option<Reading>; 2]) -> Option<f64> {
        let sound = self.plausibility[i].quality().is_good();
        readings[i].as_ref().filter(|_| sound).map(|reading| reading.position)
    }

    /// Whether the reading of a cycle is good, and whether it is odd: not good, or a warning of its plausibility stands.
    #[inline(always)]
    pub(super) fn check(
        &mut self,
        i: usize,
        readings: &[Option<Reading>; 2],
        now: Evaluation,
    ) -> (bool, bool) {
        let (reading, beside) = (readings[i].as_ref(), self.relied_on(1 - i, readings));
        let is_plain = self.plausibility[i].take_plain(reading, beside);
        // Nearly always: what is good and stands for nothing changes nothing.
        if is_plain && !self.speaks() && !self.implausible[i].raised() {
            return (true, false);
        }
        let is_good = self.judge_plausibility(i, is_plain, readings, now).is_good();
        (is_good, !is_good || self.implausible[i].raised())
    }

    /// Whether there is anything that [`Self::take_unnamed`] returns.
    #[inline]
    pub const fn has_unnamed(&self) -> bool {
        self.plausibility[0].unnamed.has_news() || self.plausibility[1].unnamed.has_news()
    }

    /// Bits of a status that were never set before, and to which the configuration gives no meaning.
    pub fn take_unnamed(&mut self) -> impl Iterator<Item = (Transducer, u64)> {
        let news = TRANSDUCERS.into_iter().zip(&mut self.plausibility);
        news.filter_map(|(transducer, it)| Some((transducer, it.unnamed.take_news()?)))
    }

    /// Judges what is no plain reading, or was none.
    #[inline(never)]
    fn judge_plausibility(
        &mut self,
        i: usize,
        is_plain: bool,
        readings: &[Option<Reading>; 2],
        now: Evaluation,
    ) -> Quality {
        let reading = readings[i].as_ref();
        let mut quality = Quality::Good;
        if !is_plain {
            let way = if now.gate == Opening::Open { self.way } else { 0.0 };
            let beside = self.relied_on(1 - i, readings);
            let moment = Moment {
                live: now.heard.has(self.design.buses[i]),
                push: Push::of(way, 0.0),
                way,
                been: self.last.been(),
                other: beside.map(|position| Other::new(position, &self.motions[1 - i])),
            };
            quality = self.plausibility[i].judge(reading, moment);
        }
        if self.speaks() {
            quality = self.overrule(i, reading.is_some());
        }
        if !quality.is_good() || self.implausible[i].raised() {
            quality = self.judge_implausible(i, reading, quality, now.at);
        }
        quality
    }

    /// Judges what is not good, or was not; returns the quality that it is taken for.
    fn judge_implausible(
        &mut self,
        i: usize,
        reading: Option<&Reading>,
        mut quality: Quality,
        at: Timestamp,
    ) -> Quality {
        let is_absent = matches!(quality, Quality::Missing | Quality::Stale);
        let is_heard_of = self.word(i) != DeviceWord::Lost;
        if is_absent && self.inputs.is_doubted(TRANSDUCERS[i]) {
            quality = self.plausibility[i].doubt();
        } else if is_absent && is_heard_of && self.inputs.is_refused(TRANSDUCERS[i]) {
            quality = self.plausibility[i].spare();
        }
        if quality == Quality::Frozen && self.may_be_at_rest(i) {
            quality = self.plausibility[i].take_for_rest();
        }
        let checks = &self.plausibility[i];
        let beyond = reading.map_or(0.0, |reading| checks.beyond(reading.position));
        let report = self.report(i);
        self.implausible[i].judge(at, Checked { quality, beyond, report });
        self.tally.implausible[i] += u64::from(reading.is_some() && !quality.is_good());
        quality
    }

    /// Whether reading `i`, which seems frozen, may be that of a rod at rest: the only witness is the other reading, which
    /// had parted from it long before it came to stand, and is not known to be right.
    fn may_be_at_rest(&self, i: usize) -> bool {
        let parted = self.sequential.as_deref().filter(|it| it.is_displaced());
        let alarm = parted.and_then(Sequential::alarm);
        let (reading, own) = (&self.plausibility[i], [Suspect::C1, Suspect::C2][i]);
        let alarm = alarm.map(|it| (it.suspect, it.stood));
        let named = self.blame.pattern.proposal(Accuser::Fde3).map(|it| it.suspect);
        let mut apart = [alarm, named.zip(self.bank.difference_age())].into_iter().flatten();
        let before = reading.idle().saturating_add(self.design.observers[i].settle);
        let is_older = |(suspect, age)| suspect != own && age > before;
        apart.any(is_older) && !reading.is_driven()
    }
}
