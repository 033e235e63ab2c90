//! The page for people after a replay.

use super::{Summary, Zone, verdict, wording};
use comfy_table::{
    Attribute, Cell, CellAlignment, Color, ColumnConstraint, ContentArrangement, Table, Width,
    presets,
};
use console::style;
use std::fmt::Write as _;
use tertius_config::{MachineNames, visible_lines};
use tertius_core::incident::Incident;
use tertius_core::monitor::Notice;

/// Most gaps, jumps and restarts that are kept for the page; further ones are counted.
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

    pub fn kept(&self) -> &[Notice] {
        &self.kept
    }

    /// Number of notices beyond [`NOTICES_KEPT`].
    pub const fn left_out(&self) -> u64 {
        self.left_out
    }
}

/// Width of the text, columns.
const WIDTH: usize = 80;

/// Most incidents in the text's table.
const IN_TABLE: usize = 40;

/// Most incidents whose story is told in the text: the worst ones.
const IN_STORIES: usize = 3;

/// Heading above the tables.
#[derive(Clone, Copy, Debug)]
pub struct Heading<'a> {
    /// Names of the recordings.
    pub inputs: &'a str,
    pub machine: &'a str,
    pub config: &'a str,
    /// How times are written.
    pub zone: &'a Zone,
    /// Whether to use colours and attributes of a terminal.
    pub colour: bool,
}

/// The page as text. Whatever others may have written is escaped before colours are added: names of files, interfaces
/// and the platform's states.
pub fn page(heading: &Heading<'_>, summary: &Summary<'_>, notices: &Notices) -> String {
    let mut page = String::new();
    // Writing to a string cannot fail.
    let (inputs, machine, config) = (heading.inputs, heading.machine, heading.config);
    _ = writeln!(page, "{inputs}  with {machine} ({config}: {})\n", summary.judged_by());
    let headline = visible_lines(&summary.judgement.headline()).into_owned();
    if !headline.is_empty() {
        let red = || style(&headline).red().force_styling(true).to_string();
        let headline = if heading.colour { red() } else { headline.clone() };
        _ = writeln!(page, "{headline}");
    }
    for line in verdict::lines(summary, heading.zone) {
        _ = writeln!(page, "{}", textwrap::fill(&line, WIDTH));
    }
    for remark in summary.remarks {
        let remark = textwrap::fill(&visible_lines(&format!("Look at {remark}.")), WIDTH);
        let yellow = || style(&remark).yellow().force_styling(true).to_string();
        _ = writeln!(page, "\n{}", if heading.colour { yellow() } else { remark.clone() });
    }
    page += &incidents(heading, summary);
    _ = writeln!(page, "\n{}", visible_lines(overview(summary).trim_end()));
    _ = writeln!(page, "{}\n", textwrap::fill(&wording::warnings(summary), WIDTH));
    page += &cylinders(heading, summary);
    page += &on_the_stops(heading, summary);
    page += &what_was_noticed(heading, summary, notices);
    page += &visible_lines(&what_was_bad(summary));
    page
}

pub(super) fn overview(summary: &Summary<'_>) -> String {
    let Summary { statistics, counts, .. } = summary;
    let mut text = format!(
        "{} of recording{}: {}, of which {} not used by this configuration\n",
        wording::clock(summary.recorded),
        within(summary),
        tertius_core::text::counted(statistics.frames, "frame"),
        summary.ignored_frames(),
    );
    _ = writeln!(
        text,
        "{} cycles, {} incomplete, {} missing",
        counts.cycles, counts.incomplete, counts.missing
    );
    for (count, what, which) in [
        (counts.late, "frame", "that came after the cycle was decided"),
        (counts.repeated, "frame", "that came twice"),
        (counts.contradicting, "frame", "that contradicted another one with the same count"),
        (counts.short, "frame", "too short for the signals that are configured (left out)"),
        (counts.sync_doubted, "second", "in which Sync was missing or too frequent"),
        (counts.held, "frame", "that came before the cycle (kept for it)"),
        (counts.bad_signals, "value", "beyond the end of the frame, or not a number"),
        (
            counts.unnamed_status_bits,
            "bit",
            "of status signals that the configuration gives no meaning",
        ),
        (counts.backwards, "frame", "with a time stamp earlier than the previous one"),
        (counts.time_jumps, "jump", "of the time stamps (everything restarted)"),
        (counts.interruptions, "interruption", "of the bus (everything restarted)"),
        (statistics.error_frames, "error frame", "of the controller"),
        (statistics.remote_frames, "remote frame", ""),
        (statistics.other_interface_frames, "frame", "of other interfaces"),
    ] {
        if count > 0 {
            let counted = tertius_core::text::counted(count, what);
            _ = writeln!(text, "{}", format!("{counted} {which}").trim_end());
        }
    }
    if statistics.interfaces.len() > 1 {
        _ = writeln!(text, "interfaces: {}", statistics.interfaces_found());
    }
    text + "\n"
}

/// The time in which it was recorded, where there was more of it between the first frame and the last; where there was
/// less, by how much its clock was set back.
fn within(summary: &Summary<'_>) -> String {
    let more = summary.duration - summary.recorded;
    match more {
        _ if more >= 1.0 => format!(" within {}", wording::clock(summary.duration)),
        _ if more <= -1.0 => format!(", whose clock was set back by {}", wording::clock(-more)),
        _ => String::new(),
    }
}

