//! The incidents of a cylinder, or of the machine, that are not closed, in atomics.

use super::cell::{Gauge, Total};
use serde::Serialize;
use std::sync::atomic::{AtomicI64, AtomicU8, AtomicU64, Ordering, fence};
use tertius_config::MachineNames;
use tertius_core::alarm::Level;
use tertius_core::incident::{
    Cylinders, Incident, MOST_AT_ONCE, Naming, Progress, QUANTITIES, Quantity, Scope,
};
use tertius_core::time::Timestamp;
use tertius_core::verdict::{Fault, Suspect};
use tertius_report::story;

/// Most tries to read a place that is being written; further ones would see it half old, as long as a frame takes.
const TRIES: usize = 8;

/// Bits of the marks of a [`Slot`]: whether the suspect is named, and by the end of the fault, and whether the cylinder
/// has C1 alone. Below them is the number
/// of the quantity that was largest against its limit, from 1; 0 for none.
const NAMED: u64 = 0x40;
const BY_ITS_END: u64 = 0x80;
const ALONE: u64 = 0x20;
const QUANTITY: u64 = 0x1F;

/// The places for the open incidents of one cylinder, or of the machine. One thread writes.
#[derive(Debug, Default)]
pub(super) struct Incidents {
    slots: [Slot; MOST_AT_ONCE],
    pub opened: Total,
}

/// An incident, of which `packed` is zero without one: its number in the upper half, then marks, level, suspect and
/// fault, a byte each.
#[derive(Debug, Default)]
struct Slot {
    packed: AtomicU64,
    /// The cylinders of an incident that is the machine's.
    cylinders: AtomicU8,
    begin: AtomicI64,
    named: AtomicI64,
    /// Largest value of its worst quantity, and the limit of that, m.
    peak: Gauge,
    limit: Gauge,
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
    /// Whether its cylinder has C1 alone.
    pub is_alone: bool,
    /// Time stamp of its first warning.
    pub begin: Timestamp,
    /// When the suspect was named.
    pub named: Option<Naming>,
    /// What was largest against its limit.
    pub worst: Option<OpenWorst>,
}

/// How bad an open incident is: the quantity that was largest against its limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OpenWorst {
    pub quantity: Quantity,
    /// Its largest absolute value so far, m.
    pub peak: f64,
    /// Its limit, m.
    pub limit: f64,
}

/// An open incident, for people and scripts.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct OpenIncident {
    pub number: u32,
    /// Its cylinder; `None` for what is the machine's.
    pub cylinder: Option<usize>,
    /// Name of the cylinder, if it has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// The cylinders that an incident of the machine concerns.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub cylinders: Vec<u8>,
    pub suspect: &'static str,
    /// Name of the transducer that is suspected, if it has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub suspect_name: Option<String>,
    /// Time stamp at which the suspect was named, s; `null` while it is undecided.
    pub named: Option<f64>,
    /// Whether the end of the fault named it.
    pub named_by_its_end: Option<bool>,
    pub level: &'static str,
    pub fault: &'static str,
    /// The fault in words: `growing error`.
    pub kind: &'static str,
    /// Time stamp of its first warning, s.
    pub begin: f64,
    /// The quantity that was largest against its limit: `r1`, `r2`, `r3` or `c1_c2`.
    pub quantity: Option<&'static str>,
    /// Its largest absolute value so far, that in the newest cycle, and its limit, m.
    pub peak_m: Option<f64>,
    pub now_m: Option<f64>,
    pub limit_m: Option<f64>,
    /// In words: `cylinder 5, C1, black: growing error, C1 − C2 up to 65.8 mm (limit 50.0 mm)`.
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

    /// In words: `cylinder 5, C1, black: growing error, C1 − C2 up to 65.8 mm (limit 50.0 mm)`.
    pub fn summary(&self, cylinder: usize, names: &MachineNames) -> String {
        let of = match self.is_of_machine() {
            true => story::of_machine(self.cylinders),
            false => story::of_cylinder(names, cylinder, (self.suspect, self.is_alone)),
        };
        let worst = self.worst.map(|it| story::largest(it.quantity, it.peak, it.limit));
        story::line_of((of, self.level), story::naming(self.begin, self.named), self.kind(), worst)
    }
}

