//! The estimates of (4-7) and (4-8), against the truth and against NumPy.

use crate::identify_support::{self, BOTH, GAMMA, Simulated, THETA, TS, estimate, row, shaping};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::{Value, json};
use tertius::identify::{
    Candidate, Estimate, IdentificationRefusal, OffsetRule, Shaper, Sources, Validator,
};
use tertius::observe::model::Model;
use tertius::observe::observer::ObserverDesign;
use tertius::survey::Row;
use tertius_testing::oracle;

fn close(found: &[f64], expected: &[f64], tolerance: f64) -> bool {
    let near = |(a, b): (&f64, &f64)| (a - b).abs() <= tolerance * b.abs();
    found.len() == expected.len() && found.iter().zip(expected).all(near)
}

#[test]
fn without_noise_the_parameters_of_table_4_1_come_back() {
    for rule in [OffsetRule::Never, OffsetRule::WhereItMatters] {
        let rows = Simulated::new(1, 5000).rows();
        let found = estimate(&rows, 1, BOTH, rule).expect("the data are sound");
        assert!(close(&found.theta, &THETA, 1e-9), "{found:?}");
        assert!(close(&found.gamma, &GAMMA, 1e-9), "{found:?}");
        assert_eq!(found.command_offset, None);
    }
}

#[test]
fn a_command_that_rests_at_an_offset_is_found_with_it() {
    let rows = Simulated { offset: -0.139, ..Simulated::new(2, 5000) }.rows();
    let found = estimate(&rows, 1, BOTH, OffsetRule::WhereItMatters).expect("sound");
    assert!((found.command_offset.expect("it matters") + 0.139).abs() < 1e-9, "{found:?}");
    assert!(found.pressure_offset.abs() < 1e-6, "{found:?}");
    assert!(close(&found.theta, &THETA, 1e-8) && close(&found.gamma, &GAMMA, 1e-8), "{found:?}");
    let bent = estimate(&rows, 1, BOTH, OffsetRule::Never).expect("sound");
    assert!(!close(&bent.theta, &THETA, 1e-2), "without a constant it cannot be right: {bent:?}");
}

/// The rows for the oracle, with a hole at 3000 that no average may cross.
fn rows_with_a_gap() -> Vec<Row> {
    let mut rows = Simulated { offset: 0.05, ..Simulated::new(3, 6000) }.noisy().rows();
    rows.drain(3000..3010);
    rows
}

fn compare_with_numpy(constant: bool, pressure: bool) {
    let rows = rows_with_a_gap();
    let rule = if constant { OffsetRule::Always } else { OffsetRule::Never };
    let sources = Sources { velocity: true, pressure };
    let found = estimate(&rows, 5, sources, rule).expect("the data are sound");
    let signals: Vec<[f64; 5]> = rows
        .iter()
        .map(|row| {
            let p = row.load_pressure(0.5).expect("known");
            [row.cycle as f64, row.c1.unwrap(), row.v1.unwrap(), p, row.u.unwrap()]
        })
        .collect();
    let input =
        json!({"signals": signals, "window": 5, "constant": constant, "pressure": pressure});
    let answer: Value = serde_json::from_str(&oracle::run("identify.py", &[], &input.to_string()))
        .expect("the oracle answers in JSON");
    let compare = |name: &str, regression: &tertius::identify::qr::Regression| {
        let numbers = |key: &str| -> Vec<f64> {
            let list = answer[name][key].as_array().expect("a list");
            list.iter().map(|value| value.as_f64().expect("a number")).collect()
        };
        let theirs = numbers("coefficients");
        assert!(close(&regression.coefficients, &theirs, 1e-10), "{regression:?}\n{answer}");
        assert!(close(&regression.standard_errors, &numbers("errors"), 1e-8), "{answer}");
        let single = |key: &str| answer[name][key].as_f64().expect("a number");
        assert!(close(&[regression.residual_norm], &[single("residual_norm")], 1e-10));
        assert!(close(&[regression.condition], &[single("condition")], 1e-8));
        assert_eq!(regression.rows as f64, single("rows"));
    };
    compare("velocity", &found.velocity_row);
    assert_eq!(found.pressure_row.is_some(), pressure);
    if let Some(row) = &found.pressure_row {
        compare("pressure", row);
    }
}

