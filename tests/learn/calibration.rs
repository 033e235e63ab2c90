//! The calibration of C2 against what it was made with, and what it does not take.

use crate::learning_support::{self, normal, random, row};
use rand::RngExt;
use serde_json::{Value, json};
use std::convert::Infallible;
use tertius::calibrate::{
    CalibrationCourse, CalibrationRefusal, Fitted, Fitting, Gathering, Recording, Trying,
};
use tertius::config;
use tertius::sample::Quality;
use tertius::sequential::whitening::Whitening;
use tertius::survey::{Row, Surveyor, Timeline, Window};
use tertius_testing::oracle;
use tertius_testing::support;

const A: f64 = 1.002_484_63;
const B: f64 = 3.138_27e-3;

/// C2 and C1 over the stroke, exact.
fn points(count: u64) -> Vec<(f64, f64)> {
    let c2 = |k: u64| 0.8 * (0.013 * k as f64).sin() + 0.3 * (0.0071 * k as f64).cos();
    (0..count).map(|k| (c2(k), A * c2(k) + B)).collect()
}

fn rows(points: &[(f64, f64)]) -> Vec<Row> {
    (0..).zip(points).map(|(k, (c2, c1))| row(k, 1, Some(*c1), Some(*c2))).collect()
}

fn gather(rows: &[Row], cylinders: usize) -> Gathering {
    gather_configured(rows, vec![None; cylinders])
}

fn gather_configured(rows: &[Row], configured: Vec<Option<(f64, f64)>>) -> Gathering {
    let mut gathering = Gathering::new(3.0, configured);
    rows.iter().for_each(|row| gathering.row(row));
    gathering
}

fn calibrate(points: &[(f64, f64)]) -> Result<Fitted, CalibrationRefusal> {
    let rows = rows(points);
    let robust = gather(&rows, 1).judge(0)?;
    let mut fitting = Fitting::new([Some(robust)]);
    rows.iter().for_each(|row| fitting.row(row));
    fitting.result(0).expect("there is a line")
}

/// Every fiftieth sample of C1 or C2 is 50 mm off, to either side.
fn with_faults(mut points: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    for (k, (c2, c1)) in points.iter_mut().enumerate().skip(7).step_by(50) {
        let reading = if k % 100 == 7 { c2 } else { c1 };
        *reading += if k % 3 == 0 { -0.05 } else { 0.05 };
    }
    points
}

fn with_noise(mut points: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    let mut random = random(1);
    for (c2, c1) in &mut points {
        *c1 += 1e-4 * normal(&mut random);
        *c2 += 1e-4 * normal(&mut random);
    }
    points
}

#[test]
fn without_noise_a_and_b_come_back_to_the_last_digits() {
    for points in [points(3000), points(50_000), with_faults(points(50_000))] {
        let fitted = calibrate(&points).expect("it moves");
        assert!((fitted.line.gain - A).abs() < 1e-12, "{fitted:?}");
        assert!((fitted.line.offset - B).abs() < 1e-12, "{fitted:?}");
    }
}

/// Within 20 µm over the whole stroke, a fifth of a count, whatever two of a hundred samples say.
#[test]
fn faulty_samples_are_left_out() {
    let clean = calibrate(&with_noise(points(20_000))).expect("it moves");
    let faulty = calibrate(&with_faults(with_noise(points(20_000)))).expect("it moves");
    assert_eq!((clean.trimmed, faulty.trimmed), (0, 400));
    for fitted in [clean, faulty] {
        for end in [-1.5, 1.5] {
            let error = fitted.line.error(end, A * end + B);
            assert!(error.abs() < 2e-5, "{fitted:?} at {end}: {error}");
        }
    }
}

#[test]
fn the_line_is_that_of_numpy() {
    let points = with_noise(points(5000));
    let fitted = calibrate(&points).expect("it moves");
    let case = json!({ "points": points.iter().map(|(c2, c1)| [c2, c1]).collect::<Vec<_>>() });
    let answer: Value =
        serde_json::from_str(&oracle::run("extremes.py", &[], &format!("{case}\n"))).expect("JSON");
    let of = |i: usize| answer["line"][i].as_f64().expect("a number");
    assert!((fitted.line.gain - of(0)).abs() < 1e-12, "{fitted:?} {answer}");
    assert!((fitted.line.offset - of(1)).abs() < 1e-12, "{fitted:?} {answer}");
}

