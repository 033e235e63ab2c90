//! The Riccati solver against SciPy, NumPy and 60 digits of mpmath, on seeded random models.

use nalgebra::{Complex, SMatrix};
use proptest::prelude::*;
use serde_json::{Value, json};
use tertius::observe::model::{Model, POSITION, POSITION_AND_VELOCITY};
use tertius::observe::riccati::{self, RiccatiError};
use tertius_testing::oracle;

const THETA: [f64; 5] = [-0.0101, -0.1231, -1.6891e-5, -10.7104, -0.0023];
const GAMMA: [f64; 2] = [0.0926, 6.5427];
const Q: [f64; 3] = [1e-8, 1e-3, 100.0];
const R: [f64; 2] = [1e-8, 1e-2];

/// C.
type Outputs<const M: usize> = SMatrix<f64, M, 3>;

/// SplitMix64: the same models in every run, and no more than this test needs.
struct Seeded(u64);

impl Seeded {
    /// Uniform in `low..high`.
    fn between(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^= z >> 31;
        low + (high - low) * (z >> 11) as f64 / (1u64 << 53) as f64
    }

    /// A power of ten, its exponent uniform in `low..high`.
    fn decade(&mut self, low: f64, high: f64) -> f64 {
        10f64.powf(self.between(low, high))
    }

    fn sign(&mut self) -> f64 {
        self.between(-1.0, 1.0).signum()
    }
}

#[derive(Clone, Copy)]
struct Case {
    model: Model,
    q: [f64; 3],
    r: [f64; 2],
}

/// Every parameter within 30 % of Table 4-1, every weight within two decades of the default.
fn near(seeded: &mut Seeded) -> Case {
    let theta = THETA.map(|value| value * seeded.between(0.7, 1.3));
    let q = Q.map(|weight| weight * seeded.decade(-2.0, 2.0));
    let r = R.map(|weight| weight * seeded.decade(-2.0, 2.0));
    Case { model: Model::new(0.02, theta, GAMMA), q, r }
}

/// Other machines: 10 Hz to 1 kHz, unstable and oscillating ones among them, weights over ten
/// decades.
fn far(seeded: &mut Seeded) -> Case {
    let theta = [
        seeded.between(-0.5, 0.1),
        seeded.between(-1.5, 0.1),
        seeded.sign() * seeded.decade(-6.0, -2.0),
        seeded.sign() * seeded.decade(0.0, 3.0),
        seeded.between(-1.5, 0.05),
    ];
    let q = [-10.0, -6.0, -3.0].map(|low| seeded.decade(low, low + 7.0));
    let r = [-10.0, -6.0].map(|low| seeded.decade(low, low + 7.0));
    Case { model: Model::new(seeded.decade(-3.0, -1.0), theta, GAMMA), q, r }
}

fn cases() -> Vec<Case> {
    let mut seeded = Seeded(41);
    (0..240)
        .map(|i| match i {
            0 => Case { model: Model::new(0.02, THETA, GAMMA), q: Q, r: R },
            1..120 => near(&mut seeded),
            _ => far(&mut seeded),
        })
        .collect()
}

fn matrix<const ROWS: usize, const COLUMNS: usize>(value: &Value) -> SMatrix<f64, ROWS, COLUMNS> {
    SMatrix::from_fn(|i, j| value[i][j].as_f64().expect("a number"))
}

fn rows<const ROWS: usize, const COLUMNS: usize>(m: &SMatrix<f64, ROWS, COLUMNS>) -> Value {
    json!(m.row_iter().map(|row| row.iter().copied().collect::<Vec<_>>()).collect::<Vec<_>>())
}

/// P and L.
type Pair<const M: usize> = (SMatrix<f64, 3, 3>, SMatrix<f64, 3, M>);

fn pair<const M: usize>(value: &Value) -> Pair<M> {
    (matrix(&value["p"]), matrix(&value["l"]))
}

/// The larger of the differences of P and L, each entry relative to the standard deviations of its
/// row and column: of the predicted state, and of the innovation.
fn difference<const M: usize>(one: &Pair<M>, exact: &Pair<M>, c: &Outputs<M>, r: &[f64; M]) -> f64 {
    let state = exact.0.diagonal().map(f64::sqrt);
    let variance = (c * exact.0 * c.transpose()).diagonal() + SMatrix::<f64, M, 1>::from(*r);
    let innovation = variance.map(f64::sqrt);
    let in_p = (one.0 - exact.0).component_div(&(state * state.transpose())).amax();
    let per_innovation = state * innovation.map(f64::recip).transpose();
    in_p.max((one.1 - exact.1).component_div(&per_innovation).amax())
}

