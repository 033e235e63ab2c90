//! Why an incident is what it is: what spoke up, in the order of time, and what stayed quiet.

use super::{naming, span};
use tertius_core::alarm::detector::WarningPlace;
use tertius_core::incident::{Incident, Outset, Part, Quantity};
use tertius_core::text::{Millimetres, listed};
use tertius_core::time::Timestamp;
use tertius_core::verdict::{Fault, Suspect, Testimony};

/// Detectors that compare, with their quantities and their names for people.
const COMPARING: [(WarningPlace, Quantity, &str); 3] = [
    (WarningPlace::Fde1, Quantity::R1, "C1's observer"),
    (WarningPlace::Fde2, Quantity::R2, "C2's observer"),
    (WarningPlace::Fde3, Quantity::R3, "the difference"),
];

/// The evidence for the suspect, in a sentence without its full stop: what spoke up, in the order of time, then what
/// stayed quiet.
pub fn evidence(incident: &Incident) -> String {
    let mut clauses = in_time(observed(incident));
    if incident.scope.cylinder().is_none() {
        clauses.push("it is what these cylinders share, so no transducer is suspected".to_owned());
        return clauses.join("; ");
    }
    clauses.extend(quiet(incident));
    clauses.extend(testimony(incident));
    clauses.push(conclusion(incident));
    clauses.join("; ")
}

/// Whom the evidence names, and when it did so; where that was not at once, also by which detector.
fn conclusion(incident: &Incident) -> String {
    let is_alone = incident.is_alone();
    if let Some(part) = common_jump(incident) {
        let jump = Millimetres(part.finding.residual.unwrap_or_default().abs());
        return format!("both jumped by {jump}, as no rod does, so it is what C1 and C2 share");
    }
    match (departure(incident), incident.suspect) {
        (Some((name, _)), Suspect::C1 | Suspect::C2) => {
            return format!(
                "{name} is blamed, but a cylinder that leaks or a valve that has changed looks the same"
            );
        }
        (Some(_), Suspect::Process) => {
            return "either C1 and C2 share a fault, or the cylinder does not follow its valve"
                .to_owned();
        }
        _ => {}
    }
    if stop(incident).is_some() && incident.suspect == Suspect::Undecided {
        return "so it is C1 or its stop: one that has worn by more than usual, or is dented, looks the same"
            .to_owned();
    }
    let by_observer = incident.part(WarningPlace::Fde1).is_some()
        && incident.part(WarningPlace::PlausibilityOfC1).is_none()
        && tilt(incident).is_none();
    let whom = match incident.suspect {
        Suspect::C1 if is_alone && by_observer => {
            "there is no second transducer to ask, so C1 is blamed"
        }
        Suspect::Process if is_alone => "so it is not C1",
        Suspect::Undecided if is_alone => "whether it is C1 or the cylinder is not known",
        Suspect::C1 => "so it is C1",
        Suspect::C2 => "so it is C2",
        Suspect::Process => "so it is neither transducer",
        Suspect::Undecided => return "so it is not known which of the two is faulty".to_owned(),
    };
    let Some(named) = naming(incident.begin, incident.named) else { return whom.to_owned() };
    let by = COMPARING.iter().find(|(place, ..)| incident.namer() == Some(*place));
    let by = by.map_or(String::new(), |(.., name)| format!(" by {name}"));
    format!("{whom} ({})", named.replacen("named", &format!("named{by}"), 1))
}

/// Something that spoke up.
struct Observation {
    at: Timestamp,
    clause: String,
    /// Clause where others come later.
    first: String,
    /// Clause where others came before.
    later: String,
}

impl Observation {
    fn new(at: Timestamp, clause: String) -> Self {
        Self { at, first: clause.clone(), later: clause.clone(), clause }
    }
}

/// Everything that spoke up, as it came.
fn observed(incident: &Incident) -> Vec<Observation> {
    let mut observed = facts(incident);
    observed.extend(risen(incident));
    observed.extend(departure(incident).map(departed));
    let weighed = [
        (WarningPlace::Sequential, "the evidence of many samples"),
        (WarningPlace::Process, "what valve, pressures and rod say of each other"),
    ];
    for (place, what) in weighed {
        let part = incident.part(place).filter(|part| !is_of_an_only_one(incident, part));
        observed.extend(part.map(|part| sampled(part, what)));
    }
    observed.extend(stop(incident).map(stood));
    observed.extend(tilt(incident).map(tilted));
    observed.sort_by_key(|it| it.at);
    observed
}

