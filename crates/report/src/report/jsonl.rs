//! Lines of JSON for scripts, one object each.

mod incident;
mod named;

use super::device::DeviceFields;
use super::notice::NoticeFields;
use super::stops::TrendLine;
use super::{IdentityFields, Summary};
use serde::Serialize;
use serde_json::value::RawValue;
use std::collections::BTreeMap;
use std::fmt::Display;
use std::io::{self, Write};
use tertius_config::{CylinderNames, MachineNames, visible};
use tertius_core::alarm::{Detector, Warning};
use tertius_core::monitor::Notice;
use tertius_core::process::ProcessCoverage;
use tertius_core::sequential::{Coverage, Unknown};
use tertius_core::time::Timestamp;

pub use incident::incident;
pub(super) use named::NameFields;

/// Seconds as a JSON number with all their digits.
pub(super) type Digits = Box<RawValue>;

pub(super) fn digits(time: impl Display) -> Digits {
    // Seconds are written as JSON writes numbers: digits, one point, digits.
    RawValue::from_string(time.to_string()).unwrap_or_default()
}

#[derive(Serialize)]
struct WarningLine<'a> {
    r#type: &'static str,
    t: Digits,
    timestamp: Digits,
    cylinder: u8,
    #[serde(flatten)]
    names: NameFields<'a>,
    detector: &'static str,
    fault: &'static str,
    suspect: &'static str,
    by: &'static str,
    level: &'static str,
    state: &'static str,
    residual: Option<f64>,
    threshold: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none", flatten)]
    evidence: Option<EvidenceFields>,
    #[serde(skip_serializing_if = "Option::is_none")]
    device: Option<DeviceFields>,
}

/// Fields of a detector that weighs evidence.
#[derive(Serialize)]
struct EvidenceFields {
    evidence: f64,
    location_evidence: Option<f64>,
    onset: Digits,
    size: Option<f64>,
    /// In the unit of its kind, see [`tertius_core::alarm::Evidence::size`].
    #[serde(skip_serializing_if = "Option::is_none")]
    process_size: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    shape: Option<&'static str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    gain_percent: Option<f64>,
}

#[derive(Serialize)]
struct NoticeLine<'a> {
    r#type: &'static str,
    t: Digits,
    timestamp: Digits,
    #[serde(flatten)]
    fields: NoticeFields,
    #[serde(skip_serializing_if = "Option::is_none")]
    name: Option<&'a str>,
}

#[derive(Serialize)]
struct SummaryLine<'a> {
    r#type: &'static str,
    judged: bool,
    /// Reasons why nothing was judged.
    #[serde(skip_serializing_if = "<[_]>::is_empty")]
    reasons: &'a [String],
    /// What of the cycle is other than the configuration says.
    #[serde(skip_serializing_if = "<[_]>::is_empty")]
    remarks: &'a [String],
    #[serde(flatten)]
    judged_by: IdentityFields<'a>,
    frames: u64,
    ignored_frames: u64,
    error_frames: u64,
    bad_lines: u64,
    damaged_inputs: u64,
    cycles: u64,
    incomplete_cycles: u64,
    missing_cycles: u64,
    late_frames: u64,
    repeated_frames: u64,
    contradicting_frames: u64,
    short_frames: u64,
    sync_doubted_seconds: u64,
    held_frames: u64,
    bad_signals: u64,
    unnamed_status_bits: u64,
    backwards: u64,
    time_jumps: u64,
    interruptions: u64,
    duration: f64,
    incidents: u64,
    warnings: BTreeMap<Position, u64>,
    cylinders: Vec<CylinderLine<'a>>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    trends: Vec<TrendLine>,
}

/// A detector as a key, sorted in the order of the detectors and not of their names.
#[derive(PartialEq, Eq, PartialOrd, Ord)]
struct Position(Detector);

impl Serialize for Position {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.0.name())
    }
}

#[derive(Serialize)]
struct CylinderLine<'a> {
    cylinder: usize,
    #[serde(flatten)]
    names: Option<&'a CylinderNames>,
    samples: u64,
    gated: u64,
    incomplete: u64,
    implausible: [u64; 2],
    counter_jumps: [u64; 2],
    worst_r1: Option<f64>,
    worst_r2: Option<f64>,
    worst_r3: Option<f64>,
    warnings: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    sequential: Option<CoverageFields>,
    #[serde(skip_serializing_if = "Option::is_none")]
    process: Option<ProcessCoverageFields>,
}

/// Time in which a process detector could judge, and in which it did; a relation that it does not know is absent.
#[derive(Serialize)]
struct ProcessCoverageFields {
    monitored_seconds: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    spool_seconds: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    chambers_seconds: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    flow_seconds: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    friction_seconds: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    supply_seconds: Option<f64>,
}

impl ProcessCoverageFields {
    fn new(coverage: &ProcessCoverage, sample_time: f64) -> Self {
        let seconds = |cycles: u64| in_seconds(cycles, sample_time);
        let [spool_seconds, chambers_seconds, flow_seconds, friction_seconds, supply_seconds] =
            coverage.judged().map(|it| it.map(seconds));
        Self {
            monitored_seconds: seconds(coverage.monitored),
            spool_seconds,
            chambers_seconds,
            flow_seconds,
            friction_seconds,
            supply_seconds,
        }
    }
}

