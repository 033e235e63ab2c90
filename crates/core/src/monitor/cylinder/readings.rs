//! Readings of a cylinder: which of them can be relied on. What is plain is so at once, all else is judged out of line.

use super::devices::Watches;
use super::{CylinderDesign, Evaluation};
use crate::blame::{Accuser, BlameMemory};
use crate::frame::{BusNumber, Buses};
use crate::monitor::gate::Opening;
use crate::monitor::implausible::{Checked, Implausible};
use crate::sample::device::{DeviceNews, DeviceState, DeviceWatch, DeviceWord};
use crate::sample::emergency::Emergency;
use crate::sample::motion::ReadingMotion;
use crate::sample::plausibility::{Moment, Other, Plausibility, Push};
use crate::sample::{DeviceReport, DeviceRole, Inputs, Quality, Reading, Transducer};
use crate::sequential::Sequential;
use crate::state::state;
use crate::time::Timestamp;
use crate::verdict::{Bank, Fault, Suspect};
use alloc::boxed::Box;

/// Checks of the readings and the command of a cylinder, and their warnings.
#[derive(Clone, Debug)]
pub struct Readings {
    pub(super) plausibility: [Plausibility; 2],
    motions: [ReadingMotion; 2],
    /// By [`DeviceRole`].
    pub(super) implausible: [Implausible; 3],
    /// `None` without devices that report on themselves.
    devices: Option<Box<Watches>>,
}

state! {
    Readings { plausibility, motions, implausible }
    parts { devices }
}

/// What a reading is judged by that is not plain.
pub(super) struct CheckContext<'a> {
    pub now: Evaluation,
    pub design: &'a CylinderDesign,
    pub inputs: &'a Inputs,
    /// Way in one cycle of the command, m, signed.
    pub way: f64,
    /// Lowest and highest length while nothing was found, m.
    pub been: [f64; 2],
    pub sequential: Option<&'a Sequential>,
    pub bank: &'a Bank,
    pub blame: &'a BlameMemory,
}

impl Readings {
    pub(super) fn new(design: &CylinderDesign) -> Self {
        Self {
            plausibility: design.limits.each_ref().map(|limits| Plausibility::new(limits.clone())),
            motions: [ReadingMotion::default(); 2],
            implausible: core::array::from_fn(|_| Implausible::new(design.clear)),
            devices: Watches::of(&design.devices),
        }
    }

    /// Takes the readings of a cycle, before they are checked.
    #[inline(always)]
    pub(super) fn take(
        &mut self,
        now: &Evaluation,
        design: &CylinderDesign,
        readings: &[Option<Reading>; 2],
    ) {
        if self.has_devices() {
            self.step_devices(now.heard, &design.buses, readings);
        }
        for (motion, reading) in self.motions.iter_mut().zip(readings) {
            motion.follow(reading.as_ref().map(|reading| reading.position));
        }
    }

    /// Reading of a transducer, m, if it was sound when it was last judged.
    #[inline(always)]
    fn relied_on(&self, i: usize, readings: &[Option<Reading>; 2]) -> Option<f64> {
        let sound = self.plausibility[i].quality().is_good();
        readings[i].as_ref().filter(|_| sound).map(|reading| reading.position)
    }

    /// Takes the reading of transducer `i` if it is plain. Returns whether it was, and whether that is all: nearly always what
    /// is good and stands for nothing changes nothing.
    #[inline(always)]
    pub(super) fn take_plain(&mut self, i: usize, readings: &[Option<Reading>; 2]) -> (bool, bool) {
        let beside = self.relied_on(1 - i, readings);
        let is_plain = self.plausibility[i].take_plain(readings[i].as_ref(), beside);
        (is_plain, is_plain && !self.has_devices() && !self.implausible[i].raised())
    }

    /// Judges what is no plain reading, or was none.
    #[inline(never)]
    pub(super) fn judge(
        &mut self,
        i: usize,
        is_plain: bool,
        readings: &[Option<Reading>; 2],
        context: &CheckContext<'_>,
    ) -> Quality {
        let (now, reading) = (&context.now, readings[i].as_ref());
        let mut quality = Quality::Good;
        if !is_plain {
            let way = if now.gate == Opening::Open { context.way } else { 0.0 };
            let beside = self.relied_on(1 - i, readings);
            let moment = Moment {
                live: now.heard.has(context.design.buses[i]),
                push: Push::of(way, 0.0),
                way,
                been: context.been,
                other: beside.map(|position| Other::new(position, &self.motions[1 - i])),
            };
            quality = self.plausibility[i].judge(reading, moment);
        }
        if self.has_devices() {
            quality = self.overrule(i, reading.is_some());
        }
        if !quality.is_good() || self.implausible[i].raised() {
            quality = self.judge_implausible(i, reading, quality, context);
        }
        quality
    }