/// Clauses in the order of time: the time of a later one counts from the first.
fn in_time(observed: Vec<Observation>) -> Vec<String> {
    let Some(begin) = observed.first().map(|it| it.at) else { return Vec::new() };
    let is_later = |it: &Observation| it.at > begin;
    let is_first = observed.get(1).is_some_and(is_later);
    let clause = |(place, it): (usize, Observation)| match place {
        0 if is_first => it.first,
        _ if is_later(&it) => format!("after {} {}", span(it.at.since(begin)), it.later),
        _ => it.clause,
    };
    observed.into_iter().enumerate().map(clause).collect()
}

/// Facts about readings, which need no comparison.
fn facts(incident: &Incident) -> Vec<Observation> {
    let places = [
        (WarningPlace::PlausibilityOfC1, "C1"),
        (WarningPlace::PlausibilityOfC2, "C2"),
        (WarningPlace::PlausibilityOfCommand, "the command"),
    ];
    let fact = |(place, name): (WarningPlace, &str)| {
        let part = incident.part(place)?;
        if let Some(device) = part.finding.device {
            let clause = format!("{name}'s device: {device}{}", again(part));
            return Some(Observation::new(part.raised, clause));
        }
        let what = match part.finding.fault {
            Fault::Frozen => "did not change while the cylinder was driven",
            Fault::OutOfRange => "read a length that the cylinder cannot have",
            Fault::BrokenWire => "reported that it has no signal",
            Fault::Stale => "did not come",
            _ => "was not plausible",
        };
        let clause = format!("{name} {what}{}", again(part));
        let later = format!("it was found that {clause}");
        Some(Observation { later, ..Observation::new(part.raised, clause) })
    };
    places.into_iter().filter_map(fact).collect()
}

/// The comparing detectors that rose, those of one moment together.
fn risen(incident: &Incident) -> Vec<Observation> {
    let risen = COMPARING.iter().filter_map(|(place, _, name)| {
        let part = incident.part(*place).filter(|part| !departs(part))?;
        Some((part, format!("{name}{}", again(part))))
    });
    let mut risen: Vec<(&Part, String)> = risen.collect();
    risen.sort_by_key(|(part, _)| part.raised);
    let mut observed = Vec::new();
    let mut rest = &risen[..];
    while let Some((first, _)) = rest.first() {
        let at_once = |(part, _): &&(&Part, String)| part.raised == first.raised;
        let (group, others) = rest.split_at(rest.iter().take_while(at_once).count());
        let names = listed(&group.iter().map(|(_, name)| name).collect::<Vec<_>>());
        let together = if group.len() > 1 { " together" } else { "" };
        observed.push(Observation::new(first.raised, format!("{names} rose{together}")));
        rest = others;
    }
    observed
}

fn departs(part: &Part) -> bool {
    part.finding.evidence.is_some_and(|it| it.by == Some(Testimony::Way))
}

/// What the stop has found of an only transducer.
pub(super) fn stop(incident: &Incident) -> Option<&Part> {
    of_an_only_one(incident, Testimony::Stop)
}

/// What the deck's attitude has found of an only transducer.
fn tilt(incident: &Incident) -> Option<&Part> {
    of_an_only_one(incident, Testimony::Attitude)
}

fn of_an_only_one(incident: &Incident, by: Testimony) -> Option<&Part> {
    let part = incident.part(WarningPlace::Sequential).filter(|_| incident.is_alone())?;
    part.finding.evidence.is_some_and(|it| it.by == Some(by)).then_some(part)
}

/// Whether there is no sequential detector that found it, but the stop or the deck, of an only transducer.
fn is_of_an_only_one(incident: &Incident, part: &Part) -> bool {
    let by = part.finding.evidence.and_then(|it| it.by);
    incident.is_alone() && matches!(by, Some(Testimony::Stop | Testimony::Attitude))
}

fn stood(part: &Part) -> Observation {
    let moved = Millimetres(part.finding.residual.unwrap_or_default().abs());
    let clause = format!("on its stop C1 read {moved} beside what it read there before");
    Observation::new(part.raised, clause)
}

/// What both readings have jumped by together, which is latched.
fn common_jump(incident: &Incident) -> Option<&Part> {
    let is_jump = |part: &&Part| {
        part.finding.suspect == Suspect::Process
            && part.finding.evidence.is_some_and(|it| it.by == Some(Testimony::Innovations))
    };
    incident.part(WarningPlace::Fde1).filter(is_jump)
}

/// Whether C1 and C2 may share a fault.
pub(super) fn is_common(incident: &Incident) -> bool {
    common_jump(incident).is_some() || departure(incident).is_some()
}

