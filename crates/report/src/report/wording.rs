//! Texts of a replay that several outputs share: rows, lines and numbers.

use super::notice::NoticeFields;
use super::{Episode, Summary, Zone};
use crate::story;
use tertius_config::MachineNames;
use tertius_core::alarm::Detector;
use tertius_core::alarm::detector::Basis;
use tertius_core::incident::Incident;
use tertius_core::monitor::Notice;
use tertius_core::process;
use tertius_core::sequential::Unknown;
use tertius_core::text::{Millimetres, counted};
use tertius_core::time::Timestamp;

pub const CYLINDER_COLUMNS: [&str; 8] =
    ["cylinder", "gated", "missing", "rejected", "worst R1", "worst R2", "worst R3", "incidents"];

/// Columns of the time in which the sequential detectors judged, and why not otherwise.
pub const COVERAGE_COLUMNS: [&str; 6] =
    ["cylinder", "judged", UNKNOWN[0], UNKNOWN[1], UNKNOWN[2], UNKNOWN[3]];

/// Reasons for which a sequential detector did not judge, in the order of [`Unknown::ALL`].
pub const UNKNOWN: [&str; Unknown::ALL.len()] =
    ["not monitored", "no reading", "not calibrated", "no baseline"];

/// What the process detectors judge by, in the order of [`tertius_core::process::ProcessCoverage::judged`].
pub const RELATIONS: [&str; process::RELATIONS] =
    ["the spools", "the chambers' pressures", "the flow", "the friction", "the supply"];

/// Columns of the time in which the process detectors judged.
pub const PROCESS_COLUMNS: [&str; 2 + process::RELATIONS] = [
    "cylinder",
    "monitored",
    "by the spool",
    "by the pressures",
    "by the flow",
    "by the friction",
    "by the supply",
];

pub const EPISODE_COLUMNS: [&str; 10] = [
    "at", "log time", "cylinder", "detector", "fault", "suspect", "level", "residual", "limit",
    "lasted",
];

/// Columns of the incidents.
pub const INCIDENT_COLUMNS: [&str; 7] =
    ["at", "cylinder", "suspect", "level", "what", "largest, mm", "lasted"];

/// Index of the column of an incident's level.
pub const LEVEL_COLUMN: usize = 3;

/// A row in the order of [`INCIDENT_COLUMNS`].
pub fn incident_row(zone: &Zone, incident: &Incident, names: &MachineNames) -> [String; 7] {
    let largest = incident.worst().map_or("–".to_owned(), |(quantity, peak)| {
        let (name, size) = (story::quantity(quantity), Millimetres(peak.value.abs()).to_string());
        format!("{} {}", name.replace(" − ", "−"), size.trim_end_matches(" mm"))
    });
    let over = || if incident.stands() { "stands" } else { "–" }.to_owned();
    let lasted = story::lasted(incident).unwrap_or_else(over);
    [
        zone.time(incident.begin),
        match incident.scope.cylinder() {
            Some(number) => names.short(number),
            None => story::numbers(incident.scope.cylinders()),
        },
        story::suspect_in_time(incident),
        incident.level.name().to_owned(),
        story::kind(incident),
        largest,
        lasted,
    ]
}

/// An incident in sentences: how it lasted, the evidence and what to do.
pub fn incident_story(zone: &Zone, incident: &Incident, names: &MachineNames) -> [String; 3] {
    [
        format!(
            "{} (stamped {}), {}.",
            capitalised(&zone.moment(incident.begin)),
            log_time(incident.begin),
            story::ending(incident)
        ),
        capitalised(&format!("{}.", story::evidence(incident))),
        story::advice(incident, names),
    ]
}

/// A row for each cylinder.
pub fn cylinder_rows(summary: &Summary<'_>) -> Vec<[String; 8]> {
    let row = |(number, tally): (usize, &tertius_core::monitor::cylinder::Tally)| {
        let [r1, r2, r3] = tally.worst.map(millimetres);
        [
            summary.names.short(number),
            tally.gated.to_string(),
            tally.incomplete.to_string(),
            (tally.implausible[0] + tally.implausible[1]).to_string(),
            r1,
            r2,
            r3,
            summary.incidents.of_cylinder(number).to_string(),
        ]
    };
    (1..).zip(summary.tallies).map(row).collect()
}

