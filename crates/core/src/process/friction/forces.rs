//! Pressures and movements of a rod in means over blocks of cycles, without what is slow.

use super::super::flow::block_cycles;
use super::super::parameters::ProcessParameters;
use crate::state::{state, whole};

const P: &ProcessParameters = &ProcessParameters::DEFAULT;

/// Number of terms that a load pressure is made of: l, v̇, v and tanh(v/v₀).
pub const FORCE_TERMS: usize = 4;

/// A rod in one cycle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ForceSample {
    /// Mean of both transducers, m.
    pub length: f64,
    /// P_L, bar.
    pub load: f64,
}

whole! { ForceSample { length, load } }

/// A block without what is slow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ForceBlock {
    /// Mean of P_L, bar.
    pub load: f64,
    /// l, m, v̇, m/s², v, m/s, and tanh(v/v₀).
    pub terms: [f64; FORCE_TERMS],
}

/// Values that a slow part is known of: P_L and the terms.
const VALUES: usize = FORCE_TERMS + 1;

/// Makes blocks of cycles.
#[derive(Clone, Debug)]
pub struct Forces {
    sample_time: f64,
    /// Cycles of a block.
    block: u32,
    /// Part of a value that the slow one moves by in a block.
    share: f64,
    /// Blocks until the slow parts are those of the present.
    settling: u32,
    /// The block that is not complete.
    open: Option<OpenForces>,
    /// The newest complete one, whose acceleration follows from the next, and the speed of the one before it.
    closed: Option<ClosedForces>,
    before: Option<f64>,
    slow: [f64; VALUES],
    /// Blocks that the slow parts have seen.
    seen: u32,
}