#[test]
fn with_noise_the_estimates_are_those_of_numpy_on_the_same_regressors() {
    compare_with_numpy(false, true);
}

#[test]
fn so_are_those_with_a_constant_and_those_without_a_load_pressure() {
    compare_with_numpy(true, true);
    compare_with_numpy(true, false);
    compare_with_numpy(false, false);
}

/// In a first-order machine no load pressure is missed, and the slope of the position will do.
///
/// In (4-1) the velocity l̇(k) leads from l(k) to l(k + 1), so that a centred slope is that of half a
/// cycle before: the machine looks half a cycle slower, and its gain is right.
#[test]
fn position_and_command_are_enough_for_the_reduced_model() {
    let (theta, gamma) = ([-0.002, -0.12, 0.0, 0.0, -1.0], [0.09, 0.0]);
    let model = Model::new(TS, theta, gamma);
    let mut x = nalgebra::Vector3::zeros();
    let one = |k: u32| {
        let u = (f64::from(k) * 0.011).sin() * 0.3;
        let row = Row { v1: None, pressure_bottom: None, ..row(1, k, x[0], 0.0, 0.0, u) };
        x = model.a * x + model.b * u;
        row
    };
    let rows: Vec<Row> = (0..20_000).map(one).collect();
    let sources = Sources { velocity: false, pressure: false };
    let found = estimate(&rows, 1, sources, OffsetRule::Never).expect("sound");
    assert!(found.is_reduced());
    let gain = -found.gamma[0] / found.theta[1];
    assert!((gain - 0.75).abs() < 1e-3, "{found:?}");
    let lag = -1.0 / found.theta[1];
    assert!((lag - (1.0 / 0.12 + 0.5)).abs() < 0.02, "{lag} cycles: {found:?}");
    assert_eq!((&found.theta[2..], found.gamma[1]), (&theta[2..], 0.0));
    let design =
        ObserverDesign::new(&found.model(TS), [1e-8, 1e-3, 100.0], [1e-8, 1e-2], false, 50, 5);
    assert!(design.is_ok(), "the reduced model has an observer: {design:?}");
}

fn tried(of: &Estimate, rows: &[Row]) -> tertius::identify::validate::Trials {
    let model = of.model(TS);
    let observer = ObserverDesign::new(&model, [1e-8, 1e-3, 100.0], [1e-8, 1e-2], true, 50, 5).ok();
    let candidate = Candidate { of: 1, model, pressure_offset: of.pressure_offset, observer };
    let mut validator = Validator::new(Shaper::new(shaping(1), BOTH), 0.0, 1, &[candidate]);
    for (index, row) in rows.iter().enumerate() {
        if index == 1500 {
            validator.gap();
        }
        validator.row(row);
    }
    validator.finish()
}

#[test]
fn the_true_model_accounts_for_everything_and_a_wrong_one_does_not() {
    let rows = Simulated::new(1, 3000).rows();
    let right = estimate(&rows, 1, BOTH, OffsetRule::Never).expect("sound");
    let trials = tried(&right, &rows);
    assert_eq!(trials.starts, 2);
    let simulated = trials.tried[0].simulated;
    assert!(simulated.position.vaf() > 99.999_999 && simulated.velocity.vaf() > 99.999_999);
    assert_eq!(simulated.position.count(), 3000);
    assert_eq!(trials.excerpt.len(), 3000);
    let wrong = Estimate { gamma: [0.5 * GAMMA[0], 0.5 * GAMMA[1]], ..right };
    let trials = tried(&wrong, &rows);
    let simulated = trials.tried[0].simulated;
    assert!(simulated.position.vaf() < 90.0, "{simulated:?}");
    let predicted = trials.tried[0].predicted;
    assert!(predicted.position.vaf() > 99.0, "the observer is led by the readings");
    let whiteness = trials.tried[0].whiteness[0].as_ref().expect("enough");
    assert!(!whiteness.is_white() && whiteness.cross_beyond() > 5, "{whiteness:?}");
}

