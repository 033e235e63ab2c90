//! What a cycle is evidence of: the statistics take samples for independent ones.

use super::motion::Motion;

/// What a sample counts for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum News {
    /// Nothing: it says what the one before has said.
    Repeated,
    /// The rod stands or nearly so: one sample says much of what the one before has said.
    AtRest,
    InMotion,
}

/// Readings that differ by less are the same, m: it is only the rounding of their decoding.
const ROUNDING: f64 = 1e-9;

/// A residual that differs by less than this part of the healthy deviation is the same.
const ALIKE: f64 = 0.5;

/// Follows both readings and what they differ by.
///
/// Where a rod goes whole counts from cycle to cycle, each reading is rounded at the same place between
/// two counts again and again, and the difference of both stays as it is for as long as the speed does.
/// Such samples are no more evidence than one. They are known by both readings moving by what they have
/// moved by in the cycle before; readings with a noise of a count or more hardly ever do.
#[derive(Clone, Debug)]
pub struct Gate {
    motion: Motion,
    /// m.
    alike: f64,
    lengths: [f64; 2],
    residual: f64,
    /// What the readings moved by in the newest cycle, m; `None` before there were two.
    moved: Option<[f64; 2]>,
    begun: bool,
}

impl Gate {
    /// For samples every `sample_time` seconds, of healthy residuals of this `deviation`, m.
    pub fn new(sample_time: f64, deviation: f64) -> Self {
        Self {
            motion: Motion::new(sample_time),
            alike: ALIKE * deviation,
            lengths: [0.0; 2],
            residual: 0.0,
            moved: None,
            begun: false,
        }
    }

    pub fn reset(&mut self) {
        self.motion.reset();
        (self.moved, self.begun) = (None, false);
    }

    /// Takes the readings of a cycle and their residual, m.
    pub fn step(&mut self, lengths: [f64; 2], residual: f64) -> News {
        let repeated = self.repeated(lengths, residual);
        if self.motion.step(lengths) && !repeated {
            News::InMotion
        } else if repeated {
            News::Repeated
        } else {
            News::AtRest
        }
    }

    fn repeated(&mut self, lengths: [f64; 2], residual: f64) -> bool {
        let moved = [lengths[0] - self.lengths[0], lengths[1] - self.lengths[1]];
        let same = self.moved.is_some_and(|before| {
            before.iter().zip(moved).all(|(before, now)| (now - before).abs() < ROUNDING)
        });
        let alike = (residual - self.residual).abs() < self.alike;
        self.moved = self.begun.then_some(moved);
        (self.lengths, self.residual, self.begun) = (lengths, residual, true);
        same && alike
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const COUNT: f64 = 4e-4;

    /// The news of a rod whose readings C1 and C2 are so many counts.
    fn news(counts: impl IntoIterator<Item = [i32; 2]>) -> Vec<News> {
        let mut gate = Gate::new(0.02, 2e-4);
        let read = |counts: [i32; 2]| counts.map(|count| COUNT * f64::from(count));
        counts.into_iter().map(read).map(|read| gate.step(read, read[0] - read[1])).collect()
    }

    #[test]
    fn the_same_counts_again_and_again_are_news_once() {
        // Two counts a cycle, C1 rounded up; then a cycle in which C2 is, too.
        let counts = (0..20).map(|k| [2 * k + 1, 2 * k]).chain((20..30).map(|k| [2 * k + 1; 2]));
        let news = news(counts);
        assert_eq!(news[..2], [News::AtRest; 2], "there is nothing to compare with");
        assert_eq!(news[2..20], [News::Repeated; 18]);
        assert_eq!(news[20..22], [News::InMotion; 2], "C2 went three counts, and then two again");
        assert_eq!(news[22..], [News::Repeated; 8]);
    }

    #[test]
    fn readings_that_part_steadily_are_news() {
        // C1 is frozen: each cycle it is two counts more off.
        assert!(news((0..30).map(|k| [0, 2 * k]))[11..].iter().all(|it| *it == News::InMotion));
    }

    #[test]
    fn a_rod_that_stands_says_it_once() {
        let news = news((0..40).map(|k| [i32::from(k > 20), 0]));
        assert_eq!(news[2..21], [News::Repeated; 19]);
        assert_eq!(news[21..23], [News::AtRest; 2]);
        assert_eq!(news[23..], [News::Repeated; 17]);
    }

    #[test]
    fn nothing_outlasts_a_reset() {
        let mut gate = Gate::new(0.02, 2e-4);
        (0..20).for_each(|_| _ = gate.step([0.0; 2], 0.0));
        gate.reset();
        assert_eq!([(); 3].map(|()| gate.step([0.0; 2], 0.0))[..2], [News::AtRest; 2]);
        assert_eq!(gate.step([0.0; 2], 0.0), News::Repeated);
    }
}
