//! An evaluation as text for a terminal and as JSON. The HTML page is made from the same tables.

mod accommodate;
mod contest;
mod handover;
mod hexapod;
mod last;
mod process;
mod side;
mod weights;

use super::IdentityFields;
use super::sheet::{Section, Sheet};
use serde::Serialize;
use tertius_config::Fingerprints;
use tertius_core::text::Millimetres;
use tertius_lab::evaluate::rows::{IncidentFigures, RowGroup, RowResult};
use tertius_lab::evaluate::{
    CONFIDENCE, Cell, EstimateResult, Evaluation, HealthyCell, Plan, Proportion, SuspectFigures,
    WITHIN,
};

/// Fixed parts of the JSON, between the values.
pub const JSON_PARTS: [&str; 3] = ["{\n  \"machine\": \"", ",\n  \"seed\": ", ",\n  \"rows\": ["];

#[derive(Serialize)]
struct Document<'a> {
    machine: &'a str,
    #[serde(flatten)]
    judged_by: IdentityFields<'a>,
    #[serde(flatten)]
    evaluation: &'a Evaluation,
}

/// The evaluation `with` a configuration as JSON for scripts: the same evaluation gives the same text.
pub fn json(evaluation: &Evaluation, with: &Fingerprints) -> String {
    let document = Document { machine: &evaluation.machine, judged_by: with.into(), evaluation };
    let mut text = serde_json::to_string_pretty(&document)
        .expect("names are strings, and JSON has a word for what is no number");
    text.push('\n');
    text
}

/// The text; `with` is the configuration that was evaluated.
pub fn text(plan: &Plan, evaluation: &Evaluation, with: &Fingerprints) -> String {
    let mut text = format!("{} with {with}\n{}\n", evaluation.machine, extent(plan));
    for section in sections(plan, evaluation) {
        text += "\n";
        text += &section.text();
    }
    text
}

/// Extent of the evaluation, and the meaning of the columns.
pub fn extent(plan: &Plan) -> String {
    format!(
        "simulated, seed {}, {} faults a row (a quarter for the loop and the hand-over); intervals of {:.0} % \
         confidence, exact; suspects: right/undecided/process/the other transducer",
        plan.seed,
        plan.extent.trials,
        CONFIDENCE * 1e2
    )
}

/// All tables that have rows.
pub fn sections(plan: &Plan, evaluation: &Evaluation) -> Vec<Section> {
    let rows = evaluation.rows.as_deref().unwrap_or_default();
    let cells = plan.extent.cells();
    let mut sections = vec![thesis(rows)];
    sections.extend(cells.iter().map(|cell| detection(*cell, rows)));
    sections.extend(cells.iter().map(|cell| incidents(*cell, rows)));
    sections.push(loops(rows));
    sections.extend(evaluation.healthy.iter().map(|cells| healthy(cells)));
    sections.extend(evaluation.contest.iter().flat_map(|grades| contest::sections(grades)));
    sections.extend(evaluation.estimates.iter().map(|cases| estimates(cases)));
    sections.extend(evaluation.weights.iter().map(|sets| weights::section(sets)));
    sections.extend(evaluation.process.iter().flat_map(process::sections));
    sections.extend(evaluation.handover.iter().flat_map(handover::sections));
    sections.extend(evaluation.side.iter().flat_map(side::sections));
    sections.extend(evaluation.hexapod.iter().flat_map(hexapod::sections));
    sections.extend(evaluation.last.iter().flat_map(last::sections));
    sections.extend(evaluation.accommodate.iter().map(accommodate::section));
    sections.retain(|section| !section.sheet.rows.is_empty());
    sections
}

/// A cell in words.
pub fn place(grade: &str, [height, period]: [f64; 2]) -> String {
    format!("{grade} transducers, sea of {height} m and {period} s")
}

fn sea([height, period]: [f64; 2]) -> String {
    format!("{height} m {period} s")
}

