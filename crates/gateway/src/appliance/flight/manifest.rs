//! The file that says what a recording is, and what the gateway said of it.

use super::plan::FlightPlan;
use serde::Serialize;
use serde_json::value::RawValue;
use std::io;
use tertius_config::MachineNames;
use tertius_core::incident::Incident;
use tertius_core::time::Timestamp;
use tertius_report::report::jsonl;

/// The fields of a [`MANIFEST`](super::plan::MANIFEST).
#[derive(Serialize)]
pub(super) struct Manifest<'a> {
    r#type: &'static str,
    cause: &'static str,
    machine: &'a str,
    version: &'static str,
    /// Identity of the configuration beside it, and of the calibration in that.
    configuration: String,
    calibration: Option<String>,
    cylinder: Option<u8>,
    /// Name of the cylinder, if it has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    name: Option<&'a str>,
    incident: Option<u32>,
    /// When the incident began, or the recording was asked for.
    time: String,
    /// Time stamps of the first and the last frame.
    from: Box<RawValue>,
    to: Box<RawValue>,
    frames: u64,
    /// Number of frames that came to the gateway and are missing in the recording.
    lost: u64,
    /// Whether the recording goes on until its time after the incident.
    complete: bool,
    /// Lines of the incident as `replay --format jsonl` writes them.
    lines: Vec<Box<RawValue>>,
}

/// What the frames of a recording are.
#[derive(Clone, Copy, Debug)]
pub(super) struct Extent {
    /// Time stamps of the first and the last frame.
    pub ends: [Timestamp; 2],
    pub frames: u64,
    pub lost: u64,
    pub complete: bool,
}

impl<'a> Manifest<'a> {
    /// The manifest of a recording by `plan` of the incident `told`, as it was told step by step; of one on demand where
    /// nothing was told.
    pub fn new(
        plan: &'a FlightPlan,
        at: Timestamp,
        extent: Extent,
        told: &[Incident],
    ) -> io::Result<Self> {
        let [first, last] = extent.ends;
        let number = |at: Timestamp| RawValue::from_string(at.to_string()).unwrap_or_default();
        let incident = told.first();
        Ok(Self {
            r#type: "recording",
            cause: if incident.is_some() { "incident" } else { "on demand" },
            machine: &plan.machine,
            version: env!("CARGO_PKG_VERSION"),
            configuration: plan.fingerprints.configuration.to_string(),
            calibration: plan.fingerprints.calibration.map(|it| it.to_string()),
            cylinder: incident.and_then(|it| it.scope.cylinder()),
            name: incident
                .and_then(|it| it.scope.cylinder())
                .and_then(|number| plan.names.of_cylinder(number)),
            incident: incident.map(|it| it.number),
            time: utc(at).map_or_else(String::new, |at| at.to_string()),
            from: number(first),
            to: number(last),
            frames: extent.frames,
            lost: extent.lost,
            complete: extent.complete,
            lines: told.iter().map(|it| line(first, it, &plan.names)).collect::<io::Result<_>>()?,
        })
    }

    /// The file's content.
    pub fn to_bytes(&self) -> io::Result<Vec<u8>> {
        let mut bytes = serde_json::to_vec_pretty(self)?;
        bytes.push(b'\n');
        Ok(bytes)
    }
}

fn line(first: Timestamp, incident: &Incident, names: &MachineNames) -> io::Result<Box<RawValue>> {
    let mut line = Vec::new();
    jsonl::incident(&mut line, first, incident, names)?;
    let line = String::from_utf8(line).map_err(io::Error::other)?;
    Ok(RawValue::from_string(line.trim_end().to_owned())?)
}

/// `at` as a point of civil time; `None` beyond the year 9999.
pub(super) fn utc(at: Timestamp) -> Option<jiff::Timestamp> {
    jiff::Timestamp::from_nanosecond(i128::from(at.as_nanos())).ok()
}
