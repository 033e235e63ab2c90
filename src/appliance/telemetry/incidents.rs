//! The incidents of a cylinder, or of the machine, that are not closed, in atomics.

use super::cell::Total;
use crate::alarm::Level;
use crate::incident::{Cylinders, Incident, MOST_AT_ONCE, Progress, Scope};
use crate::story;
use crate::time::Timestamp;
use crate::verdict::{Fault, Suspect};
use serde::Serialize;
use std::sync::atomic::{AtomicI64, AtomicU64, Ordering};

/// The places for the open incidents of one cylinder, or of the machine. One thread writes.
#[derive(Debug, Default)]
pub(super) struct Incidents {
    slots: [Slot; MOST_AT_ONCE],
    pub opened: Total,
}

/// An incident in two words, of which the first is zero without one: its number in the upper half, then the cylinders of
/// one that is the machine's, level, suspect and fault, a byte each.
#[derive(Debug, Default)]
struct Slot {
    packed: AtomicU64,
    begin: AtomicI64,
}

/// An open incident.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OpenSlot {
    pub number: u32,
    /// The cylinders that an incident of the machine concerns; none of one cylinder's own.
    pub cylinders: Cylinders,
    pub level: Level,
    pub suspect: Suspect,
    pub fault: Fault,
    /// Time stamp of its first warning.
    pub begin: Timestamp,
}

/// An open incident, for people and scripts.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct OpenIncident {
    pub number: u32,
    /// Its cylinder; `None` for what is the machine's.
    pub cylinder: Option<usize>,
    /// The cylinders that an incident of the machine concerns.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub cylinders: Vec<u8>,
    pub suspect: &'static str,
    pub level: &'static str,
    pub fault: &'static str,
    /// The fault in words: `growing error`.
    pub kind: &'static str,
    /// Time stamp of its first warning, s.
    pub begin: f64,
    /// In words: `cylinder 5, C1, black: growing error`.
    pub summary: String,
}

impl OpenSlot {
    /// Whether it is the machine's.
    pub fn is_of_machine(&self) -> bool {
        self.cylinders != Cylinders::NONE
    }

    /// The fault in words: `growing error`.
    pub fn kind(&self) -> &'static str {
        match self.is_of_machine() {
            true => story::in_common(self.fault),
            false => story::what(self.suspect, self.fault),
        }
    }

    /// In words: `cylinder 5, C1, black: growing error`.
    pub fn summary(&self, cylinder: usize) -> String {
        let of = match self.is_of_machine() {
            true => story::of_machine(self.cylinders),
            false => format!("cylinder {cylinder}, {}", story::whom(self.suspect)),
        };
        format!("{of}, {}: {}", self.level.name(), self.kind())
    }
}

impl OpenIncident {
    /// Whether it concerns the cylinder with this number, from 1.
    pub fn concerns(&self, cylinder: usize) -> bool {
        let mut all = self.cylinders.iter().map(|number| usize::from(*number));
        self.cylinder == Some(cylinder) || all.any(|number| number == cylinder)
    }
}

impl Incidents {
    /// Takes an incident that was opened, revised or closed.
    pub fn take(&self, incident: &Incident) {
        let number = u64::from(incident.number);
        let is = |slot: &&Slot| slot.packed.load(Ordering::Relaxed) >> 32 == number;
        let known = self.slots.iter().find(is);
        match incident.progress {
            Progress::Closed => {
                known.into_iter().for_each(|slot| slot.packed.store(0, Ordering::Relaxed));
                return;
            }
            Progress::Opened => self.opened.add(1),
            Progress::Revised | Progress::Standing => {}
        }
        let free = |slot: &&Slot| slot.packed.load(Ordering::Relaxed) == 0;
        let Some(slot) = known.or_else(|| self.slots.iter().find(free)) else { return };
        let level = incident.level as u64;
        let (suspect, fault) = (incident.suspect as u64, incident.fault as u64);
        slot.begin.store(incident.begin.as_nanos(), Ordering::Relaxed);
        let cylinders = match incident.scope {
            Scope::Cylinder(_) => Cylinders::NONE,
            Scope::Machine(cylinders) => cylinders,
        };
        let what = u64::from(cylinders.bits()) << 24 | level << 16 | suspect << 8 | fault;
        slot.packed.store(number << 32 | what, Ordering::Release);
    }

    /// Forgets all of them: another monitor counts anew.
    pub fn clear(&self) {
        self.slots.iter().for_each(|slot| slot.packed.store(0, Ordering::Relaxed));
    }

    /// The open incidents.
    pub fn slots(&self) -> impl Iterator<Item = OpenSlot> {
        self.slots.iter().filter_map(|slot| {
            let packed = slot.packed.load(Ordering::Acquire);
            let number = u32::try_from(packed >> 32).ok().filter(|number| *number > 0)?;
            let byte = |shift: u32| (packed >> shift & 0xFF) as usize;
            Some(OpenSlot {
                number,
                cylinders: Cylinders::from_bits(byte(24) as u8),
                level: *Level::ALL.get(byte(16))?,
                suspect: *Suspect::ALL.get(byte(8))?,
                fault: *Fault::ALL.get(byte(0))?,
                begin: Timestamp::from_nanos(slot.begin.load(Ordering::Relaxed)),
            })
        })
    }

    /// The open incidents of the cylinder `cylinder`, or of the machine, for people and scripts.
    pub fn open(&self, cylinder: usize) -> impl Iterator<Item = OpenIncident> {
        self.slots().map(move |open| OpenIncident {
            number: open.number,
            cylinder: Some(cylinder).filter(|_| !open.is_of_machine()),
            cylinders: open.cylinders.numbers().collect(),
            suspect: open.suspect.name(),
            level: open.level.name(),
            fault: open.fault.name(),
            kind: open.kind(),
            begin: open.begin.as_seconds(),
            summary: open.summary(cylinder),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A new variant has a place in the list, or an open incident would be shown as another one.
    #[test]
    fn numbers_are_places() {
        for (place, level) in Level::ALL.into_iter().enumerate() {
            assert_eq!(level as usize, place);
        }
        for (place, suspect) in Suspect::ALL.into_iter().enumerate() {
            assert_eq!(suspect as usize, place);
        }
        for (place, fault) in Fault::ALL.into_iter().enumerate() {
            assert_eq!(fault as usize, place);
        }
    }
}
