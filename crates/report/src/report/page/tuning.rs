//! The page of a tuning.

use super::axis::Axis;
use super::figure::{Curve, Figure, FigureMark, HALF, Level, Panel, Shape, WIDE};
use super::html::{Captioned, capitalised};
use super::{Page, palette};
use crate::report::ReadWith;
use crate::report::tuning as text;
use tertius_learn::extremes::four_digits;
use tertius_learn::extremes::{Tail, per_second};
use tertius_learn::tables::tuning::length;
use tertius_learn::tune::{Detector, Tuning};

/// Number of bins of the sketch that form one of the figure: 4 % of the magnitude.
const GROUP: usize = 8;

/// Number of points of a fitted tail.
const STEPS: u32 = 80;

/// Ratio of levels beyond which the axis is logarithmic.
const FAR: f64 = 12.0;

const HOUR: f64 = 3600.0;

/// The whole page; the recordings were read with the configuration `with`.
pub fn page(result: &Tuning, with: &ReadWith) -> String {
    let mut page = Page::new("tune", &format!("Tuning: {}", result.machine));
    page.paragraph(&format!("{} with {with}", result.inputs));
    page.verdict(&text::verdict(result));
    page.contents();
    add(&mut page, result);
    page.finish()
}

/// Adds everything except the origin of the data.
pub fn add(page: &mut Page, result: &Tuning) {
    page.paragraph(&capitalised(&text::part(result)));
    page.lines(&result.remarks.join("\n"));
    page.heading("Thresholds");
    page.lines(&text::thresholds(result));
    page.section(&text::ladder(result));
    page.lines(text::sequential(result).trim());
    page.figure(&together(result), &format!(
        "False alarms of all detectors together\nAbove the grey line the curve is supported by the \
         recording, which is {:.3} h long; below it is extrapolated",
        result.thresholds.hours
    ));
    page.heading("Smallest faults");
    page.section(&text::sensitivity(result));
    page.figures([(&responses(result), "The residual after a step of 1 in the reading")]);
    page.heading("Healthy residuals and their tails");
    page.section(&text::tails(result));
    page.captioned(&pairs(result));
    page.heading("Weights");
    page.section(&text::search(&result.search));
    page.paragraph(&capitalised(&text::tried(&result.search)));
}

/// Thresholds as vertical lines on `x`; δ_h as it is written.
fn thresholds(result: &Tuning, x: &Axis) -> Vec<FigureMark> {
    let mark = |name: &str, colour, value: f64| {
        let beyond = if 1e3 * value > x.high() { ", beyond the scale" } else { "" };
        let name = format!("{name}: {}{beyond}", length(value));
        FigureMark { name, colour, at: 1e3 * value }
    };
    let thresholds = &result.thresholds;
    vec![
        mark("δ_l", palette::LOW, four_digits(thresholds.low)),
        mark("δ_h", palette::HIGH, four_digits(thresholds.high)),
    ]
}

/// A scale from `floor` to a little beyond `end`, m, logarithmic if they are far apart: the axis in
/// mm, and levels at which to draw a curve.
fn scale(label: &str, floor: f64, end: f64) -> (Axis, Vec<f64>) {
    let end = if end.is_finite() { 1.15 * end.max(floor) } else { 1e3 * floor };
    let part = |k: u32| f64::from(k) / f64::from(STEPS);
    if floor > 0.0 && end > FAR * floor {
        let levels = (0..=STEPS).map(|k| floor * (end / floor).powf(part(k)));
        return (Axis::log(label, 0.95e3 * floor, 1e3 * end), levels.collect());
    }
    let levels = (0..=STEPS).map(|k| floor + (end - floor) * part(k));
    (Axis::linear(label, 0.95e3 * floor, 1e3 * end), levels.collect())
}

/// Figure of all tails together.
fn together(result: &Tuning) -> Figure {
    let tails: Vec<&Tail> = result.detectors.iter().filter_map(|it| it.tail.as_ref()).collect();
    let floor = tails.iter().map(|tail| tail.floor).fold(0.0, f64::max);
    let (x, levels) = scale("threshold (mm)", floor, result.thresholds.high);
    let rate = |level: f64| tails.iter().map(|tail| HOUR * tail.rate(level)).sum::<f64>();
    let fitted = levels.into_iter().map(|level| (1e3 * level, rate(level))).collect();
    let wanted = HOUR * per_second(result.thresholds.per_year);
    let evidence = 1.0 / result.thresholds.hours;
    let most = rate(floor).max(evidence);
    let line = Curve::line("fitted tails, added up", palette::BLUE, fitted);
    let y = Axis::log("false alarms an hour", 0.2 * wanted.min(evidence), 2.0 * most).with_ticks(8);
    let mut panel = Panel::new(220, y, vec![line]);
    let level = |name: &str, colour, value| Level { name: name.to_owned(), colour, value };
    panel.levels = vec![
        level("one in the whole recording", palette::GREY, evidence),
        level(&format!("wanted: {} a year", result.thresholds.per_year), palette::GREEN, wanted),
    ];
    panel.marks = thresholds(result, &x);
    Figure::single(WIDE, x.with_ticks(9), panel)
}