#[test]
fn the_band_is_that_of_the_second_part_and_never_was_exceeded_in_it() {
    let points = with_faults(with_noise(points(20_000)));
    let fitted = calibrate(&points).expect("it moves");
    let mut trying = Trying::new([Some(&fitted)], 50);
    rows(&points).iter().for_each(|row| trying.row(row));
    let bound = trying.bound(1.0, 0.02, |_| true).expect("400 s");
    let often = trying.bound(1e6, 0.02, |_| true).expect("400 s");
    let tried = trying.into_cylinders().remove(0).expect("it has a fit");
    assert_eq!((tried.faulty, tried.after.count), (400, 19_600));
    // Both have 0.1 mm of noise, and C2 differs by up to 5 mm before.
    assert!((1.3e-4..1.6e-4).contains(&tried.after.rms()), "{:?}", tried.after);
    assert!(tried.before.range() > 4e-3 && tried.after.range() < 1.5e-3);
    assert!(bound.level > tried.after.largest && bound.level < 2e-3, "{bound:?}");
    assert!(often.level < bound.level && often.level >= tried.after.largest);
}

#[test]
fn a_stroke_that_hardly_moves_is_told_how_much_it_needs() {
    let still: Vec<_> = points(5000).iter().map(|(c2, _)| (0.01 * c2, A * 0.01 * c2 + B)).collect();
    let refusal = calibrate(&with_faults(still)).expect_err("20 mm");
    let CalibrationRefusal::HardlyMoves { range_mm, least_mm } = refusal else {
        panic!("{refusal}")
    };
    assert!((15.0..25.0).contains(&range_mm) && (least_mm - 300.0).abs() < 1e-9, "{refusal}");
    assert!(refusal.to_string().contains("300 mm, a tenth of the stroke"), "{refusal}");
}

fn refusal(points: &[(f64, f64)]) -> String {
    calibrate(points).expect_err("it is refused").to_string()
}

#[test]
fn units_and_signals_that_are_wrong_are_named() {
    let change = |of: fn(f64, f64) -> (f64, f64)| {
        points(5000).iter().map(|(c2, c1)| of(*c2, *c1)).collect::<Vec<_>>()
    };
    let millimetres = refusal(&change(|c2, c1| (c2, 1e-3 * c1)));
    assert!(millimetres.contains("about a factor of 1/1000"), "{millimetres}");
    let kilometres = refusal(&change(|c2, c1| (1e-3 * c2, c1)));
    assert!(kilometres.contains("about a factor of 1000"), "{kilometres}");
    let opposite = refusal(&change(|c2, c1| (-c2, c1)));
    assert!(opposite.contains("opposite"), "{opposite}");
    let constant = refusal(&change(|_, c1| (0.25, c1)));
    assert!(constant.contains("C2 is constant at 0.25 m"), "{constant}");
    let mut random = random(3);
    let other: Vec<_> = points(5000).iter().map(|(_, c1)| (random.random(), *c1)).collect();
    let other = refusal(&other);
    assert!(other.contains("do not move together"), "{other}");
    let two_lines: Vec<_> = (0..)
        .zip(points(5000))
        .map(|(k, (c2, c1))| (c2, if k % 5 == 0 { c1 + 0.01 } else { c1 + 1e-5 * c2.sin() }))
        .collect();
    let two_lines = refusal(&two_lines);
    assert!(two_lines.contains("from any one line"), "{two_lines}");
}

#[test]
fn what_is_missing_is_named() {
    let told = |rows: &[Row]| gather(rows, 1).judge(0).expect_err("it is refused").to_string();
    assert!(told(&[]).contains("no frame of it"));
    assert!(
        told(&rows(&points(400)))
            .contains("400 cycles have both readings, and at least 500 are needed")
    );
    let mut without = rows(&points(5000));
    without.iter_mut().for_each(|row| row.c2 = None);
    assert!(told(&without).contains("C2 is missing in 5000 of 5000 cycles"));
    for row in &mut without {
        row.raw[1] = row.raw[1].map(|metres| metres * 1e3);
        row.qualities[1] = Quality::OutOfRange;
    }
    let millimetres = told(&without);
    assert!(millimetres.contains("5000 out of range"), "{millimetres}");
    assert!(millimetres.contains("in millimetres, a factor of 1000?"), "{millimetres}");
}

#[test]
fn swapped_transducers_show_against_an_earlier_calibration() {
    let swapped: Vec<_> = points(5000).iter().map(|(c2, c1)| (*c1, *c2)).collect();
    let judged =
        |points: &[(f64, f64)]| gather_configured(&rows(points), vec![Some((A, B))]).judge(0);
    let told = judged(&with_faults(swapped.clone())).expect_err("it is refused").to_string();
    assert!(told.contains("C1 and C2 look swapped"), "{told}");
    assert!(judged(&with_faults(points(5000))).is_ok());
    // Without one it cannot be told, which is said.
    let gathering = gather(&rows(&swapped), 1);
    assert!(gathering.judge(0).is_ok() && gathering.remarks(0)[0].contains("cannot be told"));
}

