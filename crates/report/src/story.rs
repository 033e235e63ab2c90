//! Incidents and notices in words: what is wrong, whom the monitor suspects and why, how bad it is, and what to do.
//!
//! Every output for people takes its words from here, so that they cannot disagree.

mod evidence;
mod machine;
mod notice;

pub use evidence::evidence;
pub use machine::{in_common, numbers, of_machine};
pub use notice::{notice_line, notice_words};

use std::cmp::Ordering;
use tertius_config::MachineNames;
use tertius_core::alarm::detector::WarningPlace;
use tertius_core::alarm::{Detector, Level};
use tertius_core::incident::{Ending, Incident, Naming, Quantity, Scope};
use tertius_core::sample::Transducer;
use tertius_core::text::Millimetres;
use tertius_core::time::{Span, Timestamp};
use tertius_core::verdict::{Fault, Suspect};

/// Time after the begin of an incident within which its suspect counts as named at once.
const AT_ONCE: Span = Span::from_nanos(1_000_000_000);

/// Whom an incident is about, as a short cell: `C1`, `C1 or C2`.
pub const fn suspect(suspect: Suspect) -> &'static str {
    match suspect {
        Suspect::C1 => "C1",
        Suspect::C2 => "C2",
        Suspect::Undecided => "C1 or C2",
        Suspect::Process => "neither",
    }
}

/// A suspect as one word, whatever transducers the cylinder has: `C1`, `undecided`.
pub const fn suspect_word(suspect: Suspect) -> &'static str {
    match suspect {
        Suspect::C1 => "C1",
        Suspect::C2 => "C2",
        Suspect::Undecided | Suspect::Process => suspect.name(),
    }
}

/// As [`suspect`], about a cylinder that may have C1 alone.
pub const fn suspect_of(whom: Suspect, is_alone: bool) -> &'static str {
    match whom {
        Suspect::Undecided if is_alone => "C1 or the cylinder",
        Suspect::Process if is_alone => "not C1",
        other => suspect(other),
    }
}

/// What is wrong: `step of 1.21 mm`, `frozen reading`.
pub fn kind(incident: &Incident) -> String {
    if let Some(gain) = incident.gain {
        return scale_error(gain);
    }
    match (incident.fault, incident.size) {
        (Fault::Abrupt, Some(size)) => format!("step of {}", Millimetres(size.abs())),
        (kind, _) => match process_size(incident) {
            Some(size) => format!("{} ({size})", fault(kind)),
            None if incident.scope.cylinder().is_none() => in_common(kind).to_owned(),
            None => what(incident.suspect, kind).to_owned(),
        },
    }
}

/// A gain of C1 that is off from that of C2.
pub fn scale_error(gain: f64) -> String {
    format!("scale error of {:+.2} %", 100.0 * gain)
}

/// How large a fault of the process is, where that is known.
fn process_size(incident: &Incident) -> Option<String> {
    let finding = &incident.part(WarningPlace::Process)?.finding;
    let size = finding.evidence?.size.filter(|_| finding.fault == incident.fault)?;
    Some(match finding.fault {
        Fault::ValveSticking => format!("within {size:.2} in the unit of the spool's signal"),
        Fault::Leakage => format!("{:.1} mm/s at 24 bar", size * 1e3),
        Fault::ValveOffset | Fault::ValveDeadBand => {
            format!("{size:+.2} in the unit of the spool's signal")
        }
        Fault::Supply | Fault::PressureSensor | Fault::Friction => format!("{size:+.1} bar"),
        Fault::Command if size == 1.0 => "1 cycle late".to_owned(),
        Fault::Command => format!("{size:.0} cycles late"),
        _ => return None,
    })
}

/// What is wrong, by whom it is about: what does not come of neither transducer is the command.
pub const fn what(suspect: Suspect, kind: Fault) -> &'static str {
    match (suspect, kind) {
        (Suspect::Process, Fault::Stale) => "no command",
        _ => fault(kind),
    }
}

