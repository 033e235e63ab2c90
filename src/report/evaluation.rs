//! An evaluation as a page for people and as JSON.

use crate::evaluate::{
    CONFIDENCE, Evaluation, HealthyCell, Plan, Proportion, RowResult, Study, SuspectFigures, WITHIN,
};
use comfy_table::{CellAlignment, Table, presets};
use std::fmt::Write as _;

/// All of it, for scripts: the same evaluation is the same text.
pub fn json(evaluation: &Evaluation) -> String {
    let mut text = serde_json::to_string_pretty(evaluation)
        .expect("names are strings, and JSON has a word for what is no number");
    text.push('\n');
    text
}

/// The page.
pub fn page(plan: &Plan, evaluation: &Evaluation) -> String {
    let mut text = format!(
        "{}, simulated; seed {}, {} faults a row\nintervals of {:.0} % confidence, exact; suspects: \
         right/undecided/process/the other transducer\n",
        evaluation.machine,
        evaluation.seed,
        plan.extent.trials,
        CONFIDENCE * 1e2
    );
    text += &thesis(evaluation);
    for cell in &plan.cells {
        let of_cell = |it: &&RowResult| it.row.cell == *cell && it.row.study != Study::Loop;
        let rows: Vec<&RowResult> = evaluation.rows.iter().filter(of_cell).collect();
        if !rows.is_empty() {
            let place = place(cell.grade.name(), cell.sea);
            _ = write!(text, "\nWhat is found: {place}\n{}\n", detection(&rows));
        }
    }
    text += &loops(evaluation);
    text += &healthy(&evaluation.healthy);
    text
}

fn place(grade: &str, [height, period]: [f64; 2]) -> String {
    format!("{grade} transducers, sea of {height} m and {period} s")
}

fn table(header: &[&str], texts: usize) -> Table {
    let mut table = Table::new();
    table.load_style(presets::NOTHING);
    table.force_no_tty();
    table.set_header(header.iter().copied());
    for column in table.column_iter_mut().skip(texts) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table
}

/// Types I, II and III beside the thesis's claims.
fn thesis(evaluation: &Evaluation) -> String {
    let claimed = || evaluation.rows.iter().filter_map(|row| Some((row, row.thesis.as_ref()?)));
    if claimed().next().is_none() {
        return String::new();
    }
    let header =
        ["fault", "the thesis", "transducers", "sea", "δ_h crossed", "probability", "holds"];
    let mut table = table(&header, 2);
    for (row, judged) in claimed() {
        let [height, period] = row.sea;
        table.add_row([
            row.label.clone(),
            judged.claim.clone(),
            row.grade.to_owned(),
            format!("{height} m {period} s"),
            count(&judged.found),
            interval(&judged.found),
            if judged.holds { "yes" } else { "no" }.to_owned(),
        ]);
    }
    format!(
        "\nWhat the thesis claims (section 5-4), by the observer on the faulty transducer\n{table}\n"
    )
}

fn detection(rows: &[&RowResult]) -> Table {
    let within = WITHIN.map(|seconds| format!("{seconds} s"));
    let mut header = vec!["fault", "faults"];
    header.extend(within.iter().map(String::as_str));
    header.extend(["interval", "median", "99 %", "suspect", "kind", "own", "FDE3", "data"]);
    let mut table = table(&header, 1);
    for row in rows {
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
        table.add_row(cells);
    }
    table
}

/// The same faults beside the loop and in it.
fn loops(evaluation: &Evaluation) -> String {
    let header = [
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
        "beside",
    ];
    let mut table = table(&header, 2);
    let mm = |metres: f64| format!("{:.2}", metres * 1e3);
    for row in evaluation.rows.iter().filter(|row| row.row.study == Study::Loop) {
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
        table.add_row(cells);
    }
    if table.is_empty() {
        return String::new();
    }
    format!(
        "\nThe loop: R1 to R3 are medians of the largest, rod and C1 against the same machine \
         without the fault, mm\n{table}\n"
    )
}

fn healthy(cells: &[HealthyCell]) -> String {
    if cells.is_empty() {
        return String::new();
    }
    let header = [
        "transducers",
        "sea",
        "hours",
        "false alarms",
        "a year",
        "at most",
        "FDE1",
        "FDE2",
        "FDE3",
        "data",
        "R1 within",
        "R2 within",
        "R3 within",
    ];
    let mut table = table(&header, 2);
    for cell in cells {
        let [height, period] = cell.sea;
        let events = |name: &str| cell.detectors.get(name).map_or(0, |rate| rate.events);
        let mut cells = vec![
            cell.grade.to_owned(),
            format!("{height} m {period} s"),
            format!("{:.1}", cell.hours),
            cell.false_alarms.events.to_string(),
            rate(cell.false_alarms.per_year),
            rate(cell.false_alarms.at_most),
        ];
        cells.extend(["fde1", "fde2", "fde3", "plausibility"].map(|name| events(name).to_string()));
        let share = |it: &Proportion| format!("{:.5} %", it.probability.unwrap_or(0.0) * 1e2);
        cells.extend(cell.within.iter().map(share));
        table.add_row(cells);
    }
    format!(
        "\nFalse alarms of a machine, all cylinders together; a year is 8766 monitored hours\n\
         {table}\n"
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

/// Events a year, to as many digits as they are worth.
fn rate(per_year: f64) -> String {
    match per_year {
        0.0 => "0".to_owned(),
        it if it < 100.0 => format!("{it:.1}"),
        it => format!("{it:.0}"),
    }
}
