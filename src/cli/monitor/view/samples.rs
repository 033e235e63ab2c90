//! A machine for the tests of the view.

use crate::appliance::telemetry::lamp::Lamp;
use crate::cli::monitor::news::{
    News, Sizes, WatchedCylinder, WatchedIncident, WatchedMachine, WatchedOverview,
    WatchedTransducer,
};
use crate::cli::monitor::picture::Picture;
use crate::cli::monitor::viewer::Viewer;
use std::time::Duration;

/// 04:12:33 of some day, s.
const TIME: f64 = 86_400.0 * 20_000.0 + 15_153.0;

/// A viewer of [`picture`].
pub fn viewer(now: Duration) -> Viewer {
    let mut viewer = Viewer::new("http://127.0.0.1:9481".to_owned());
    told().into_iter().for_each(|news| viewer.take(news, now));
    viewer
}

/// Six cylinders, told at `now`.
pub fn picture(now: Duration) -> Picture {
    let mut picture = Picture::default();
    told().into_iter().for_each(|news| picture.take(news, now));
    picture
}

fn told() -> [News; 3] {
    let limits_m = vec![[1e-3, 1e-3, 1.5e-3, 0.05].map(Some).to_vec(); 6];
    let machine = WatchedMachine {
        name: "Ampelmann E-type".to_owned(),
        limits_m,
        ..WatchedMachine::default()
    };
    [News::Machine(machine), News::Trends(trend()), News::Overview(overview())]
}

/// Cylinder 3's C1 has failed, 5's may have, 4's C2 is out of operation and 2's drifts.
pub fn overview() -> WatchedOverview {
    let lamps = [
        [Lamp::Good, Lamp::Good],
        [Lamp::Good, Lamp::MaintenanceRequired],
        [Lamp::Failure, Lamp::Good],
        [Lamp::Good, Lamp::CheckFunction],
        [Lamp::OutOfSpecification, Lamp::OutOfSpecification],
        [Lamp::Unknown, Lamp::Good],
    ];
    let sizes = [
        [0.21, 0.18, 0.33],
        [0.35, 0.41, 0.72],
        [3.98, 0.20, 4.02],
        [0.28, 0.30, 0.45],
        [0.62, 0.55, 1.61],
        [0.15, 0.17, 0.20],
    ];
    let cylinder = |(index, (lamps, sizes)): (usize, ([Lamp; 2], [f64; 3]))| WatchedCylinder {
        number: index + 1,
        transducers: lamps.map(|lamp| transducer(lamp, reason(lamp))),
        residuals_mm: sizes.map(|size| Some(size).filter(|_| !(index == 5 && size == 0.15))),
        estimate_m: Some(0.213),
        sigma_mm: Some(0.17),
    };
    WatchedOverview {
        time: TIME,
        status: "degraded".to_owned(),
        reason: "cylinder 3, C1, red: step; and 1 more".to_owned(),
        mode: Some("monitoring".to_owned()),
        platform: Some("engaged".to_owned()),
        bus: "open".to_owned(),
        controller: Some("error-active".to_owned()),
        level: "red".to_owned(),
        incidents: vec![
            incident(7, "red", 40.0, "cylinder 3, C1, red: step"),
            incident(6, "yellow", 97.0, "cylinder 5, C1 or C2, yellow: growing error"),
        ],
        seconds_since_frame: Some(0.01),
        cylinders: lamps.into_iter().zip(sizes).enumerate().map(cylinder).collect(),
    }
}

const fn reason(lamp: Lamp) -> &'static str {
    match lamp {
        Lamp::Failure => ": step",
        Lamp::MaintenanceRequired => ": its readings on the stops drift",
        _ => "",
    }
}

fn transducer(lamp: Lamp, reason: &str) -> WatchedTransducer {
    let words = format!("{}{reason}", lamp.words());
    let transducer = WatchedTransducer { lamp, words, ..WatchedTransducer::default() };
    if lamp != Lamp::MaintenanceRequired {
        return transducer;
    }
    WatchedTransducer {
        drift_mm_per_month: Some(0.31),
        error_mm_per_month: Some(0.02),
        months_left: [Some(4.0), Some(3.4), Some(5.6)],
        ..transducer
    }
}

fn incident(number: u32, level: &str, before: f64, summary: &str) -> WatchedIncident {
    let (level, summary) = (level.to_owned(), summary.to_owned());
    WatchedIncident { number, level, begin: TIME - before, summary }
}

/// Five minutes, in which cylinder 3 got a step of 4 mm on C1, 40 s ago.
fn trend() -> Vec<Sizes> {
    let bin = |(cylinder, k): (usize, u32)| {
        let before = f64::from(600 - k) / 2.0;
        let sea = 2e-4 * (1.5 + (f64::from(k) / 9.0).sin());
        let step = if cylinder == 3 && before < 40.0 { 4e-3 } else { 0.0 };
        let residuals = [Some(sea + step), Some(sea), Some(sea + step)];
        Sizes { cylinder, time: TIME - before, residuals }
    };
    (1..=6).flat_map(|cylinder| (0..600).map(move |k| (cylinder, k))).map(bin).collect()
}