/// Types I, II and III beside the thesis's claims.
fn thesis(rows: &[RowResult]) -> Section {
    let mut sheet = Sheet::new(&[
        "fault",
        "the thesis",
        "transducers",
        "sea",
        "δ_h crossed",
        "probability",
        "holds",
        "by any",
    ]);
    let claimed = rows.iter().filter_map(|row| Some((row, row.thesis.as_ref()?)));
    for (row, judged) in claimed {
        sheet.add_row([
            row.label.clone(),
            judged.claim.clone(),
            row.grade.to_owned(),
            sea(row.sea),
            count(&judged.found),
            interval(&judged.found),
            if judged.holds { "yes" } else { "no" }.to_owned(),
            count(&judged.by_any),
        ]);
    }
    sheet.about(
        "what the thesis claims (section 5-4) of the observer on the faulty transducer, and what any \
         detector finds in the same time",
    )
}

fn detection(cell: Cell, rows: &[RowResult]) -> Section {
    let mut header: Vec<String> = ["fault", "faults"].map(str::to_owned).to_vec();
    header.extend(WITHIN.map(|seconds| format!("{seconds} s")));
    let more =
        ["interval", "median", "99 %", "suspect", "kind", "own observer", "FDE3", "plausibility"];
    header.extend(more.map(str::to_owned));
    let mut sheet = Sheet::new(&header);
    let of_cell = |it: &&RowResult| it.row.cell == cell && it.row.group != RowGroup::Loop;
    for row in rows.iter().filter(of_cell) {
        let figures = &row.figures;
        let mut cells = vec![row.label.clone(), figures.faults.to_string()];
        cells.extend(figures.found.iter().map(|found| percent(&found.found)));
        let last = figures.found.last().expect("there are times");
        let by = |name: &str| figures.detectors.get(name).map(|it| percent(&it.found));
        cells.extend([
            interval(&last.found),
            seconds(figures.delay.median),
            seconds(figures.delay.p99),
            suspects(&figures.suspect),
            figures.kind.map_or("–".to_owned(), |kind| percent(&kind.named)),
            percent(&figures.own.found),
            by("fde3").unwrap_or_default(),
            by("plausibility").unwrap_or_default(),
        ]);
        sheet.add_row(cells);
    }
    sheet.about(format!("what is found: {}", place(cell.grade.name(), cell.sea)))
}

/// What the incidents say, beside the warnings that they are made of, and in the last row of all faults of the
/// cell together.
fn incidents(cell: Cell, rows: &[RowResult]) -> Section {
    let mut sheet = Sheet::new(&[
        "fault",
        "found",
        "one incident",
        "several",
        "its suspect",
        "of the warnings",
        "its kind",
        "of the warnings",
    ]);
    let of_cell = |it: &&RowResult| it.row.cell == cell && it.row.group != RowGroup::Loop;
    let (mut one, mut of, mut split) = (0, 0, 0);
    for row in rows.iter().filter(of_cell) {
        let IncidentFigures { one: alone, split: several, suspect, named } = row.figures.incidents;
        if alone.of == 0 {
            continue;
        }
        (one, of, split) = (one + alone.count, of + alone.of, split + several);
        let kind = |named: Option<Proportion>| named.map_or("–".to_owned(), |it| percent(&it));
        sheet.add_row([
            row.label.clone(),
            alone.of.to_string(),
            percent(&alone),
            several.to_string(),
            suspects(&suspect),
            suspects(&row.figures.suspect),
            kind(named),
            kind(row.figures.kind.map(|kind| kind.named)),
        ]);
    }
    if of > 0 {
        let all = Proportion::new(one, of);
        let mut cells =
            ["all".to_owned(), of.to_string(), percent(&all), split.to_string()].to_vec();
        cells.extend(std::iter::repeat_n("–".to_owned(), 4));
        sheet.add_row(cells);
    }
    sheet.about(format!("what the incidents say: {}", place(cell.grade.name(), cell.sea)))
}

/// Table of the same faults beside the loop and in it.
fn loops(rows: &[RowResult]) -> Section {
    let mut sheet = Sheet::new(&[
        "fault of C1",
        "controller",
        "faults",
        "found",
        "median",
        "suspect at first",
        "in the end",
        "kind",
        "R1",
        "R2",
        "R3",
        "rod off",
        "at most",
        "C1 off",
        "others",
    ]);
    let mm = |metres: f64| format!("{:.2}", metres * 1e3);
    for row in rows.iter().filter(|row| row.row.group == RowGroup::Loop) {
        let figures = &row.figures;
        let Some(moved) = figures.moved else { continue };
        let mut cells = vec![
            row.label.clone(),
            if row.in_loop { "reads it" } else { "does not" }.to_owned(),
            figures.faults.to_string(),
            percent(&figures.found_watched),
            seconds(figures.delay.median),
            suspects(&figures.suspect_first),
            suspects(&figures.suspect),
            figures.kind.map_or("–".to_owned(), |kind| percent(&kind.named)),
        ];
        cells.extend(figures.worst.map(mm));
        cells.extend([moved.rod_median, moved.rod_largest, moved.reading_median].map(mm));
        cells.push(figures.beside.unwrap_or(0).to_string());
        sheet.add_row(cells);
    }
    sheet.about(
        "the loop: R1 to R3 are medians of the largest, rod and C1 against the same machine without \
         the fault, mm; others are warnings of other cylinders",
    )
}

