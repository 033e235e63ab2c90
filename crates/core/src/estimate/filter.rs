//! The Kalman filter of one transducer, with a time-varying covariance.

use super::dynamics::Dynamics;
use super::mean::Mean;
use crate::state::whole;
use nalgebra::{Matrix3, Vector3};

/// How an innovation is counted.
#[derive(Clone, Copy, Debug)]
pub struct Counted {
    /// As no more than this, as a square by the expected one.
    pub wild: f64,
    /// In a mean over so many.
    pub memory: u32,
}

/// Follows the readings of one transducer.
#[derive(Clone, Debug, Default)]
pub struct Filter {
    x: Vector3<f64>,
    p: Matrix3<f64>,
    running: bool,
    /// Cycles since the newest reading.
    coasted: u32,
    /// Readings since the start.
    seen: u32,
    /// Readings since the command was first known in every cycle.
    followed: u32,
    /// Innovation of the newest reading, m.
    innovation: f64,
    /// Mean of ν² over the value that the filter expects.
    surprise: Mean,
}

whole! { Filter { x, p, running, coasted, seen, followed, innovation, surprise } }

impl Filter {
    /// Stops following the rod; what is known of the transducer stays.
    pub fn stop(&mut self) {
        *self = Self { surprise: self.surprise, ..Self::default() };
    }

    /// Takes the reading of a cycle, m, or that there was none; after more than `max_gap` cycles
    /// without one the filter stops. A sound reading, one with `counted`, updates the measure of the
    /// filter's own accuracy.
    pub fn correct(
        &mut self,
        dynamics: &Dynamics,
        reading: Option<f64>,
        max_gap: u32,
        counted: Option<Counted>,
    ) {
        let Some(reading) = reading else {
            self.coasted = self.coasted.saturating_add(1);
            if self.coasted > max_gap {
                self.stop();
            }
            return;
        };
        if !self.running {
            self.stop();
            self.running = true;
            self.x = Vector3::new(reading, 0.0, 0.0);
            self.p = Matrix3::from_diagonal(&dynamics.unknown);
        }
        let innovation = reading - self.x[0];
        let variance = self.p[(0, 0)] + dynamics.reading;
        if let Some(Counted { wild, memory }) = counted.filter(|_| self.seen > 0) {
            self.surprise.add((innovation * innovation / variance).min(wild), memory);
        }
        self.innovation = innovation;
        let covariances = self.p.column(0).into_owned();
        let gain = covariances / variance;
        self.x += gain * innovation;
        self.p -= gain * covariances.transpose();
        self.coasted = 0;
        self.seen = self.seen.saturating_add(1);
        self.followed = self.followed.saturating_add(1);
    }

    /// Predicts the next cycle with the command's part; without one the rod may move anywhere.
    pub fn predict(&mut self, dynamics: &Dynamics, part: Option<&Vector3<f64>>) {
        if !self.running {
            return;
        }
        match part {
            Some(part) => {
                self.x = dynamics.a * self.x + part;
                let p = dynamics.a * self.p * dynamics.a.transpose();
                self.p = (p + p.transpose()) * 0.5 + Matrix3::from_diagonal(&dynamics.process);
            }
            None => {
                let length = self.p[(0, 0)];
                self.x = Vector3::new(self.x[0], 0.0, 0.0);
                self.p = Matrix3::from_diagonal(&dynamics.unknown);
                self.p[(0, 0)] += length;
                self.followed = 0;
            }
        }
        if !(self.x.iter().chain(self.p.iter()).all(|value| value.is_finite())) {
            self.stop();
        }
    }

    /// State x(k|k).
    pub const fn state(&self) -> &Vector3<f64> {
        &self.x
    }

    /// Variance of the length, m², enlarged by as much as innovations exceed what the filter
    /// expects.
    pub fn variance(&self) -> f64 {
        self.p[(0, 0)].max(0.0) * self.surprise.value().max(1.0)
    }