state! {
    Forces { open, closed, before, slow, seen }
    but { sample_time, block, share, settling }
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct OpenForces {
    /// Length at its begin, m.
    first: f64,
    /// Sum of P_L, bar.
    load: f64,
    cycles: u32,
}

whole! { OpenForces { first, load, cycles } }

/// Means over a complete block.
#[derive(Clone, Copy, Debug, PartialEq)]
struct ClosedForces {
    load: f64,
    length: f64,
    speed: f64,
}

whole! { ClosedForces { load, length, speed } }

impl Forces {
    pub fn new(sample_time: f64) -> Self {
        let block = block_cycles(sample_time);
        let seconds = f64::from(block) * sample_time;
        Self {
            sample_time,
            block,
            share: (seconds / P.friction_slow).min(1.0),
            settling: libm::ceil(P.friction_settling / seconds) as u32,
            open: None,
            closed: None,
            before: None,
            slow: [0.0; VALUES],
            seen: 0,
        }
    }

    /// Cycles of a block.
    pub const fn block(&self) -> u32 {
        self.block
    }

    /// Whether blocks are given.
    pub const fn is_settled(&self) -> bool {
        self.seen >= self.settling
    }

    pub const fn reset(&mut self) {
        (self.open, self.closed, self.before, self.seen) = (None, None, None, 0);
    }

    /// One cycle; `None` without all of it, after which everything begins anew. Returns the block before the one that
    /// is completed.
    #[inline]
    pub fn step(&mut self, sample: Option<ForceSample>) -> Option<ForceBlock> {
        let Some(sample) = sample else {
            self.reset();
            return None;
        };
        let Some(open) = &mut self.open else {
            self.open = Some(OpenForces { first: sample.length, load: 0.0, cycles: 0 });
            return None;
        };
        open.load += sample.load;
        open.cycles = open.cycles.saturating_add(1);
        if open.cycles < self.block { None } else { self.close(sample.length) }
    }

    /// Completes the open block, which ends at this length.
    fn close(&mut self, length: f64) -> Option<ForceBlock> {
        let open = self.open.replace(OpenForces { first: length, load: 0.0, cycles: 0 })?;
        let cycles = f64::from(open.cycles);
        let time = cycles * self.sample_time;
        let next = ClosedForces {
            // P_L of the block's end counts in full and that of its begin not at all: half a cycle late.
            load: open.load / cycles,
            length: 0.5 * (open.first + length),
            speed: (length - open.first) / time,
        };
        let block = self.closed.replace(next)?;
        let before = self.before.replace(block.speed)?;
        let acceleration = (next.speed - before) / (2.0 * time);
        let direction = libm::tanh(block.speed / P.friction_speed);
        self.fast([block.load, block.length, acceleration, block.speed, direction])
    }

    /// Values without their slow parts, once these are known.
    fn fast(&mut self, values: [f64; VALUES]) -> Option<ForceBlock> {
        if !values.iter().all(|it| it.is_finite()) {
            self.reset();
            return None;
        }
        if self.seen == 0 {
            self.slow = values;
        }
        let mut fast = [0.0; VALUES];
        for ((fast, slow), value) in fast.iter_mut().zip(&mut self.slow).zip(values) {
            *fast = value - *slow;
            *slow += self.share * *fast;
        }
        let is_settled = self.is_settled();
        self.seen = self.seen.saturating_add(1);
        let [load, terms @ ..] = fast;
        is_settled.then_some(ForceBlock { load, terms })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::vec::Vec;

    fn blocks(samples: impl Iterator<Item = Option<ForceSample>>) -> Vec<ForceBlock> {
        let mut forces = Forces::new(0.02);
        samples.filter_map(|sample| forces.step(sample)).collect()
    }

    /// A rod that swings by half a metre in 8 s, with a load of these four and a slow one.
    fn swinging(k: u32) -> ForceSample {
        let (t, w) = (0.02 * f64::from(k), 2.0 * core::f64::consts::PI / 8.0);
        // P_L counts from a cycle to the next, so that it is that of its middle.
        let of = |t: f64| [libm::sin(w * t), w * libm::cos(w * t)].map(|it| 0.5 * it);
        let ([length, _], [at, speed]) = (of(t), of(t - 0.01));
        let by = [2.0, -w * w * at * 5.0, 20.0 * speed, 1.5 * libm::tanh(speed / 0.01)];
        let load = 24.0 + 0.01 * t + by[0] * at + by[1] + by[2] + by[3];
        ForceSample { length, load }
    }

    #[test]
    fn a_block_has_the_terms_that_its_pressure_is_made_of() {
        let blocks = blocks((0..3000).map(|k| Some(swinging(k))));
        assert!(blocks.len() > 200, "{}", blocks.len());
        let error = |block: &ForceBlock| {
            let of = [2.0, 5.0, 20.0, 1.5];
            let expected: f64 = block.terms.iter().zip(of).map(|(term, of)| term * of).sum();
            (block.load - expected).abs()
        };
        let mut errors: Vec<f64> = blocks.iter().map(error).collect();
        errors.sort_unstable_by(f64::total_cmp);
        // What is slow is nearly gone: 0.01 bar/s over three seconds. Where the rod turns round, tanh bends within the block.
        let [usual, largest] = [errors.len() * 8 / 10, errors.len() - 1].map(|at| errors[at]);
        assert!(usual < 0.08 && largest < 0.7, "{usual} {largest}");
    }

    #[test]
    fn nothing_is_said_over_a_gap_until_the_slow_parts_are_known_again() {
        let whole = blocks((0..3000).map(|k| Some(swinging(k)))).len();
        let parted = blocks((0..3000).map(|k| (k != 1500).then(|| swinging(k)))).len();
        let settling = libm::ceil(P.friction_settling / 0.2) as usize;
        assert!((whole - parted).abs_diff(settling + 2) <= 1, "{whole} {parted}");
        assert_eq!(blocks((0..3000).map(|k| (k % 200 != 0).then(|| swinging(k)))), []);
    }

    #[test]
    fn what_is_no_number_is_no_block_and_spoils_none() {
        let spoilt = |k| ForceSample { load: if k == 1500 { f64::NAN } else { 0.0 }, length: 0.0 };
        let blocks = blocks((0..3000).map(|k| Some(spoilt(k))));
        assert!(blocks.len() > 100);
        assert!(blocks.iter().all(|block| block.load == 0.0), "{blocks:?}");
    }
}
