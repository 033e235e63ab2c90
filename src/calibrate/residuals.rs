//! What the difference of both readings is beyond a [`Profile`], on a part of the recording that it was
//! not fitted to.

use super::fitting::Fitted;
use super::line::Line;
use super::profile::Profile;
use super::trying::FAULTY;
use crate::sequential::Reference;
use crate::sequential::baseline::Baseline;
use crate::sequential::novelty::{News, Novelty};
use crate::sequential::samples::Sample;
use crate::sequential::velocity::Velocity;
use crate::survey::Row;

/// Of the deviation before it is known, m.
const GUESS: f64 = 1e-4;

/// Follows one cylinder as its detector will.
#[derive(Clone, Debug)]
pub struct Residuals {
    line: Line,
    limit: f64,
    reference: Reference,
    velocity: Velocity,
    baseline: Baseline,
    novelty: Novelty,
}

/// What a row has come to.
#[derive(Clone, Copy, Debug)]
pub struct Residual {
    /// C1 and C2, m.
    pub lengths: [f64; 2],
    /// m/s.
    pub velocity: f64,
    /// Beyond the baseline, m; `None` before it has begun.
    pub beyond: Option<f64>,
    pub news: News,
}

impl Residual {
    /// Beyond the baseline, m, where it is evidence of a rod that moves.
    pub fn in_motion(&self) -> Option<f64> {
        self.beyond.filter(|_| self.news == News::InMotion)
    }
}

/// The deviation from a line, as far as it is known, m.
pub fn deviation(fitted: &Fitted) -> f64 {
    if fitted.rms > 0.0 { fitted.rms } else { GUESS }
}

impl Residuals {
    /// Of a cylinder with this line and profile, sampled every `sample_time` seconds.
    pub fn new(sample_time: f64, fitted: &Fitted, profile: &Profile) -> Self {
        let deviation = deviation(fitted);
        Self {
            line: fitted.line,
            limit: FAULTY * fitted.limit,
            reference: profile.reference.clone(),
            velocity: Velocity::new(sample_time),
            baseline: Baseline::new(sample_time, deviation),
            // How far healthy residuals go is what is being learnt.
            novelty: Novelty::new(sample_time, deviation, f64::INFINITY),
        }
    }

    pub fn interrupt(&mut self) {
        self.velocity.reset();
        self.baseline.reset();
        self.novelty.reset();
    }

    /// Takes a row of a monitored cycle; `None` where there is nothing to compare, or one of both is
    /// wrong by a lot.
    pub fn take(&mut self, row: &Row) -> Option<Residual> {
        let velocity = self.velocity.step(row.c2, row.v2);
        let healthy = |(c1, c2): &(f64, f64)| self.line.error(*c2, *c1).abs() <= self.limit;
        let (c1, c2) = row.c1.zip(row.c2).filter(healthy)?;
        let velocity = velocity?;
        let residual = self.reference.residual(c1, c2, velocity)?;
        let baseline = self.baseline.value();
        self.baseline.follow(residual);
        let news = self.novelty.step([c1, c2], Sample::at_rest(residual));
        let beyond = baseline.map(|baseline| residual - baseline);
        Some(Residual { lengths: [c1, c2], velocity, beyond, news })
    }
}
