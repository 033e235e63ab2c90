//! Machines that differ from the plant: by the spools of their valves, or by load and friction.

use super::grade::Grade;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use serde::Serialize;
use tertius_machine::simulator::Change;

/// Transducers, and the time constant of the spools, s.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ProcessMachine {
    pub grade: Grade,
    pub lag: f64,
}

/// Time constant of the spools of fast servo-valves, s, which are tried beside the plant's own.
const FAST: f64 = 0.01;

impl ProcessMachine {
    /// Machines of every grade, with spools of the time constant `lag`, s, and with fast ones.
    pub(super) fn all(lag: f64) -> Vec<Self> {
        let of = |grade| [lag, FAST].map(|lag| Self { grade, lag });
        Grade::ALL.into_iter().flat_map(of).collect()
    }
}

/// Loads and friction of healthy machines, as factors of the usual.
const LOADS: [f64; 2] = [0.7, 1.3];
const FRICTIONS: [f64; 2] = [1.0, 1.1];

/// The load of a healthy machine, and the factor of its friction.
pub(super) fn varied(rng: &mut ChaCha8Rng) -> (Change, f64) {
    let part = rng.random_range(LOADS[0]..LOADS[1]);
    let friction = rng.random_range(FRICTIONS[0]..FRICTIONS[1]);
    (Change { time: [0.0, 1e9], part }, friction)
}
