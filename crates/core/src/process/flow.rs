//! How far the oil that passes the valve should move the rod.
//!
//! ΔC = Ts Σ f(x̄) √((P_S ∓ P̄_L)/210 bar) + c₁ Ts Σ P̄_L + c₂ ΔP_L over a block of cycles: (3-8) with the flow (3-7), f
//! being learnt, c₁ = −β/α and c₂ = −1/α. What is left of C1 and of the corrected C2 beside it is laid on the
//! directions in which faults move a rod: leakage, a valve whose null has moved, a wider dead band, worn edges.

pub mod directions;
pub mod evidence;
pub mod passage;
mod side;
mod watch;

use super::curve::Curve;
use super::parameters::{DIRECTIONS, ProcessParameters};
use crate::state::{state, whole};
use crate::time;
use alloc::vec::Vec;
use directions::{Along, Direction, LEAKAGE_LOAD};
pub use evidence::{FlowKind, FlowWeighing, FlowWindows};
pub use passage::{FlowSample, Passage};
pub use side::FlowSide;
pub use watch::FlowWatch;

/// What is known of a valve and its cylinder.
#[derive(Clone, Debug, PartialEq)]
pub struct FlowDesign {
    /// Position of the spool at the outermost knots, in the unit of its signal.
    pub limit: f64,
    /// f: the piston's speed by the spool's position, m/s.
    pub curve: Curve,
    /// Whether positions in each piece of f were taught.
    pub taught: Vec<bool>,
    /// ρ: where between its positions at two cycles the spool is in the mean.
    pub between: f64,
    /// c₁, m/s per bar, and c₂, m per bar.
    pub leakage: f64,
    pub compression: f64,
    /// α of (3-5).
    pub area_ratio: f64,
    /// Least and largest P_S that were taught, bar.
    pub supplies: [f64; 2],
    /// Ω for C1 and for C2: the long-run covariance of a block's residual times its directions.
    pub scatter: [[[f64; DIRECTIONS]; DIRECTIONS]; 2],
}

impl FlowDesign {
    /// Which pieces are taught by so many `samples` in each: those of which the neighbours are, too, since a knot with
    /// few samples beyond it may be anywhere.
    pub fn taught(samples: &[u64]) -> Vec<bool> {
        let enough = |index: Option<usize>| {
            let count = index.and_then(|index| samples.get(index));
            count.is_some_and(|count| *count >= ProcessParameters::DEFAULT.flow_samples)
        };
        let piece = |i: usize| enough(Some(i)) && enough(i.checked_sub(1)) && enough(Some(i + 1));
        (0..samples.len()).map(piece).collect()
    }

    /// Whether f was taught at about this P_S, bar.
    pub fn knows(&self, supply: f64) -> bool {
        let ([lowest, highest], beyond) = (self.supplies, ProcessParameters::DEFAULT.flow_untaught);
        supply >= lowest * (1.0 - beyond) && supply <= highest * (1.0 + beyond)
    }

    /// Mean slope of f, m/s per unit of the spool's position.
    pub fn slope(&self) -> f64 {
        let values = self.curve.values();
        let rise = values.last().zip(values.first()).map_or(0.0, |(last, first)| last - first);
        rise / (2.0 * self.limit)
    }
}

/// What is left of the rod's way over a block of cycles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlowBlock {
    /// By C1 and by the corrected C2, m.
    pub left: [f64; 2],
    /// The way that a fault of size 1 adds, of each direction.
    pub directions: [f64; DIRECTIONS],
    /// By how much C1 has moved away from C2, m, where it is known.
    pub parted: Option<f64>,
}

/// The balance of oil and rod.
#[derive(Clone, Debug)]
pub struct Flow {
    design: FlowDesign,
    slope: f64,
    sample_time: f64,
    /// Cycles of a block.
    block: u32,
    /// `None` until a cycle is known.
    open: Option<OpenBlock>,
    /// Speed at which the oil has moved the rod since the cycle before, m/s; `None` where that was not taught.
    speed: Option<f64>,
}

/// Directions that add up cycle by cycle; the last one is of a whole block.
const BY_CYCLE: usize = DIRECTIONS - 1;

state! {
    Flow { open, speed }
    but { design, slope, sample_time, block }
}