/// Responses of each observer's residual to a step; identical curves are drawn once.
fn responses(result: &Tuning) -> Figure {
    let mut curves: Vec<Curve> = Vec::new();
    for detector in result.detectors.iter().filter(|it| !it.response.is_empty()) {
        let cycles = detector.response.iter().enumerate();
        let points: Vec<(f64, f64)> = cycles.map(|(k, value)| (k as f64, *value)).collect();
        match curves.iter_mut().find(|known| known.runs[0] == points) {
            Some(known) => known.name += &format!(", {}", short(detector)),
            None => {
                let colour = palette::cylinder(curves.len() + 1);
                curves.push(Curve::line(&short(detector), colour, points));
            }
        }
    }
    if curves.len() == 1 {
        curves.iter_mut().for_each(|curve| "all residuals".clone_into(&mut curve.name));
    }
    let values: Vec<f64> = curves.iter().flat_map(Curve::values).chain([0.0]).collect();
    let last = curves.iter().flat_map(|curve| &curve.runs[0]).map(|(k, _)| *k).fold(1.0, f64::max);
    let mut panel = Panel::new(160, Axis::over("residual", values).with_ticks(5), curves);
    let tenth = |value: f64| Level { name: "a tenth".to_owned(), colour: palette::PALE, value };
    panel.levels = vec![tenth(0.1), tenth(-0.1)];
    Figure::single(HALF, Axis::linear("cycles after the step", 0.0, last), panel)
}

fn short(detector: &Detector) -> String {
    format!("R{} of {}", detector.transducer + 1, detector.cylinder)
}

/// Histogram and tail of each residual beside each other.
fn pairs(result: &Tuning) -> Vec<Captioned> {
    let known = result.detectors.iter().filter_map(|it| Some((it, it.tail.as_ref()?)));
    known
        .flat_map(|(detector, tail)| {
            let name = format!("Cylinder {}, R{}", detector.cylinder, detector.transducer + 1);
            let kind = if tail.heavy { "generalised Pareto" } else { "exponential" };
            [
                (histogram(result, detector), format!("{name}: healthy residuals")),
                (extrapolation(result, detector, tail), format!("{name}: tail, {kind}")),
            ]
        })
        .collect()
}

/// Cycles by magnitude; the bins grow with it, so counts are given for each µm.
fn histogram(result: &Tuning, detector: &Detector) -> Figure {
    let bins: Vec<(f64, f64, u64)> = detector.magnitudes.bins(GROUP).collect();
    let density = |(low, high, count): &(f64, f64, u64)| *count as f64 / (1e6 * (high - low));
    let mut points: Vec<(f64, f64)> = Vec::new();
    let mut end = 0.0;
    for bin in &bins {
        if bin.0 > end {
            points.push((1e3 * end, 0.0));
        }
        points.push((1e3 * bin.0, density(bin)));
        end = bin.1;
    }
    points.push((1e3 * end, 0.0));
    let values = bins.iter().map(density);
    let (least, most) = values.fold((f64::INFINITY, 0.0_f64), |(a, b), v| (a.min(v), b.max(v)));
    let curve = Curve::line("cycles", palette::PALE, points).shaped(Shape::Bars);
    let y = Axis::log("cycles for each µm", 0.5 * least, 2.0 * most).with_ticks(5);
    let mut panel = Panel::new(130, y, vec![curve]);
    let largest = detector.magnitudes.largest();
    // What is that far from all residuals would leave no room for them.
    let end = 1.1 * largest.max(result.thresholds.high.min(FAR * largest));
    let x = Axis::linear("|residual| (mm)", 0.0, 1e3 * end).with_ticks(6);
    panel.marks = thresholds(result, &x);
    Figure::single(HALF, x, panel)
}

/// Seconds (of alarm.clear) in an hour in which the residual is beyond a level: seen, and fitted.
fn extrapolation(result: &Tuning, detector: &Detector, tail: &Tail) -> Figure {
    let hours = tail.seconds / HOUR;
    let seen = detector.peaks.iter().enumerate().filter(|(_, peak)| **peak >= tail.floor);
    let seen: Vec<(f64, f64)> =
        seen.map(|(k, peak)| (1e3 * peak, (k + 1) as f64 / hours)).collect();
    let end = result.thresholds.high.max(tail.worst);
    let (x, levels) = scale("level (mm)", tail.floor, end);
    let fitted = levels.into_iter().map(|level| (1e3 * level, HOUR * tail.rate(level))).collect();
    let share = HOUR * per_second(result.thresholds.per_year) / result.detectors.len() as f64;
    let most = HOUR * tail.peaks as f64 / tail.seconds;
    let y =
        Axis::log("exceedances an hour", 0.2 * share.min(1.0 / hours), 2.0 * most).with_ticks(6);
    let curves = vec![
        Curve::dots("seen", palette::VERMILION, thinned(seen)),
        Curve::line("fitted", palette::BLUE, fitted),
    ];
    let mut panel = Panel::new(130, y, curves);
    let level = |name: &str, colour, value| Level { name: name.to_owned(), colour, value };
    panel.levels = vec![
        level("one in the recording: the evidence ends", palette::GREY, 1.0 / hours),
        level("equal share of the wanted rate", palette::GREEN, share),
    ];
    panel.marks = thresholds(result, &x);
    Figure::single(HALF, x.with_ticks(6), panel)
}

/// All of the largest values, and some of the many others.
fn thinned(seen: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    let stride = |place: usize| if place < 60 { 1 } else { 8 };
    let kept = seen.into_iter().enumerate().filter(|(place, _)| place % stride(*place) == 0);
    kept.map(|(_, point)| point).collect()
}
