//! The page of a commissioning.

use super::axis::Axis;
use super::figure::{Curve, Figure, Panel, WIDE};
use super::html::capitalised;
use super::{Differences, Page, calibration, identification, palette, tuning};
use crate::report::ReadWith;
use crate::report::commission as text;
use tertius_lab::commission::Commissioned;

/// The whole page, with the `differences` of its calibration if there is one; the recordings were read with the
/// configuration `with`, whose bound of R3 was `configured`, m.
pub fn page(
    result: &Commissioned,
    differences: Option<&Differences>,
    configured: f64,
    with: &ReadWith,
) -> String {
    let mut page = Page::new("commission", &format!("Commissioning: {}", result.machine));
    let verdict = &result.verdict;
    if text::is_good(result) {
        page.good(&verdict.sentence);
    } else {
        let said = [&verdict.sentence].into_iter().chain(&verdict.reasons).chain(&verdict.advice);
        let lines: Vec<String> = said.map(|line| capitalised(line)).collect();
        page.alarm(&lines.join("\n"));
    }
    page.paragraph(&capitalised(&text::origin(result, with)));
    page.section(&text::tables(result));
    if result.trial.is_some() {
        page.heading("Trial on what was held back");
        page.section(&text::trial(result));
        page.section(&text::faults(result));
    }
    let wins = text::wins(result);
    if !result.coverage.is_empty() {
        page.heading("What a longer recording would add");
        page.lines(&capitalised_lines(&wins));
        page.figure(&strokes(result), "What the sequential detectors know of the strokes");
    }
    let taught = &result.taught;
    if let Some(outcome) = &taught.identification {
        page.part("Model", |page| identification::add(page, outcome));
    }
    if let Some((it, differences)) = taught.calibration.as_ref().zip(differences) {
        page.part("Calibration", |page| calibration::add(page, it, differences, configured));
    }
    if let Some(it) = &taught.tuning {
        page.part("Tuning", |page| tuning::add(page, it));
    }
    page.finish()
}

fn capitalised_lines(lines: &[String]) -> String {
    lines.iter().map(|line| capitalised(line)).collect::<Vec<_>>().join("\n")
}

/// A line for each cylinder, drawn where its stroke is known.
fn strokes(result: &Commissioned) -> Figure {
    let ends = result.coverage.iter().flat_map(|it| it.stroke);
    let x = Axis::over("C2 (m)", ends).with_ticks(8);
    let curve = |number: u8, known: Vec<[f64; 2]>| {
        let y = f64::from(number);
        let values =
            known.into_iter().flat_map(|[from, to]| [(from, Some(y)), (to, Some(y)), (to, None)]);
        let name = format!("cylinder {number}");
        Curve::broken(&name, palette::cylinder(usize::from(number)), values)
    };
    let curves = result.coverage.iter().map(|it| curve(it.cylinder, it.known()));
    let most = result.coverage.iter().map(|it| f64::from(it.cylinder)).fold(1.0, f64::max);
    let y = Axis::linear("cylinder", 0.5, most + 0.5).with_ticks(most as usize);
    Figure::single(WIDE, x, Panel::new(120, y, curves.collect()))
}
