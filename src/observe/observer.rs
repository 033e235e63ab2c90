//! The observer of one transducer: predicts the cylinder's length and gives the innovation.

use super::model::{Model, POSITION, POSITION_AND_VELOCITY};
use super::riccati::{self, RiccatiError};
use nalgebra::{Matrix3, Matrix3x2, Vector2, Vector3};

/// What one observer runs on, fixed for its life: the model (4-1) and the gain of (5-4).
#[derive(Clone, Debug)]
pub struct Design {
    /// A, 3 × 3, states `[l, l̇, P_L]` in m, m/s, bar.
    pub a: Matrix3<f64>,
    /// B, 3 × 1, input l̇_ctrl in m/s.
    pub b: Vector3<f64>,
    /// L, 3 × 2; its second column is zero where no velocity is measured.
    pub l: Matrix3x2<f64>,
    /// Cycles to follow readings before judging.
    pub settle: u32,
    /// Cycles without a reading that are predicted over.
    pub max_gap: u32,
}

impl Design {
    /// The observer of `model` with the diagonal weights `q` and `r` (5-6), which reads position
    /// and, if `velocity`, velocity.
    ///
    /// # Errors
    /// Weights or models for which the Riccati equation has no gain.
    pub fn new(
        model: &Model,
        q: [f64; 3],
        r: [f64; 2],
        velocity: bool,
        settle: u32,
        max_gap: u32,
    ) -> Result<Self, RiccatiError> {
        let l = if velocity {
            riccati::solve(&model.a, &POSITION_AND_VELOCITY, q, r)?.gain
        } else {
            let gain = riccati::solve(&model.a, &POSITION, q, [r[0]])?.gain;
            Matrix3x2::from_columns(&[gain, Vector3::zeros()])
        };
        Ok(Self { a: model.a, b: model.b, l, settle, max_gap })
    }
}

/// A reading that passed the plausibility checks.
#[derive(Clone, Copy, Debug)]
pub struct Measurement {
    /// l, m.
    pub position: f64,
    /// l̇, m/s; where it is absent the velocity is not corrected.
    pub velocity: Option<f64>,
}

/// Prediction and innovation of one cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Innovation {
    /// C x̂(k|k−1), the predicted length, m.
    pub estimate: f64,
    /// y − C x̂ before the correction, m.
    pub residual: f64,
    /// The observer has followed long enough for the residual to be judged.
    pub settled: bool,
}

/// Why an observer starts anew.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Restart {
    /// Readings were missing or implausible for longer than it predicts over.
    Gap,
    /// Its state left the finite numbers.
    Diverged,
    /// Time stamps jumped.
    TimeJump,
    /// The bus was lost.
    Interruption,
}

/// The observer's state.
#[derive(Clone, Debug)]
pub struct Observer {
    design: Design,
    x: Vector3<f64>,
    /// Last known command, m/s.
    u: f64,
    followed: u32,
    coasted: u32,
    running: bool,
    stopped_by: Option<Restart>,
}

impl Observer {
    pub fn new(design: Design) -> Self {
        Self {
            design,
            x: Vector3::zeros(),
            u: 0.0,
            followed: 0,
            coasted: 0,
            running: false,
            stopped_by: None,
        }
    }

    /// One cycle: the innovation of `measurement`, then the step to the next cycle by (5-4).
    ///
    /// `command` is u(k) of the same cycle, m/s; the last one is held where it is absent. Without a
    /// measurement the model alone predicts. The first measurement after a stop sets the state, and
    /// the second value then says why it had stopped.
    pub fn step(
        &mut self,
        measurement: Option<Measurement>,
        command: Option<f64>,
    ) -> (Option<Innovation>, Option<Restart>) {
        self.u = command.unwrap_or(self.u);
        match (measurement, self.running) {
            (Some(measurement), true) => (Some(self.follow(measurement)), None),
            (Some(measurement), false) => (Some(self.start(measurement)), self.stopped_by.take()),
            (None, true) => {
                self.coast();
                (None, None)
            }
            (None, false) => (None, None),
        }
    }

    /// Stops; the next measurement starts it anew and names `reason`.
    pub fn stop(&mut self, reason: Restart) {
        if self.running {
            self.running = false;
            self.stopped_by = Some(reason);
        }
    }

    fn start(&mut self, y: Measurement) -> Innovation {
        self.x = Vector3::new(y.position, y.velocity.unwrap_or(0.0), 0.0);
        self.running = true;
        self.followed = 0;
        self.follow(y)
    }

    fn follow(&mut self, y: Measurement) -> Innovation {
        let estimate = self.x[0];
        let residual = y.position - estimate;
        let velocity = y.velocity.map_or(0.0, |velocity| velocity - self.x[1]);
        let settled = self.followed >= self.design.settle;
        self.followed = self.followed.saturating_add(1);
        self.coasted = 0;
        self.predict(Vector2::new(residual, velocity));
        Innovation { estimate, residual, settled }
    }

    fn coast(&mut self) {
        self.coasted += 1;
        if self.coasted > self.design.max_gap {
            self.stop(Restart::Gap);
        } else {
            self.predict(Vector2::zeros());
        }
    }

    fn predict(&mut self, innovation: Vector2<f64>) {
        let Design { a, b, l, .. } = &self.design;
        self.x = a * self.x + b * self.u + l * innovation;
        if !self.x.iter().all(|value| value.is_finite()) {
            self.stop(Restart::Diverged);
        }
    }
}
