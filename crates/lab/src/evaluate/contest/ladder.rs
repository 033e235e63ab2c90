//! Detectors at all levels at once: when the first value beyond each level came.

use serde::Serialize;

/// Detectors that are compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Rival {
    /// |R1| or |R2| beyond δ.
    Observers,
    /// |R3| beyond its bound.
    Comparator,
    /// The mean's or the variance's likelihood ratio beyond h.
    Sequential,
}

/// Number of levels of each rival.
pub const LEVELS: usize = 28;

impl Rival {
    pub const ALL: [Self; 3] = [Self::Observers, Self::Comparator, Self::Sequential];

    pub const fn name(self) -> &'static str {
        match self {
            Self::Observers => "observers",
            Self::Comparator => "comparator",
            Self::Sequential => "sequential",
        }
    }

    /// The level of `index`: m, or nats for the sequential detector.
    pub fn level(self, index: usize) -> f64 {
        let step = index as f64;
        match self {
            Self::Observers | Self::Comparator => 5e-4 + 1.25e-4 * step,
            Self::Sequential => 3.0 + step,
        }
    }
}

/// Cycles until the first value beyond each level of each rival, counting that cycle.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Ladder {
    first: [[Option<u32>; LEVELS]; Rival::ALL.len()],
}

impl Ladder {
    /// Takes the values of the cycle `number` (from 1), in the order of [`Rival::ALL`].
    pub fn take(&mut self, number: u32, values: [Option<f64>; Rival::ALL.len()]) {
        for (rival, value) in Rival::ALL.into_iter().zip(values) {
            let Some(value) = value else { continue };
            for (index, first) in self.first[rival as usize].iter_mut().enumerate() {
                if value <= rival.level(index) {
                    break;
                }
                first.get_or_insert(number);
            }
        }
    }

    /// Cycles until `rival` was beyond its level of `index`.
    pub const fn first(&self, rival: Rival, index: usize) -> Option<u32> {
        self.first[rival as usize][index]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_value_beyond_each_level_counts() {
        let mut ladder = Ladder::default();
        ladder.take(1, [None, Some(0.0), Some(4.5)]);
        ladder.take(2, [Some(1.0), None, Some(3.5)]);
        ladder.take(3, [None, Some(0.0), Some(6.5)]);
        let of = |rival| [0, 1, 2, 3, 4].map(|index| ladder.first(rival, index));
        assert_eq!(of(Rival::Sequential), [Some(1), Some(1), Some(3), Some(3), None]);
        assert_eq!(of(Rival::Observers), [Some(2); 5]);
        assert_eq!(of(Rival::Comparator), [None; 5]);
    }
}
