//! The page that a person reads after a replay.

use super::jsonl::restart_name;
use super::{Episode, Summary};
use crate::alarm::Detector;
use crate::monitor::Notice;
use crate::time::Timestamp;
use crate::verdict::Suspect;
use comfy_table::{Attribute, Cell, CellAlignment, Color, Table, presets};
use std::fmt::Write as _;

/// Gaps, jumps and restarts that are kept for the page; the others are counted.
pub const NOTICES_KEPT: usize = 20;

/// Notices of a replay.
#[derive(Clone, Debug, Default)]
pub struct Notices {
    kept: Vec<Notice>,
    left_out: u64,
}

impl Notices {
    pub fn take(&mut self, notice: &Notice) {
        if self.kept.len() < NOTICES_KEPT {
            self.kept.push(*notice);
        } else {
            self.left_out += 1;
        }
    }
}

/// What stands above the tables.
#[derive(Clone, Copy, Debug)]
pub struct Heading<'a> {
    /// The recordings.
    pub inputs: &'a str,
    pub machine: &'a str,
    pub config: &'a str,
    /// The recording's first frame.
    pub first: Timestamp,
    /// Colours and attributes for a terminal.
    pub colour: bool,
}

/// The page as text.
pub fn page(heading: &Heading<'_>, summary: &Summary<'_>, notices: &Notices) -> String {
    let mut page = String::new();
    // Writing to a string cannot fail.
    _ = writeln!(page, "{}  with {} ({})\n", heading.inputs, heading.machine, heading.config);
    page += &overview(summary);
    page += &cylinders(heading, summary);
    page += &what_happened(heading, summary);
    page += &what_was_noticed(heading, notices);
    page += &what_was_bad(summary);
    page
}

fn overview(summary: &Summary<'_>) -> String {
    let Summary { statistics, counts, .. } = summary;
    let mut text = format!(
        "{} of recording: {} frames, of which {} not used by this configuration\n",
        clock(summary.duration),
        statistics.frames,
        summary.ignored_frames(),
    );
    _ = writeln!(
        text,
        "{} cycles, {} incomplete, {} missing",
        counts.cycles, counts.incomplete, counts.missing
    );
    for (count, what) in [
        (counts.late, "frames after the deadline of their cycle"),
        (counts.repeated, "frames that came twice in a cycle (the first one counts)"),
        (counts.bad_signals, "values that their frame was too short for, or not a number"),
        (counts.backwards, "frames with a time stamp before the one before"),
        (counts.time_jumps, "jumps of the time stamps (everything started anew)"),
        (statistics.error_frames, "error frames of the controller"),
        (statistics.remote_frames, "remote frames"),
        (statistics.other_interface_frames, "frames of other interfaces"),
    ] {
        if count > 0 {
            _ = writeln!(text, "{count} {what}");
        }
    }
    if statistics.interfaces.len() > 1 {
        let names = statistics.interfaces.iter().map(|i| format!("{} ({})", i.name, i.frames));
        let names = names.collect::<Vec<_>>().join(", ");
        _ = writeln!(text, "several interfaces, read as one: {names}; choose one with --interface");
    }
    if counts.cycles == 0 {
        text += "no cycle was found: does the configuration fit this recording?\n";
    }
    text + "\n"
}

fn table(heading: &Heading<'_>, columns: &[&str]) -> Table {
    let mut table = Table::new();
    table.load_style(presets::NOTHING);
    if !heading.colour {
        table.force_no_tty();
    }
    let header = columns.iter().map(|name| {
        let cell = Cell::new(name);
        if heading.colour { cell.add_attribute(Attribute::Bold) } else { cell }
    });
    table.set_header(header);
    table
}

fn cylinders(heading: &Heading<'_>, summary: &Summary<'_>) -> String {
    let columns = [
        "cylinder",
        "samples",
        "gated",
        "missing",
        "implausible",
        "worst R1",
        "worst R2",
        "worst R3",
        "warnings",
    ];
    let mut table = table(heading, &columns);
    for (index, tally) in summary.tallies.iter().enumerate() {
        let [r1, r2, r3] = tally.worst.map(|worst| worst.map_or("–".to_owned(), millimetres));
        let warnings = summary.episodes.of_cylinder(index + 1);
        table.add_row([
            (index + 1).to_string(),
            tally.cycles.to_string(),
            tally.gated.to_string(),
            tally.incomplete.to_string(),
            (tally.implausible[0] + tally.implausible[1]).to_string(),
            r1,
            r2,
            r3,
            warnings.to_string(),
        ]);
    }
    for column in table.column_iter_mut() {
        column.set_cell_alignment(CellAlignment::Right);
    }
    let mut text = format!("{}\n", table.trim_fmt());
    let jumps: u64 = summary.counter_jumps.iter().flatten().sum();
    if jumps > 0 {
        _ = writeln!(text, "alive counters jumped {jumps} times");
    }
    text + "\n"
}

