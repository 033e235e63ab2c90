//! What the difference of both readings is beyond what one part of the recording has taught, on another
//! one.

use super::division::{Division, Halves};
use super::fitting::Fitted;
use super::line::Line;
use super::trying::FAULTY;
use crate::survey::Row;
use tertius_core::sequential::baseline::{Baseline, Loss};
use tertius_core::sequential::novelty::{News, Novelty};
use tertius_core::sequential::parameters::ResidualParameters;
use tertius_core::sequential::samples::Sample;
use tertius_core::sequential::velocity::Velocity;

/// Of the deviation before it is known, m.
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
    /// The square of what that may be off by, for what it is compared with may be, m².
    pub doubt: f64,
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
    /// Of a cylinder with this line, by what the halves of `division` have taught, sampled every
    /// `sample_time` seconds.
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
            novelty: Novelty::new(parameters, sample_time, deviation, f64::INFINITY),
        }
    }

    /// Cycles are missing.
    pub fn interrupt(&mut self) {
        self.velocity.reset();
        self.novelty.reset();
        self.loss.begin();
    }

    /// The platform has left its state: what is learnt of one is void in another.
    pub fn leave(&mut self) {
        self.interrupt();
        self.baseline.reset();
    }

    /// Takes a row of a monitored cycle; `None` where there is nothing to compare, or one of both is
    /// wrong by a lot.
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
        let news = self.novelty.step([c1, c2], Sample::at_rest(residual));
        let beyond = baseline.map(|baseline| residual - baseline);
        let doubt = doubt * doubt + of_baseline * of_baseline;
        Some(Residual { lengths: [c1, c2], velocity, beyond, doubt, news })
    }
}