#[test]
fn data_that_cannot_tell_the_parameters_apart_are_refused() {
    let rows = Simulated::new(1, 400).rows();
    let few = estimate(&rows, 5, BOTH, OffsetRule::Never).expect_err("too few");
    assert_eq!(few, IdentificationRefusal::TooFewRows { rows: 395, least: 500 });
    let rows: Vec<Row> = Simulated::new(1, 5000)
        .rows()
        .into_iter()
        .map(|row| Row { u: row.v1.map(|v| 2.0 * v), ..row })
        .collect();
    let together = estimate(&rows, 1, BOTH, OffsetRule::Never).expect_err("collinear");
    let words = together.to_string();
    assert!(words.contains("the velocity and the command cannot be told apart"), "{words}");
}

/// Rows of a cylinder that is never commanded to rest: it would at −`creep`, m/s. Its load `pushes` it, m/s and bar a
/// cycle.
fn never_at_rest(creep: f64, pushes: [f64; 2]) -> Vec<Row> {
    let model = Model::new(TS, THETA, GAMMA);
    let mut x = nalgebra::Vector3::new(0.05, 1.0, 3.0);
    let mut generator = ChaCha8Rng::seed_from_u64(7);
    let one = |k: u32| {
        let t = f64::from(k) * TS;
        let commanded = 0.5 + 0.2 * (0.7 * t).sin() + 0.2 * (5.3 * t).sin();
        let row = identify_support::row(1, k, x[0], x[1], x[2], commanded);
        x = model.a * x + model.b * (commanded + creep);
        x[1] += pushes[0] * (generator.random::<f64>() - 0.5);
        x[2] += pushes[1] * (generator.random::<f64>() - 0.5);
        row
    };
    (0..5000).map(one).collect()
}

/// Where it would rest is a guess beyond all that was commanded.
#[test]
fn a_rest_that_was_never_commanded_is_refused_where_it_carries_the_motion() {
    let rows = never_at_rest(0.62, [0.0; 2]);
    for rule in [OffsetRule::WhereItMatters, OffsetRule::Always] {
        let refusal = estimate(&rows, 1, BOTH, rule).expect_err("nothing rests there");
        let IdentificationRefusal::RestNeverCommanded { offset, low, high } = refusal else {
            panic!("{refusal}")
        };
        assert!((offset + 0.62).abs() < 1e-6, "{offset}");
        assert!((0.09..0.2).contains(&low) && (0.8..0.91).contains(&high), "{low} {high}");
        let told = refusal.to_string();
        assert!(told.contains("-0.6200 m/s") && told.contains("--offset never"), "{told}");
    }
    estimate(&rows, 1, BOTH, OffsetRule::Never).expect("as it was asked for");
}

#[test]
fn a_rest_that_was_never_commanded_is_left_out_where_the_model_predicts_as_well_without_it() {
    let rows = never_at_rest(0.05, [0.03, 2.0]);
    estimate(&rows, 1, BOTH, OffsetRule::Always).expect_err("nothing rests there");
    let found = estimate(&rows, 1, BOTH, OffsetRule::WhereItMatters).expect("it predicts");
    let never = estimate(&rows, 1, BOTH, OffsetRule::Never).expect("as it was asked for");
    let offset = found.never_commanded.expect("it would rest there");
    assert!((offset + 0.05).abs() < 0.04, "{offset}");
    assert_eq!((found.theta, found.command_offset), (never.theta, None));
}