/// The farthest that a pole is from its counterpart.
fn distance(ours: &[Complex<f64>; 3], theirs: &Value) -> f64 {
    let mut theirs: Vec<_> = (0..3)
        .map(|i| theirs[i][0].as_f64().zip(theirs[i][1].as_f64()).expect("two numbers"))
        .map(|(re, im)| Complex::new(re, im))
        .collect();
    ours.iter().fold(0.0, |worst: f64, pole| {
        let apart = |other: &Complex<f64>| (other - pole).norm();
        let nearest = (0..theirs.len())
            .min_by(|&i, &j| apart(&theirs[i]).total_cmp(&apart(&theirs[j])))
            .expect("as many as ours");
        worst.max(apart(&theirs.swap_remove(nearest)))
    })
}

/// What is compared, on 240 models (see `cases`), of which none may be left out:
/// - with the exact solution: P and L to 1e-11;
/// - with SciPy: P and L to 1e-9, except where SciPy itself is farther than that from the exact
///   solution. It may be so on 5 models at most, or this compares nothing;
/// - with NumPy: the eigenvalues of A − L C to 1e-11.
fn compare<const M: usize>(c: Outputs<M>) {
    let solved: Vec<_> = cases()
        .into_iter()
        .map(|Case { model, q, r }| {
            let r: [f64; M] = std::array::from_fn(|i| r[i]);
            let ours = riccati::solve(&model.a, &c, q, r)
                .unwrap_or_else(|error| panic!("{error}\n{model:?} {q:?} {r:?}"));
            (model, q, r, ours)
        })
        .collect();
    let input: String = solved
        .iter()
        .map(|(model, q, r, ours)| {
            let (a, c, gain) = (rows(&model.a), rows(&c), rows(&ours.gain));
            format!("{}\n", json!({"a": a, "c": c, "q": q, "r": &r[..], "gain": gain}))
        })
        .collect();
    let output = oracle::run("riccati.py", &[], &input);
    let answers: Vec<Value> =
        output.lines().map(|line| serde_json::from_str(line).expect("JSON")).collect();
    assert_eq!(answers.len(), solved.len());

    let mut scipy_is_off = 0;
    for ((model, q, r, ours), answer) in solved.iter().zip(&answers) {
        let case = format!("{model:?} {q:?} {r:?}\n{ours:?}\n{answer}");
        let found = (ours.covariance, ours.gain);
        let exact = pair(&answer["exact"]);
        let error = difference(&found, &exact, &c, r);
        assert!(error < 1e-11, "{error:e} from the exact solution: {case}");

        let scipy = (!answer["scipy"].is_null()).then(|| pair(&answer["scipy"]));
        match scipy.filter(|scipy| difference(scipy, &exact, &c, r) < 1e-9) {
            Some(scipy) => {
                let apart = difference(&found, &scipy, &c, r);
                assert!(apart < 1.01e-9, "{apart:e} from SciPy: {case}");
            }
            None => scipy_is_off += 1,
        }

        let apart = distance(&ours.poles, &answer["poles"]);
        assert!(apart < 1e-11, "the poles are {apart:e} from NumPy's: {case}");
        assert!(ours.poles.iter().all(|pole| pole.norm() < 1.0), "{case}");
        assert!(ours.poles[0].norm() >= ours.poles[2].norm(), "the slowest is first: {case}");
    }
    assert!(scipy_is_off <= 5, "SciPy is not accurate on {scipy_is_off} models");
}

#[test]
fn position_and_velocity() {
    compare(POSITION_AND_VELOCITY);
}

#[test]
fn position_alone() {
    compare(POSITION);
}

fn table() -> Model {
    Model::new(0.02, THETA, GAMMA)
}

/// Without θ3 the pressure does not act on what is measured, and with θ5 = 0 it never settles.
#[test]
fn a_mode_that_is_neither_measured_nor_settles_is_refused() {
    for (theta5, modulus) in [(0.0, 1.0), (0.01, 1.01), (-2.5, 1.5)] {
        let theta = [THETA[0], THETA[1], 0.0, THETA[3], theta5];
        let model = Model::new(0.02, theta, GAMMA);
        let refused = [
            riccati::solve(&model.a, &POSITION_AND_VELOCITY, Q, R).unwrap_err(),
            riccati::solve(&model.a, &POSITION, Q, [R[0]]).unwrap_err(),
        ];
        for error in refused {
            let RiccatiError::NotDetectable { modulus: found } = error else { panic!("{error:?}") };
            assert!((found - modulus).abs() < 1e-9, "{error}");
        }
    }
    // One that settles by itself need not be measured.
    let theta = [THETA[0], THETA[1], 0.0, THETA[3], -0.1];
    let solution = riccati::solve(&Model::new(0.02, theta, GAMMA).a, &POSITION, Q, [R[0]]).unwrap();
    assert!((solution.poles[0].norm() - 0.9).abs() < 1e-9, "{:?}", solution.poles);
}

