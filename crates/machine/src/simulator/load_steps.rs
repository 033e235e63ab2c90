//! Loads that change suddenly, as where people walk over the gangway or it slews and stops.

use crate::plant::CYLINDERS;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use serde::Deserialize;

/// Sudden changes of the load of each cylinder, at random.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LoadSteps {
    /// From and until, s after the first cycle.
    pub time: [f64; 2],
    /// Largest change from the usual load, as a part of it.
    pub part: f64,
    /// Mean time from one change to the next, s.
    pub every: f64,
    /// Time that a change takes, s.
    pub within: f64,
}

/// Present loads of the cylinders, as factors of the usual ones.
#[derive(Clone, Debug)]
pub struct SteppedLoads {
    table: LoadSteps,
    rng: ChaCha8Rng,
    loads: [Step; CYLINDERS],
}

/// A change of a load and the time left of it.
#[derive(Clone, Copy, Debug)]
struct Step {
    factor: f64,
    target: f64,
    left: f64,
}

impl SteppedLoads {
    pub fn new(table: LoadSteps, rng: ChaCha8Rng) -> Self {
        Self { table, rng, loads: [Step { factor: 1.0, target: 1.0, left: 0.0 }; CYLINDERS] }
    }

    /// Advances to `time`, s, which is `elapsed` s later than before.
    pub fn advance(&mut self, time: f64, elapsed: f64) {
        let LoadSteps { time: [from, until], part, every, within } = self.table;
        for it in &mut self.loads {
            // Always drawn, so that the times of the others' changes do not depend on it.
            let (begins, target) = (self.rng.random::<f64>(), self.rng.random_range(-1.0..=1.0));
            if !(from..until).contains(&time) {
                if it.target != 1.0 {
                    (it.target, it.left) = (1.0, within.max(elapsed));
                }
            } else if it.left <= 0.0 && begins < elapsed / every {
                (it.target, it.left) = (1.0 + part * target, within.max(elapsed));
            }
            if it.left > elapsed {
                it.factor += (it.target - it.factor) * elapsed / it.left;
                it.left -= elapsed;
            } else if it.left > 0.0 {
                (it.factor, it.left) = (it.target, 0.0);
            }
        }
    }

    /// Factor of the load of cylinder `leg`, from 0.
    pub fn factor(&self, leg: usize) -> f64 {
        self.loads[leg].factor
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;

    #[test]
    fn loads_change_now_and_then_in_the_time_that_a_change_takes() {
        let table = LoadSteps { time: [10.0, 3610.0], part: 0.3, every: 60.0, within: 1.0 };
        let mut loads = SteppedLoads::new(table, ChaCha8Rng::seed_from_u64(7));
        let (mut changes, mut moving, mut last) = (0, false, 1.0);
        for cycle in 0..181_000_u32 {
            let time = f64::from(cycle) * 0.02;
            loads.advance(time, 0.02);
            let factor = loads.factor(2);
            assert!((0.7..=1.3).contains(&factor), "{factor} at {time}");
            assert!((factor - last).abs() <= 0.6 / 50.0 + 1e-12, "{factor} after {last}");
            assert!((10.0..3610.0).contains(&time) || factor == 1.0 || time >= 3610.0);
            changes += u32::from(factor != last && !moving);
            (moving, last) = (factor != last, factor);
        }
        assert!((40..=80).contains(&changes), "{changes} changes in an hour");
        assert!((last - 1.0).abs() < 1e-9, "at the end the load is the usual one: {last}");
    }
}
