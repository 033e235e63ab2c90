//! A figure of what is known of a cylinder along its stroke.

use super::axis::Axis;
use super::figure::{Band, Curve, Figure, HALF, Panel, Shape};
use super::palette;
use crate::report::coverage;
use tertius_core::sequential::reference::{DOUBTED, LARGEST_DOUBT};
use tertius_core::sequential::statistic::DEAD_BAND;
use tertius_learn::calibrate::{CylinderCalibration, Line, Profile};

/// Width of the band around the profile, standard deviations.
const BAND: f64 = 2.0;

/// Length of the stroke that is shown beyond what was seen, m.
const BESIDE: f64 = 0.2;

/// The profile with its band, and the time spent at each place; `None` where nothing is known.
pub(super) fn figure(
    cylinder: &CylinderCalibration,
    profile: &Profile,
) -> Option<(Figure, String)> {
    let line = cylinder.result.as_ref().ok()?.line;
    let reference = &profile.reference;
    let known = coverage::known(profile);
    let node = |i: usize| reference.first + reference.spacing * i as f64;
    let seen = profile.samples.iter().enumerate().filter(|(_, samples)| **samples > 0);
    let seen = seen.flat_map(|(cell, _)| [node(cell), node(cell + 1)]);
    let ends = known.iter().flatten().copied().chain(seen);
    let (low, high) = ends
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), at| (low.min(at), high.max(at)));
    known.first()?;
    let (low, high) = (low - BESIDE, high + BESIDE);
    let x = Axis::linear("C2 (m)", low, high).with_ticks(6);
    let upper = profile_panel(profile, line, &known);
    let bars = profile.samples.iter().enumerate().filter(|(_, samples)| **samples > 0);
    let bars = bars.map(|(cell, samples)| {
        let seconds = *samples as f64 * cylinder.sample_time;
        vec![(node(cell), seconds), (node(cell + 1), seconds)]
    });
    let curve = Curve {
        name: "time in motion there".to_owned(),
        colour: palette::SKY,
        shape: Shape::Bars,
        runs: bars.collect(),
    };
    let most = curve.values().fold(1.0, f64::max);
    let lower = Panel::new(70, Axis::log("time (s)", 0.1, most), vec![curve]);
    let mut panels = vec![upper, lower];
    let mut unknown = vec![low];
    known.iter().for_each(|span| unknown.extend(span));
    unknown.push(high);
    let thin = reference.spans(DEAD_BAND, LARGEST_DOUBT);
    for panel in &mut panels {
        let between = unknown.chunks(2).map(|ends| [ends[0], ends[1]]);
        panel.bands.extend(between.map(|ends| shade("unknown", palette::GREY, ends)));
        panel.bands.extend(thin.iter().map(|ends| shade("thin place", palette::ORANGE, *ends)));
    }
    let caption = format!("Cylinder {}: what is known along the stroke", cylinder.number);
    Some((Figure { width: HALF, x, panels }, caption))
}

fn shade(name: &str, colour: plotters::style::RGBColor, [from, to]: [f64; 2]) -> Band {
    Band { name: name.to_owned(), colour, from, to }
}

/// The profile of C1 − Ĉ2, mm, within the spans that are `known`.
fn profile_panel(profile: &Profile, line: Line, known: &[[f64; 2]]) -> Panel {
    let reference = &profile.reference;
    let at = |length: f64| {
        let along = ((length - reference.first) / reference.spacing).max(0.0);
        let cell = (along as usize).min(reference.nodes.len() - 2);
        let part = along - cell as f64;
        let between = |values: &[f64]| values[cell] + part * (values[cell + 1] - values[cell]);
        let healthy = between(&reference.nodes);
        let value = healthy - ((line.gain - 1.0) * length + line.offset);
        (1e3 * value, 1e3 * BAND / DOUBTED * between(&reference.doubts))
    };
    let run = |[from, to]: &[f64; 2], times: f64| {
        let nodes =
            (0..reference.nodes.len()).map(|i| reference.first + reference.spacing * i as f64);
        let inner = nodes.filter(|node| from < node && node < to);
        let lengths = std::iter::once(*from).chain(inner).chain([*to]);
        let point = |length| {
            let (value, band) = at(length);
            (length, value + times * band)
        };
        lengths.map(point).collect()
    };
    let curve = |name: &str, colour, shape, times: &[f64]| {
        let runs = times.iter().flat_map(|times| known.iter().map(|span| run(span, *times)));
        Curve { name: name.to_owned(), colour, shape, runs: runs.collect() }
    };
    let curves = vec![
        curve("± 2 standard deviations", palette::SKY, Shape::Line, &[-1.0, 1.0]),
        curve("C1 − Ĉ2 of the profile", palette::BLUE, Shape::Line, &[0.0]),
    ];
    let values: Vec<f64> = curves.iter().flat_map(Curve::values).chain([-0.1, 0.1]).collect();
    Panel::new(105, Axis::over("C1 − Ĉ2 (mm)", values).with_ticks(5), curves)
}
