//! Figures of delay against false alarms for each detector at every level.

use crate::report::page::axis::Axis;
use crate::report::page::figure::{Curve, Figure, HALF, Panel};
use crate::report::page::html::capitalised;
use crate::report::page::palette;
use plotters::style::RGBColor;
use tertius_lab::evaluate::contest::{GradeResult, Point, Rival, RowFigures};

/// Range of rates of false alarms that is shown, a year: from one in a thousand years to one in ten
/// seconds.
const SHOWN: [f64; 2] = [1e-3, 3e6];

const COLOURS: [(Rival, &str, RGBColor); 3] = [
    (Rival::Observers, "R1, R2", palette::GREEN),
    (Rival::Comparator, "R3", palette::VERMILION),
    (Rival::Sequential, "sequential", palette::BLUE),
];

/// A figure for every fault of every grade that has curves.
pub(super) fn figures(results: &[GradeResult]) -> Vec<(Figure, String)> {
    let rows = results.iter().flat_map(|result| result.rows.iter().map(move |row| (result, row)));
    rows.filter_map(|(result, row)| figure(result, row)).collect()
}

fn figure(result: &GradeResult, row: &RowFigures) -> Option<(Figure, String)> {
    let [low, high] = SHOWN;
    let shown = |point: &&Point| (low..=high).contains(&point.false_alarms_per_year);
    let curve = |(rival, name, colour): (Rival, &str, RGBColor)| {
        let points = row.curves[rival as usize].iter().filter(shown);
        let points = points.filter_map(|point| Some((point.false_alarms_per_year, point.median?)));
        let points: Vec<(f64, f64)> = points.collect();
        [Curve::line(name, colour, points.clone()), Curve::dots("", colour, points)]
    };
    let curves: Vec<Curve> = COLOURS.into_iter().flat_map(curve).collect();
    let slowest = curves.iter().flat_map(Curve::values).reduce(f64::max)?;
    let fastest = curves.iter().flat_map(Curve::values).fold(slowest, f64::min);
    let x = Axis::log("false alarms a year", low, high).with_ticks(5);
    let y = Axis::log("median delay (s)", 0.7 * fastest, 1.5 * slowest).with_ticks(4);
    let title = format!(
        "{}, {} transducers\nEach dot is a level; a line ends where fewer than half are found.",
        capitalised(&row.label),
        result.grade
    );
    Some((Figure::single(HALF, x, Panel::new(150, y, curves)), title))
}
