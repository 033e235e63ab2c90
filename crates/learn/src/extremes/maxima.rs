//! The largest magnitudes of blocks of cycles.

use super::sketch::Sketch;

/// Least number of maxima that are kept: as many as a tail ever needs.
const KEPT: usize = 1000;

/// The same where runs count once: a run may take many. With blocks of a second it is a day and a half.
const KEPT_OF_RUNS: usize = 128 * KEPT;

/// Multiple of the median from which a block is far from the ordinary.
const FAR: f64 = 2.0;

/// Maxima of blocks of cycles; the largest of them are kept singly.
#[derive(Clone, Debug)]
pub struct Maxima {
    /// Length of a block, cycles.
    block: u32,
    /// Maximum of the block that is not yet full.
    newest: f64,
    filled: u32,
    cycles: u64,
    blocks: u64,
    /// Number of the next block: one more than that of the block before it, and two after a pause.
    number: u64,
    /// Number of each kept block, and its maximum.
    largest: Vec<(u64, f64)>,
    all: Sketch,
    /// Whether blocks that are far from the ordinary are one where they follow each other.
    runs: bool,
}

impl Maxima {
    /// Maxima of blocks of `block` cycles, at least one.
    pub fn new(block: u32) -> Self {
        Self {
            block: block.max(1),
            newest: 0.0,
            filled: 0,
            cycles: 0,
            blocks: 0,
            number: 0,
            largest: Vec::new(),
            all: Sketch::new(),
            runs: false,
        }
    }

    /// Maxima of residuals that show an error as long as it lasts: blocks that follow each other far
    /// from the ordinary are one event (runs declustering: Coles, section 5.3). A minute on the stop,
    /// where the line of a calibration is off, is one warning and not sixty.
    pub fn of_runs(block: u32) -> Self {
        Self { runs: true, ..Self::new(block) }
    }

    /// Takes a cycle's residual. Cycles that are not judged are left out, so that a block measures
    /// judged time.
    pub fn add(&mut self, residual: f64) {
        self.newest = self.newest.max(residual.abs());
        self.filled += 1;
        self.cycles += 1;
        if self.filled == self.block {
            self.close();
        }
    }

    /// Begins a block anew after a pause, so that the blocks of a file do not depend on what was
    /// recorded before it. What there is of a block counts as one if it is at least half a block,
    /// and is left out otherwise.
    pub fn pause(&mut self) {
        if 2 * self.filled >= self.block {
            self.close();
        }
        (self.newest, self.filled) = (0.0, 0);
        self.number += 1;
    }

    fn close(&mut self) {
        self.largest.push((self.number, self.newest));
        self.all.add(self.newest);
        self.blocks += 1;
        self.number += 1;
        (self.newest, self.filled) = (0.0, 0);
        // Twice as many as are kept, so that sorting them out is seldom.
        if self.largest.len() == 2 * self.kept() {
            self.largest.sort_unstable_by(|(_, a), (_, b)| b.total_cmp(a));
            self.largest.truncate(self.kept());
        }
    }

    /// Least number of maxima that are kept.
    const fn kept(&self) -> usize {
        if self.runs { KEPT_OF_RUNS } else { KEPT }
    }

    /// Number of cycles taken.
    pub const fn cycles(&self) -> u64 {
        self.cycles
    }

    /// Number of full blocks.
    pub const fn blocks(&self) -> u64 {
        self.blocks
    }

    /// Length of a block, cycles.
    pub const fn block(&self) -> u32 {
        self.block
    }

    /// The largest magnitude of the full blocks.
    pub const fn worst(&self) -> f64 {
        self.all.largest()
    }

    /// The level that the share `part` of all blocks does not exceed; `None` without a full block.
    pub fn quantile(&self, part: f64) -> Option<f64> {
        self.all.quantile(part)
    }

    /// The largest maxima in descending order: all of them, or at least a thousand.
    pub fn largest(&self) -> Vec<f64> {
        let mut kept = self.largest.clone();
        kept.sort_unstable_by(|(_, a), (_, b)| b.total_cmp(a));
        kept.truncate(self.kept());
        if self.runs {
            kept = self.runs_of(kept);
        }
        kept.into_iter().map(|(_, maximum)| maximum).collect()
    }

    /// These blocks, of each run far from the ordinary the largest alone.
    fn runs_of(&self, mut kept: Vec<(u64, f64)>) -> Vec<(u64, f64)> {
        let Some(ordinary) = self.quantile(0.5) else { return kept };
        let far = FAR * ordinary;
        kept.sort_unstable_by_key(|(number, _)| *number);
        let follow =
            |(one, a): &(u64, f64), (other, b): &(u64, f64)| one + 1 == *other && a.min(*b) > far;
        let largest = |run: &[(u64, f64)]| run.iter().copied().max_by(|a, b| a.1.total_cmp(&b.1));
        let mut events: Vec<_> = kept.chunk_by(follow).filter_map(largest).collect();
        events.sort_unstable_by(|(_, a), (_, b)| b.total_cmp(a));
        events
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
    fn what_is_far_from_the_ordinary_is_one_event_as_long_as_it_lasts() {
        let blocks = |k: u32| match k {
            500..560 => 19.0 + f64::from(k % 7) / 10.0,
            // Coming and going: still far, and then no more.
            499 | 560 => 5.0,
            498 | 561 => 1.9,
            // Another one later.
            900..903 => 7.0,
            _ => 1.0,
        };
        let take = |mut maxima: Maxima| {
            (0..2000).for_each(|k| maxima.add(blocks(k)));
            maxima
        };
        let events = take(Maxima::of_runs(1)).largest();
        assert_eq!(events[..5], [19.6, 7.0, 1.9, 1.9, 1.0]);
        let each = take(Maxima::new(1));
        assert_eq!(each.largest().iter().filter(|it| **it > 2.0).count(), 65);
        assert_eq!((each.blocks(), each.worst()), (2000, 19.6));
    }

    #[test]
    fn blocks_and_runs_begin_anew_after_a_pause() {
        let of = |files: &[&[f64]]| {
            let mut maxima = Maxima::new(4);
            for file in files {
                maxima.pause();
                file.iter().for_each(|residual| maxima.add(*residual));
            }
            (maxima.blocks(), maxima.largest())
        };
        // Half a block counts, and less does not.
        let (one, other) = ([1.0, 9.0, 2.0, 3.0, 5.0, 4.0], [8.0, 0.5, 0.5, 0.5, 7.0]);
        assert_eq!(of(&[&one, &other, &[]]), (3, vec![9.0, 8.0, 5.0]));
        assert_eq!(of(&[&other, &one, &[]]), of(&[&one, &other, &[]]));
        // Far from the ordinary until the end of a file, and from the beginning of the next one.
        let mut maxima = Maxima::of_runs(1);
        (0..200).for_each(|k| maxima.add(if k < 190 { 1.0 } else { 5.0 }));
        maxima.pause();
        (0..200).for_each(|k| maxima.add(if k < 10 { 6.0 } else { 1.0 }));
        assert_eq!(maxima.largest()[..3], [6.0, 5.0, 1.0]);
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
