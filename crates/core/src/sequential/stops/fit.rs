//! Least squares with prior knowledge of the coefficients.

use super::parameters::{Scatter, StopParameters};

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

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::vec::Vec;
    use nalgebra::{Matrix4, Vector4};

    const ROWS: [[f64; 2]; 4] = [[1.0, 0.0], [1.0, 0.2], [1.0, 0.7], [1.0, 1.0]];
    const VALUES: [f64; 4] = [0.3e-3, 0.5e-3, 1.1e-3, 1.2e-3];

    /// The density of values that are normal, with coefficients that are normal, is known.
    #[test]
    fn likelihoods_differ_as_those_of_the_normal_distribution() {
        let variance = 1e-8;
        let direct = |deviations: [f64; 2]| {
            let mut covariance = Matrix4::identity() * variance;
            for (which, deviation) in deviations.into_iter().enumerate() {
                let column = Vector4::from(ROWS.map(|row| row[which]));
                covariance += column * column.transpose() * deviation * deviation;
            }
            let values = Vector4::from(VALUES);
            let inverse = covariance.try_inverse().expect("it is positive");
            -0.5 * ((values.transpose() * inverse * values)[0] + covariance.determinant().ln())
        };
        let found =
            |deviations| likelihood(&ROWS, &VALUES, deviations, variance).expect("it has one");
        let usual = [1e-3, 1e-3];
        for deviations in [[1e-3, 0.1e-3], [0.2e-3, 3e-3], [5e-3, 5e-3]] {
            let expected = direct(deviations) - direct(usual);
            let found = found(deviations) - found(usual);
            assert!((found - expected).abs() < 1e-6 * expected.abs(), "{found} for {expected}");
        }
    }

    #[test]
    fn a_line_is_fitted_and_its_scatter_told() {
        let scatter = Scatter { usual: 1e-4, least: 1e-6 };
        let free = [f64::INFINITY; 2];
        let rows: Vec<[f64; 2]> = (0..200).map(|k| [1.0, f64::from(k) / 199.0]).collect();
        // To either side in pairs, so that neighbours are neither alike nor unlike.
        let noise = |k: usize| if k % 4 < 2 { 3e-4 } else { -3e-4 };
        let values: Vec<f64> =
            rows.iter().enumerate().map(|(k, row)| 5.0 + 2e-3 * row[1] + noise(k)).collect();
        let found = fit(&rows, &values, free, scatter).expect("it is determined");
        assert!((found.moved - 2e-3).abs() < 2e-5, "{found:?}");
        assert!((found.scatter.sqrt() - 3e-4).abs() < 1e-5, "{found:?}");
        // σ²/Σ(x − x̄)², with x evenly from 0 to 1.
        let expected = found.scatter * 12.0 / 200.0;
        assert!((found.variance / expected - 1.0).abs() < 0.03, "{found:?}");
        // A prior of nothing leaves nothing, and one row determines no line.
        let held = fit(&rows, &values, [f64::INFINITY, 1e-9], scatter).expect("it is determined");
        assert!(held.moved.abs() < 1e-6, "{held:?}");
        assert_eq!(fit(&rows[..1], &values[..1], free, scatter), None);
    }
}