    /// Innovation of the newest reading, m.
    pub const fn innovation(&self) -> f64 {
        self.innovation
    }

    pub const fn is_running(&self) -> bool {
        self.running
    }

    /// Whether there was a reading in this cycle.
    pub const fn is_fresh(&self) -> bool {
        self.running && self.coasted == 0
    }

    /// Readings since the start, and readings since the command was first known in every cycle.
    pub const fn evidence(&self) -> [u32; 2] {
        [self.seen, self.followed]
    }
}

#[cfg(test)]
mod tests {
    use super::super::parameters::EstimateParameters;
    use super::*;
    use crate::observe::model::{Model, POSITION};
    use crate::observe::riccati;

    const COUNTED: Option<Counted> = Some(Counted { wild: 100.0, memory: 15_000 });

    fn dynamics() -> Dynamics {
        let theta = [-0.0101, -0.1231, -1.6891e-5, -10.7104, -0.0023];
        let model = Model::new(0.02, theta, [0.0926, 6.5427]);
        Dynamics::model(&model, 0.0, [1e-8, 1e-3, 100.0], 1e-8, 0.02, &EstimateParameters::DEFAULT)
    }

    /// The covariance converges to that of the Riccati equation, which is that of the prediction.
    #[test]
    fn with_a_reading_in_every_cycle_its_covariance_is_the_steady_one() {
        let dynamics = dynamics();
        let (mut filter, part) = (Filter::default(), Vector3::zeros());
        for _ in 0..2000 {
            filter.correct(&dynamics, Some(0.3), 5, COUNTED);
            filter.predict(&dynamics, Some(&part));
        }
        let q = [1e-8, 1e-3, 100.0];
        let steady = riccati::solve(&dynamics.a, &POSITION, q, [1e-8]).expect("there is a gain");
        let apart = (filter.p - steady.covariance).component_div(&steady.covariance);
        assert!(apart.iter().all(|part| part.abs() < 1e-6), "{apart}");
    }

    #[test]
    fn without_readings_it_knows_less_and_then_nothing() {
        let dynamics = dynamics();
        let (mut filter, part) = (Filter::default(), Vector3::zeros());
        for _ in 0..100 {
            filter.predict(&dynamics, Some(&part));
            filter.correct(&dynamics, Some(0.3), 5, COUNTED);
        }
        let mut before = filter.variance();
        for _ in 0..5 {
            filter.predict(&dynamics, Some(&part));
            filter.correct(&dynamics, None, 5, COUNTED);
            assert!(filter.is_running() && !filter.is_fresh() && filter.variance() > before);
            before = filter.variance();
        }
        filter.correct(&dynamics, None, 5, COUNTED);
        assert!(!filter.is_running());
    }

    #[test]
    fn where_the_command_is_not_known_it_takes_the_reading() {
        let dynamics = dynamics();
        let mut filter = Filter::default();
        for k in 0..50 {
            filter.correct(&dynamics, Some(0.01 * f64::from(k)), 5, COUNTED);
            assert!((filter.state()[0] - 0.01 * f64::from(k)).abs() < 1e-6);
            filter.predict(&dynamics, None);
        }
        assert_eq!(filter.evidence(), [50, 0]);
    }

    /// Readings that scatter twice as much double the standard deviation.
    #[test]
    fn innovations_that_are_too_large_are_told() {
        let dynamics = dynamics();
        let run = |size: f64| {
            let (mut filter, part) = (Filter::default(), Vector3::zeros());
            for k in 0..4000 {
                let reading = if k % 2 == 0 { size } else { -size };
                filter.correct(&dynamics, Some(reading), 5, COUNTED);
                filter.predict(&dynamics, Some(&part));
            }
            filter.variance().sqrt()
        };
        assert!(run(2e-3) > 1.8 * run(1e-3), "{} {}", run(2e-3), run(1e-3));
    }
}
