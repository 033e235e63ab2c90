//! FDE3: C1 against the corrected C2.

/// Calibration of one cylinder, Ĉ2 = a·C2 + b (5-20).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Comparator {
    /// Gain a, dimensionless.
    pub gain: f64,
    /// Offset b, m.
    pub offset: f64,
}

impl Comparator {
    /// Corrected reading Ĉ2, m.
    pub fn corrected(&self, c2: f64) -> f64 {
        self.gain * c2 + self.offset
    }

    /// Residual R3 = C1 − Ĉ2 (5-14) with the correction of section 5-5, m, signed.
    pub fn residual(&self, c1: f64, c2: f64) -> f64 {
        c1 - self.corrected(c2)
    }
}
