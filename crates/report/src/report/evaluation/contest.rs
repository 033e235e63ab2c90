//! Tables of the comparison of the detectors.

use super::{percent, rate, seconds, suspects};
use crate::report::sheet::{Section, Sheet};
use tertius_core::text::Millimetres;
use tertius_lab::evaluate::contest::{GradeResult, Rival, RowFigures};

/// All tables of the contest.
pub(super) fn sections(results: &[GradeResult]) -> Vec<Section> {
    let mut sections = vec![hours(results)];
    sections.extend(results.iter().map(rows));
    sections.extend(results.iter().map(curves));
    sections
}

/// Rates of false alarms, a year, for which levels of the curves are shown.
const TOLD: [f64; 3] = [1.0, 100.0, 8766.0];

fn hours(results: &[GradeResult]) -> Section {
    let mut sheet = Sheet::new(&[
        "transducers",
        "h",
        "hours",
        "FDE1",
        "FDE2",
        "FDE3",
        "sequential",
        "at most a year",
        "extrapolated",
        "largest",
        "h of one a year",
        "residual",
    ]);
    for result in results.iter().filter(|result| result.hours.hours > 0.0) {
        let hours = &result.hours;
        let raises = |name: &str| hours.detectors.get(name).map_or(0, |it| it.events).to_string();
        let at_most = hours.detectors.get("sequential").map_or(0.0, |it| it.at_most);
        let number = |value: Option<f64>, digits: usize| {
            value.map_or("–".to_owned(), |value| format!("{value:.digits$}"))
        };
        sheet.add_row([
            result.grade.to_owned(),
            format!("{:.2} nats", result.level),
            format!("{:.1}", hours.hours),
            raises("fde1"),
            raises("fde2"),
            raises("fde3"),
            raises("sequential"),
            rate(at_most),
            number(hours.expected, 3),
            format!("{:.2} nats", hours.largest[Rival::Sequential as usize]),
            number(hours.level_of_one, 2),
            format!("{:.4}", Millimetres(hours.deviation)),
        ]);
    }
    sheet.about(
        "healthy machines, the seas in turn: false alarms of the thesis's thresholds and of the \
         sequential detectors at their level h, with the bound of 95 % and the extrapolated tail",
    )
}

fn rows(result: &GradeResult) -> Section {
    let mut sheet = Sheet::new(&[
        "fault",
        "faults",
        "R1, R2",
        "R3",
        "sequential",
        "median",
        "95 %",
        "bound",
        "ratio",
        "suspect",
        "decided",
        "kind",
    ]);
    for row in &result.rows {
        let RowFigures { found, suspect, .. } = row;
        let [observers, comparator, sequential] = found;
        let decided = suspect.right + suspect.wrong;
        let share = |count: u64| 1e2 * count as f64 / suspect.all().max(1) as f64;
        sheet.add_row([
            row.label.clone(),
            row.faults.to_string(),
            percent(&observers.found),
            percent(&comparator.found),
            percent(&sequential.found),
            seconds(sequential.delay.median),
            seconds(sequential.delay.p95),
            seconds(row.bound),
            row.ratio.map_or("–".to_owned(), |ratio| format!("{ratio:.2}")),
            suspects(suspect),
            format!("{:.1} %", share(decided)),
            row.kind.map_or("–".to_owned(), |kind| percent(&kind)),
        ]);
    }
    sheet.about(format!(
        "thresholds and sequential detector on the same faults, in the loop: {} transducers, h = {:.2} \
         nats; median, 95 %, suspect and kind are the sequential detector's; bound: Lorden, for one \
         false alarm a year",
        result.grade, result.level
    ))
}

/// What each rival needs at the same rate of false alarms.
fn curves(result: &GradeResult) -> Section {
    let mut header = vec!["fault".to_owned()];
    for per_year in TOLD {
        let rate =
            if per_year > 8000.0 { "1 an hour".to_owned() } else { format!("{per_year} a year") };
        header.extend(Rival::ALL.map(|rival| format!("{}, {rate}", rival.name())));
    }
    let mut sheet = Sheet::new(&header);
    for row in result.rows.iter().filter(|row| !row.curves[0].is_empty()) {
        let mut cells = vec![row.label.clone()];
        for per_year in TOLD {
            cells.extend(Rival::ALL.map(|rival| {
                let points = &row.curves[rival as usize];
                let first = points.iter().find(|point| point.false_alarms_per_year <= per_year);
                first.map_or("–".to_owned(), |point| seconds(point.median))
            }));
        }
        sheet.add_row(cells);
    }
    sheet.about(format!(
        "median delay at equal rates of false alarms, each detector at the lowest level with no \
         more false alarms: {} transducers",
        result.grade
    ))
}
