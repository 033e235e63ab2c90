//! The devices of a cylinder, and what they say of themselves.

use super::{Cylinder, TRANSDUCERS};
use crate::monitor::implausible::Checked;
use crate::sample::device::{DeviceDesign, DeviceNews, DeviceState, DeviceWatch, DeviceWord};
use crate::sample::emergency::Emergency;
use crate::sample::{DeviceReport, DeviceRole, Quality, Reading};
use crate::time::Timestamp;
use alloc::boxed::Box;

/// Watches on the devices of a cylinder, by [`DeviceRole`].
pub(super) type Watches = Box<[Option<DeviceWatch>; 3]>;

/// The watches on the devices of `designs`; `None` without any.
pub(super) fn watches(designs: &[Option<DeviceDesign>; 3]) -> Option<Watches> {
    let watch =
        |role: DeviceRole| designs[role as usize].map(|design| DeviceWatch::new(design, role));
    let any = designs.iter().any(Option::is_some);
    any.then(|| Box::new(DeviceRole::ALL.map(watch)))
}

impl Cylinder {
    fn watch_mut(&mut self, role: DeviceRole) -> Option<&mut DeviceWatch> {
        self.devices.as_mut()?[role as usize].as_mut()
    }

    pub fn hear_heartbeat(&mut self, role: DeviceRole, state: DeviceState) {
        if let Some(watch) = self.watch_mut(role) {
            watch.heartbeat(state);
        }
    }

    /// Takes an emergency message; returns whether it raises a warning.
    pub fn hear_emergency(
        &mut self,
        role: DeviceRole,
        at: Timestamp,
        emergency: Emergency,
    ) -> bool {
        let Some(watch) = self.watch_mut(role) else { return false };
        watch.emergency(emergency);
        let (failed, report) = (watch.said() == DeviceWord::Failed, watch.report());
        let implausible = &mut self.implausible[role as usize];
        let raises = failed && !implausible.raised();
        if raises {
            implausible.judge(at, Checked { quality: Quality::Failed, beyond: 0.0, report });
        }
        raises
    }

    /// What the devices say in a cycle, by [`DeviceRole`].
    #[inline(always)]
    pub(super) fn listen(
        &mut self,
        live: bool,
        readings: &[Option<Reading>; 2],
    ) -> [DeviceWord; 3] {
        if self.devices.is_none() {
            return [DeviceWord::Nothing; 3];
        }
        self.step_devices(live, readings.each_ref().map(Option::is_some))
    }

    #[inline(never)]
    fn step_devices(&mut self, live: bool, [c1, c2]: [bool; 2]) -> [DeviceWord; 3] {
        let Some(watches) = &mut self.devices else { return [DeviceWord::Nothing; 3] };
        let reads = [c1, c2, false];
        core::array::from_fn(|i| {
            watches[i].as_mut().map_or(DeviceWord::Nothing, |watch| watch.step(live, reads[i]))
        })
    }

    /// What the device of index `i` ([`DeviceRole`]) says of its fault.
    #[cold]
    pub(super) fn report(&self, i: usize) -> Option<DeviceReport> {
        self.devices.as_ref()?[i].as_ref()?.report()
    }

    /// Whether the valve says that it is not operational: then the rod does not follow the command, and no
    /// transducer is at fault.
    #[inline]
    pub(super) fn has_idle_valve(&self) -> bool {
        self.devices.as_ref().is_some_and(|watches| {
            let valve = watches[DeviceRole::Valve as usize].as_ref();
            valve.is_some_and(|watch| watch.said() == DeviceWord::NotOperational)
        })
    }

    /// Passes to `tell` what the devices have said that is no fault, with the role and node-ID of each.
    #[inline]
    pub fn take_news(&mut self, mut tell: impl FnMut(DeviceRole, u8, DeviceNews)) {
        let Some(watches) = &mut self.devices else { return };
        for (role, watch) in DeviceRole::ALL.into_iter().zip(watches.iter_mut()) {
            let Some(watch) = watch else { continue };
            while let Some(news) = watch.take_news() {
                tell(role, watch.node(), news);
            }
        }
    }

    /// Restarts the times of the devices; see [`DeviceWatch::interrupt`].
    pub(super) fn interrupt_devices(&mut self) {
        let watches = self.devices.iter_mut().flat_map(|watches| watches.iter_mut());
        watches.flatten().for_each(DeviceWatch::interrupt);
    }
}

// The first devices are the transducers.
const _: () = assert!(
    DeviceRole::C1 as usize == TRANSDUCERS[0] as usize
        && DeviceRole::C2 as usize == TRANSDUCERS[1] as usize
);