#[test]
fn swapped_cylinders_show_against_each_other() {
    let rows: Vec<Row> = (0..5000)
        .flat_map(|k| {
            let at = |n: f64| 0.8 * ((0.01 + 0.003 * n) * k as f64).sin();
            // C2 of cylinders 1 and 2 have changed places; 3 is as it should be.
            [(1, 1.0, 2.0), (2, 2.0, 1.0), (3, 3.0, 3.0)]
                .map(|(n, c1, c2)| row(k, n, Some(at(c1)), Some(at(c2))))
        })
        .collect();
    let gathering = gather(&rows, 3);
    let told = |index| gathering.judge(index).map_err(|refusal| refusal.to_string());
    assert!(told(0).expect_err("swapped").contains("C2 of cylinder 2"));
    assert!(told(1).expect_err("swapped").contains("C2 of cylinder 1"));
    assert!(told(2).is_ok());
}

/// A recording of one cylinder of the E-type.
struct Recorded(Vec<Row>);

impl Recording for Recorded {
    type Error = Infallible;

    fn read(&self, window: Window, mut surveyor: impl Surveyor) -> Result<(), Infallible> {
        self.0.iter().filter(|row| window.holds(row.t)).for_each(|row| surveyor.row(row));
        Ok(())
    }
}

/// A command that has nothing to do with the rod is no drive, though least squares finds one.
#[test]
fn a_command_that_predicts_nothing_is_no_drive() {
    let settings =
        config::load(&support::top().join("config/e-type.toml")).expect("sound").settings;
    let half = 300.0;
    let course = CalibrationCourse {
        settings: &settings,
        timeline: &Timeline::default(),
        fitted: Window { from: 0.0, to: half },
        tried: Window { from: half, to: 2.0 * half },
        per_year: 1.0,
    };
    let calibrated = |command: &dyn Fn(f64) -> f64| {
        let mut rows = learning_support::rows(1, 30_000);
        rows.iter_mut().for_each(|row| row.u = row.u.map(command));
        let calibrated = course.run(&Recorded(rows)).unwrap_or_else(|never| match never {});
        let table = calibrated.cylinders[0].table().expect("it has a line");
        table.sequential.expect("it moves")
    };
    let driven = calibrated(&|u| u);
    assert!(driven.drive.is_some() && driven.prediction < 3e-4, "{} m", driven.prediction);
    let correlation = driven.prediction_correlation.expect("there were errors enough");
    assert!(Whitening::of(&correlation).is_some(), "{correlation:?}");
    let unrelated = calibrated(&|u| (1e6 * u).sin());
    assert_eq!((unrelated.drive, unrelated.prediction), (None, 0.0));
    assert_eq!(unrelated.prediction_correlation, None);
}

/// A recording that loses a cycle every four seconds.
struct Lossy(Vec<Row>);

impl Recording for Lossy {
    type Error = Infallible;

    fn read(&self, window: Window, mut surveyor: impl Surveyor) -> Result<(), Infallible> {
        for row in self.0.iter().filter(|row| window.holds(row.t)) {
            if row.cycle.is_multiple_of(200) {
                surveyor.gap(1);
            } else {
                surveyor.row(row);
            }
        }
        Ok(())
    }
}

/// Baselines take five seconds to begin, and would never have done so.
#[test]
fn a_cycle_that_is_lost_every_few_seconds_costs_no_calibration() {
    let settings =
        config::load(&support::top().join("config/e-type.toml")).expect("sound").settings;
    let all = Window { from: 0.0, to: 600.0 };
    let course = CalibrationCourse {
        settings: &settings,
        timeline: &Timeline::default(),
        fitted: all,
        tried: all,
        per_year: 1.0,
    };
    let rows = learning_support::rows(1, 30_000);
    let fitted = |calibrated: Result<tertius::calibrate::Calibrated, Infallible>| {
        let calibrated = calibrated.unwrap_or_else(|never| match never {});
        let table = calibrated.cylinders[0].table().expect("it has a line");
        table.sequential.expect("it moves")
    };
    let (whole, lossy) =
        (fitted(course.run(&Recorded(rows.clone()))), fitted(course.run(&Lossy(rows))));
    assert!((lossy.deviation / whole.deviation - 1.0).abs() < 0.02, "{lossy:?}");
    let [one, other] = [&whole, &lossy].map(|table| table.level.expect("there was enough"));
    assert!((one / other - 1.0).abs() < 0.1, "{one} {other}");
}