/// Seconds of coverage, a row for each cylinder with a sequential detector.
pub fn coverage_rows(summary: &Summary<'_>) -> Vec<[String; 6]> {
    let seconds = |cycles: u64| format!("{:.1} s", cycles as f64 * summary.sample_time);
    let row = |(number, tally): (usize, &tertius_core::monitor::cylinder::Tally)| {
        let coverage = tally.sequential?;
        let [unmonitored, unread, uncalibrated, baseline] = coverage.unknown.map(seconds);
        let judged = seconds(coverage.judged);
        Some([summary.names.short(number), judged, unmonitored, unread, uncalibrated, baseline])
    };
    (1..).zip(summary.tallies).filter_map(row).collect()
}

/// Seconds of coverage, a row for each cylinder with a process detector; a dash stands for what none of its
/// detectors judges by.
pub fn process_rows(summary: &Summary<'_>) -> Vec<[String; PROCESS_COLUMNS.len()]> {
    let seconds = |cycles: u64| format!("{:.1} s", cycles as f64 * summary.sample_time);
    let row = |(number, tally): (usize, &tertius_core::monitor::cylinder::Tally)| {
        let coverage = tally.process?;
        let [spool, chambers, flow, friction, supply] =
            coverage.judged().map(|it| it.map_or("–".to_owned(), seconds));
        let monitored = seconds(coverage.monitored);
        Some([summary.names.short(number), monitored, spool, chambers, flow, friction, supply])
    };
    (1..).zip(summary.tallies).filter_map(row).collect()
}

/// Introduction to the rows of [`process_rows`].
pub const PROCESS_COVERAGE: &str = "Process detectors: how long the platform was in a monitored \
    state, and how long they judged by each of what they compare";

/// Introduction to the rows of [`coverage_rows`].
pub const COVERAGE: &str = "Sequential detectors: how long they judged, and how long they could \
    not because the platform was in no monitored state, C1, C2 or the speed was missing or \
implausible, the rod was where the calibration has no data, or the difference in this stretch of \
motion was not yet learnt";

/// Number of times in words: once, or a number.
pub fn times(count: u64) -> String {
    if count == 1 { "once".to_owned() } else { format!("{count} times") }
}

/// Introduction to the `listed` first of the lines that were bad: `1 of 257 lines was bad:`.
pub fn bad_lines(bad: u64, lines: u64, listed: u64) -> String {
    let were = if bad == 1 { "was" } else { "were" };
    let first = match listed {
        all if all >= bad => String::new(),
        1 => "; the first".to_owned(),
        few => format!("; the first {few}"),
    };
    format!("{bad} of {} {were} bad{first}:", counted(lines, "line"))
}

/// A line about the counters; empty where none jumped.
pub fn counter_jumps(summary: &Summary<'_>) -> String {
    let jumps: u64 = summary.counter_jumps.iter().flatten().sum();
    if jumps == 0 {
        return String::new();
    }
    format!("alive counters jumped {}\n", times(jumps))
}

/// Number of warnings, by detector.
pub fn warnings(summary: &Summary<'_>) -> String {
    let episodes = summary.episodes;
    let total: u64 = episodes.raised().iter().sum();
    if total == 0 {
        return summary.judgement.without_warnings().to_owned();
    }
    let by_detector = Detector::ALL
        .iter()
        .zip(episodes.raised())
        .filter(|(_, raised)| **raised > 0)
        .map(|(detector, raised)| format!("{} {raised}", detector.label()));
    let by_detector = by_detector.collect::<Vec<_>>().join(", ");
    let warnings = if total == 1 { "warning" } else { "warnings" };
    format!("{total} {warnings}: {by_detector}")
}

