//! The CANopen devices of a cylinder, and what they report on themselves.

use crate::sample::device::{DeviceDesign, DeviceNews, DeviceWatch};
use crate::sample::{DeviceRole, Transducer};
use crate::state::state;
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

impl Watches {
    /// The watches on the devices of `designs`; `None` without any.
    pub fn of(designs: &[Option<DeviceDesign>; 3]) -> Option<Box<Self>> {
        let watch =
            |role: DeviceRole| designs[role as usize].map(|design| DeviceWatch::new(design, role));
        let any = designs.iter().any(Option::is_some);
        any.then(|| Box::new(Self { each: DeviceRole::ALL.map(watch) }))
    }

    pub fn watch(&self, role: DeviceRole) -> Option<&DeviceWatch> {
        self.each[role as usize].as_ref()
    }

    pub fn watch_mut(&mut self, role: DeviceRole) -> Option<&mut DeviceWatch> {
        self.each[role as usize].as_mut()
    }

    /// Takes a cycle; `live` and `reads` are those of [`DeviceWatch::step`].
    pub fn step(&mut self, live: [bool; 3], reads: [bool; 3]) {
        for (i, (watch, reads)) in self.each.iter_mut().zip(reads).enumerate() {
            if let Some(watch) = watch {
                watch.step(live[i], reads);
            }
        }
    }

    /// Passes to `report` what the devices have sent that is no fault, with the role and node-ID of each.
    pub fn take_news(&mut self, mut report: impl FnMut(DeviceRole, u8, DeviceNews)) {
        for (role, watch) in DeviceRole::ALL.into_iter().zip(&mut self.each) {
            let Some(watch) = watch else { continue };
            while let Some(news) = watch.take_news() {
                report(role, watch.node(), news);
            }
        }
    }

    /// Restarts the times of the devices that were `lost`; see [`DeviceWatch::interrupt`].
    pub fn interrupt(&mut self, lost: [bool; 3]) {
        let lost = self.each.iter_mut().zip(lost).filter(|(_, lost)| *lost);
        lost.filter_map(|(watch, _)| watch.as_mut()).for_each(DeviceWatch::interrupt);
    }
}

// The first devices are the transducers.
const _: () = assert!(
    DeviceRole::C1 as usize == Transducer::C1 as usize
        && DeviceRole::C2 as usize == Transducer::C2 as usize
);
