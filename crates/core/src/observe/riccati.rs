//! The steady-state gain of an observer: the discrete algebraic Riccati equation in filter form,
//!
//! P = A P Aᵀ − A P Cᵀ (C P Cᵀ + R)⁻¹ C P Aᵀ + Q,  L = A P Cᵀ (C P Cᵀ + R)⁻¹,
//!
//! solved by structured doubling: pass i jumps over 2ⁱ steps of the filter, so that about ten
//! passes do. P is the covariance of the prediction x̂(k|k−1), L the predictor's gain in
//! x̂(k+1) = A x̂(k) + B u(k) + L (y(k) − C x̂(k)). This is what (5-6) means.
//!
//! Source: Chu, Fan, Lin and Wang, *Structure-preserving algorithms for periodic discrete-time
//! algebraic Riccati equations*, Int. J. Control 77 (2004), with A for their Aᵀ and Cᵀ for their B.

use nalgebra::{Cholesky, Complex, Matrix3, SMatrix, SVector, Vector3};
use thiserror::Error;

use super::model::{Balanced, LARGEST, eigenvalues, is_usable, modulus};

/// Most passes: twice as many as a filter needs that forgets over 2³² samples, three years at 50
/// Hz.
const PASSES: u32 = 64;

/// Largest residual of a valid solution, relative to the terms of the equation.
const TOLERANCE: f64 = 1e-10;

/// Distance from the unit circle within which modes are taken to be on it.
const CIRCLE: f64 = 1e-12;

/// The stabilising solution for `M` outputs, checked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solution<const M: usize> {
    /// Covariance P of the prediction, 3×3, symmetric, in the squared units of the state.
    pub covariance: Matrix3<f64>,
    /// Gain L of the predictor, 3×M.
    pub gain: SMatrix<f64, 3, M>,
    /// Eigenvalues of A − L C, all inside the unit circle, the largest modulus first.
    pub poles: [Complex<f64>; 3],
    /// Number of passes of the doubling.
    pub passes: u32,
    /// Residual of the equation with P, relative to the terms that add up to it.
    pub residual: f64,
}

/// Why a model and its weights have no observer.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum RiccatiError {
    #[error(
        "the model holds a number that is not finite or beyond {LARGEST:e}; identify it again, or \
         correct theta"
    )]
    Model,
    #[error(
        "{matrix}[{index}] = {value} cannot be a weight (entries count from 0); {matrix} takes \
         {expected}"
    )]
    Weight { matrix: &'static str, index: usize, value: f64, expected: &'static str },
    #[error(
        "the readings do not show the model's mode of modulus {modulus:.6}, which does not decay by \
         itself, so no observer can follow it; add a velocity signal or correct theta (theta 3 \
         couples the load pressure to the motion)"
    )]
    NotDetectable { modulus: f64 },
    #[error(
        "the observer would ignore its readings in the model's mode of modulus {modulus:.6}, which \
         does not decay by itself, because the weights q give it no noise; make them larger than 0"
    )]
    NotExcited { modulus: f64 },
    #[error(
        "the observer's gain did not settle in {passes} passes; bring the weights q and r within \
         fewer powers of ten of each other"
    )]
    NotConverged { passes: u32 },
    #[error(
        "the observer's gain is not accurate: the Riccati equation is met to {residual:e} only, \
         and the slowest pole of the observer has modulus {radius:.12} (it must be below 1); bring \
         the weights q and r within fewer powers of ten of each other"
    )]
    Inaccurate { residual: f64, radius: f64 },
}

/// Solves the equation for the model's `a`, the outputs' `c` (M×3, one or two of them), and the
/// diagonals `q` of Q (at least 0) and `r` of R (above 0), in the squared units of state and
/// outputs.
///
/// # Errors
/// Numbers that are not finite or huge, weights out of range, modes on or outside the unit
/// circle that are not measured or (on it) not excited, and a result that fails its check.
pub fn solve<const M: usize>(
    a: &Matrix3<f64>,
    c: &SMatrix<f64, M, 3>,
    q: [f64; 3],
    r: [f64; M],
) -> Result<Solution<M>, RiccatiError> {
    check_weights(q, r)?;
    if !(is_usable(a) && is_usable(c)) {
        return Err(RiccatiError::Model);
    }
    check_modes(a, c, q)?;

    // Both in units in which the noise is of size 1, whatever the units of the state and outputs.
    let (q, r) = (Vector3::from(q), SVector::from(r));
    let units = noise_units(a, &q);
    let scale = Matrix3::from_diagonal(&units);
    let unscale = Matrix3::from_diagonal(&units.map(f64::recip));
    let root = SMatrix::<f64, M, M>::from_diagonal(&r.map(|weight| libm::sqrt(weight).recip()));
    let scaled = unscale * a * scale;
    let outputs = root * c * scale;
    let noise = Matrix3::from_diagonal(&q.component_div(&units.component_mul(&units)));

    let (p, passes) = double(scaled, outputs.tr_mul(&outputs), noise)?;
    let unsettled = RiccatiError::NotConverged { passes };
    let innovation = outputs * p * outputs.transpose() + SMatrix::identity();
    let cross = outputs * p * scaled.transpose();
    let gain = Cholesky::new(innovation).ok_or(unsettled)?.solve(&cross).transpose();

    let residual = residual(&scaled, &noise, &p, &(gain * cross));
    let poles = eigenvalues(&(scaled - gain * outputs)).ok_or(unsettled)?;
    let radius = modulus(poles[0]);
    // Written so that a NaN is refused as well.
    if !(residual <= TOLERANCE && radius < 1.0) {
        return Err(RiccatiError::Inaccurate { residual, radius });
    }
    let (covariance, gain) = (scale * p * scale, scale * gain * root);
    // Weights of 1e300 are weights, but what follows from them may not be a number.
    if !covariance.iter().chain(gain.iter()).all(|entry| entry.is_finite()) {
        return Err(unsettled);
    }
    Ok(Solution { covariance, gain, poles, passes, residual })
}

