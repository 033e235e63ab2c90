//! Warnings, incidents and dwells as rows: the fields of their lines of JSON.

use super::column::{Cells, TableColumn, TableRow, seconds};
use crate::report::device::{DeviceFields, EmergencyFields};
use crate::report::jsonl::NameFields;
use crate::story;
use std::borrow::Cow;
use tertius_config::MachineNames;
use tertius_core::alarm::register::DETECTORS;
use tertius_core::alarm::{Evidence, Warning};
use tertius_core::incident::{Excursion, Incident, Quantity};
use tertius_core::sequential::Dwell;
use tertius_core::time::{Span, Timestamp};

/// A warning that was raised, changed or cleared.
#[derive(Clone, Debug)]
pub struct WarningRow {
    /// Time stamp of the first frame of all, from which seconds count.
    begin: Timestamp,
    warning: Warning,
    /// As in the lines of JSON.
    name: Option<String>,
    suspect_name: Option<String>,
}

/// An incident that was opened, revised or closed.
#[derive(Clone, Debug)]
pub struct IncidentRow {
    /// As [`WarningRow::begin`].
    begin: Timestamp,
    incident: Incident,
    /// As in the lines of JSON.
    name: Option<String>,
    suspect_name: Option<String>,
    /// In words.
    summary: String,
}

/// A dwell on a mechanical stop.
#[derive(Clone, Debug)]
pub struct DwellRow {
    /// As [`WarningRow::begin`].
    begin: Timestamp,
    /// Cylinder number, counted from 1.
    cylinder: u8,
    name: Option<String>,
    dwell: Dwell,
}

macro_rules! columns {
    ($($name:literal, $unit:literal, $kind:ident, $meaning:literal, $get:expr;)*) => {
        &[$(TableColumn { name: $name, unit: $unit, meaning: $meaning, cells: Cells::$kind($get) }),*]
    };
}
pub(super) use columns;

pub(super) type Word = Option<Cow<'static, str>>;

/// A name that is always there.
#[expect(clippy::unnecessary_wraps, reason = "a cell may be null")]
pub(super) const fn word(name: &'static str) -> Word {
    Some(Cow::Borrowed(name))
}

impl WarningRow {
    /// The row of `warning`, of recordings whose first frame has the time stamp `begin`.
    pub fn new(begin: Timestamp, warning: &Warning, names: &MachineNames) -> Self {
        let named = NameFields::new(names, Some(warning.cylinder), warning.finding.suspect);
        Self {
            begin,
            warning: *warning,
            name: named.name.map(str::to_owned),
            suspect_name: named.suspect_name.map(str::to_owned),
        }
    }

    fn since(&self, at: Timestamp) -> Span {
        at.since(self.begin)
    }

    const fn evidence(&self) -> Option<&Evidence> {
        self.warning.finding.evidence.as_ref()
    }

    fn device(&self) -> Option<DeviceFields> {
        self.warning.finding.device.map(DeviceFields::from)
    }

    fn emergency(&self) -> Option<EmergencyFields> {
        self.device()?.emergency
    }
}

impl TableRow for WarningRow {
    const TABLE: &'static str = "warnings";

