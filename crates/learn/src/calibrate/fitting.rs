//! The least squares of (5-20).

use super::line::{Line, Robust};
use super::refusal::CalibrationRefusal;
use super::roughness::Roughness;
use crate::identify::qr::Triangle;
use crate::survey::{Row, Surveyor};

/// Distance from the robust line, in deviations, beyond which samples are not fitted. The
/// difference of two transducers is not only noise but also bends along the stroke, so that some
/// deviations are healthy.
const NEAR: f64 = 8.0;

/// Rounding, m: samples nearer than this are always fitted.
const ROUNDING: f64 = 1e-6;

/// Largest part of the samples that may be left out as faulty.
const MOST_TRIMMED: f64 = 0.1;

/// Calibration of one cylinder.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fitted {
    /// a and b of (5-20), b in m.
    pub line: Line,
    /// Standard errors of a and b, if the residuals were white (they are not).
    pub errors: [f64; 2],
    /// Residual C1 − Ĉ2 on the samples of the fit, root mean square, m.
    pub rms: f64,
    pub rows: u64,
    /// Number of samples that were farther than `limit` from the robust line and left out.
    pub trimmed: u64,
    /// Distance from the robust line beyond which samples are left out, m.
    pub limit: f64,
    /// Standard deviation of C1 − Ĉ2 from cycle to cycle, m.
    pub roughness: f64,
}

#[derive(Clone, Debug)]
struct Regressed {
    robust: Robust,
    limit: f64,
    /// Triangle of the columns C2, 1 and C1.
    triangle: Triangle<3>,
    roughness: Roughness,
    trimmed: u64,
}

/// The second pass: least squares of all samples near the robust lines.
#[derive(Clone, Debug)]
pub struct Fitting {
    cylinders: Vec<Option<Regressed>>,
}

impl Fitting {
    /// A fit of samples near these lines; `None` where there is nothing to fit.
    pub fn new(lines: impl IntoIterator<Item = Option<Robust>>) -> Self {
        let regressed = |robust: Robust| Regressed {
            robust,
            limit: ROUNDING.max(NEAR * robust.deviation),
            triangle: Triangle::new(),
            roughness: Roughness::default(),
            trimmed: 0,
        };
        Self { cylinders: lines.into_iter().map(|line| line.map(regressed)).collect() }
    }

    /// The fit of the cylinder of `index` (from 0); `None` where there was nothing to fit.
    ///
    /// # Errors
    /// Too many samples are far from the line.
    pub fn result(&self, index: usize) -> Option<Result<Fitted, CalibrationRefusal>> {
        self.cylinders[index].as_ref().map(Regressed::result)
    }
}

impl Surveyor for Fitting {
    fn row(&mut self, row: &Row) {
        let regressed = self.cylinders[usize::from(row.cylinder) - 1].as_mut();
        if let (Some(regressed), Some((c1, c2))) = (regressed, row.c1.zip(row.c2)) {
            regressed.take(c1, c2);
        }
    }

    fn gap(&mut self, cylinder: u8) {
        if let Some(regressed) = self.cylinders[usize::from(cylinder) - 1].as_mut() {
            regressed.roughness.interrupt();
        }
    }
}

impl Regressed {
    fn take(&mut self, c1: f64, c2: f64) {
        let error = self.robust.line.error(c2, c1);
        if error.abs() <= self.limit {
            self.triangle.add(&[c2, 1.0, c1]);
            self.roughness.add(error);
        } else {
            self.trimmed += 1;
        }
    }

    fn result(&self) -> Result<Fitted, CalibrationRefusal> {
        let Self { limit, trimmed, .. } = *self;
        let rows = self.triangle.rows() + trimmed;
        let no_line = CalibrationRefusal::NotALine { trimmed, rows, limit_mm: 1e3 * limit };
        if trimmed as f64 > MOST_TRIMMED * rows as f64 {
            return Err(no_line);
        }
        let solved = self.triangle.solve(&[0, 1], 2).map_err(|_| no_line)?;
        let rows = self.triangle.rows();
        Ok(Fitted {
            line: Line { gain: solved.coefficients[0], offset: solved.coefficients[1] },
            errors: [solved.standard_errors[0], solved.standard_errors[1]],
            rms: solved.residual_norm / (rows as f64).sqrt(),
            rows,
            trimmed,
            limit,
            roughness: self.roughness.deviation(),
        })
    }
}