/// What is said is worth a millisecond.
pub(super) fn in_seconds(cycles: u64, sample_time: f64) -> f64 {
    (cycles as f64 * sample_time * 1e3).round() / 1e3
}

/// Time in which a sequential detector judged, and why not otherwise.
#[derive(Serialize)]
struct CoverageFields {
    judged_seconds: f64,
    unknown_seconds: BTreeMap<&'static str, f64>,
}

impl CoverageFields {
    fn new(coverage: &Coverage, sample_time: f64) -> Self {
        let seconds = |cycles: u64| in_seconds(cycles, sample_time);
        let unknown = Unknown::ALL.map(Unknown::name).into_iter();
        Self {
            judged_seconds: seconds(coverage.judged),
            unknown_seconds: unknown.zip(coverage.unknown.map(seconds)).collect(),
        }
    }
}

/// Writes `warning`; `first` is the time stamp of the recording's first frame.
///
/// # Errors
/// Errors of `out`.
pub fn warning(
    out: &mut impl Write,
    first: Timestamp,
    warning: &Warning,
    names: &MachineNames,
) -> io::Result<()> {
    let finding = &warning.finding;
    write_line(
        out,
        &WarningLine {
            r#type: "warning",
            t: digits(warning.timestamp.since(first)),
            timestamp: digits(warning.timestamp),
            cylinder: warning.cylinder,
            names: NameFields::new(names, Some(warning.cylinder), finding.suspect),
            detector: warning.detector.name(),
            fault: finding.fault.name(),
            suspect: finding.suspect.name(),
            by: finding.rule.name(),
            level: finding.level.name(),
            state: warning.state.name(),
            residual: finding.residual,
            threshold: finding.threshold,
            evidence: finding.evidence.map(|evidence| EvidenceFields {
                evidence: evidence.fault,
                location_evidence: evidence.location,
                onset: digits(evidence.onset.since(first)),
                size: finding.residual,
                process_size: evidence.size,
                shape: evidence.gain.map(|_| "scale"),
                gain_percent: evidence.gain.map(|gain| 100.0 * gain),
            }),
            device: finding.device.map(DeviceFields::from),
        },
    )
}

/// Writes `notice`; see [`warning`].
///
/// # Errors
/// Errors of `out`.
pub fn notice(
    out: &mut impl Write,
    first: Timestamp,
    notice: &Notice,
    names: &MachineNames,
) -> io::Result<()> {
    let fields = NoticeFields::from(notice);
    let name = fields.cylinder.and_then(|number| names.of_cylinder(number));
    let (t, timestamp) = (digits(fields.at.since(first)), digits(fields.at));
    write_line(out, &NoticeLine { r#type: "notice", t, timestamp, fields, name })
}

/// Writes the last line.
///
/// # Errors
/// Errors of `out`.
pub fn summary(out: &mut impl Write, summary: &Summary<'_>) -> io::Result<()> {
    let Summary { statistics, counts, episodes, fingerprints, .. } = summary;
    let cylinders = summary.tallies.iter().zip(summary.counter_jumps).enumerate();
    let line = SummaryLine {
        r#type: "summary",
        judged: summary.judgement.is_judged(),
        reasons: summary.judgement.reasons(),
        remarks: summary.remarks,
        judged_by: (*fingerprints).into(),
        frames: statistics.frames,
        ignored_frames: summary.ignored_frames(),
        error_frames: statistics.error_frames,
        bad_lines: statistics.bad_lines,
        damaged_inputs: statistics.damaged_inputs,
        cycles: counts.cycles,
        incomplete_cycles: counts.incomplete,
        missing_cycles: counts.missing,
        late_frames: counts.late,
        repeated_frames: counts.repeated,
        contradicting_frames: counts.contradicting,
        short_frames: counts.short,
        sync_doubted_seconds: counts.sync_doubted,
        held_frames: counts.held,
        bad_signals: counts.bad_signals,
        unnamed_status_bits: counts.unnamed_status_bits,
        backwards: counts.backwards,
        time_jumps: counts.time_jumps,
        interruptions: counts.interruptions,
        duration: summary.duration,
        incidents: summary.incidents.count(),
        warnings: Detector::ALL.map(Position).into_iter().zip(*episodes.raised()).collect(),
        cylinders: cylinders
            .map(|(index, (tally, jumps))| CylinderLine {
                cylinder: index + 1,
                names: summary.names.of(index + 1),
                samples: tally.cycles,
                gated: tally.gated,
                incomplete: tally.incomplete,
                implausible: tally.implausible,
                counter_jumps: *jumps,
                worst_r1: tally.worst[0],
                worst_r2: tally.worst[1],
                worst_r3: tally.worst[2],
                warnings: episodes.of_cylinder(index + 1),
                sequential: tally
                    .sequential
                    .map(|coverage| CoverageFields::new(&coverage, summary.sample_time)),
                process: tally
                    .process
                    .map(|coverage| ProcessCoverageFields::new(&coverage, summary.sample_time)),
            })
            .collect(),
        trends: summary.stops.lines(),
    };
    write_line(out, &line)
}

fn write_line(out: &mut impl Write, line: &impl Serialize) -> io::Result<()> {
    // It may go to a terminal, and JSON leaves C1 controls and what turns the direction of writing as they are.
    let line = serde_json::to_string(line)?;
    out.write_all(visible(&line).as_bytes())?;
    out.write_all(b"\n")
}
