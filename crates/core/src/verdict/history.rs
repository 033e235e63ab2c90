//! The newest residuals of one detector.

use crate::state::state;

/// A ring of the last `N` values; places not yet filled read as zero.
#[derive(Clone, Debug)]
pub struct ResidualHistory<const N: usize> {
    values: [f64; N],
    next: usize,
    known: usize,
}

state! {
    ResidualHistory<N> [const N: usize] { values, next, known }
    sound |it| it.next < N && it.known <= N
}

impl<const N: usize> Default for ResidualHistory<N> {
    fn default() -> Self {
        Self { values: [0.0; N], next: 0, known: 0 }
    }
}

impl<const N: usize> ResidualHistory<N> {
    #[inline(always)]
    pub fn push(&mut self, value: f64) {
        self.values[self.next] = value;
        self.known += usize::from(self.known < N);
        self.next = if self.next + 1 == N { 0 } else { self.next + 1 };
    }

    /// How many of the newest values are known.
    pub const fn known(&self) -> usize {
        self.known
    }

    /// All values, oldest first.
    pub fn in_order(&self) -> [f64; N] {
        let mut values = self.values;
        values.rotate_left(self.next);
        values
    }

    pub fn clear(&mut self) {
        (self.values, self.known) = ([0.0; N], 0);
    }
}