    /// Judges what is not good, or was not; returns the quality that it is taken for.
    fn judge_implausible(
        &mut self,
        i: usize,
        reading: Option<&Reading>,
        mut quality: Quality,
        context: &CheckContext<'_>,
    ) -> Quality {
        let is_absent = matches!(quality, Quality::Missing | Quality::Stale);
        let is_heard_of = self.word(i) != DeviceWord::Lost;
        if is_absent && context.inputs.is_doubted(Transducer::ALL[i]) {
            quality = self.plausibility[i].doubt();
        } else if is_absent && is_heard_of && context.inputs.is_refused(Transducer::ALL[i]) {
            quality = self.plausibility[i].spare();
        }
        if quality == Quality::Frozen && self.may_be_at_rest(i, context) {
            quality = self.plausibility[i].take_for_rest();
        }
        let checks = &self.plausibility[i];
        let beyond = reading.map_or(0.0, |reading| checks.beyond(reading.position));
        let report = self.report(i);
        self.implausible[i].judge(context.now.at, Checked { quality, beyond, report });
        quality
    }

    /// Whether reading `i`, which seems frozen, may be that of a rod at rest: the only witness is the other reading, which
    /// had parted from it long before it came to stand, and is not known to be right.
    fn may_be_at_rest(&self, i: usize, context: &CheckContext<'_>) -> bool {
        let parted = context.sequential.filter(|it| it.is_displaced());
        let alarm = parted.and_then(Sequential::alarm);
        let (reading, own) = (&self.plausibility[i], [Suspect::C1, Suspect::C2][i]);
        let alarm = alarm.map(|it| (it.suspect, it.stood));
        let named = context.blame.pattern.proposal(Accuser::Fde3).map(|it| it.suspect);
        let mut apart = [alarm, named.zip(context.bank.difference_age())].into_iter().flatten();
        let before = reading.idle().saturating_add(context.design.observers[i].settle);
        let is_older = |(suspect, age)| suspect != own && age > before;
        apart.any(is_older) && !reading.is_driven()
    }

    /// Judges a command of this quality, where that is not good, or was not.
    #[inline]
    pub(super) fn check_command(&mut self, quality: Quality, at: Timestamp) {
        let is_odd = !quality.is_good() || self.implausible[DeviceRole::Valve as usize].raised();
        if is_odd || self.has_devices() {
            self.doubt_command(quality, at);
        }
    }

    #[inline(never)]
    fn doubt_command(&mut self, quality: Quality, at: Timestamp) {
        let quality = match self.word(DeviceRole::Valve as usize) {
            DeviceWord::Failed => Quality::Failed,
            DeviceWord::Lost => Quality::Stale,
            DeviceWord::Nothing | DeviceWord::NotOperational => quality,
        };
        let report = self.report(DeviceRole::Valve as usize);
        self.implausible[DeviceRole::Valve as usize]
            .judge(at, Checked { quality, beyond: 0.0, report });
    }

    /// Readings, m, that the machine itself compares: it replaces one without a signal, or an impossible one, by the other.
    #[inline(always)]
    pub(super) fn measured(&self, readings: &[Option<Reading>; 2]) -> [Option<f64>; 2] {
        [0, 1].map(|i: usize| {
            let taken = matches!(self.plausibility[i].quality(), Quality::Good | Quality::Frozen);
            readings[i].as_ref().filter(|_| taken).map(|reading| reading.position)
        })
    }

    pub(super) fn quality(&self, i: usize) -> Quality {
        self.plausibility[i].quality()
    }

    /// Whether a warning stands of transducer `i`.
    pub(super) fn is_implausible(&self, i: usize) -> bool {
        self.implausible[i].raised()
    }

    pub(super) fn any_implausible(&self) -> bool {
        self.implausible.iter().any(Implausible::raised)
    }

    pub(super) fn is_frozen(&self, i: usize) -> bool {
        self.implausible[i].raised() && self.implausible[i].fault == Fault::Frozen
    }