/// A kind of fault.
const fn fault(fault: Fault) -> &'static str {
    match fault {
        Fault::Abrupt => "step",
        Fault::Noise => "noise",
        Fault::Incipient => "growing error",
        Fault::OutOfRange => "reading out of range",
        Fault::BrokenWire => "no signal",
        Fault::Frozen => "frozen reading",
        Fault::Stale => "no readings",
        Fault::ValveSticking => "sticking valve",
        Fault::Leakage => "internal leakage",
        Fault::ValveOffset => "valve beside its command, or its null has moved",
        Fault::Supply => "supply pressure, or its sensor",
        Fault::PressureSensor => "pressure sensor",
        Fault::Command => "late or wrong command of the valve",
        Fault::Friction => "friction of the rod",
        Fault::ValveDeadBand => "changed dead band of the valve",
        Fault::Unclassified => "unclassified error",
        Fault::NotCalibrated => "not calibrated",
    }
}

/// Whom an incident of the cylinder `number` is about, in a sentence: `C1`, `C1 (LT-101A)`, `neither transducer`; about
/// a cylinder that may have C1 alone.
pub fn whom(names: &MachineNames, number: usize, whom: Suspect, is_alone: bool) -> String {
    let [c1, c2] = [Transducer::C1, Transducer::C2].map(|it| names.transducer(number, it));
    match (whom, is_alone) {
        (Suspect::C1, _) => c1,
        (Suspect::C2, _) => c2,
        (Suspect::Undecided, true) => format!("{c1} or the cylinder"),
        (Suspect::Undecided, false) => format!("{c1} or {c2}"),
        (Suspect::Process, true) => format!("not {c1}"),
        (Suspect::Process, false) => "neither transducer".to_owned(),
    }
}

/// The transducer that a suspect is, if it is one.
pub const fn transducer(suspect: Suspect) -> Option<Transducer> {
    match suspect {
        Suspect::C1 => Some(Transducer::C1),
        Suspect::C2 => Some(Transducer::C2),
        Suspect::Undecided | Suspect::Process => None,
    }
}

/// When the suspect was named, where it was not at once: `named after 118.7 s`, `named after 118.7 s, when the fault
/// ended`.
pub fn naming(begin: Timestamp, named: Option<Naming>) -> Option<String> {
    let Naming { at, by_its_end } = named?;
    let after = at.since(begin);
    let ended = if by_its_end { ", when the fault ended" } else { "" };
    (after > AT_ONCE).then(|| format!("named after {}{ended}", span(after)))
}

/// Whom an incident is about, as a short cell, with a mark where it was not named at once: `C2 late`.
pub fn suspect_in_time(incident: &Incident) -> String {
    let late = naming(incident.begin, incident.named).map_or("", |_| " late");
    format!("{}{late}", suspect_of(incident.suspect, incident.is_alone()))
}

/// Name of a quantity for people.
pub const fn quantity(quantity: Quantity) -> &'static str {
    match quantity {
        Quantity::R1 => "R1",
        Quantity::R2 => "R2",
        Quantity::R3 => "R3",
        Quantity::Measured => "C1 − C2",
    }
}

/// How bad it got: `R3 up to 2.00 mm (limit 1.50 mm)`.
pub fn largest(which: Quantity, peak: f64, limit: f64) -> String {
    let (name, peak, limit) = (quantity(which), Millimetres(peak.abs()), Millimetres(limit));
    format!("{name} up to {peak} (limit {limit})")
}