fn table(heading: &Heading<'_>, columns: &[&str]) -> Table {
    let mut table = Table::new();
    table.load_style(presets::NOTHING);
    table.set_content_arrangement(ContentArrangement::Dynamic).set_width(WIDTH as u16);
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
    let mut table = table(heading, &wording::CYLINDER_COLUMNS);
    for row in wording::cylinder_rows(summary) {
        table.add_row(row);
    }
    for column in table.column_iter_mut() {
        column.set_cell_alignment(CellAlignment::Right);
    }
    format!("{}\n{}", table.trim_fmt(), wording::counter_jumps(summary))
}

fn incidents(heading: &Heading<'_>, summary: &Summary<'_>) -> String {
    let all = summary.incidents.by_severity();
    if all.is_empty() {
        return String::new();
    }
    let mut table = table(heading, &wording::INCIDENT_COLUMNS);
    for incident in all.iter().take(IN_TABLE) {
        table.add_row(row(heading, incident, summary.names));
    }
    for column in [0, 1, 5, 6] {
        if let Some(column) = table.column_mut(column) {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    let mut text = format!("\n{}\n", table.trim_fmt());
    let left_out = summary.incidents.count() - all.len().min(IN_TABLE) as u64;
    if left_out > 0 {
        _ = writeln!(text, "… and {left_out} more; --format jsonl gives them all");
    }
    for incident in all.iter().take(IN_STORIES) {
        _ = writeln!(text, "\n{}", story(heading, incident, summary.names));
    }
    text
}

/// An incident in sentences, folded under its line.
fn story(heading: &Heading<'_>, incident: &Incident, names: &MachineNames) -> String {
    let indented = textwrap::Options::new(WIDTH).initial_indent("  ").subsequent_indent("  ");
    let line = wording::capitalised(&crate::story::line(incident, names));
    let mut text = textwrap::fill(&line, WIDTH);
    for sentence in wording::incident_story(heading.zone, incident, names) {
        text += "\n";
        text += &textwrap::fill(&sentence, &indented);
    }
    text
}

fn on_the_stops(heading: &Heading<'_>, summary: &Summary<'_>) -> String {
    let stops = summary.stops;
    if stops.is_empty() {
        return String::new();
    }
    if !stops.is_judged() {
        return format!("\n{}\n", stops.verdict());
    }
    let columns = stops.columns();
    let mut table = table(heading, &columns.iter().map(String::as_str).collect::<Vec<_>>());
    for row in stops.rows() {
        table.add_row(row);
    }
    if let Some(column) = table.column_mut(1) {
        // The longest word in it, which is not to be broken.
        column.set_constraint(ColumnConstraint::Absolute(Width::Fixed(12)));
    }
    for column in [0, 2, 4, 5] {
        if let Some(column) = table.column_mut(column) {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    format!("\n{}\n\n{}\n", stops.verdict(), table.trim_fmt())
}

fn row(heading: &Heading<'_>, incident: &Incident, names: &MachineNames) -> Vec<Cell> {
    let mut cells = wording::incident_row(heading.zone, incident, names).map(Cell::new).to_vec();
    let name = incident.level.name();
    let level = Cell::new(name);
    cells[wording::LEVEL_COLUMN] = match (heading.colour, name) {
        (true, "yellow") => level.fg(Color::Yellow),
        (true, "orange") => level.fg(Color::DarkYellow),
        (true, "red") => level.fg(Color::Red),
        (true, "black") => level.fg(Color::Red).add_attribute(Attribute::Reverse),
        _ => level,
    };
    cells
}

fn what_was_noticed(heading: &Heading<'_>, summary: &Summary<'_>, notices: &Notices) -> String {
    let mut text = String::new();
    if !notices.kept.is_empty() {
        text += "\nNoticed:\n";
    }
    for notice in &notices.kept {
        let [clock, what] = wording::notice(heading.zone.first(), notice, summary.names);
        let indent = " ".repeat(16);
        let folded = textwrap::Options::new(WIDTH).subsequent_indent(&indent);
        _ = writeln!(text, "{}", textwrap::fill(&format!("{clock:>14}  {what}"), folded));
    }
    if notices.left_out > 0 {
        let left_out = notices.left_out;
        _ = writeln!(text, "{:>14}  … and {left_out} more; --format jsonl gives them all", "");
    }
    text
}

pub(super) fn what_was_bad(summary: &Summary<'_>) -> String {
    let statistics = summary.statistics;
    let mut text = String::new();
    if statistics.bad_lines > 0 {
        let (bad, lines) = (statistics.bad_lines, statistics.lines);
        let listed = statistics.first_bad_lines.len() as u64;
        _ = writeln!(text, "\n{}", wording::bad_lines(bad, lines, listed));
        for line in &statistics.first_bad_lines {
            _ = writeln!(text, "  {line}");
        }
    }
    // Else they are told above all.
    for barren in statistics.barren.iter().filter(|_| summary.counts.used > 0) {
        _ = writeln!(text, "\n{barren}");
    }
    for damage in &statistics.damage {
        _ = writeln!(text, "\n{damage}");
    }
    text
}