    const COLUMNS: &'static [TableColumn<Self>] = columns! {
        "timestamp", "ns since 1970, UTC", Time, "when it was raised, changed or cleared", |it| Some(it.warning.timestamp);
        "t", "s", Number, "the same since the first frame of all", |it| seconds(it.since(it.warning.timestamp));
        "cylinder", "", Count, "from 1", |it| Some(it.warning.cylinder.into());
        "name", "", Text, "name of the cylinder, if it has one", |it| it.name.clone().map(Into::into);
        "detector", "", Text, "which detector", |it| word(it.warning.detector.name());
        "fault", "", Text, "the kind of fault", |it| word(it.warning.finding.fault.name());
        "suspect", "", Text, "undecided, c1, c2, process", |it| word(it.warning.finding.suspect.name());
        "by", "", Text, "rule that named the suspect", |it| word(it.warning.finding.rule.name());
        "suspect_name", "", Text, "name of the transducer that is suspected, if it has one", |it| it.suspect_name.clone().map(Into::into);
        "level", "", Text, "none, yellow, orange, red, black", |it| word(it.warning.finding.level.name());
        "state", "", Text, "raised, changed, cleared", |it| word(it.warning.state.name());
        "residual", "m", Number, "what was compared, signed", |it| it.warning.finding.residual;
        "threshold", "m", Number, "what it was compared with", |it| it.warning.finding.threshold;
        "evidence", "nats", Number, "of a detector that weighs it: of a fault", |it| it.evidence().map(|it| it.fault);
        "location_evidence", "nats", Number, "which of the two it is: positive for C1", |it| it.evidence()?.location;
        "onset", "ns since 1970, UTC", Time, "when the fault began", |it| it.evidence().map(|it| it.onset);
        "size", "m", Number, "the fault's size", |it| it.evidence().and(it.warning.finding.residual);
        "process_size", "of its kind", Number, "size of a fault of process, as in the lines of JSON", |it| it.evidence()?.size;
        "shape", "", Text, "scale, where it is a gain that is off", |it| it.evidence()?.gain.and(word("scale"));
        "gain_percent", "%", Number, "how far C1's gain is off from C2's", |it| Some(100.0 * it.evidence()?.gain?);
        "device_node", "", Count, "CANopen node that said so of itself", |it| it.device().map(|it| it.node.into());
        "device_reason", "", Text, "emergency, heartbeat_lost", |it| it.device().and_then(|it| word(it.reason));
        "device_code", "", Text, "error code of the emergency", |it| it.emergency().map(|it| it.code.into());
        "device_words", "", Text, "the code in words", |it| it.emergency().and_then(|it| word(it.words));
        "device_register", "", Text, "error register", |it| it.emergency().map(|it| it.register.into());
        "device_field", "", Text, "the maker's own bytes", |it| it.emergency().map(|it| it.field.into());
    };

    fn at(&self) -> Timestamp {
        self.warning.timestamp
    }
}

impl IncidentRow {
    /// The row of `incident`, of recordings whose first frame has the time stamp `begin`.
    pub fn new(begin: Timestamp, incident: &Incident, names: &MachineNames) -> Self {
        let named = NameFields::new(names, incident.scope.cylinder(), incident.suspect);
        Self {
            begin,
            incident: *incident,
            name: named.name.map(str::to_owned),
            suspect_name: named.suspect_name.map(str::to_owned),
            summary: story::line(incident, names),
        }
    }

    fn since(&self, at: Timestamp) -> Option<f64> {
        seconds(at.since(self.begin))
    }

    fn worst(&self) -> Option<(Quantity, Excursion)> {
        self.incident.worst()
    }

    fn peak(&self, quantity: Quantity) -> Option<f64> {
        Some(self.incident.peaks[quantity as usize]?.value)
    }

    /// Names of the detectors that were raised, in their order, with commas between them.
    fn detectors(&self) -> String {
        let parts = DETECTORS.into_iter().zip(&self.incident.parts);
        let raised = parts.filter(|(_, part)| part.is_some()).map(|(detector, _)| detector.name());
        let mut names: Vec<&str> = raised.collect();
        // Plausibility has several places.
        names.dedup();
        names.join(",")
    }
}

impl TableRow for IncidentRow {
    const TABLE: &'static str = "incidents";