/// A block that is not complete.
#[derive(Clone, Copy, Debug, PartialEq)]
struct OpenBlock {
    first: FlowSample,
    /// The newest cycle.
    last: FlowSample,
    /// Sums of the speeds along each of them, m/s.
    speeds: [f64; BY_CYCLE],
    cycles: u32,
    is_taught: bool,
}

whole! { OpenBlock { first, last, speeds, cycles, is_taught } }

impl OpenBlock {
    const fn new(first: FlowSample) -> Self {
        Self { first, last: first, speeds: [0.0; BY_CYCLE], cycles: 0, is_taught: true }
    }
}

impl Flow {
    pub fn new(design: FlowDesign, sample_time: f64) -> Self {
        let block = block_cycles(sample_time);
        Self { slope: design.slope(), design, sample_time, block, open: None, speed: None }
    }

    pub const fn design(&self) -> &FlowDesign {
        &self.design
    }

    /// Cycles of a block.
    pub const fn block(&self) -> u32 {
        self.block
    }

    pub const fn reset(&mut self) {
        self.open = None;
        self.speed = None;
    }

    /// How fast the oil has moved the rod since the cycle before, m/s; `None` where that was not taught.
    pub const fn speed(&self) -> Option<f64> {
        self.speed
    }

    /// Whether the newest cycle was known, at a position that was taught.
    pub fn is_judging(&self) -> bool {
        self.open.as_ref().is_some_and(|open| open.is_taught && open.last.lengths.is_some())
    }

    /// One cycle; `None` without its oil. That, or a length that is missing, ends the block. Returns a block when it is
    /// complete.
    #[inline(always)]
    pub fn step(&mut self, sample: Option<FlowSample>) -> Option<FlowBlock> {
        let Some(sample) = sample else {
            self.reset();
            return None;
        };
        let Some(open) = &mut self.open else {
            self.open = Some(OpenBlock::new(sample));
            self.speed = None;
            return None;
        };
        let design = &self.design;
        let passage = Passage::of(&open.last, &sample, design.between);
        let pressed = sample.load - open.last.load;
        open.last = sample;
        let at = design.curve.place(passage.position);
        let along = Along::new(&design.curve, self.slope, &passage, at);
        let is_taught = passage.position.abs() <= design.limit && design.taught[at.0];
        let by_load =
            design.leakage * passage.load + design.compression * pressed / self.sample_time;
        self.speed = is_taught.then_some(along.speed + by_load);
        if open.first.lengths.is_none() || sample.lengths.is_none() {
            *open = OpenBlock::new(sample);
            return None;
        }
        open.is_taught &= is_taught;
        for (sum, speed) in open.speeds.iter_mut().zip(along.speeds()) {
            *sum += speed;
        }
        open.cycles = open.cycles.saturating_add(1);
        if open.cycles < self.block {
            return None;
        }
        self.close()
    }

    /// Ends the open block and begins the next one.
    #[inline(never)]
    fn close(&mut self) -> Option<FlowBlock> {
        let open = self.open.as_mut()?;
        let full = core::mem::replace(open, OpenBlock::new(open.last));
        if full.is_taught { full.close(&self.design, self.sample_time) } else { None }
    }
}

impl OpenBlock {
    /// The block, which ends with its newest cycle; `None` where a length is missing at either end.
    fn close(self, design: &FlowDesign, sample_time: f64) -> Option<FlowBlock> {
        let Self { first, last, .. } = self;
        let (from, to) = (first.lengths?, last.lengths?);
        let pressed = last.load - first.load;
        let mut directions = [pressed; DIRECTIONS];
        for (way, speeds) in directions.iter_mut().zip(self.speeds) {
            *way = sample_time * speeds;
        }
        // The way by f, what leaks, and what is pressed together.
        let leaked = -LEAKAGE_LOAD * directions[Direction::Leakage as usize];
        let by_oil = directions[Direction::Gain as usize];
        let way = by_oil + design.leakage * leaked + design.compression * pressed;
        let left = core::array::from_fn(|i| to[i] - from[i] - way);
        let parted = last.apart.zip(first.apart).map(|(now, before)| now - before);
        Some(FlowBlock { left, directions, parted })
    }
}

/// Cycles of a block at this sample time, s.
pub fn block_cycles(sample_time: f64) -> u32 {
    time::samples(ProcessParameters::DEFAULT.flow_block, sample_time)
}

