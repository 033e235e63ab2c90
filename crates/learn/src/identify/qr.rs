//! Least squares over a stream of rows.
//!
//! Only the triangle R of the QR decomposition of all rows is kept. A block of new rows is put
//! below it and both are triangularised again by Householder reflections. Thus nothing is squared,
//! as it would be in the normal equations (4-5), and memory does not grow. The triangle holds every
//! regression of one of its columns on any of the others.

use nalgebra::{DMatrix, DVector, SVD};

/// Number of rows that are collected before they are triangularised.
const BLOCK: usize = 256;

/// The triangle of `K` columns, regressors and targets.
#[derive(Clone, Debug)]
pub struct Triangle<const K: usize> {
    /// R above, the gathered rows below, zero beyond them; (K + BLOCK)×K.
    stack: DMatrix<f64>,
    gathered: usize,
    rows: u64,
}

/// Result of a regression.
#[derive(Clone, Debug, PartialEq)]
pub struct Regression {
    pub coefficients: Vec<f64>,
    /// Standard errors of the coefficients, if the residuals were white.
    pub standard_errors: Vec<f64>,
    /// Residual norm √Σ(y − φᵀθ)², the root of N V(θ) of (4-6).
    pub residual_norm: f64,
    /// Norm √Σy² of the target.
    pub target_norm: f64,
    /// Condition number of the regressors, each scaled to length 1.
    pub condition: f64,
    pub rows: u64,
}

impl Regression {
    /// Part of the target's sum of squares that the regressors explain, 0 to 1.
    pub fn share(&self) -> f64 {
        1.0 - (self.residual_norm / self.target_norm).powi(2)
    }
}

/// Why a regression has no solution.
#[derive(Clone, Debug, PartialEq)]
pub enum NoRegression {
    /// There are no more rows than coefficients.
    TooFewRows { rows: u64 },
    /// The regressors of these indices (in the order requested) are nearly collinear.
    Collinear { condition: f64, among: Vec<usize> },
}

/// Largest condition number of a regression: readings have four digits at best, and with 1e5 the
/// fit would depend on their last one.
pub const LARGEST_CONDITION: f64 = 1e5;

impl<const K: usize> Triangle<K> {
    pub fn new() -> Self {
        Self { stack: DMatrix::zeros(K + BLOCK, K), gathered: 0, rows: 0 }
    }

    pub const fn rows(&self) -> u64 {
        self.rows
    }

    /// Adds a row of regressors and targets. All must be finite.
    pub fn add(&mut self, row: &[f64; K]) {
        for (column, value) in row.iter().enumerate() {
            self.stack[(K + self.gathered, column)] = *value;
        }
        self.gathered += 1;
        self.rows += 1;
        if self.gathered == BLOCK {
            self.stack = restacked::<K>(&self.triangle());
            self.gathered = 0;
        }
    }

    /// The triangle R, K×K.
    fn triangle(&self) -> DMatrix<f64> {
        self.stack.rows(0, K + self.gathered).into_owned().qr().unpack_r()
    }

    /// The regression of the column `target` on the columns `regressors`.
    ///
    /// # Errors
    /// Too few rows, or regressors that cannot be told apart ([`LARGEST_CONDITION`]).
    pub fn solve(&self, regressors: &[usize], target: usize) -> Result<Regression, NoRegression> {
        let count = regressors.len();
        if self.rows <= count as u64 {
            return Err(NoRegression::TooFewRows { rows: self.rows });
        }
        let all: Vec<usize> = regressors.iter().chain([&target]).copied().collect();
        let r = self.triangle().select_columns(&all).qr().unpack_r();
        let scales = DVector::from_fn(count, |j, _| r.column(j).norm());
        if let Some(zero) = scales.iter().position(|scale| *scale <= 0.0) {
            return Err(NoRegression::Collinear { condition: f64::INFINITY, among: vec![zero] });
        }
        let scaled = DMatrix::from_fn(count, count, |i, j| r[(i, j)] / scales[j]);
        let condition = self::condition(&scaled)?;
        // The condition number says that no diagonal entry is zero.
        let inverse = scaled
            .solve_upper_triangular(&DMatrix::identity(count, count))
            .ok_or_else(|| NoRegression::Collinear { condition, among: (0..count).collect() })?;
        let solution = &inverse * r.view((0, count), (count, 1));
        let residual_norm = r[(count, count)].abs();
        let freedom = (self.rows - count as u64) as f64;
        let deviation = residual_norm / freedom.sqrt();
        Ok(Regression {
            coefficients: (0..count).map(|j| solution[j] / scales[j]).collect(),
            standard_errors: (0..count)
                .map(|j| deviation * inverse.row(j).norm() / scales[j])
                .collect(),
            residual_norm,
            target_norm: r.column(count).norm(),
            condition,
            rows: self.rows,
        })
    }

