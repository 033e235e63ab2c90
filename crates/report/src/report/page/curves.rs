//! Flow and friction curves (section 3-3-1) on the page of an identification.

use super::axis::Axis;
use super::figure::{Curve, Figure, HALF, Panel, Shape};
use super::html::{Captioned, capitalised};
use super::{Page, palette};
use crate::report::nonlinear as text;
use tertius_learn::identify::flow::FlowCurve;
use tertius_learn::identify::friction::FrictionCurve;
use tertius_learn::identify::nonlinear::Nonlinear;

/// Number of points of a friction curve.
const STEPS: u32 = 120;

/// Adds both sections.
pub fn add(page: &mut Page, nonlinear: &Nonlinear) {
    page.heading("Flow against the spool (3-17), (3-18)");
    page.lines(&capitalised(&text::sources(nonlinear)));
    let curves = (1..).zip(&nonlinear.flow).zip(&nonlinear.points);
    let figures: Vec<Captioned> = curves
        .filter(|((_, curves), _)| curves.iter().any(Result::is_ok))
        .map(|((number, curves), points)| {
            let known: Vec<&FlowCurve> = curves.iter().filter_map(|it| it.as_ref().ok()).collect();
            flow(nonlinear, number, &known, points)
        })
        .collect();
    page.captioned(&figures);
    page.lines(&text::no_flow(nonlinear));
    page.section(&text::valves(nonlinear));
    page.lines(&text::no_valve(nonlinear));
    page.heading("Friction (3-13), (3-19)");
    let known = (1..).zip(&nonlinear.friction).filter_map(|(n, it)| Some((n, it.as_ref().ok()?)));
    let figures: Vec<Captioned> = known.map(|(number, curve)| friction(number, curve)).collect();
    page.captioned(&figures);
    page.lines(&text::no_friction(nonlinear));
}

/// f_NL over the spool: samples, and the line through the singletons that are known.
fn flow(
    nonlinear: &Nonlinear,
    number: usize,
    curves: &[&FlowCurve],
    points: &[(f64, f64)],
) -> Captioned {
    let samples = points.iter().map(|(x, value)| (*x, 1e3 * value)).collect();
    let mut lines = vec![Curve::dots("samples of the recording", palette::PALE, samples)];
    for curve in curves {
        let nodes = curve
            .singletons
            .iter()
            .map(|singleton| (singleton.centre, singleton.value.map(|(value, _)| 1e3 * value)));
        let line = Curve::broken("singleton fuzzy model", palette::BLUE, nodes);
        let nodes = line.runs.iter().flatten().copied().collect();
        lines.push(line);
        lines.push(Curve::dots("singletons", palette::BLUE, nodes));
    }
    // The curve and what lies around it; single samples may lie far off.
    let told = lines[1..].iter().flat_map(Curve::values);
    let (low, high) = told.fold((0.0_f64, 0.0_f64), |(a, b), value| (a.min(value), b.max(value)));
    let room = 0.15 * (high - low);
    let y = Axis::linear("f_NL/A_p (mm/s/√bar)", low - room, high + room).with_ticks(6);
    let x = if nonlinear.sources.spool { "spool position x (its unit)" } else { "command u (m/s)" };
    let ends = curves.iter().filter_map(|curve| Some(curve.singletons.last()?.centre));
    let x = Axis::over(x, ends.chain([0.0])).with_ticks(6);
    let known: Vec<String> = curves
        .iter()
        .map(|curve| {
            let way = curve.singletons.last().is_some_and(|last| last.centre < 0.0);
            let way = if way { "retracting" } else { "extending" };
            format!(
                "{way}: {} of {} singletons known, RMS {:.3}",
                curve.known(),
                curve.singletons.len(),
                1e3 * curve.rms
            )
        })
        .collect();
    let mut caption = format!("Cylinder {number}\n{}", known.join("\n"));
    let panel = Panel::new(200, y, lines);
    if panel.beyond() > 0 {
        caption +=
            &format!("\n{} of {} samples are beyond the scale", panel.beyond(), points.len());
    }
    (Figure::single(HALF, x, panel), caption)
}

/// Friction curve (3-13), with the speeds that it was fitted to.
fn friction(number: usize, curve: &FrictionCurve) -> Captioned {
    let speeds = curve.points.iter().map(|point| point.velocity);
    let (low, high) = speeds.fold((0.0_f64, 0.0_f64), |(a, b), v| (a.min(v), b.max(v)));
    let side = |from: f64, to: f64| {
        let part = |k: u32| from + (to - from) * f64::from(k) / f64::from(STEPS);
        (0..=STEPS).map(|k| (1e3 * part(k), curve.at(part(k)))).collect::<Vec<_>>()
    };
    // It jumps at standstill.
    let least = 1e-6;
    let runs = [(low, -least), (least, high)].into_iter().filter(|(from, to)| from < to);
    let line = Curve {
        name: "(3-13)".to_owned(),
        colour: palette::BLUE,
        shape: Shape::Line,
        runs: runs.map(|(from, to)| side(from, to)).collect(),
    };
    let spreads = curve.points.iter().map(|point| {
        let v = 1e3 * point.velocity;
        vec![(v, point.force - point.deviation), (v, point.force + point.deviation)]
    });
    let spread = Curve {
        name: "± deviation between stretches".to_owned(),
        colour: palette::VERMILION,
        shape: Shape::Line,
        runs: spreads.collect(),
    };
    let points = curve.points.iter().map(|point| (1e3 * point.velocity, point.force)).collect();
    let points = Curve::dots("means of stretches", palette::VERMILION, points);
    let curves = vec![spread, points, line];
    let y = Axis::over("friction/A_p (bar)", curves.iter().flat_map(Curve::values)).with_ticks(6);
    let x = Axis::over("velocity (mm/s)", [1e3 * low, 1e3 * high]).with_ticks(6);
    let caption = format!("Cylinder {number}\n{}", text::stribeck_line(curve));
    (Figure::single(HALF, x, Panel::new(180, y, curves)), caption)
}
