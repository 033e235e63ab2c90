//! A mean with a fading memory.

use crate::state::whole;

/// The mean of values: of all of them at first, later with an exponential memory.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Mean {
    value: f64,
    count: u32,
}

whole! { Mean { value, count } }

impl Mean {
    /// Adds `value` to a mean over about `memory` values.
    pub fn add(&mut self, value: f64, memory: u32) {
        self.count = self.count.saturating_add(1).min(memory.max(1));
        self.value += (value - self.value) / f64::from(self.count);
    }

    /// The mean; zero without any value.
    pub const fn value(&self) -> f64 {
        self.value
    }

    /// Number of values in the mean.
    pub const fn count(&self) -> u32 {
        self.count
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_the_mean_of_all_and_then_forgets() {
        let mut mean = Mean::default();
        for value in [1.0, 2.0, 6.0] {
            mean.add(value, 4);
        }
        assert_eq!((mean.value(), mean.count()), (3.0, 3));
        (0..100).for_each(|_| mean.add(7.0, 4));
        assert!((mean.value() - 7.0).abs() < 1e-9 && mean.count() == 4);
    }
}
