//! Supply pressure and what the rods take, in means over blocks of cycles.

use super::super::flow::block_cycles;
use crate::alarm::status::MAX_CYLINDERS;
use crate::state::{state, whole};

/// A machine in one cycle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OilSample {
    /// P_S, bar.
    pub pressure: f64,
    /// Lengths of all rods, m; 0 where there is none.
    pub lengths: [f64; MAX_CYLINDERS],
}

whole! { OilSample { pressure, lengths } }

/// The supply between the middles of two blocks that follow one another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OilBlock {
    /// P_S at both, bar.
    pub pressures: [f64; 2],
    /// Ways of all rods together, m: out, and in.
    pub ways: [f64; 2],
    /// Whether the block before is the one that begins where this one does.
    pub follows: bool,
}

/// Makes blocks of cycles.
#[derive(Clone, Debug)]
pub struct Oil {
    /// Cycles of a block.
    block: u32,
    /// Sums over the cycles of the block that is not complete.
    open: OilSample,
    cycles: u32,
    /// Means of the newest complete one, and whether there is one before it.
    closed: Option<OilSample>,
    follows: bool,
}

state! {
    Oil { open, cycles, closed, follows }
    but { block }
    sound |it| it.cycles < it.block
}

impl Oil {
    pub fn new(sample_time: f64) -> Self {
        let (block, open) = (block_cycles(sample_time), OilSample::default());
        Self { block, open, cycles: 0, closed: None, follows: false }
    }

    /// Cycles of a block.
    pub const fn block(&self) -> u32 {
        self.block
    }

    /// Whether a block is complete, so that the next one tells how the pressure went on.
    pub const fn is_begun(&self) -> bool {
        self.closed.is_some()
    }

    pub fn reset(&mut self) {
        (self.open, self.cycles) = (OilSample::default(), 0);
        (self.closed, self.follows) = (None, false);
    }

    /// One cycle; `None` without all of it, after which everything begins anew.
    #[inline]
    pub fn step(&mut self, sample: Option<&OilSample>) -> Option<OilBlock> {
        let Some(sample) = sample else {
            self.reset();
            return None;
        };
        self.open.pressure += sample.pressure;
        for (sum, length) in self.open.lengths.iter_mut().zip(sample.lengths) {
            *sum += length;
        }
        self.cycles += 1;
        if self.cycles < self.block { None } else { self.close() }
    }

    fn close(&mut self) -> Option<OilBlock> {
        let share = 1.0 / f64::from(self.block);
        let OilSample { pressure, lengths } = self.open;
        let mean =
            OilSample { pressure: pressure * share, lengths: lengths.map(|length| length * share) };
        (self.open, self.cycles) = (OilSample::default(), 0);
        let is_finite = mean.lengths.iter().all(|length| length.is_finite());
        if !(is_finite && mean.pressure > 0.0 && mean.pressure.is_finite()) {
            self.reset();
            return None;
        }
        let before = self.closed.replace(mean)?;
        let mut ways = [0.0; 2];
        for (to, from) in mean.lengths.iter().zip(before.lengths) {
            let way = to - from;
            ways[usize::from(way < 0.0)] += way.abs();
        }
        let follows = core::mem::replace(&mut self.follows, true);
        Some(OilBlock { pressures: [before.pressure, mean.pressure], ways, follows })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::vec::Vec;

    /// Blocks of rods that go out by 0.1 and in by 0.2 m/s, while the pressure falls by 5 bar/s.
    fn blocks(is_there: impl Fn(u32) -> bool) -> Vec<OilBlock> {
        let mut oil = Oil::new(0.02);
        let sample = |k: u32| {
            let t = 0.02 * f64::from(k);
            let mut lengths = [0.0; MAX_CYLINDERS];
            (lengths[0], lengths[1]) = (0.1 * t, 0.5 - 0.2 * t);
            OilSample { pressure: 230.0 - 5.0 * t, lengths }
        };
        (0..100)
            .filter_map(|k| oil.step(Some(sample(k)).filter(|_| is_there(k)).as_ref()))
            .collect()
    }

    #[test]
    fn ways_and_pressures_are_those_from_middle_to_middle() {
        let blocks = blocks(|_| true);
        assert_eq!(blocks.len(), 9);
        for (number, block) in blocks.iter().enumerate() {
            let middle = 0.02 * (4.5 + 10.0 * number as f64);
            let expected = [0.0, 0.2].map(|later| 230.0 - 5.0 * (middle + later));
            for (found, expected) in block.pressures.iter().zip(expected) {
                assert!((found - expected).abs() < 1e-9, "{block:?}");
            }
            assert!((block.ways[0] - 0.02).abs() < 1e-12, "{block:?}");
            assert!((block.ways[1] - 0.04).abs() < 1e-12, "{block:?}");
            assert_eq!(block.follows, number > 0);
        }
    }

    #[test]
    fn a_cycle_that_is_missing_or_no_number_begins_anew() {
        let parted = blocks(|k| k != 45);
        let follows: Vec<bool> = parted.iter().map(|it| it.follows).collect();
        assert_eq!(follows, [false, true, true, false, true, true, true]);
        let mut oil = Oil::new(0.02);
        let sample = OilSample { pressure: f64::NAN, ..OilSample::default() };
        assert!((0..100).all(|_| oil.step(Some(&sample)).is_none()) && !oil.is_begun());
    }
}
