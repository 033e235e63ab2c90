//! The line of an incident.

use super::named::NameFields;
use super::{Digits, digits, write_line};
use crate::story;
use serde::Serialize;
use std::collections::BTreeMap;
use std::io::{self, Write};
use tertius_config::MachineNames;
use tertius_core::alarm::register::DETECTORS;
use tertius_core::blame::Rule;
use tertius_core::incident::{Incident, Quantity, Scope};
use tertius_core::time::Timestamp;

#[derive(Serialize)]
struct IncidentLine<'a> {
    r#type: &'static str,
    t: Digits,
    timestamp: Digits,
    incident: u32,
    state: &'static str,
    /// `null` for what is the machine's; then `cylinders` has those that it concerns.
    cylinder: Option<u8>,
    #[serde(flatten)]
    names: NameFields<'a>,
    #[serde(skip_serializing_if = "Option::is_none")]
    cylinders: Option<Vec<u8>>,
    level: &'static str,
    suspect: &'static str,
    by: Option<&'static str>,
    named: Option<Digits>,
    named_by_its_end: Option<bool>,
    fault: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    shape: Option<&'static str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    gain_percent: Option<f64>,
    begin: Digits,
    onset: Digits,
    end: Option<Digits>,
    ending: Option<&'static str>,
    size: Option<f64>,
    quantity: Option<&'static str>,
    peak: Option<f64>,
    peak_at: Option<Digits>,
    limit: Option<f64>,
    now: Option<f64>,
    peaks: BTreeMap<&'static str, f64>,
    detectors: Vec<DetectorFields>,
    summary: &'a str,
    evidence: &'a str,
}

/// A detector's share in an incident.
#[derive(Serialize)]
struct DetectorFields {
    detector: &'static str,
    suspect: &'static str,
    by: &'static str,
    raised: Digits,
    raises: u32,
}

/// Writes `incident`; see [`super::warning`].
///
/// # Errors
/// Errors of `out`.
pub fn incident(
    out: &mut impl Write,
    first: Timestamp,
    incident: &Incident,
    names: &MachineNames,
) -> io::Result<()> {
    let since = |at: Timestamp| digits(at.since(first));
    let worst = incident.worst();
    let peaks = Quantity::ALL.into_iter().zip(incident.peaks);
    let parts = DETECTORS.into_iter().zip(&incident.parts);
    let parts = parts.filter_map(|(detector, part)| {
        part.map(|part| DetectorFields {
            detector: detector.name(),
            suspect: part.finding.suspect.name(),
            by: part.finding.rule.name(),
            raised: since(part.raised),
            raises: part.raises,
        })
    });
    write_line(
        out,
        &IncidentLine {
            r#type: "incident",
            t: since(incident.timestamp),
            timestamp: digits(incident.timestamp),
            incident: incident.number,
            state: incident.progress.name(),
            cylinder: incident.scope.cylinder(),
            names: NameFields::new(names, incident.scope.cylinder(), incident.suspect),
            cylinders: match incident.scope {
                Scope::Cylinder(_) => None,
                Scope::Machine(cylinders) => Some(cylinders.numbers().collect()),
            },
            level: incident.level.name(),
            suspect: incident.suspect.name(),
            by: incident.rule().map(Rule::name),
            named: incident.named.map(|it| since(it.at)),
            named_by_its_end: incident.named.map(|it| it.by_its_end),
            fault: incident.fault.name(),
            shape: incident.gain.map(|_| "scale"),
            gain_percent: incident.gain.map(|gain| 100.0 * gain),
            begin: since(incident.begin),
            onset: since(incident.onset),
            end: incident.end.map(|(at, _)| since(at)),
            ending: incident.end.map(|(_, how)| how.name()),
            size: incident.size,
            quantity: worst.map(|(quantity, _)| quantity.name()),
            peak: worst.map(|(_, peak)| peak.value),
            peak_at: worst.map(|(_, peak)| since(peak.at)),
            limit: worst.map(|(quantity, _)| incident.limits[quantity as usize]),
            now: incident.worst_now(),
            peaks: peaks
                .filter_map(|(quantity, peak)| Some((quantity.name(), peak?.value)))
                .collect(),
            detectors: parts.collect(),
            summary: &story::line(incident, names),
            evidence: &story::evidence(incident),
        },
    )
}