/// θ1 = 0 makes the position a pure integrator: fine with noise on it, no gain without.
#[test]
fn an_integrator_needs_noise() {
    let theta = [0.0, THETA[1], THETA[2], THETA[3], THETA[4]];
    let model = Model::new(0.02, theta, GAMMA);
    assert!(riccati::solve(&model.a, &POSITION, Q, [R[0]]).is_ok());
    let error = riccati::solve(&model.a, &POSITION, [0.0; 3], [R[0]]).unwrap_err();
    assert!(matches!(error, RiccatiError::NotExcited { .. }), "{error:?}");
    assert!(error.to_string().contains("weights q"), "{error}");
}

#[test]
fn a_stable_model_without_noise_needs_no_correction() {
    let solution = riccati::solve(&table().a, &POSITION_AND_VELOCITY, [0.0; 3], R).unwrap();
    assert_eq!((solution.covariance.amax(), solution.gain.amax()), (0.0, 0.0));
    assert_eq!(Some(solution.poles), table().poles());
}

/// P is a variance and L has no unit of its own: both weights times 1e12 is the same observer.
#[test]
fn only_the_ratio_of_the_weights_makes_the_gain() {
    let one = riccati::solve(&table().a, &POSITION_AND_VELOCITY, Q, R).unwrap();
    for factor in [1e-12, 1e12] {
        let (q, r) = (Q.map(|weight| weight * factor), R.map(|weight| weight * factor));
        let other = riccati::solve(&table().a, &POSITION_AND_VELOCITY, q, r).unwrap();
        let other = (other.covariance / factor, other.gain);
        let apart = difference(&other, &(one.covariance, one.gain), &POSITION_AND_VELOCITY, &R);
        assert!(apart < 1e-12, "{factor:e}: {apart:e}");
    }
}

#[test]
fn weights_that_cannot_be_are_named() {
    let solve = |q, r| riccati::solve(&table().a, &POSITION_AND_VELOCITY, q, r).unwrap_err();
    for (error, place) in [
        (solve([1e-8, -1e-3, 1.0], R), "q[1]"),
        (solve([1e-8, 1e-3, f64::NAN], R), "q[2]"),
        (solve([f64::INFINITY, 1e-3, 1.0], R), "q[0]"),
        (solve(Q, [0.0, 1e-2]), "r[0]"),
        (solve(Q, [1e-8, -1.0]), "r[1]"),
        (solve(Q, [1e-8, f64::NAN]), "r[1]"),
    ] {
        assert!(matches!(error, RiccatiError::Weight { .. }), "{error:?}");
        assert!(error.to_string().contains(place), "{error}");
    }
    let mut model = table();
    model.a[(1, 1)] = f64::NAN;
    let error = riccati::solve(&model.a, &POSITION, Q, [R[0]]).unwrap_err();
    assert_eq!(error, RiccatiError::Model);
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    /// Whatever the numbers, it ends, and what it returns is finite and stable.
    #[test]
    fn any_numbers_have_an_answer(
        theta in prop::array::uniform5(any::<f64>()),
        ordinary in prop::array::uniform5(-3.0..3.0f64),
        wild in prop::array::uniform5(any::<bool>()),
        q in prop::array::uniform3((-300.0..300.0f64).prop_map(|e| 10f64.powf(e))),
        r in (-300.0..300.0f64).prop_map(|e| 10f64.powf(e)),
    ) {
        let theta = std::array::from_fn(|i| if wild[i] { theta[i] } else { ordinary[i] });
        let model = Model::new(0.02, theta, GAMMA);
        if let Ok(solution) = riccati::solve(&model.a, &POSITION, q, [r]) {
            prop_assert!(solution.gain.iter().all(|entry| entry.is_finite()));
            prop_assert!(solution.covariance.iter().all(|entry| entry.is_finite()));
            prop_assert!(solution.poles.iter().all(|pole| pole.norm() < 1.0));
        }
    }
}