    /// The root mean square of a column.
    pub fn rms(&self, column: usize) -> f64 {
        let rows = self.rows.max(1) as f64;
        self.triangle().column(column).norm() / rows.sqrt()
    }
}

impl<const K: usize> Default for Triangle<K> {
    fn default() -> Self {
        Self::new()
    }
}

fn restacked<const K: usize>(triangle: &DMatrix<f64>) -> DMatrix<f64> {
    let mut stack = DMatrix::zeros(K + BLOCK, K);
    stack.rows_mut(0, K).copy_from(triangle);
    stack
}

/// The condition number of columns of length 1, or the columns that are collinear.
fn condition(scaled: &DMatrix<f64>) -> Result<f64, NoRegression> {
    let svd = SVD::new(scaled.clone(), false, true);
    let (largest, smallest) = (svd.singular_values.max(), svd.singular_values.min());
    let condition = largest / smallest;
    if condition <= LARGEST_CONDITION {
        return Ok(condition);
    }
    let place = svd.singular_values.imin();
    let among = svd.v_t.map_or_else(Vec::new, |v_t| {
        (0..scaled.ncols()).filter(|j| v_t[(place, *j)].abs() > 0.2).collect()
    });
    Err(NoRegression::Collinear { condition, among })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(k: u32) -> [f64; 4] {
        let x = f64::from(k);
        let (a, b) = ((0.1 * x).sin(), (0.37 * x).cos());
        [a, b, 1.0, 3.0 * a - 2e-5 * b + 0.5]
    }

    #[test]
    fn any_subset_is_solved_whatever_the_number_of_rows() {
        for rows in [5, 256, 257, 1000] {
            let mut triangle = Triangle::<4>::new();
            (0..rows).for_each(|k| triangle.add(&row(k)));
            let all = triangle.solve(&[1, 0, 2], 3).expect("it is well posed");
            for (found, expected) in all.coefficients.iter().zip([-2e-5, 3.0, 0.5]) {
                assert!((found - expected).abs() < 1e-13, "{rows}: {all:?}");
            }
            assert!(all.residual_norm < 1e-13 && all.rows == u64::from(rows));
            let squares = (0..rows).map(|k| row(k)[3].powi(2)).sum::<f64>();
            assert!((all.target_norm.powi(2) - squares).abs() < 1e-12 * squares, "{all:?}");
            // Without the constant something is left over.
            let partial = triangle.solve(&[0, 1], 3).expect("it is well posed");
            assert!(partial.residual_norm > 0.01, "{partial:?}");
            assert!((0.0..1.0).contains(&partial.share()) && all.share() > 0.999_999);
        }
    }

    #[test]
    fn columns_that_go_together_are_named() {
        let mut triangle = Triangle::<4>::new();
        for k in 0..100 {
            let [a, b, _, y] = row(k);
            triangle.add(&[a, b, 1000.0 * a, y]);
        }
        let Err(NoRegression::Collinear { condition, among }) = triangle.solve(&[1, 0, 2], 3)
        else {
            panic!("columns 0 and 2 are one");
        };
        assert!(condition > 1e12 && among == [1, 2], "{condition} {among:?}");
        assert!(matches!(
            Triangle::<4>::new().solve(&[0], 3),
            Err(NoRegression::TooFewRows { rows: 0 })
        ));
    }

    /// A scale is not a collinearity.
    #[test]
    fn units_do_not_change_the_condition() {
        let mut one = Triangle::<4>::new();
        let mut other = Triangle::<4>::new();
        for k in 0..500 {
            let [a, b, c, y] = row(k);
            one.add(&[a, b, c, y]);
            other.add(&[a * 1e9, b * 1e-9, c, y]);
        }
        let [one, other] = [one, other].map(|t| t.solve(&[0, 1, 2], 3).expect("sound").condition);
        assert!((one - other).abs() < 1e-6 * one, "{one} {other}");
    }
}