fn what_happened(heading: &Heading<'_>, summary: &Summary<'_>) -> String {
    let episodes = summary.episodes;
    let total: u64 = episodes.raised().iter().sum();
    if total == 0 {
        return "No warnings.\n".to_owned();
    }
    let by_detector = Detector::ALL
        .iter()
        .zip(episodes.raised())
        .filter(|(_, raised)| **raised > 0)
        .map(|(detector, raised)| format!("{} {raised}", label(*detector)));
    let by_detector = by_detector.collect::<Vec<_>>().join(", ");
    let mut text = format!("{total} warnings: {by_detector}\n\n");
    let columns = [
        "at", "log time", "cylinder", "detector", "fault", "suspect", "level", "residual", "limit",
        "lasted",
    ];
    let mut table = table(heading, &columns);
    for episode in episodes.kept() {
        table.add_row(row(heading, episode));
    }
    for column in [0, 1, 2, 7, 8, 9] {
        if let Some(column) = table.column_mut(column) {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    _ = writeln!(text, "{}", table.trim_fmt());
    if episodes.left_out() > 0 {
        let left_out = episodes.left_out();
        _ = writeln!(text, "… and {left_out} more; --format jsonl gives them all");
    }
    text
}

fn row(heading: &Heading<'_>, episode: &Episode) -> Vec<Cell> {
    let finding = &episode.finding;
    let fault = if episode.first_fault == finding.fault {
        words(finding.fault.name())
    } else {
        format!("{} → {}", words(episode.first_fault.name()), words(finding.fault.name()))
    };
    let level = Cell::new(finding.level.name());
    let level = match (heading.colour, finding.level.name()) {
        (true, "yellow") => level.fg(Color::Yellow),
        (true, "orange") => level.fg(Color::DarkYellow),
        (true, "red") => level.fg(Color::Red),
        (true, "black") => level.fg(Color::Red).add_attribute(Attribute::Reverse),
        _ => level,
    };
    let lasted = match episode.cleared {
        Some(cleared) => format!("{:.2} s", cleared.since(episode.raised).as_seconds()),
        None => "still raised".to_owned(),
    };
    let millimetres = |value: Option<f64>| value.map_or("–".to_owned(), millimetres);
    vec![
        Cell::new(clock(episode.raised.since(heading.first).as_seconds())),
        Cell::new(log_time(episode.raised)),
        Cell::new(episode.cylinder),
        Cell::new(label(episode.detector)),
        Cell::new(fault),
        Cell::new(suspect(finding.suspect)),
        level,
        Cell::new(millimetres(finding.residual)),
        Cell::new(millimetres(finding.threshold)),
        Cell::new(lasted),
    ]
}

fn what_was_noticed(heading: &Heading<'_>, notices: &Notices) -> String {
    let mut text = String::new();
    if !notices.kept.is_empty() {
        text += "\nNoticed:\n";
    }
    for notice in &notices.kept {
        let (at, what) = match *notice {
            Notice::Gap { at, length } => {
                (at, format!("cycles again after {:.2} s without any", length.as_seconds()))
            }
            Notice::TimeJump { at, by } => {
                (at, format!("time stamps jumped by {:+.3} s", by.as_seconds()))
            }
            Notice::Interruption { at } => (at, "the bus was lost".to_owned()),
            Notice::Restart { at, cylinder, detector, reason } => {
                let (label, reason) = (label(detector), words(restart_name(reason)));
                (at, format!("cylinder {cylinder}: {label}'s observer starts anew ({reason})"))
            }
        };
        let clock = clock(at.since(heading.first).as_seconds());
        _ = writeln!(text, "{clock:>14}  {what}");
    }
    if notices.left_out > 0 {
        let left_out = notices.left_out;
        _ = writeln!(text, "{:>14}  … and {left_out} more; --format jsonl gives them all", "");
    }
    text
}

fn what_was_bad(summary: &Summary<'_>) -> String {
    let statistics = summary.statistics;
    let mut text = String::new();
    if statistics.bad_lines > 0 {
        let (bad, lines) = (statistics.bad_lines, statistics.lines);
        _ = writeln!(text, "\n{bad} of {lines} lines were bad; the first:");
        for line in &statistics.first_bad_lines {
            _ = writeln!(text, "  {line}");
        }
    }
    for damage in &statistics.damage {
        _ = writeln!(text, "\n{damage}");
    }
    text
}

fn label(detector: Detector) -> &'static str {
    match detector {
        Detector::Fde1 => "FDE1",
        Detector::Fde2 => "FDE2",
        Detector::Fde3 => "FDE3",
        other => other.name(),
    }
}

fn suspect(suspect: Suspect) -> &'static str {
    match suspect {
        Suspect::C1 => "C1",
        Suspect::C2 => "C2",
        other => other.name(),
    }
}

fn words(name: &str) -> String {
    name.replace('_', " ")
}

fn millimetres(metres: f64) -> String {
    format!("{:.2} mm", metres * 1e3)
}

/// As candump writes it, so that the place is found in the log with a search.
fn log_time(at: Timestamp) -> String {
    let micros = at.as_nanos().div_euclid(1000);
    format!("{}.{:06}", micros.div_euclid(1_000_000), micros.rem_euclid(1_000_000))
}

/// Hours, minutes and seconds, as few as there are.
fn clock(seconds: f64) -> String {
    let sign = if seconds < 0.0 { "-" } else { "" };
    let millis = (seconds.abs() * 1e3).round() as u64;
    let (hours, minutes) = (millis / 3_600_000, millis / 60_000 % 60);
    let (seconds, millis) = (millis / 1000 % 60, millis % 1000);
    match hours {
        0 => format!("{sign}{minutes}:{seconds:02}.{millis:03}"),
        _ => format!("{sign}{hours}:{minutes:02}:{seconds:02}.{millis:03}"),
    }
}
