//! The observer of one transducer, which predicts the cylinder's length and gives the innovation.

use super::model::{Model, POSITION, POSITION_AND_VELOCITY};
use super::parameters::ObserverParameters;
use super::riccati::{self, RiccatiError};
use crate::state::{choice, state, whole};
use nalgebra::{Matrix2x3, Matrix3, Matrix3x2, Vector3};

/// Fixed parameters of one observer: the model (4-1) and the gain of (5-4).
#[derive(Clone, Debug)]
pub struct ObserverDesign {
    /// State matrix A, 3 × 3, states `[l, l̇, P_L]` in m, m/s, bar.
    pub a: Matrix3<f64>,
    /// Input matrix B, 3 × 1, input l̇_ctrl in m/s.
    pub b: Vector3<f64>,
    /// Gain L, 3 × 2; its second column is zero where no velocity is measured.
    pub l: Matrix3x2<f64>,
    /// Number of cycles to follow readings before judging.
    pub settle: u32,
    /// Number of cycles without a reading that are predicted over.
    pub max_gap: u32,
}

impl ObserverDesign {
    /// The observer of `model` with the diagonal weights `q` and `r` (5-6), which reads position
    /// and, if `velocity`, velocity.
    ///
    /// # Errors
    /// Weights or a model for which the Riccati equation has no gain.
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

    /// A − L C: what is left of an error of the state in the next cycle.
    fn decay(&self) -> Matrix3<f64> {
        let mut c = Matrix2x3::identity();
        c[(1, 1)] = if self.l.column(1).iter().all(|gain| *gain == 0.0) { 0.0 } else { 1.0 };
        self.a - self.l * c
    }

    /// Number of cycles until a missed correction affects the innovation by less than
    /// [`ObserverParameters::recovered`] of its first effect, from the powers of A − L C; at most the time to settle.
    pub fn recovery(&self) -> u32 {
        let decay = self.decay();
        let mut error: Vector3<f64> = self.l.column(0).into();
        let shown = ObserverParameters::DEFAULT.recovered * error[0].abs();
        let mut cycles = 0;
        while cycles < self.settle && error[0].abs() >= shown && error[0] != 0.0 {
            error = decay * error;
            cycles += 1;
        }
        cycles
    }
}

/// A reading that passed the plausibility checks.
#[derive(Clone, Copy, Debug)]
pub struct Measurement {
    /// Length l, m.
    pub position: f64,
    /// Velocity l̇, m/s; where it is absent the velocity is not corrected.
    pub velocity: Option<f64>,
}

/// Prediction and innovation of one cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Innovation {
    /// Predicted length C x̂(k|k−1), m.
    pub estimate: f64,
    /// Innovation y − C x̂ before the correction, m.
    pub residual: f64,
    /// Whether the observer has followed for long enough for the residual to be judged, and one of its latest innovations
    /// was whole: not longer ago than it predicts over a gap.
    pub settled: bool,
    /// Whether nothing that the prediction depends on was missing: neither a command nor a reading
    /// of the last cycles ([`ObserverDesign::recovery`]). Otherwise the residual is that of a longer
    /// prediction, for which the thresholds were not made.
    pub whole: bool,
}

/// Why an observer restarts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Restart {
    /// Readings were missing or implausible for longer than the observer predicts over.
    Gap,
    /// The state was no longer finite.
    Diverged,
    /// Time stamps jumped.
    TimeJump,
    /// The bus was lost.
    Interruption,
}

impl Restart {
    /// Name in files and reports.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Gap => "gap",
            Self::Diverged => "diverged",
            Self::TimeJump => "time_jump",
            Self::Interruption => "interruption",
        }
    }
}

choice! { Restart { Gap, Diverged, TimeJump, Interruption } }

/// State `[l, l̇, P_L]` of an observer that some readings have not corrected, because they may be wild.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Uncorrected {
    x: [f64; 3],
}

whole! { Uncorrected { x } }

impl Uncorrected {
    /// Predicted length, m.
    pub const fn length(&self) -> f64 {
        self.x[0]
    }
}

/// An observer with its state.
#[derive(Clone, Debug)]
pub struct Observer {
    design: ObserverDesign,
    x: [f64; 3],
    /// Last known command, m/s.
    u: f64,
    followed: u32,
    coasted: u32,
    /// Number of cycles until the innovations are whole again, see [`Innovation::whole`].
    recovering: u32,
    recovery: u32,
    /// [`Self::followed`] at the newest whole innovation, where the newest one is not whole.
    torn: u32,
    running: bool,
    stopped_by: Option<Restart>,
}

state! {
    Observer { x, u, followed, coasted, recovering, torn, running, stopped_by }
    but { design, recovery }
    sound |it| it.coasted <= it.design.max_gap.saturating_add(1)
}

