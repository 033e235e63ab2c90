//! Residuals of one part of the recording against the reference learnt from another.

use super::division::{Division, Halves};
use super::fitting::Fitted;
use super::line::Line;
use super::trying::FAULTY;
use crate::survey::Row;
use tertius_core::sequential::baseline::{Baseline, Loss};
use tertius_core::sequential::parameters::ResidualParameters;
use tertius_core::sequential::samples::{Independence, Sample};
use tertius_core::sequential::thinning::Thinning;
use tertius_core::sequential::velocity::Velocity;

/// Standard deviation that is assumed before it is known, m.
const GUESS: f64 = 1e-4;

/// Follows one cylinder as its detector will.
#[derive(Clone, Debug)]
pub struct Residuals {
    line: Line,
    limit: f64,
    division: Division,
    halves: Halves,
    velocity: Velocity,
    baseline: Baseline,
    loss: Loss,
    thinning: Thinning,
}

/// Residual of one row.
#[derive(Clone, Copy, Debug)]
pub struct Residual {
    /// C1 and C2, m.
    pub lengths: [f64; 2],
    /// Velocity, m/s.
    pub velocity: f64,
    /// Residual beyond the baseline, m; `None` before the baseline has begun.
    pub beyond: Option<f64>,
    /// Variance of the residual due to the uncertainty of its reference, m².
    pub doubt: f64,
    pub independence: Independence,
}

impl Residual {
    /// Residual beyond the baseline, m, where it is evidence from a rod in motion.
    pub fn in_motion(&self) -> Option<f64> {
        self.beyond.filter(|_| self.independence == Independence::InMotion)
    }
}

/// Standard deviation from a line, as far as it is known, m.
pub fn deviation(fitted: &Fitted) -> f64 {
    if fitted.rms > 0.0 { fitted.rms } else { GUESS }
}

impl Residuals {
    /// Residuals of a cylinder with this line, against the references from the halves of
    /// `division`, sampled every `sample_time` seconds.
    pub fn new(sample_time: f64, fitted: &Fitted, division: Division, halves: Halves) -> Self {
        let deviation = deviation(fitted);
        let parameters = &ResidualParameters::DEFAULT;
        Self {
            line: fitted.line,
            limit: FAULTY * fitted.limit,
            division,
            halves,
            velocity: Velocity::new(parameters, sample_time),
            baseline: Baseline::new(parameters, sample_time, deviation),
            loss: Loss::default(),
            // How far healthy residuals go is what is being learnt.
            thinning: Thinning::new(parameters, sample_time, deviation, f64::INFINITY),
        }
    }

    /// Reports that cycles are missing.
    pub fn interrupt(&mut self) {
        self.velocity.reset();
        self.thinning.reset();
        self.loss.begin();
    }

    /// Reports that the platform has left its state; what was learnt in one does not apply in
    /// another.
    pub fn leave(&mut self) {
        self.interrupt();
        self.baseline.reset();
    }

    /// Takes a row of a monitored cycle; `None` where there is nothing to compare, or a reading is
    /// grossly wrong.
    pub fn take(&mut self, row: &Row) -> Option<Residual> {
        let velocity = self.velocity.step(row.c2, row.v2);
        let healthy = |(c1, c2): &(f64, f64)| self.line.error(*c2, *c1).abs() <= self.limit;
        let (c1, c2) = row.c1.zip(row.c2).filter(healthy)?;
        let velocity = velocity?;
        let half = self.division.judged(row.t)?;
        let (residual, doubt) = self.halves[half].as_ref()?.residual(c1, c2, velocity)?;
        if self.loss.is_long(row.timestamp) {
            self.baseline.reset();
        }
        let (baseline, of_baseline) = (self.baseline.value(), self.baseline.doubt());
        self.baseline.follow(residual, doubt);
        let independence = self.thinning.step([c1, c2], Sample::at_rest(residual));
        let beyond = baseline.map(|baseline| residual - baseline);
        let doubt = doubt * doubt + of_baseline * of_baseline;
        Some(Residual { lengths: [c1, c2], velocity, beyond, doubt, independence })
    }
}