/// The incident in a line, without its time: `cylinder 5, C1, black: growing error, C1 − C2 up to 65.8 mm (limit 50.0
/// mm)`, `machine (cylinders 1 to 6), black: no messages in time`.
pub fn line(incident: &Incident, names: &MachineNames) -> String {
    let Incident { scope, suspect, level, begin, named, .. } = *incident;
    let worst = incident
        .worst()
        .map(|(quantity, peak)| largest(quantity, peak.value, incident.limits[quantity as usize]));
    let departure = evidence::departure(incident);
    let departed =
        departure.map(|(_, part)| format!("beside its way by {}", evidence::beside(part)));
    let worst = departed.or(worst);
    let of = match scope {
        Scope::Cylinder(number) => {
            of_cylinder(names, number.into(), (suspect, incident.is_alone()))
        }
        Scope::Machine(cylinders) => of_machine(cylinders),
    };
    line_of((of, level), naming(begin, named), &kind(incident), worst)
}

/// Which cylinder an incident is of, and whom it is about: `cylinder 5, C1`, `cylinder 5 (AftPort), C1 (LT-105A)`.
pub fn of_cylinder(
    names: &MachineNames,
    number: usize,
    (suspect, is_alone): (Suspect, bool),
) -> String {
    format!("{}, {}", names.cylinder(number), whom(names, number, suspect, is_alone))
}

/// The line of an incident: what it is of and its level, when its suspect was named, what is wrong, and how bad it got.
pub fn line_of(
    (of, level): (String, Level),
    named: Option<String>,
    kind: &str,
    worst: Option<String>,
) -> String {
    let named = named.map_or(String::new(), |named| format!(" ({named})"));
    let worst = worst.map_or(String::new(), |worst| format!(", {worst}"));
    format!("{of}{named}, {}: {kind}{worst}", level.name())
}

/// What a person should do.
pub fn advice(incident: &Incident, names: &MachineNames) -> String {
    let whom = match (incident.scope.cylinder(), transducer(incident.suspect)) {
        (Some(number), Some(it)) => names.transducer(number, it),
        _ => suspect(incident.suspect).to_owned(),
    };
    if incident.scope.cylinder().is_none() && incident.fault != Fault::Supply {
        return machine::advice(incident.fault).to_owned();
    }
    if incident.part(WarningPlace::PlausibilityOfCommand).is_some() {
        return "Check the controller: without its command the observers cannot judge.".to_owned();
    }
    match (incident.suspect, incident.fault) {
        (_, Fault::ValveSticking) => {
            "Have the valve's spool and pilot looked at, and the oil's cleanliness; it may stick more.".to_owned()
        }
        (_, Fault::Leakage) => {
            "Have the piston's seals and the valve's edges looked at; compare with the other cylinders.".to_owned()
        }
        (_, Fault::Friction) => {
            "Have the rod, its seals and its bearings looked at, and whether anything rubs along its way.".to_owned()
        }
        (_, Fault::ValveDeadBand) => {
            "If other cylinders show it, too, look at the oil and its temperature; else have the valve's edges looked at \
            at the next maintenance."
                .to_owned()
        }
        (_, Fault::ValveOffset) => {
            "Check the valve's null and the sensor of its spool's position.".to_owned()
        }
        (_, Fault::Supply) => {
            "Check the sensor of the supply pressure against a gauge, then pump and accumulator.".to_owned()
        }
        (_, Fault::PressureSensor) => {
            "Check both pressure sensors of the cylinder; which of them it is, their sum does not tell.".to_owned()
        }
        (_, Fault::Command) => {
            "Compare the command on the bus with what reaches the valve: its electronics, its cable, the \
            controller's timing."
                .to_owned()
        }
        (Suspect::Process, _) if evidence::is_common(incident) => {
            "Look at what C1 and C2 share: their supply, cable, input card and mounting. Then at the cylinder and its valve."
                .to_owned()
        }
        (Suspect::Process, _) => {
            "Look at the cylinder, its valve and its supply. If nothing is wrong \
            there, the model no longer fits: identify it on a newer recording."
                .to_owned()
        }
        (Suspect::Undecided, _) if evidence::stop(incident).is_some() => {
            "Look at the cylinder's stop and what the rod stands on there, and measure its length. If nothing is wrong \
             there, check the mounting and the magnet of C1, and have it calibrated."
                .to_owned()
        }
        (Suspect::Undecided, _) if incident.is_alone() => {
            "Drive the cylinder to its end stop: if C1 reads another length there than before, it is at fault. \
            Otherwise look at the cylinder, its valve and its supply."
                .to_owned()
        }
        (Suspect::Undecided, _) => {
            "Drive the cylinder to its end stop: the transducer that reads another \
            length there than before is the one at fault."
                .to_owned()
        }
        (_, Fault::Stale | Fault::BrokenWire | Fault::Frozen) => {
            format!("Check the cable, the connector and the supply of {whom}.")
        }
        (_, Fault::Noise) => {
            format!("Check the screen, the earth and the connector of {whom}.{}", otherwise(incident))
        }
        (_, Fault::OutOfRange | Fault::Abrupt) => {
            let otherwise = otherwise(incident);
            format!("Check the connector, the cable and the magnet of {whom}.{otherwise}")
        }
        (_, Fault::Incipient | Fault::Unclassified | Fault::NotCalibrated) => {
            let otherwise = otherwise(incident);
            format!("Check the mounting and the magnet of {whom}, and have it calibrated.{otherwise}")
        }
    }
}

