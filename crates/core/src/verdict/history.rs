//! The newest residuals of one detector.

use crate::state::state;

/// A ring of the last `N` values, a power of two; places not yet filled read as zero.
#[derive(Clone, Debug)]
pub struct ResidualHistory<const N: usize> {
    values: [f64; N],
    /// Values taken since the start or [`Self::clear`].
    count: u64,
}

state! {
    ResidualHistory<N> [const N: usize] { values, count }
}

impl<const N: usize> Default for ResidualHistory<N> {
    fn default() -> Self {
        const { assert!(N.is_power_of_two(), "its place is a mask of the count") };
        Self { values: [0.0; N], count: 0 }
    }
}

impl<const N: usize> ResidualHistory<N> {
    #[inline(always)]
    pub const fn push(&mut self, value: f64) {
        self.values[self.next()] = value;
        self.count = self.count.wrapping_add(1);
    }

    /// Place of the next value, which is that of the oldest one.
    #[inline(always)]
    const fn next(&self) -> usize {
        self.count as usize % N
    }

    /// How many of the newest values are known.
    pub fn known(&self) -> usize {
        self.count.min(N as u64) as usize
    }

    /// All values, oldest first.
    pub fn in_order(&self) -> [f64; N] {
        let mut values = self.values;
        values.rotate_left(self.next());
        values
    }

    pub fn clear(&mut self) {
        *self = Self::default();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_newest_values_are_held_in_their_order() {
        let mut history = ResidualHistory::<4>::default();
        assert_eq!((history.in_order(), history.known()), ([0.0; 4], 0));
        [1.0, 2.0, 3.0].into_iter().for_each(|value| history.push(value));
        assert_eq!((history.in_order(), history.known()), ([0.0, 1.0, 2.0, 3.0], 3));
        [4.0, 5.0, 6.0].into_iter().for_each(|value| history.push(value));
        assert_eq!((history.in_order(), history.known()), ([3.0, 4.0, 5.0, 6.0], 4));
        history.clear();
        assert_eq!((history.in_order(), history.known()), ([0.0; 4], 0));
    }
}
