//! The largest magnitudes of blocks of cycles.

use super::sketch::Sketch;

/// Least number of maxima that are kept: as many as a tail ever needs.
const KEPT: usize = 1000;

/// Maxima of blocks of cycles; the largest of them are kept singly.
///
/// Blocks that follow each other and are at rest from beginning to end are one: a rod that stands
/// says the same again and again, and a minute of it is one event and not sixty (runs
/// declustering: Coles, section 5.3).
#[derive(Clone, Debug)]
pub struct Maxima {
    /// Length of a block, cycles.
    block: u32,
    /// Maximum of the block that is not yet full.
    newest: f64,
    filled: u32,
    /// Whether any cycle of that block was in motion.
    moved: bool,
    /// Maximum of the blocks of a rest that may go on.
    rest: Option<f64>,
    cycles: u64,
    blocks: u64,
    largest: Vec<f64>,
    all: Sketch,
}

impl Maxima {
    /// Maxima of blocks of `block` cycles, at least one.
    pub fn new(block: u32) -> Self {
        Self {
            block: block.max(1),
            newest: 0.0,
            filled: 0,
            moved: false,
            rest: None,
            cycles: 0,
            blocks: 0,
            largest: Vec::new(),
            all: Sketch::new(),
        }
    }

    /// Takes a cycle's residual. Cycles that are not judged are left out, so that a block measures
    /// judged time.
    pub fn add(&mut self, residual: f64) {
        self.take(residual, true);
    }

    /// Takes the residual of a cycle in which nothing moves.
    pub fn add_at_rest(&mut self, residual: f64) {
        self.take(residual, false);
    }

    fn take(&mut self, residual: f64, moves: bool) {
        self.newest = self.newest.max(residual.abs());
        self.moved |= moves;
        self.filled += 1;
        self.cycles += 1;
        if self.filled < self.block {
            return;
        }
        let full = std::mem::take(&mut self.newest);
        self.filled = 0;
        if std::mem::take(&mut self.moved) {
            if let Some(rest) = self.rest.take() {
                self.keep(rest);
            }
            self.keep(full);
        } else {
            self.rest = Some(self.rest.map_or(full, |rest| rest.max(full)));
        }
    }

    fn keep(&mut self, maximum: f64) {
        self.largest.push(maximum);
        self.all.add(maximum);
        self.blocks += 1;
        // Twice as many as are kept, so that sorting them out is seldom.
        if self.largest.len() == 2 * KEPT {
            self.largest.sort_unstable_by(|a, b| b.total_cmp(a));
            self.largest.truncate(KEPT);
        }
    }

    /// Number of cycles taken.
    pub const fn cycles(&self) -> u64 {
        self.cycles
    }

    /// Number of full blocks, with those of a rest as one.
    pub const fn blocks(&self) -> u64 {
        self.blocks + self.rest.is_some() as u64
    }

    /// Length of a block, cycles.
    pub const fn block(&self) -> u32 {
        self.block
    }

    /// The largest magnitude of the full blocks.
    pub fn worst(&self) -> f64 {
        self.all.largest().max(self.rest.unwrap_or(0.0))
    }

    /// The level that the share `part` of all blocks does not exceed; `None` without a full block.
    pub fn quantile(&self, part: f64) -> Option<f64> {
        self.all.quantile(part)
    }

    /// The largest maxima in descending order: all of them, or at least a thousand.
    pub fn largest(&self) -> Vec<f64> {
        let mut largest: Vec<f64> = self.largest.iter().copied().chain(self.rest).collect();
        largest.sort_unstable_by(|a, b| b.total_cmp(a));
        largest.truncate(KEPT);
        largest
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_burst_within_a_block_counts_once() {
        let mut maxima = Maxima::new(4);
        [1.0, -9.0, 8.0, 7.0, 0.5, 0.0, -2.0, 1.0, 50.0].iter().for_each(|r| maxima.add(*r));
        assert_eq!((maxima.blocks(), maxima.cycles(), maxima.worst()), (2, 9, 9.0));
        assert_eq!(maxima.largest(), [9.0, 2.0]);
    }

    #[test]
    fn a_rest_is_one_block_however_long() {
        let mut maxima = Maxima::new(2);
        let motion = |maxima: &mut Maxima| [1.0, 2.0].iter().for_each(|r| maxima.add(*r));
        motion(&mut maxima);
        // It begins within a block, which is one of motion.
        maxima.add(3.0);
        [4.0, 7.0, 9.0, 8.0, 7.0, 6.0].iter().for_each(|r| maxima.add_at_rest(*r));
        // While it lasts, and when it has ended.
        assert_eq!((maxima.blocks(), maxima.worst()), (3, 9.0));
        assert_eq!(maxima.largest(), [9.0, 4.0, 2.0]);
        maxima.add(5.0);
        motion(&mut maxima);
        assert_eq!((maxima.blocks(), maxima.cycles()), (5, 12));
        assert_eq!(maxima.largest(), [9.0, 6.0, 4.0, 2.0, 2.0]);
        // A second one is another.
        (0..4).for_each(|_| maxima.add_at_rest(9.0));
        assert_eq!(maxima.blocks(), 6);
        assert_eq!(maxima.largest(), [9.0, 9.0, 6.0, 4.0, 2.0, 2.0]);
    }

    #[test]
    fn the_largest_are_kept_however_many_come() {
        let mut maxima = Maxima::new(1);
        // 7919 is prime to 10 000: every number comes once, out of order.
        (0..10_000_u32).for_each(|k| maxima.add(f64::from(7919 * k % 10_000)));
        let largest = maxima.largest();
        assert_eq!((largest.len(), largest[0], largest[999]), (1000, 9999.0, 9000.0));
        assert_eq!(maxima.blocks(), 10_000);
    }
}
