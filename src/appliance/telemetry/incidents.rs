//! The incidents of a cylinder that are not closed, in atomics.

use super::cell::Total;
use crate::alarm::Level;
use crate::incident::{Incident, MOST_AT_ONCE, Progress};
use crate::story;
use crate::time::Timestamp;
use crate::verdict::{Fault, Suspect};
use serde::Serialize;
use std::sync::atomic::{AtomicI64, AtomicU64, Ordering};

/// The places for the open incidents of one cylinder. One thread writes.
#[derive(Debug, Default)]
pub(super) struct Incidents {
    slots: [Slot; MOST_AT_ONCE],
    pub opened: Total,
}

/// An incident in two words, of which the first is zero without one: its number in the upper half, then whether its
/// cylinder has C1 alone, level, suspect and fault, a byte each.
#[derive(Debug, Default)]
struct Slot {
    packed: AtomicU64,
    begin: AtomicI64,
}

/// An open incident.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OpenSlot {
    pub number: u32,
    pub level: Level,
    pub suspect: Suspect,
    pub fault: Fault,
    /// Whether its cylinder has C1 alone.
    pub is_alone: bool,
    /// Time stamp of its first warning.
    pub begin: Timestamp,
}

/// An open incident, for people and scripts.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct OpenIncident {
    pub number: u32,
    pub cylinder: usize,
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
    /// In words: `cylinder 5, C1, black: growing error`.
    pub fn summary(&self, cylinder: usize) -> String {
        let (whom, kind) =
            (story::whom(self.suspect, self.is_alone), story::what(self.suspect, self.fault));
        format!("cylinder {cylinder}, {whom}, {}: {kind}", self.level.name())
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
        let (level, alone) = (incident.level as u64, u64::from(incident.is_alone()));
        let (suspect, fault) = (incident.suspect as u64, incident.fault as u64);
        slot.begin.store(incident.begin.as_nanos(), Ordering::Relaxed);
        slot.packed.store(
            number << 32 | alone << 24 | level << 16 | suspect << 8 | fault,
            Ordering::Release,
        );
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
                is_alone: byte(24) != 0,
                level: *Level::ALL.get(byte(16))?,
                suspect: *Suspect::ALL.get(byte(8))?,
                fault: *Fault::ALL.get(byte(0))?,
                begin: Timestamp::from_nanos(slot.begin.load(Ordering::Relaxed)),
            })
        })
    }

    /// The open incidents of the cylinder `cylinder`, for people and scripts.
    pub fn open(&self, cylinder: usize) -> impl Iterator<Item = OpenIncident> {
        self.slots().map(move |open| OpenIncident {
            number: open.number,
            cylinder,
            suspect: open.suspect.name(),
            level: open.level.name(),
            fault: open.fault.name(),
            kind: story::what(open.suspect, open.fault),
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