/// Where else to look if nothing is wrong with C1: alone, its observer and dead reckoning cannot tell it from the cylinder.
fn otherwise(incident: &Incident) -> &'static str {
    let is_single = incident.is_alone() && incident.part(WarningPlace::Fde1).is_some();
    if is_single || evidence::departure(incident).is_some() {
        " If nothing is wrong there, look at the cylinder, its valve and its supply."
    } else {
        ""
    }
}

/// How long it lasted; `None` while it is not over, and where the clock was set back meanwhile.
pub fn lasted(incident: &Incident) -> Option<String> {
    let (end, _) = incident.end?;
    (end >= incident.begin).then(|| span(end.since(incident.begin)))
}

/// How it ended, or that it stands.
pub fn ending(incident: &Incident) -> String {
    match incident.end {
        None if incident.stands() => "still standing".to_owned(),
        None => "no warning stands; it may come again".to_owned(),
        Some((_, how)) => {
            let lasted =
                lasted(incident).map_or(String::new(), |lasted| format!(" after {lasted}"));
            let how = match how {
                Ending::Returned => "the reading came back",
                Ending::Quiet => "below the limits since, which is no proof that it is gone",
                Ending::Cut => "below the limits when the data ended",
                Ending::Joined => {
                    "most other cylinders show the same, and it is one incident of the machine"
                }
            };
            format!("over{lasted}: {how}")
        }
    }
}

/// The order of a list: the highest level first, then what was largest against its limit, then the earliest.
pub fn order(a: &Incident, b: &Incident) -> Ordering {
    let [(trips_a, share_a), (trips_b, share_b)] = [a.severity(), b.severity()];
    let level = b.level.cmp(&a.level).then(trips_b.cmp(&trips_a));
    level.then(share_b.total_cmp(&share_a)).then(a.begin.cmp(&b.begin))
}

/// Detectors that rose, in the order of their numbers.
pub fn detectors(incident: &Incident) -> Vec<Detector> {
    let parts = tertius_core::alarm::detector::DETECTORS.into_iter().zip(&incident.parts);
    let mut risen: Vec<Detector> =
        parts.filter(|(_, part)| part.is_some()).map(|(detector, _)| detector).collect();
    risen.dedup();
    risen
}

/// A span in the unit that a person would choose.
pub fn span(span: Span) -> String {
    let seconds = span.as_seconds();
    match seconds {
        s if s < 1.0 => format!("{:.0} ms", 1e3 * s),
        s if s < 120.0 => format!("{s:.1} s"),
        s if s < 7200.0 => format!("{:.0} min", s / 60.0),
        s if s < 259_200.0 => format!("{:.1} h", s / 3600.0),
        s => format!("{:.1} days", s / 86_400.0),
    }
}

#[cfg(test)]
mod tests;