    /// Whether there is anything that [`Self::take_unnamed`] returns.
    #[inline]
    pub const fn has_unnamed(&self) -> bool {
        self.plausibility[0].unnamed.has_news() || self.plausibility[1].unnamed.has_news()
    }

    /// Bits of a status that were never set before, and to which the configuration gives no meaning.
    pub fn take_unnamed(&mut self) -> impl Iterator<Item = (Transducer, u64)> {
        let news = Transducer::ALL.into_iter().zip(&mut self.plausibility);
        news.filter_map(|(transducer, it)| Some((transducer, it.unnamed.take_news()?)))
    }

    /// Restarts what was learnt of the motion by what was `lost`, of C1, C2 and the command.
    pub(super) fn interrupt(&mut self, lost: [bool; 3]) {
        for i in (0..2).filter(|i| lost[*i]) {
            self.plausibility[i].reset();
            self.motions[i] = ReadingMotion::default();
        }
        let warnings = self.implausible.iter_mut().zip(lost).filter(|(_, lost)| *lost);
        warnings.for_each(|(warning, _)| warning.trigger.interrupt());
        if let Some(watches) = &mut self.devices {
            watches.interrupt(lost);
        }
    }
    fn watch(&self, role: DeviceRole) -> Option<&DeviceWatch> {
        self.devices.as_ref()?.watch(role)
    }

    fn watch_mut(&mut self, role: DeviceRole) -> Option<&mut DeviceWatch> {
        self.devices.as_mut()?.watch_mut(role)
    }

    pub fn take_heartbeat(&mut self, role: DeviceRole, state: DeviceState) {
        if let Some(watch) = self.watch_mut(role) {
            watch.heartbeat(state);
        }
    }

    /// Takes an emergency message; returns whether it raises a warning.
    pub fn take_emergency(
        &mut self,
        role: DeviceRole,
        at: Timestamp,
        emergency: Emergency,
    ) -> bool {
        let Some(watch) = self.watch_mut(role) else { return false };
        watch.emergency(emergency);
        let (failed, report) = (watch.word() == DeviceWord::Failed, watch.report());
        let implausible = &mut self.implausible[role as usize];
        let raises = failed && !implausible.raised();
        if raises {
            implausible.judge(at, Checked { quality: Quality::Failed, beyond: 0.0, report });
        }
        raises
    }

    /// Whether it has devices that report on themselves.
    #[inline(always)]
    pub const fn has_devices(&self) -> bool {
        self.devices.is_some()
    }

    /// Takes a cycle with these `readings`; see [`DeviceWatch::step`].
    #[cold]
    fn step_devices(
        &mut self,
        heard: Buses,
        buses: &[BusNumber; 3],
        readings: &[Option<Reading>; 2],
    ) {
        let Some(watches) = &mut self.devices else { return };
        let [c1, c2] = readings.each_ref().map(Option::is_some);
        watches.step(buses.map(|bus| heard.has(bus)), [c1, c2, false]);
    }

    /// What the device of index `i` ([`DeviceRole`]) says of itself.
    #[cold]
    fn word(&self, i: usize) -> DeviceWord {
        self.watch(DeviceRole::ALL[i]).map_or(DeviceWord::Nothing, DeviceWatch::word)
    }

    /// Quality of the reading of index `i` after what its device says; `reads` tells whether there is one.
    #[cold]
    fn overrule(&mut self, i: usize, reads: bool) -> Quality {
        let word = self.word(i);
        self.plausibility[i].overrule(word, reads)
    }

    /// What the device of index `i` ([`DeviceRole`]) says of its fault.
    #[cold]
    fn report(&self, i: usize) -> Option<DeviceReport> {
        self.watch(DeviceRole::ALL[i])?.report()
    }

    /// Whether the valve says that it is not operational: then the rod does not follow the command, and no
    /// transducer is at fault.
    #[inline(always)]
    pub(super) fn has_idle_valve(&self) -> bool {
        self.has_devices() && self.word(DeviceRole::Valve as usize) == DeviceWord::NotOperational
    }

    /// Passes to `report` what the devices have sent that is no fault, with the role and node-ID of each.
    pub fn take_news(&mut self, report: impl FnMut(DeviceRole, u8, DeviceNews)) {
        if let Some(watches) = &mut self.devices {
            watches.take_news(report);
        }
    }
}
