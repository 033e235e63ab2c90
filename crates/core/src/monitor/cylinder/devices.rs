//! The CANopen devices of a cylinder, and what they report on themselves.

use super::TRANSDUCERS;
use super::readings::Readings;
use crate::frame::{BusNumber, Buses};
use crate::monitor::implausible::Checked;
use crate::sample::device::{DeviceDesign, DeviceNews, DeviceState, DeviceWatch, DeviceWord};
use crate::sample::emergency::Emergency;
use crate::sample::{DeviceReport, DeviceRole, Quality, Reading};
use crate::state::state;
use crate::time::Timestamp;
use alloc::boxed::Box;

/// Watches on the devices of a cylinder, by [`DeviceRole`].
#[derive(Clone, Debug)]
pub(super) struct Watches {
    each: [Option<DeviceWatch>; 3],
}

state! {
    Watches {}
    parts { each }
}

/// The watches on the devices of `designs`; `None` without any.
pub(super) fn watches(designs: &[Option<DeviceDesign>; 3]) -> Option<Box<Watches>> {
    let watch =
        |role: DeviceRole| designs[role as usize].map(|design| DeviceWatch::new(design, role));
    let any = designs.iter().any(Option::is_some);
    any.then(|| Box::new(Watches { each: DeviceRole::ALL.map(watch) }))
}

impl Readings {
    fn watch_mut(&mut self, role: DeviceRole) -> Option<&mut DeviceWatch> {
        self.devices.as_mut()?.each[role as usize].as_mut()
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
    pub(super) fn step_devices(
        &mut self,
        heard: Buses,
        buses: &[BusNumber; 3],
        readings: &[Option<Reading>; 2],
    ) {
        let Some(watches) = &mut self.devices else { return };
        let [c1, c2] = readings.each_ref().map(Option::is_some);
        let live = buses.map(|bus| heard.has(bus));
        for (i, (watch, reads)) in watches.each.iter_mut().zip([c1, c2, false]).enumerate() {
            if let Some(watch) = watch {
                watch.step(live[i], reads);
            }
        }
    }

    /// What the device of index `i` ([`DeviceRole`]) says of itself.
    #[cold]
    pub(super) fn word(&self, i: usize) -> DeviceWord {
        let watch = self.devices.as_ref().and_then(|watches| watches.each[i].as_ref());
        watch.map_or(DeviceWord::Nothing, DeviceWatch::word)
    }

    /// Quality of the reading of index `i` after what its device says; `reads` tells whether there is one.
    #[cold]
    pub(super) fn overrule(&mut self, i: usize, reads: bool) -> Quality {
        let word = self.word(i);
        self.plausibility[i].overrule(word, reads)
    }

    /// What the device of index `i` ([`DeviceRole`]) says of its fault.
    #[cold]
    pub(super) fn report(&self, i: usize) -> Option<DeviceReport> {
        self.devices.as_ref()?.each[i].as_ref()?.report()
    }

    /// Whether the valve says that it is not operational: then the rod does not follow the command, and no
    /// transducer is at fault.
    #[inline(always)]
    pub(super) fn has_idle_valve(&self) -> bool {
        self.has_devices() && self.word(DeviceRole::Valve as usize) == DeviceWord::NotOperational
    }

    /// Passes to `report` what the devices have sent that is no fault, with the role and node-ID of each.
    pub fn take_news(&mut self, mut report: impl FnMut(DeviceRole, u8, DeviceNews)) {
        let Some(watches) = &mut self.devices else { return };
        for (role, watch) in DeviceRole::ALL.into_iter().zip(&mut watches.each) {
            let Some(watch) = watch else { continue };
            while let Some(news) = watch.take_news() {
                report(role, watch.node(), news);
            }
        }
    }

    /// Restarts the times of the devices that were `lost`, by [`DeviceRole`]; see [`DeviceWatch::interrupt`].
    pub(super) fn interrupt_devices(&mut self, lost: [bool; 3]) {
        let watches = self.devices.iter_mut().flat_map(|watches| &mut watches.each);
        let lost = watches.zip(lost).filter(|(_, lost)| *lost);
        lost.filter_map(|(watch, _)| watch.as_mut()).for_each(DeviceWatch::interrupt);
    }
}

// The first devices are the transducers.
const _: () = assert!(
    DeviceRole::C1 as usize == TRANSDUCERS[0] as usize
        && DeviceRole::C2 as usize == TRANSDUCERS[1] as usize
);