/// h of the flow, nats, where `level` is that of a relation with a sample a cycle: blocks come more rarely, and as much
/// rarer are their false alarms.
pub fn level(level: f64, sample_time: f64) -> f64 {
    level - libm::log(f64::from(block_cycles(sample_time)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn design() -> FlowDesign {
        FlowDesign {
            limit: 50.0,
            curve: Curve::new(50.0, alloc::vec![-0.5, 0.0, 0.5]),
            taught: alloc::vec![true, false],
            between: 0.5,
            leakage: -1e-4,
            compression: -2e-4,
            area_ratio: 0.5,
            supplies: [200.0, 240.0],
            scatter: [[[0.0; DIRECTIONS]; DIRECTIONS]; 2],
        }
    }

    /// A rod that goes in at 0.1 m/s, but for what leaks and what is pressed together.
    fn sample(k: i32, length: f64) -> FlowSample {
        let load = 10.0 + f64::from(k);
        FlowSample {
            lengths: Some([length, length + 0.002 * f64::from(k)]),
            spool: -10.0,
            load,
            supply: 210.0 + load,
            apart: None,
        }
    }

    #[test]
    fn what_the_oil_explains_is_not_left() {
        let (mut flow, mut before) = (Flow::new(design(), 0.02), 0.0);
        let blocks: Vec<FlowBlock> = (0..32)
            .filter_map(|k| {
                // Its way in is by P_S + P_L, which grows by 2 bar a cycle here.
                let root: f64 =
                    (0..k).map(|k| libm::sqrt((231.0 + 2.0 * f64::from(k)) / 210.0)).sum();
                let leaks: f64 = (0..k).map(|k| -1e-4 * 0.02 * (10.5 + f64::from(k))).sum();
                let length = 0.02 * -0.1 * root + leaks - 2e-4 * f64::from(k);
                let block = flow.step(Some(sample(k, length)));
                let by_oil = flow.speed().map(|speed| 0.02 * speed);
                assert!(by_oil.is_none_or(|way| (length - before - way).abs() < 1e-12), "{k}");
                assert_eq!(by_oil.is_none(), k == 0);
                before = length;
                block
            })
            .collect();
        assert_eq!(blocks.len(), 3);
        for block in blocks {
            assert!(block.left[0].abs() < 1e-12, "{block:?}");
            assert!((block.left[1] - 0.02).abs() < 1e-12, "{block:?}");
        }
    }

    #[test]
    fn a_piece_is_taught_where_its_knots_are() {
        let taught = FlowDesign::taught(&[500, 400, 400, 600, 399, 900]);
        assert_eq!(taught, [false, true, true, false, false, false]);
    }

    /// Where no reading is, the oil still gives the speed.
    #[test]
    fn the_speed_is_that_of_positions_that_were_taught_whatever_is_read() {
        let mut flow = Flow::new(design(), 0.02);
        for (spool, is_taught) in [(-10.0, true), (10.0, false), (-60.0, false)] {
            for lengths in [None, Some([0.0; 2])] {
                flow.reset();
                let it = FlowSample { lengths, spool, ..sample(0, 0.0) };
                flow.step(Some(it));
                assert_eq!(flow.speed(), None, "it has none before");
                flow.step(Some(it));
                assert_eq!(flow.speed().is_some(), is_taught, "{spool}, {lengths:?}");
            }
        }
    }

    #[test]
    fn nothing_is_said_of_positions_that_were_not_taught_nor_over_a_gap() {
        let mut flow = Flow::new(design(), 0.02);
        let mut blocks = |samples: &mut dyn Iterator<Item = Option<FlowSample>>| {
            samples.filter_map(|sample| flow.step(sample)).count()
        };
        let out = |k| FlowSample { spool: 10.0, ..sample(k, 0.0) };
        let unread = |k| FlowSample { lengths: None, ..sample(k, 0.0) };
        assert_eq!(blocks(&mut (0..40).map(|k| Some(out(k)))), 0);
        assert_eq!(blocks(&mut (0..22).map(|k| (k % 11 < 10).then(|| sample(k, 0.0)))), 0);
        for gap in [4, 10] {
            let gaps = |k| if k % 11 == gap { unread(k) } else { sample(k, 0.0) };
            assert_eq!(blocks(&mut (0..gap + 23).map(|k| Some(gaps(k)))), 0, "{gap}");
        }
        assert_eq!(blocks(&mut (0..22).map(|k| (k % 12 < 11).then(|| sample(k, 0.0)))), 1);
    }
}
