//! Division of a recording into parts to learn from and parts to judge.

use crate::survey::{Ranking, Window};
use tertius_core::sequential::Reference;

/// Length of alternating blocks, s: long beside the baseline's memory, and short beside a change of
/// the sea.
const BLOCK: f64 = 60.0;

/// Least number of blocks of a short recording.
const LEAST_BLOCKS: f64 = 8.0;

/// Time within which readings of one place count as one look, s; a block has at least two looks.
const LOOK: f64 = 30.0;

/// Number of lots, see [`Division::lots`].
const LOTS: usize = 4;

/// One part is learnt from and another is judged. Where both are the same, its blocks alternate,
/// and each half is judged by what was learnt from the other half, so that a changing sea affects
/// both halves alike. The blocks are those of the recording's [`Ranking`]: which of its files came
/// first changes no half.
#[derive(Clone, Debug, PartialEq)]
pub struct Division {
    fitted: Window,
    tried: Window,
    /// Length of a block, s; `None` where the parts are different.
    block: Option<f64>,
    ranking: Ranking,
}

impl Division {
    /// A division of a recording with this `ranking`.
    pub fn new(fitted: Window, tried: Window, ranking: Ranking) -> Self {
        let block = (fitted == tried).then(|| BLOCK.min(fitted.length() / LEAST_BLOCKS));
        Self { fitted, tried, block, ranking }
    }

    /// Whether blocks alternate, so that every block is judged.
    pub const fn alternates(&self) -> bool {
        self.block.is_some()
    }

    /// Length of a block, s; `None` where nothing alternates.
    pub const fn block(&self) -> Option<f64> {
        self.block
    }

    /// The part that is learnt from.
    pub const fn fitted(&self) -> Window {
        self.fitted
    }

    /// The half, 0 or 1, that is learnt from the row at `t`, s.
    pub fn taught(&self, t: f64) -> Option<usize> {
        self.fitted.holds(t).then(|| self.half(t))
    }

    /// The half by which the row at `t`, s, is judged.
    pub fn judged(&self, t: f64) -> Option<usize> {
        let by = |t| if self.alternates() { 1 - self.half(t) } else { 0 };
        self.tried.holds(t).then(|| by(t))
    }

    /// Number of lots to which blocks are assigned.
    pub const fn lots(&self) -> usize {
        if self.alternates() { LOTS } else { 1 }
    }

    /// The lot of the row at `t`, s. A disturbance in one place affects few lots.
    pub fn lot(&self, t: f64) -> usize {
        self.number(t).map_or(0, |number| number % LOTS)
    }

    /// The look of the row at `t`, s: the rank of its stretch, and the number of its place.
    pub fn look(&self, t: f64) -> [u64; 2] {
        let length = self.block.map_or(LOOK, |block| LOOK.min(0.5 * block));
        [self.ranking.rank(t), (self.ranking.place(t) / length) as u64]
    }

    fn half(&self, t: f64) -> usize {
        self.number(t).map_or(0, |number| number % 2)
    }

    /// The number of the block with the row at `t`, s; `None` where nothing alternates.
    fn number(&self, t: f64) -> Option<usize> {
        self.block.map(|block| (self.ranking.place(t) / block) as usize)
    }
}

/// References of one cylinder learnt from both halves.
pub type Halves = [Option<Reference>; 2];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_alternate_and_judge_each_other() {
        let all = Window { from: 0.0, to: 600.0 };
        let division = Division::new(all, all, Ranking::default());
        for t in [0.0, 59.9, 60.0, 119.0, 120.0, 599.0] {
            let (taught, judged) = (division.taught(t), division.judged(t));
            assert_eq!((taught, judged.map(|half| 1 - half)), (judged.map(|h| 1 - h), taught));
            assert_eq!(taught, Some((t / 60.0) as usize % 2), "{t}");
        }
        assert_eq!((division.taught(600.0), division.judged(-1.0)), (None, None));
        let short = Window { from: 0.0, to: 80.0 };
        let short = Division::new(short, short, Ranking::default());
        assert_eq!([4.9, 5.0, 9.9, 10.0].map(|t| short.look(t)), [[0, 0], [0, 1], [0, 1], [0, 2]]);
        assert_eq!([29.9, 30.0].map(|t| division.look(t)), [[0, 0], [0, 1]]);
    }

    #[test]
    fn the_first_part_teaches_and_the_second_judges() {
        let [fitted, tried] = Window { from: 0.0, to: 600.0 }.split(0.5);
        let division = Division::new(fitted, tried, Ranking::default());
        assert_eq!((division.taught(100.0), division.judged(100.0)), (Some(0), None));
        assert_eq!((division.taught(400.0), division.judged(400.0)), (None, Some(0)));
    }
}
