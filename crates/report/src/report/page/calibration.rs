//! The page of a calibration.

use super::Page;
use super::axis::Axis;
use super::coverage;
use super::differences::{Difference, Differences};
use super::figure::{Band, Curve, Figure, HALF, Panel, Shape};
use super::html::capitalised;
use super::palette;
use crate::report::ReadWith;
use crate::report::calibration as text;
use crate::report::coverage as covered;
use plotters::style::RGBColor;
use tertius_core::text::Millimetres;
use tertius_learn::calibrate::{Calibration, CylinderCalibration, TriedBand};
use tertius_learn::extremes::four_digits;

const NAMES: [&str; 2] = ["C1 − C2 (mm)", "C1 − Ĉ2 (mm)"];
const SHORT: [&str; 2] = ["C1 − C2, before", "C1 − Ĉ2, after"];

/// The whole page; the recordings were read with the configuration `with`, whose bound of R3 is `configured`, m.
pub fn page(
    result: &Calibration,
    differences: &Differences,
    configured: f64,
    with: &ReadWith,
) -> String {
    let mut page = Page::new("calibrate", &format!("Calibration: {}", result.machine));
    page.paragraph(&format!("{} with {with}", result.inputs));
    page.verdict(&text::verdict(result));
    page.contents();
    add(&mut page, result, differences, configured);
    page.finish()
}

/// Adds everything except the origin of the data.
pub fn add(page: &mut Page, result: &Calibration, differences: &Differences, configured: f64) {
    page.paragraph(&capitalised(&text::parts(result)));
    page.lines(&text::remarks(result));
    page.heading("a, b and the band");
    page.section(&text::lines(result));
    page.section(&text::bands(result));
    page.section(&text::sequential(result));
    page.section(&text::excursions(result));
    page.section(&text::process(result));
    page.section(&text::supply(result));
    page.section(&covered::section(result));
    page.lines(&capitalised(&text::bound(result)));
    let figures: Vec<(Figure, String)> = result
        .cylinders
        .iter()
        .filter_map(|it| Some((it, differences.of(it.number)?)))
        .flat_map(|(it, difference)| figures(result, it, difference, configured))
        .collect();
    if !figures.is_empty() {
        page.heading("Before and after the correction (Figures 5-14 and 5-15)");
        page.captioned(&figures);
    }
    let profiles = covered::profiles(result);
    let profiles: Vec<(Figure, String)> =
        profiles.filter_map(|(cylinder, profile)| coverage::figure(cylinder, profile)).collect();
    if !profiles.is_empty() {
        page.heading("Where on the stroke the sequential detectors know C1 − C2");
        page.captioned(&profiles);
    }
}

fn figures(
    result: &Calibration,
    cylinder: &CylinderCalibration,
    difference: &Difference,
    configured: f64,
) -> [(Figure, String); 2] {
    let number = cylinder.number;
    let by_time = |which: usize| {
        let runs = difference.over_time.runs(which).into_iter();
        let runs = runs.map(|run| run.into_iter().map(|(t, d)| (t, 1e3 * d)).collect());
        Curve {
            name: SHORT[which].to_owned(),
            colour: colour(which),
            shape: Shape::Line,
            runs: runs.collect(),
        }
    };
    let by_place = |which: usize| {
        let points = difference.points(which).map(|(c2, d)| (c2, 1e3 * d)).collect();
        Curve::dots(SHORT[which], colour(which), points)
    };
    let panel = |which: usize, curve: Curve| {
        let y = scale(cylinder.tried.as_ref(), &curve, which, bound(result), configured);
        let panel = Panel::new(105, y, vec![curve]);
        if which == 0 { panel } else { with_bounds(panel, result, configured) }
    };
    let mut panels = [0, 1].map(|which| panel(which, by_time(which)));
    let fitted = Band {
        name: "the fit is from here".to_owned(),
        colour: palette::PALE,
        from: result.fitted.from,
        to: result.fitted.to,
    };
    panels.iter_mut().for_each(|panel| panel.bands.push(fitted.clone()));
    let (from, to) = (result.fitted.from.max(0.0), difference.over_time.end());
    let x = Axis::clock("time since the first frame", from, to).with_ticks(5);
    let over_time = Figure { width: HALF, x, panels: panels.to_vec() };
    let places = difference.points(0).map(|(c2, _)| c2);
    let x = Axis::over("C2 (m)", places).with_ticks(6);
    let panels = [0, 1].map(|which| panel(which, by_place(which))).to_vec();
    let beyond: usize = panels.iter().map(Panel::beyond).sum();
    let over_position = Figure { width: HALF, x, panels };
    let mut place = format!("Cylinder {number}: over the position, samples of the recording");
    if beyond > 0 {
        place += &format!("\n{beyond} samples are beyond the scale");
    }
    [(over_time, format!("Cylinder {number}: over time")), (over_position, place)]
}

const fn colour(which: usize) -> RGBColor {
    if which == 0 { palette::VERMILION } else { palette::BLUE }
}

fn bound(result: &Calibration) -> Option<f64> {
    result.bound.map(|bound| four_digits(bound.level))
}

/// A scale for everything except faulty samples, with both bounds around the corrected values.
fn scale(
    tried: Option<&TriedBand>,
    curve: &Curve,
    which: usize,
    bound: Option<f64>,
    configured: f64,
) -> Axis {
    let seen = tried.filter(|tried| tried.after.count > 0);
    let mut values: Vec<f64> = match seen {
        Some(TriedBand { before, after, .. }) => {
            let spread = [before, after][which];
            // Room for what the first part had and the second had not.
            let room = 0.25 * spread.range();
            [spread.low - room, spread.high + room].map(|d| 1e3 * d).to_vec()
        }
        None => curve.values().collect(),
    };
    if which == 1 {
        values.extend(
            [Some(configured), bound]
                .into_iter()
                .flatten()
                .flat_map(|it| [it, -it])
                .map(|it| 1e3 * it),
        );
    }
    Axis::over(NAMES[which], values).with_ticks(5)
}

fn with_bounds(panel: Panel, result: &Calibration, configured: f64) -> Panel {
    let name = format!("R3's bound as configured: {:.2}", Millimetres(configured));
    let panel = panel.with_bounds(&name, palette::LOW, 1e3 * configured);
    match bound(result) {
        Some(level) => {
            let name = format!("R3's bound as proposed: {:.3}", Millimetres(level));
            panel.with_bounds(&name, palette::HIGH, 1e3 * level)
        }
        None => panel,
    }
}