impl Observer {
    pub fn new(design: ObserverDesign) -> Self {
        Self {
            recovery: design.recovery(),
            recovering: 0,
            torn: 0,
            design,
            x: [0.0; 3],
            u: 0.0,
            followed: 0,
            coasted: 0,
            running: false,
            stopped_by: None,
        }
    }

    /// Takes one cycle: the innovation of `measurement`, then the step to the next cycle by (5-4).
    ///
    /// `command` is u(k) of the same cycle, m/s; the last one is held where it is absent. Without a
    /// measurement the model alone predicts. The first measurement after a stop sets the state, and
    /// the second return value is then the reason of the stop.
    #[inline(always)]
    pub fn step(
        &mut self,
        measurement: Option<Measurement>,
        command: Option<f64>,
    ) -> (Option<Innovation>, Option<Restart>) {
        self.u = command.unwrap_or(self.u);
        let lost = measurement.is_none() || command.is_none();
        let stepped = match (measurement, self.running) {
            (Some(measurement), true) => (Some(self.follow(measurement)), None),
            (Some(measurement), false) => (Some(self.start(measurement)), self.stopped_by.take()),
            (None, true) => {
                self.coast();
                (None, None)
            }
            (None, false) => (None, None),
        };
        if lost {
            self.lose();
        } else {
            self.recovering = self.recovering.saturating_sub(1);
        }
        stepped
    }

    /// Takes that the measurement or the command of a cycle was missing.
    #[cold]
    #[inline(never)]
    const fn lose(&mut self) {
        if self.recovering == 0 {
            self.torn = self.followed;
        }
        self.recovering = self.recovery;
    }

    /// Number of readings that it has followed since it started.
    pub const fn followed(&self) -> u32 {
        self.followed
    }

    /// The state as if the position of the newest reading, off by `residual`, m, had not corrected it.
    pub fn uncorrected(&self, residual: f64) -> Uncorrected {
        let gain = self.design.l.column(0);
        Uncorrected { x: core::array::from_fn(|i| self.x[i] - gain[i] * residual) }
    }

    /// Goes on from a state without the readings that were wild, with this reading of the newest cycle.
    pub fn resume(&mut self, from: Uncorrected, y: Measurement) -> Innovation {
        self.x = from.x;
        self.followed = self.followed.saturating_sub(1);
        self.follow(y)
    }

    /// The state as if the position of the reading before the newest one, off by `former`, m, had not corrected it, and what
    /// is then left of the newest `residual`, m.
    pub fn without_former(&self, former: f64, residual: f64) -> (Uncorrected, f64) {
        let left = self.design.l.column(0) * former;
        let moved = self.design.decay() * left;
        (Uncorrected { x: core::array::from_fn(|i| self.x[i] - moved[i]) }, residual + left[0])
    }

    /// Goes on from a state without a reading that was wild.
    pub const fn take_over(&mut self, from: Uncorrected) {
        self.x = from.x;
    }

    /// What follows in the next cycle from a state that no position corrects.
    pub fn go_on(&self, from: Uncorrected, velocity: Option<f64>) -> Uncorrected {
        let x = self.advanced(from.x, [0.0, velocity.map_or(0.0, |it| it - from.x[1])]);
        Uncorrected { x }
    }

    /// Stops the observer; the next measurement restarts it and reports `reason`.
    pub fn stop(&mut self, reason: Restart) {
        if self.running {
            self.running = false;
            self.stopped_by = Some(reason);
        }
    }

    #[cold]
    fn start(&mut self, y: Measurement) -> Innovation {
        self.x = [y.position, y.velocity.unwrap_or(0.0), 0.0];
        self.running = true;
        (self.followed, self.torn) = (0, 0);
        self.follow(y)
    }

    #[inline(always)]
    fn follow(&mut self, y: Measurement) -> Innovation {
        let estimate = self.x[0];
        let residual = y.position - estimate;
        let velocity = y.velocity.map_or(0.0, |velocity| velocity - self.x[1]);
        let whole = self.recovering == 0;
        let settled = (whole || self.was_whole_lately()) && self.followed >= self.design.settle;
        self.followed = self.followed.saturating_add(1);
        self.coasted = 0;
        self.predict([residual, velocity]);
        Innovation { estimate, residual, settled, whole }
    }

    /// Whether an innovation was whole not longer ago than it predicts over a gap.
    #[cold]
    const fn was_whole_lately(&self) -> bool {
        self.followed.saturating_sub(self.torn) < self.design.max_gap
    }

    #[cold]
    fn coast(&mut self) {
        self.coasted += 1;
        if self.coasted > self.design.max_gap {
            self.stop(Restart::Gap);
        } else {
            self.predict([0.0; 2]);
        }
    }