/// A row in the order of [`EPISODE_COLUMNS`]; `first` is the recording's first frame.
pub fn episode_row(first: Timestamp, episode: &Episode, names: &MachineNames) -> [String; 10] {
    let finding = &episode.finding;
    let first_fault = story::what(finding.suspect, episode.first_fault);
    let fault = match finding.gain() {
        Some(gain) => format!("{first_fault} → {}", story::scale_error(gain)),
        None if episode.first_fault == finding.fault => first_fault.to_owned(),
        None => format!("{first_fault} → {}", story::what(finding.suspect, finding.fault)),
    };
    let fault = match finding.device {
        Some(device) => format!("{fault}: {device}"),
        None => fault,
    };
    let lasted = match episode.cleared {
        Some(cleared) => format!("{:.2} s", cleared.since(episode.raised).as_seconds()),
        None => "still raised".to_owned(),
    };
    [
        clock(episode.raised.since(first).as_seconds()),
        log_time(episode.raised),
        names.short(episode.cylinder),
        episode.detector.label().to_owned(),
        fault,
        story::suspect(finding.suspect).to_owned(),
        finding.level.name().to_owned(),
        millimetres(finding.residual),
        millimetres(finding.threshold),
        lasted,
    ]
}

/// An episode in a line: `1:00.060: step (FDE1): C1, yellow, 1.21 mm of 1.00 mm, for 6.02 s`.
pub fn episode_line(first: Timestamp, episode: &Episode, names: &MachineNames) -> String {
    let [at, _, _, detector, fault, _, level, residual, limit, lasted] =
        episode_row(first, episode, names);
    let whom = story::whom(names, episode.cylinder.into(), episode.finding.suspect, false);
    let detector = match episode.detector.basis() {
        Basis::Residual(_) | Basis::Readings => detector,
        Basis::Samples => format!("{detector} detector"),
    };
    let size = match (episode.finding.residual, episode.finding.threshold) {
        (Some(_), Some(_)) => format!(", {residual} of {limit}"),
        (Some(_), None) => format!(", {residual}"),
        (None, _) => String::new(),
    };
    let standing = if episode.cleared.is_some() { "for " } else { "" };
    format!("{at}: {fault} ({detector}): {whom}, {level}{size}, {standing}{lasted}")
}

/// Time and text of a notice.
pub fn notice(first: Timestamp, notice: &Notice, names: &MachineNames) -> [String; 2] {
    let at = NoticeFields::from(notice).at;
    [clock(at.since(first).as_seconds()), story::notice_line(notice, names)]
}

/// `text` with a capital at the beginning, as a line of its own. A symbol stays: Δ is none of the letters that
/// δ stands for.
pub fn capitalised(text: &str) -> String {
    let mut rest = text.chars();
    rest.next().map_or(String::new(), |first| {
        std::iter::once(first.to_ascii_uppercase()).chain(rest).collect()
    })
}

/// A residual or a limit; a dash without one.
fn millimetres(metres: Option<f64>) -> String {
    metres.map_or("–".to_owned(), |it| format!("{:.2}", Millimetres(it)))
}

/// A time as candump writes it, so that it can be searched for in the log: six decimals, or nine
/// where the recording has them.
fn log_time(at: Timestamp) -> String {
    let exact = at.to_string();
    let decimals = exact.split_once('.').map_or(0, |(_, decimals)| decimals.len());
    let missing = if decimals > 6 { 9 - decimals } else { 6 - decimals };
    exact + &"0".repeat(missing)
}

/// Hours, minutes and seconds, without leading zero parts.
pub fn clock(seconds: f64) -> String {
    let sign = if seconds < 0.0 { "-" } else { "" };
    let millis = (seconds.abs() * 1e3).round() as u64;
    let (hours, minutes) = (millis / 3_600_000, millis / 60_000 % 60);
    let (seconds, millis) = (millis / 1000 % 60, millis % 1000);
    match hours {
        0 => format!("{sign}{minutes}:{seconds:02}.{millis:03}"),
        _ => format!("{sign}{hours}:{minutes:02}:{seconds:02}.{millis:03}"),
    }
}