impl Slot {
    fn write(&self, incident: &Incident) {
        let worst = incident.worst();
        let cylinders = match incident.scope {
            Scope::Cylinder(_) => Cylinders::NONE,
            Scope::Machine(cylinders) => cylinders,
        };
        self.cylinders.store(cylinders.bits(), Ordering::Relaxed);
        self.begin.store(incident.begin.as_nanos(), Ordering::Relaxed);
        self.named.store(incident.named.map_or(0, |it| it.at.as_nanos()), Ordering::Relaxed);
        self.peak.set(worst.map(|(_, peak)| peak.value.abs()));
        self.limit.set(worst.map(|(quantity, _)| incident.limits[quantity as usize]));
        let named = incident.named.map_or(0, |it| NAMED | (u64::from(it.by_its_end) * BY_ITS_END));
        let alone = u64::from(incident.is_alone()) * ALONE;
        let marks = named | alone | worst.map_or(0, |(quantity, _)| quantity as u64 + 1);
        let (number, level) = (u64::from(incident.number), incident.level as u64);
        let (suspect, fault) = (incident.suspect as u64, incident.fault as u64);
        let packed = number << 32 | marks << 24 | level << 16 | suspect << 8 | fault;
        self.packed.store(packed, Ordering::Release);
    }

    /// The incident in this place, whole unless it is written all the time.
    fn read(&self) -> Option<OpenSlot> {
        let mut packed = self.packed.load(Ordering::Acquire);
        for _ in 1..TRIES {
            let open = self.unpack(packed);
            fence(Ordering::Acquire);
            let again = self.packed.load(Ordering::Relaxed);
            if again == packed {
                return open;
            }
            packed = again;
        }
        self.unpack(packed)
    }

    fn unpack(&self, packed: u64) -> Option<OpenSlot> {
        let number = u32::try_from(packed >> 32).ok().filter(|number| *number > 0)?;
        let byte = |shift: u32| (packed >> shift & 0xFF) as usize;
        let marks = packed >> 24 & 0xFF;
        let time = |of: &AtomicI64| Timestamp::from_nanos(of.load(Ordering::Relaxed));
        let named = Naming { at: time(&self.named), by_its_end: marks & BY_ITS_END > 0 };
        let quantity = (marks & QUANTITY).checked_sub(1);
        let worst = quantity.and_then(|place| {
            let quantity = *Quantity::ALL.get(place as usize)?;
            Some(OpenWorst { quantity, peak: self.peak.get()?, limit: self.limit.get()? })
        });
        Some(OpenSlot {
            number,
            cylinders: Cylinders::from_bits(self.cylinders.load(Ordering::Relaxed)),
            level: *Level::ALL.get(byte(16))?,
            suspect: *Suspect::ALL.get(byte(8))?,
            fault: *Fault::ALL.get(byte(0))?,
            is_alone: marks & ALONE > 0,
            begin: time(&self.begin),
            named: Some(named).filter(|_| marks & NAMED > 0),
            worst,
        })
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
        slot.write(incident);
    }

    /// Takes what is of `now`: the monitor tells a size again only as it has grown by a quarter, and no largest one is below
    /// the present one.
    pub fn reach(&self, now: impl Fn() -> [Option<f64>; QUANTITIES]) {
        for slot in &self.slots {
            let packed = slot.packed.load(Ordering::Relaxed);
            let Some(place) = (packed >> 24 & QUANTITY).checked_sub(1) else { continue };
            if let Some(size) = now().get(place as usize).copied().flatten()
                && slot.peak.get().is_some_and(|peak| size > peak)
            {
                slot.peak.set(Some(size));
            }
        }
    }

    /// Forgets all of them: another monitor counts anew.
    pub fn clear(&self) {
        self.slots.iter().for_each(|slot| slot.packed.store(0, Ordering::Relaxed));
    }

    /// The open incidents.
    pub fn slots(&self) -> impl Iterator<Item = OpenSlot> {
        self.slots.iter().filter_map(Slot::read)
    }

    /// The open incidents of the cylinder `cylinder`, or of the machine, for people and scripts; `now`: the quantities of the
    /// cylinder in the newest cycle.
    pub fn open(
        &self,
        cylinder: usize,
        now: [Option<f64>; QUANTITIES],
        names: &MachineNames,
    ) -> impl Iterator<Item = OpenIncident> {
        self.slots().map(move |open| OpenIncident {
            number: open.number,
            cylinder: Some(cylinder).filter(|_| !open.is_of_machine()),
            name: names.of_cylinder(cylinder).map(str::to_owned),
            cylinders: open.cylinders.numbers().collect(),
            suspect: open.suspect.name(),
            suspect_name: story::transducer(open.suspect)
                .and_then(|it| names.of_transducer(cylinder, it))
                .map(str::to_owned),
            named: open.named.map(|it| it.at.as_seconds()),
            named_by_its_end: open.named.map(|it| it.by_its_end),
            level: open.level.name(),
            fault: open.fault.name(),
            kind: open.kind(),
            begin: open.begin.as_seconds(),
            quantity: open.worst.map(|it| it.quantity.name()),
            peak_m: open.worst.map(|it| it.peak),
            now_m: open.worst.and_then(|it| now[it.quantity as usize]),
            limit_m: open.worst.map(|it| it.limit),
            summary: open.summary(cylinder, names),
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
        for (place, quantity) in Quantity::ALL.into_iter().enumerate() {
            assert_eq!(quantity as usize, place);
        }
    }
}