    /// A x + B u + L ν (5-4), row by row; the sums are taken in the order of nalgebra's products.
    #[inline(always)]
    fn advanced(&self, x: [f64; 3], v: [f64; 2]) -> [f64; 3] {
        let ObserverDesign { a, b, l, .. } = &self.design;
        core::array::from_fn(|i| {
            let free = a[(i, 0)] * x[0] + a[(i, 1)] * x[1] + a[(i, 2)] * x[2];
            free + b[i] * self.u + (l[(i, 0)] * v[0] + l[(i, 1)] * v[1])
        })
    }

    /// Steps to the next cycle.
    #[inline(always)]
    fn predict(&mut self, innovation: [f64; 2]) {
        self.x = self.advanced(self.x, innovation);
        // A finite number times zero is zero, all else is no number: one question for all three.
        let nothing = self.x[0] * 0.0 + self.x[1] * 0.0 + self.x[2] * 0.0;
        if nothing.is_nan() {
            self.stop(Restart::Diverged);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::vec::Vec;

    /// An integrator of the command, whose error of the position goes on by −½ in each cycle.
    fn observer() -> Observer {
        Observer::new(ObserverDesign {
            a: Matrix3::identity(),
            b: Vector3::new(0.02, 0.0, 0.0),
            l: Matrix3x2::new(1.5, 0.0, 0.0, 0.0, 0.0, 0.0),
            settle: 6,
            max_gap: 2,
        })
    }

    const READ: Option<Measurement> = Some(Measurement { position: 0.5, velocity: None });

    fn follow(observer: &mut Observer, cycles: usize) -> Vec<Innovation> {
        (0..cycles).map(|_| observer.step(READ, Some(0.0)).0.expect("it was read")).collect()
    }

    /// 1, −½, ¼, −⅛, 1/16: the fifth is less than a tenth.
    #[test]
    fn what_lacks_a_command_or_a_reading_is_not_whole_until_its_effect_is_gone() {
        for (measurement, command) in [(READ, None), (None, Some(0.0)), (None, None)] {
            let mut observer = observer();
            let first = follow(&mut observer, 8);
            assert!(first.iter().all(|it| it.whole && it.residual == 0.0));
            assert_eq!(first.iter().filter(|it| it.settled).count(), 2);
            // What was predicted for this cycle lacked nothing.
            let lost = observer.step(measurement, command).0;
            assert_eq!(lost.map(|it| it.whole), measurement.map(|_| true));
            let whole: Vec<bool> = follow(&mut observer, 6).iter().map(|it| it.whole).collect();
            assert_eq!(whole, [false, false, false, false, true, true]);
        }
    }

    /// A command in every fifth cycle is none that a residual can be judged by.
    #[test]
    fn an_observer_that_always_lacks_something_does_not_judge() {
        let mut observer = observer();
        follow(&mut observer, 8);
        let mut step = |k: u32| {
            let command = k.is_multiple_of(5).then_some(0.0);
            observer.step(READ, command).0.expect("it was read").settled
        };
        let settled: Vec<bool> = (1..12).map(&mut step).collect();
        assert_eq!(
            settled[..3],
            [true; 3],
            "the first one lacked nothing, and two are predicted over"
        );
        assert_eq!(settled[3..], [false; 8]);
        assert!(!follow(&mut observer, 4).iter().any(|it| it.settled));
        assert!(follow(&mut observer, 3)[2].settled);
    }

    #[test]
    fn without_readings_it_goes_on_by_the_last_command_and_then_stops() {
        let mut observer = observer();
        follow(&mut observer, 1);
        assert_eq!(observer.step(READ, Some(0.1)).0.map(|it| it.estimate), Some(0.5));
        let coasted = observer.step(None, None);
        assert_eq!(coasted, (None, None));
        // By 0.02 m for each m/s of the command, with a reading, without one, and without both.
        let (found, restart) = observer.step(READ, Some(0.0));
        let found = found.expect("it was read");
        assert!((found.estimate - 0.504).abs() < 1e-12, "{found:?}");
        assert!((found.residual + 0.004).abs() < 1e-12, "{found:?}");
        assert_eq!(restart, None);
        // Two cycles are predicted over, three are not.
        for (missing, expected) in [(2, None), (3, Some(Restart::Gap)), (9, Some(Restart::Gap))] {
            (0..missing).for_each(|_| _ = observer.step(None, Some(0.0)));
            let (found, restart) = observer.step(READ, Some(0.0));
            assert_eq!(restart, expected, "{missing}");
            assert!(
                expected.is_none() || found.is_some_and(|it| it.residual == 0.0 && !it.settled)
            );
        }
    }
}