fn healthy(cells: &[HealthyCell]) -> Section {
    let mut sheet = Sheet::new(&[
        "transducers",
        "sea",
        "hours",
        "false alarms",
        "a year",
        "at most",
        "FDE1",
        "FDE2",
        "FDE3",
        "plausibility",
        "R1 within",
        "R2 within",
        "R3 within",
    ]);
    for cell in cells {
        let events = |name: &str| cell.detectors.get(name).map_or(0, |rate| rate.events);
        let mut cells = vec![
            cell.grade.to_owned(),
            sea(cell.sea),
            format!("{:.1}", cell.hours),
            cell.false_alarms.events.to_string(),
            rate(cell.false_alarms.per_year),
            rate(cell.false_alarms.at_most),
        ];
        cells.extend(["fde1", "fde2", "fde3", "plausibility"].map(|name| events(name).to_string()));
        let share = |it: &Proportion| format!("{:.5} %", it.probability.unwrap_or(0.0) * 1e2);
        cells.extend(cell.within.iter().map(share));
        sheet.add_row(cells);
    }
    sheet.about(
        "false alarms of a machine, all cylinders together, and the bound of 95 %; a year is 8766 \
         monitored hours",
    )
}

fn estimates(results: &[EstimateResult]) -> Section {
    let mut sheet = Sheet::new(&[
        "case",
        "transducers",
        "sea",
        "cylinders",
        "valid",
        "RMS",
        "95 %",
        "largest",
        "within 2 σ",
    ]);
    for result in results {
        let mm = |metres: f64| format!("{:.2}", Millimetres(metres));
        let mut cells = vec![
            result.case.to_owned(),
            result.grade.to_owned(),
            sea(result.sea),
            result.cylinders.to_string(),
            format!("{:.1} %", result.valid * 1e2),
        ];
        cells.extend([result.rms, result.p95, result.largest].map(mm));
        cells.push(percent(&result.within));
        sheet.add_row(cells);
    }
    sheet.about(
        "the virtual sensor while it lasts: cycles with a valid estimate; errors against the rod on the \
         scale of C1; errors within two of the standard deviations given",
    )
}

fn count(found: &Proportion) -> String {
    format!("{} of {}", found.count, found.of)
}

fn percent(found: &Proportion) -> String {
    match (found.probability, found.count) {
        (None, _) => "–".to_owned(),
        // Only what is all is shown as all.
        (Some(_), count) if count == found.of => "100 %".to_owned(),
        (Some(share), _) => format!("{:.1} %", (share * 1e2).min(99.9)),
    }
}

fn interval(found: &Proportion) -> String {
    let [low, high] = found.interval.map(|share| share * 1e2);
    format!("{low:.1} … {high:.1} %")
}

fn seconds(delay: Option<f64>) -> String {
    delay.map_or("–".to_owned(), |delay| format!("{delay:.3} s"))
}

fn suspects(figures: &SuspectFigures) -> String {
    let SuspectFigures { right, undecided, process, wrong } = figures;
    format!("{right}/{undecided}/{process}/{wrong}")
}

/// Median and 95th percentile of lengths in m, where there are any.
fn millimetres(both: &Option<[f64; 2]>) -> String {
    let text =
        |[median, late]: [f64; 2]| format!("{:.1}, {:.1}", Millimetres(median), Millimetres(late));
    both.map_or_else(|| "–".to_owned(), text)
}

/// Events a year, with as many digits as are significant.
fn rate(per_year: f64) -> String {
    match per_year {
        0.0 => "0".to_owned(),
        it if it < 100.0 => format!("{it:.1}"),
        it => format!("{it:.0}"),
    }
}
