//! The summary of a replay as a row.

use super::column::{Cells, TableColumn, TableRow, count};
use super::events::columns;
use crate::report::Summary;
use tertius_core::alarm::Detector;
use tertius_core::monitor::Counts;
use tertius_core::time::Timestamp;

/// What a summary does not have.
#[derive(Clone, Copy, Debug)]
pub struct SummaryFacts<'a> {
    /// Time stamp of the recording's first frame.
    pub begin: Timestamp,
    /// The recordings as they were named, with commas.
    pub recordings: &'a str,
    /// `sequential.false_alarms_per_year` of the configuration.
    pub false_alarms_per_year: f64,
}

/// A replay.
#[derive(Clone, Debug)]
pub struct SummaryRow {
    begin: Timestamp,
    recordings: String,
    false_alarms_per_year: f64,
    judged: bool,
    reasons: Option<String>,
    configuration: String,
    calibration: Option<String>,
    calibration_recorded: Option<String>,
    sample_time: f64,
    duration: f64,
    frames: u64,
    ignored_frames: u64,
    error_frames: u64,
    bad_lines: u64,
    damaged_inputs: u64,
    counts: Counts,
    incidents: u64,
    warnings: [u64; Detector::ALL.len()],
}

impl SummaryRow {
    /// The row of `summary`.
    pub fn new(summary: &Summary<'_>, facts: SummaryFacts<'_>) -> Self {
        let Summary { statistics, fingerprints, judgement, .. } = summary;
        Self {
            begin: facts.begin,
            recordings: facts.recordings.to_owned(),
            false_alarms_per_year: facts.false_alarms_per_year,
            judged: judgement.is_judged(),
            reasons: (!judgement.is_judged()).then(|| judgement.reasons().join("; ")),
            configuration: fingerprints.configuration.to_string(),
            calibration: fingerprints.calibration.map(|it| it.to_string()),
            calibration_recorded: fingerprints.recorded.clone(),
            sample_time: summary.sample_time,
            duration: summary.duration,
            frames: statistics.frames,
            ignored_frames: summary.ignored_frames(),
            error_frames: statistics.error_frames,
            bad_lines: statistics.bad_lines,
            damaged_inputs: statistics.damaged_inputs,
            counts: *summary.counts,
            incidents: summary.incidents.count(),
            warnings: *summary.episodes.raised(),
        }
    }

    fn warnings(&self, detector: Detector) -> Option<i64> {
        count(self.warnings[detector as usize - 1])
    }
}

impl TableRow for SummaryRow {
    const TABLE: &'static str = "summaries";

    const COLUMNS: &'static [TableColumn<Self>] = columns! {
        "begin", "ns since 1970, UTC", Time, "first frame", |it| Some(it.begin);
        "recordings", "", Text, "as they were named, with commas", |it| Some(it.recordings.clone().into());
        "judged", "", Truth, "whether any residual was judged", |it| Some(it.judged);
        "reasons", "", Text, "why not", |it| it.reasons.clone().map(Into::into);
        "configuration", "", Text, "identity of the configuration", |it| Some(it.configuration.clone().into());
        "calibration", "", Text, "identity of the calibration", |it| it.calibration.clone().map(Into::into);
        "calibration_recorded", "", Text, "day of its newest recording", |it| it.calibration_recorded.clone().map(Into::into);
        "false_alarms_per_year", "a year", Number, "the false alarms that the configuration allows", |it| Some(it.false_alarms_per_year);
        "sample_time", "s", Number, "a cycle", |it| Some(it.sample_time);
        "duration", "s", Number, "from the first frame to the last", |it| Some(it.duration);
        "frames", "", Count, "frames read", |it| count(it.frames);
        "ignored_frames", "", Count, "those that the configuration does not use", |it| count(it.ignored_frames);
        "error_frames", "", Count, "error frames", |it| count(it.error_frames);
        "bad_lines", "", Count, "lines or records that could not be read", |it| count(it.bad_lines);
        "damaged_inputs", "", Count, "files that end before their end", |it| count(it.damaged_inputs);
        "cycles", "", Count, "cycles opened", |it| count(it.counts.cycles);
        "incomplete_cycles", "", Count, "without something that is configured", |it| count(it.counts.incomplete);
        "missing_cycles", "", Count, "not opened", |it| count(it.counts.missing);
        "late_frames", "", Count, "after their deadline", |it| count(it.counts.late);
        "repeated_frames", "", Count, "twice", |it| count(it.counts.repeated);
        "contradicting_frames", "", Count, "with the same count as another one and another payload", |it| count(it.counts.contradicting);
        "short_frames", "", Count, "too short for what is configured of them", |it| count(it.counts.short);
        "sync_doubted_seconds", "s", Count, "in which Sync was missing or too frequent", |it| count(it.counts.sync_doubted);
        "held_frames", "", Count, "before their cycle, and kept", |it| count(it.counts.held);
        "bad_signals", "", Count, "signals that are no finite number", |it| count(it.counts.bad_signals);
        "unnamed_status_bits", "", Count, "of status signals, without a meaning in the configuration", |it| count(it.counts.unnamed_status_bits);
        "backwards", "", Count, "frames with an earlier time stamp", |it| count(it.counts.backwards);
        "time_jumps", "", Count, "jumps of the clock", |it| count(it.counts.time_jumps);
        "interruptions", "", Count, "losses of the bus", |it| count(it.counts.interruptions);
        "incidents", "", Count, "incidents opened", |it| count(it.incidents);
        "warnings_fde1", "", Count, "warnings raised by fde1", |it| it.warnings(Detector::Fde1);
        "warnings_fde2", "", Count, "by fde2", |it| it.warnings(Detector::Fde2);
        "warnings_fde3", "", Count, "by fde3", |it| it.warnings(Detector::Fde3);
        "warnings_plausibility", "", Count, "by plausibility", |it| it.warnings(Detector::Plausibility);
        "warnings_sequential", "", Count, "by sequential", |it| it.warnings(Detector::Sequential);
        "warnings_process", "", Count, "by process", |it| it.warnings(Detector::Process);
    };

    fn at(&self) -> Timestamp {
        self.begin
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_detector_has_a_column() {
        for detector in Detector::ALL {
            let name = format!("warnings_{}", detector.name());
            assert!(SummaryRow::COLUMNS.iter().any(|column| column.name == name), "{name}");
        }
    }
}
