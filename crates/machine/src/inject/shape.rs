//! How and when a fault changes a reading.

use crate::transducer::Grid;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use tertius_core::decode::Raw;
use tertius_core::time::Span;

/// A value that replaces a reading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Code {
    /// Raw number as in the frame.
    Raw(i64),
    /// Value in the signal's unit.
    Physical(f64),
}

/// A fault of a reading. Sizes are in the signal's unit: m for a position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// Type I (5-15): adds `size`.
    Step { size: f64 },
    /// Type II (5-17): adds `size` times a random integer of {−1, 0, 1}, drawn for each frame.
    Noise { size: f64 },
    /// Type III (5-18), (5-19): adds size · (1 − (1 + b)^−(t − t0)), t in **seconds**.
    Incipient { size: f64, b: f64 },
    /// Adds rate · (t − t0); `rate` in the signal's unit per second.
    Drift { rate: f64 },
    /// Adds `gain` times the reading itself.
    Scale { gain: f64 },
    /// Holds the last reading before the fault, to the bit.
    Freeze,
    /// Adds `size` to single frames, each with `probability`.
    Spike { size: f64, probability: f64 },
    /// Replaces the reading with this value: a broken wire's code, or a value out of range.
    Constant(Code),
    /// Repeats the whole payload of the last frame before the fault, its alive counter included.
    Stale,
    /// Drops frames, each with `probability`.
    Loss { probability: f64 },
}

/// Time of a fault after the first frame: `from` inclusive, `until` exclusive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Window {
    pub from: Span,
    /// End of the fault; `None`: the end of the recording.
    pub until: Option<Span>,
}

impl Window {
    /// Time since the fault's beginning, s, if it is active `elapsed` after the first frame.
    pub fn age(&self, elapsed: Span) -> Option<f64> {
        let there = elapsed >= self.from && self.until.is_none_or(|until| elapsed < until);
        let age = elapsed.as_nanos().saturating_sub(self.from.as_nanos());
        there.then(|| Span::from_nanos(age).as_seconds())
    }
}

/// A transducer's reading before it is rounded to counts, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unrounded {
    pub length: f64,
    pub grid: Grid,
}

/// A reading on its way through the faults of its signal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Reading {
    /// Value in the signal's unit.
    pub physical: f64,
    /// Raw number as in a frame; `None` once something was added, as rounding comes last.
    pub raw: Option<Raw>,
    /// Grid to which the transducer rounds before the value is rounded for the frame; `None` where
    /// it is not known, or where the value is no longer the transducer's.
    pub grid: Option<Grid>,
}

impl Reading {
    /// The value as its transducer rounds it, in the signal's unit.
    pub fn rounded(&self) -> f64 {
        self.grid.map_or(self.physical, |grid| grid.nearest(self.physical))
    }
}

impl Shape {
    /// What the fault adds to a reading of `physical` at `age` seconds; `None` if it does not add.
    pub(super) fn addition(self, physical: f64, age: f64, rng: &mut ChaCha8Rng) -> Option<f64> {
        Some(match self {
            Self::Step { size } => size,
            Self::Noise { size } => size * f64::from(rng.random_range(-1_i32..=1)),
            // 1 − (1 + b)^−t without the loss of digits near zero.
            Self::Incipient { size, b } => size * -(-age * b.ln_1p()).exp_m1(),
            Self::Drift { rate } => rate * age,
            Self::Scale { gain } => gain * physical,
            Self::Spike { size, probability } if rng.random_bool(probability) => size,
            Self::Spike { .. } => 0.0,
            Self::Freeze | Self::Constant(_) | Self::Stale | Self::Loss { .. } => return None,
        })
    }
}