/// Doubles until convergence: P and the number of passes, for A, G = Cᵀ R⁻¹ C and Q.
fn double(
    mut a: Matrix3<f64>,
    mut g: Matrix3<f64>,
    q: Matrix3<f64>,
) -> Result<(Matrix3<f64>, u32), RiccatiError> {
    // The paper's A is the transpose of the filter's.
    a.transpose_mut();
    let mut h = q;
    for pass in 1..=PASSES {
        let failed = RiccatiError::NotConverged { passes: pass };
        let w = (Matrix3::identity() + g * h).lu();
        let w_a = w.solve(&a).ok_or(failed)?;
        let w_g = w.solve(&g).ok_or(failed)?;
        let change = symmetric(&(a.transpose() * h * w_a));
        g = symmetric(&(g + a * w_g * a.transpose()));
        h += change;
        a *= w_a;
        if !h.iter().all(|entry| entry.is_finite()) {
            return Err(failed);
        }
        // What follows is the square of this, relatively, and so nothing.
        if relative(&change, &h) <= f64::EPSILON {
            return Ok((h, pass));
        }
    }
    Err(RiccatiError::NotConverged { passes: PASSES })
}

/// The largest entry of `part`, each relative to the standard deviations that `whole` gives its row
/// and column; infinite when an entry, or a variance, is not a valid number.
fn relative(part: &Matrix3<f64>, whole: &Matrix3<f64>) -> f64 {
    let deviations = whole.diagonal().map(libm::sqrt);
    let size = deviations * deviations.transpose();
    part.zip_map(&size, |entry, size| if entry == 0.0 { 0.0 } else { entry.abs() / size })
        .iter()
        .fold(0.0, |worst, entry| if entry.is_nan() { f64::INFINITY } else { worst.max(*entry) })
}

/// Residual A P Aᵀ + Q − L (C P Aᵀ) − P, relative to A P Aᵀ + Q; `correction` is L (C P Aᵀ).
fn residual(
    a: &Matrix3<f64>,
    q: &Matrix3<f64>,
    p: &Matrix3<f64>,
    correction: &Matrix3<f64>,
) -> f64 {
    let prediction = a * p * a.transpose() + q;
    relative(&(prediction - correction - p), &prediction)
}

/// Effect of the noise on each state within three samples: the units in which all states are alike.
/// Powers of two, so that scaling rounds nothing.
fn noise_units(a: &Matrix3<f64>, q: &Vector3<f64>) -> Vector3<f64> {
    let q = Matrix3::from_diagonal(q);
    let two = q + a * q * a.transpose();
    let three = q + a * two * a.transpose();
    three.diagonal().map(|variance| {
        let unit = libm::exp2(libm::round(libm::log2(libm::sqrt(variance))));
        if unit.is_normal() { unit } else { 1.0 }
    })
}

fn symmetric(m: &Matrix3<f64>) -> Matrix3<f64> {
    (m + m.transpose()) * 0.5
}

fn check_weights<const M: usize>(q: [f64; 3], r: [f64; M]) -> Result<(), RiccatiError> {
    let refuse = |matrix, index, value, expected| {
        Err(RiccatiError::Weight { matrix, index, value, expected })
    };
    for (index, &value) in q.iter().enumerate() {
        if !(value.is_finite() && value >= 0.0) {
            return refuse("q", index, value, "finite numbers from 0 on");
        }
    }
    for (index, &value) in r.iter().enumerate() {
        if !value.is_normal() || value < 0.0 {
            return refuse("r", index, value, "finite numbers above 0");
        }
    }
    Ok(())
}

/// Checks detectability, and that the noise reaches every mode on the unit circle: together they
/// ensure that the stabilising solution exists.
fn check_modes<const M: usize>(
    a: &Matrix3<f64>,
    c: &SMatrix<f64, M, 3>,
    q: [f64; 3],
) -> Result<(), RiccatiError> {
    let poles = eigenvalues(a).ok_or(RiccatiError::Model)?;
    let outputs = Balanced::new(a, c);
    // Excitation is the dual: what the noise reaches in A is what is measured in Aᵀ.
    let deviations = Matrix3::from_diagonal(&Vector3::from(q).map(libm::sqrt));
    let noise = Balanced::new(&a.transpose(), &deviations);
    for pole in poles {
        let modulus = modulus(pole);
        if modulus >= 1.0 - CIRCLE && !outputs.sees(pole) {
            return Err(RiccatiError::NotDetectable { modulus });
        }
        if (modulus - 1.0).abs() <= CIRCLE && !noise.sees(pole) {
            return Err(RiccatiError::NotExcited { modulus });
        }
    }
    Ok(())
}