/// The transducer that departs from dead reckoning, or both, with what was found.
pub(super) fn departure(incident: &Incident) -> Option<(&'static str, &Part)> {
    let places = [(WarningPlace::Fde1, "C1"), (WarningPlace::Fde2, "C2")];
    let of = |(place, name)| {
        let part = incident.part(place).filter(|part| departs(part))?;
        let is_of_both = part.finding.suspect == Suspect::Process;
        Some((if is_of_both { "what C1 and C2 read" } else { name }, part))
    };
    places.into_iter().find_map(of)
}

fn departed((name, part): (&'static str, &Part)) -> Observation {
    let clause =
        format!("{name} departed from the rod's way by dead reckoning, by {}", beside(part));
    Observation::new(part.raised, clause)
}

/// By how much a reading has departed from dead reckoning: `16.6 mm (limit 13.1 mm)`.
pub(super) fn beside(part: &Part) -> String {
    let [error, limit] =
        [part.finding.residual, part.finding.threshold].map(|it| it.unwrap_or_default().abs());
    format!("{} (limit {})", Millimetres(error), Millimetres(limit))
}

/// What many samples together say.
fn sampled(part: &Part, what: &str) -> Observation {
    let mut clause = what.to_owned();
    if let Some(evidence) = part.finding.evidence.filter(|it| it.fault >= 0.5) {
        clause += &format!(" ({:.0} nats", evidence.fault);
        let of_samples = evidence.by.is_none_or(|by| !by.is_of_the_rod());
        if let Some(location) = evidence.location.filter(|_| of_samples) {
            let whom = if location < 0.0 { "C2" } else { "C1" };
            clause += &format!("; {:.0} for {whom}", location.abs());
        }
        clause += ")";
    }
    clause += " showed it";
    let first = format!("{clause} first");
    Observation { first, ..Observation::new(part.raised, clause) }
}

/// What the deck's attitude says of a single transducer.
fn tilted(part: &Part) -> Observation {
    let size =
        part.finding.residual.map_or(String::new(), |it| format!(" by {}", Millimetres(it.abs())));
    let nats = part.finding.evidence.and_then(|it| it.location);
    let nats = nats.map_or(String::new(), |it| format!(" ({it:.0} nats)"));
    let clause =
        format!("the deck stood as if C1 were off{size}, as no other cylinder explains{nats}");
    Observation::new(part.raised, clause)
}

/// What has named the reading that moved, where it is neither the detectors that rose nor those that stayed quiet. Such
/// evidence agrees with the other reading, and a cylinder with C1 alone has no other.
fn testimony(incident: &Incident) -> Option<String> {
    if incident.is_alone() {
        return None;
    }
    let finding = incident.part(WarningPlace::Sequential)?.finding;
    let evidence = finding.evidence.filter(|_| finding.suspect == incident.suspect)?;
    let what = match evidence.by? {
        Testimony::Flow => "the oil that passed the valve",
        Testimony::Attitude => "the attitude of the deck",
        Testimony::Innovations | Testimony::Stop | Testimony::Way => return None,
    };
    let nats = evidence.location.map_or(String::new(), |it| format!(" ({:.0} nats)", it.abs()));
    let [moved, other] = match incident.suspect {
        Suspect::C1 => ["C1", "C2"],
        Suspect::C2 => ["C2", "C1"],
        Suspect::Undecided | Suspect::Process => return None,
    };
    Some(format!("{what} agrees with {other} and not with {moved}{nats}"))
}

/// The observers that did not rise, and whether they judged at all.
fn quiet(incident: &Incident) -> Vec<String> {
    let Outset { judged, elsewhere } = incident.outset;
    let quiet = |(place, quantity, name): &(WarningPlace, Quantity, &str)| {
        let is_there = incident.limits[*quantity as usize].is_finite();
        if incident.part(*place).is_some() || !is_there {
            return None;
        }
        Some(match incident.peaks[*quantity as usize] {
            Some(peak) => {
                let (size, limit) = (peak.value.abs(), incident.limits[*quantity as usize]);
                // Its warning is another incident's.
                let is_other = size > limit || elsewhere[*quantity as usize];
                let how = match (is_other, judged[*quantity as usize]) {
                    (true, _) => "stands for another fault",
                    (false, true) => "stayed quiet",
                    (false, false) => "was not judged at first, then stayed quiet",
                };
                format!("{name} {how} ({} of {})", Millimetres(size), Millimetres(limit))
            }
            None => format!("{name} was not judged"),
        })
    };
    COMPARING.iter().filter_map(quiet).collect()
}

fn again(part: &Part) -> String {
    match part.raises {
        1 => String::new(),
        2 => " (twice)".to_owned(),
        raises => format!(" ({raises} times)"),
    }
}