    const COLUMNS: &'static [TableColumn<Self>] = columns! {
        "timestamp", "ns since 1970, UTC", Time, "time of this report", |it| Some(it.incident.timestamp);
        "t", "s", Number, "the same since the first frame of all", |it| it.since(it.incident.timestamp);
        "incident", "", Count, "number, from 1 in a run", |it| Some(it.incident.number.into());
        "state", "", Text, "opened, revised, closed, standing", |it| word(it.incident.progress.name());
        "cylinder", "", Count, "from 1; none for the machine", |it| it.incident.scope.cylinder().map(Into::into);
        "name", "", Text, "name of the cylinder, if it has one", |it| it.name.clone().map(Into::into);
        "level", "", Text, "the highest that it reached", |it| word(it.incident.level.name());
        "suspect", "", Text, "undecided, c1, c2, process", |it| word(it.incident.suspect.name());
        "suspect_name", "", Text, "name of the transducer that is suspected, if it has one", |it| it.suspect_name.clone().map(Into::into);
        "named", "ns since 1970, UTC", Time, "when that suspect was first named", |it| it.incident.named.map(|it| it.at);
        "named_by_its_end", "", Truth, "whether the end of the fault named it", |it| it.incident.named.map(|it| it.by_its_end);
        "fault", "", Text, "the kind of fault", |it| word(it.incident.fault.name());
        "shape", "", Text, "scale, where it is a gain that is off", |it| it.incident.gain.and(word("scale"));
        "gain_percent", "%", Number, "how far C1's gain is off from C2's", |it| it.incident.gain.map(|it| 100.0 * it);
        "begin", "ns since 1970, UTC", Time, "its first warning", |it| Some(it.incident.begin);
        "onset", "ns since 1970, UTC", Time, "when the fault began", |it| Some(it.incident.onset);
        "end", "ns since 1970, UTC", Time, "when it was over", |it| it.incident.end.map(|(at, _)| at);
        "ending", "", Text, "returned, quiet, cut, joined", |it| it.incident.end.and_then(|(_, how)| word(how.name()));
        "size", "m", Number, "of a step or a drift", |it| it.incident.size;
        "quantity", "", Text, "which residual was largest against its limit", |it| it.worst().and_then(|(it, _)| word(it.name()));
        "peak", "m", Number, "the largest value of that residual", |it| it.worst().map(|(_, peak)| peak.value);
        "peak_at", "ns since 1970, UTC", Time, "when it was", |it| it.worst().map(|(_, peak)| peak.at);
        "limit", "m", Number, "its limit", |it| it.worst().map(|(quantity, _)| it.incident.limits[quantity as usize]);
        "now", "m", Number, "the newest value of that residual at the time of this report", |it| it.incident.worst_now();
        "peak_r1", "m", Number, "the largest R1", |it| it.peak(Quantity::R1);
        "peak_r2", "m", Number, "the largest R2", |it| it.peak(Quantity::R2);
        "peak_r3", "m", Number, "the largest R3", |it| it.peak(Quantity::R3);
        "peak_c1_c2", "m", Number, "the largest C1 − C2 beyond the machine's limit", |it| it.peak(Quantity::Measured);
        "detectors", "", Text, "those that were raised, with commas", |it| Some(it.detectors().into());
        "summary", "", Text, "in words", |it| Some(it.summary.clone().into());
        "evidence", "", Text, "why, in words", |it| Some(story::evidence(&it.incident).into());
    };

    fn at(&self) -> Timestamp {
        self.incident.timestamp
    }
}

impl DwellRow {
    /// The row of a `dwell` of the `cylinder`, of recordings whose first frame has the time stamp `begin`.
    pub fn new(begin: Timestamp, cylinder: u8, dwell: &Dwell, names: &MachineNames) -> Self {
        let name = names.of_cylinder(cylinder).map(str::to_owned);
        Self { begin, cylinder, name, dwell: *dwell }
    }
}

impl TableRow for DwellRow {
    const TABLE: &'static str = "dwells";

    const COLUMNS: &'static [TableColumn<Self>] = columns! {
        "timestamp", "ns since 1970, UTC", Time, "when the rod rested on its stop", |it| Some(it.dwell.at);
        "t", "s", Number, "the same since the first frame of all", |it| seconds(it.dwell.at.since(it.begin));
        "cylinder", "", Count, "from 1", |it| Some(it.cylinder.into());
        "name", "", Text, "name of the cylinder, if it has one", |it| it.name.clone().map(Into::into);
        "c1", "m", Number, "mean reading of C1", |it| Some(it.dwell.readings.c1);
        "c2", "m", Number, "mean reading of C2, if the cylinder has it", |it| it.dwell.readings.c2;
    };

    fn at(&self) -> Timestamp {
        self.dwell.at
    }
}
