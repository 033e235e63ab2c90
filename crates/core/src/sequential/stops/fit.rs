//! Least squares with prior knowledge of the coefficients.

use super::StopParameters;

/// Fit whose first two coefficients are of interest: a constant, and the move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Fit {
    /// Move of the readings, m.
    pub moved: f64,
    /// Variance of the move, m².
    pub variance: f64,
    /// Variance of the readings, m², as if they were independent.
    pub scatter: f64,
}

/// How readings scatter about a fit, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scatter {
    /// What is expected, weighing as much as [`StopParameters::expected`] readings.
    pub usual: f64,
    /// Least scatter.
    pub least: f64,
}

const P: &StopParameters = &StopParameters::DEFAULT;

/// Fits `values` by the columns of `rows`, of which column 1 is the move. `deviations` are the
/// prior standard deviations of the coefficients, m; infinite where nothing is known. `None` where
/// the rows do not determine the move.
pub(super) fn fit<const N: usize>(
    rows: &[[f64; N]],
    values: &[f64],
    deviations: [f64; N],
    scatter: Scatter,
) -> Option<Fit> {
    let n = rows.len() as f64;
    let precisions = deviations.map(|deviation| 1.0 / (deviation * deviation));
    let mut variance = scatter.usual * scatter.usual;
    let (gram, right) = products(rows, values);
    let mut round = || {
        let mut normal = gram;
        (0..N).for_each(|i| normal[i][i] += variance * precisions[i]);
        let factor = cholesky(normal)?;
        let solution = solve(&factor, right);
        let (squares, products) = residuals(rows, values, &solution);
        let expected = P.expected * scatter.usual * scatter.usual;
        variance =
            ((expected + squares) / (P.expected + n - 2.0)).max(scatter.least * scatter.least);
        let alike = if squares > 0.0 { (products / squares).clamp(0.0, P.most_alike) } else { 0.0 };
        let mut unit = [0.0; N];
        unit[1] = 1.0;
        let spread = solve(&factor, unit)[1];
        let scatter = variance * (1.0 + alike) / (1.0 - alike);
        Some(Fit { moved: solution[1], variance: scatter * spread, scatter })
    };
    round()?;
    round()
}

/// The products Xᵀ X, lower half, and Xᵀ y.
fn products<const N: usize>(rows: &[[f64; N]], values: &[f64]) -> ([[f64; N]; N], [f64; N]) {
    let (mut gram, mut right) = ([[0.0; N]; N], [0.0; N]);
    for (row, value) in rows.iter().zip(values) {
        for i in 0..N {
            right[i] += row[i] * value;
            for j in 0..=i {
                gram[i][j] += row[i] * row[j];
            }
        }
    }
    (gram, right)
}

/// Sum of the squares of the residuals, and of their products with their neighbours.
fn residuals<const N: usize>(rows: &[[f64; N]], values: &[f64], solution: &[f64; N]) -> (f64, f64) {
    let mut before = 0.0;
    rows.iter().zip(values).fold((0.0, 0.0), |(squares, products), (row, value)| {
        let fitted: f64 = row.iter().zip(solution).map(|(x, b)| x * b).sum();
        let residual = value - fitted;
        let product = residual * core::mem::replace(&mut before, residual);
        (squares + residual * residual, products + product)
    })
}

/// Cholesky factor L of a symmetric matrix given by its lower half; `None` where it has none.
fn cholesky<const N: usize>(mut a: [[f64; N]; N]) -> Option<[[f64; N]; N]> {
    for j in 0..N {
        let whole = a[j][j];
        let left = whole - (0..j).map(|k| a[j][k] * a[j][k]).sum::<f64>();
        // What is left of a column that the others make up is rounding.
        if left.is_nan() || left <= 1e-12 * whole {
            return None;
        }
        a[j][j] = libm::sqrt(left);
        for i in j + 1..N {
            let sum: f64 = (0..j).map(|k| a[i][k] * a[j][k]).sum();
            a[i][j] = (a[i][j] - sum) / a[j][j];
        }
    }
    Some(a)
}

/// Solves L Lᵀ x = b.
fn solve<const N: usize>(factor: &[[f64; N]; N], mut b: [f64; N]) -> [f64; N] {
    for i in 0..N {
        let sum: f64 = (0..i).map(|k| factor[i][k] * b[k]).sum();
        b[i] = (b[i] - sum) / factor[i][i];
    }
    for i in (0..N).rev() {
        let sum: f64 = (i + 1..N).map(|k| factor[k][i] * b[k]).sum();
        b[i] = (b[i] - sum) / factor[i][i];
    }
    b
}

/// Log-likelihood of `values`, nats, except terms that do not depend on the prior deviations of the
/// coefficients, where they scatter by `variance`, m².
pub(super) fn likelihood<const N: usize>(
    rows: &[[f64; N]],
    values: &[f64],
    deviations: [f64; N],
    variance: f64,
) -> Option<f64> {
    let (gram, right) = products(rows, values);
    let mut normal = gram;
    let mut determinant = 0.0;
    for i in 0..N {
        normal[i][i] += variance / (deviations[i] * deviations[i]);
        if deviations[i].is_finite() {
            determinant += libm::log(deviations[i] * deviations[i] / variance);
        }
    }
    let factor = cholesky(normal)?;
    determinant += (0..N).map(|i| 2.0 * libm::log(factor[i][i])).sum::<f64>();
    let solution = solve(&factor, right);
    let explained: f64 = right.iter().zip(solution).map(|(r, b)| r * b).sum();
    Some(0.5 * (explained / variance - determinant))
}
