//! The section on the stops, on the page of a replay.

use super::Page;
use super::axis::Axis;
use super::figure::{Curve, Figure, HALF, Panel};
use super::palette;
use crate::report::stops::{OF_STOP, Stop, Stops, sentence};
use crate::report::wording;
use tertius_core::sample::Transducer;
use tertius_core::sequential::Dwell;

const DAY: f64 = 86_400.0;

/// Length of a history, days, below which it is drawn on a clock.
const FEW_DAYS: f64 = 2.0;

/// Least scale of the figure, mm, which keeps the scatter small: a reading does not repeat more
/// accurately.
const LEAST: f64 = 0.05;

/// Adds the section; nothing where nothing was read.
pub(super) fn section(page: &mut Page, stops: &Stops<'_>) {
    if stops.is_empty() {
        return;
    }
    page.heading("On the stops");
    page.paragraph(&stops.verdict());
    page.paragraph(
        "Where the rods stand on their mechanical stops a reading repeats. A movement common to \
         all cylinders is the temperature; one common to both transducers of a cylinder is its \
        stop. A drift is reported where the two have come apart beyond chance, with the transducer \
        that has moved as soon as that is clear, and with the expected, earliest and latest time \
        left.",
    );
    if stops.stops.iter().any(Stop::is_single) {
        page.paragraph(&format!(
            "An only transducer is compared with what it read there before, less that temperature and what stops wear: \
             {OF_STOP}."
        ));
    }
    page.table(&stops.columns(), &stops.rows());
    let figures: Vec<(Figure, String)> =
        stops.stops.iter().filter_map(|stop| figure(stop, stops)).collect();
    page.captioned(&figures);
}

/// Moves of the readings of one cylinder; `None` with too few dwells.
fn figure(stop: &Stop<'_>, stops: &Stops<'_>) -> Option<(Figure, String)> {
    let (history, limit) = (stop.history, stops.limits.maintenance);
    let (first, newest) = (history.dwells().first()?.at, history.dwells().last()?);
    let seconds = |dwell: &Dwell| dwell.at.since(first).as_seconds();
    let days = seconds(newest) / DAY > FEW_DAYS;
    let unit = if days { DAY } else { 1.0 };
    let cylinder = wording::capitalised(&stops.names.cylinder(stop.cylinder));
    let mut caption = format!("{cylinder}: readings on the stop");
    let mut curves = Vec::new();
    for (which, colour) in stop.fitted().zip([palette::BLUE, palette::VERMILION]) {
        let (trend, name) = (history.trend(which)?, Transducer::LABELS[which]);
        let reference = newest.readings.each()[which]? - trend.moved;
        let point = |dwell: &Dwell| {
            let reading = dwell.readings.each()[which]?;
            Some((seconds(dwell) / unit, (reading - reference) * 1e3))
        };
        let points: Vec<(f64, f64)> = history.dwells().iter().filter_map(point).collect();
        curves.push(Curve::line(name, colour, points.clone()));
        curves.push(Curve::dots(name, colour, points));
        caption +=
            &format!("\n{name}: {}", sentence(&trend, limit, stop.until(which, &trend, limit)));
    }
    let values = curves.iter().flat_map(Curve::values).chain([-LEAST, LEAST]);
    let y = Axis::over("moved (mm)", values).with_ticks(5);
    let end = seconds(newest) / unit;
    let x = if days {
        Axis::linear("days since the first dwell", 0.0, end)
    } else {
        Axis::clock("time since the first dwell", 0.0, end)
    };
    Some((Figure::single(HALF, x.with_ticks(5), Panel::new(130, y, curves)), caption))
}
