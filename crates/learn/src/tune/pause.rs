//! Gaps between rows.

/// Gaps between the rows of one cylinder.
#[derive(Clone, Copy, Debug, Default)]
pub struct Pause {
    newest: Option<u64>,
    told: bool,
}

impl Pause {
    /// Reports that the next row does not follow the previous one.
    pub const fn tell(&mut self) {
        self.told = true;
    }

    /// The missing cycles to predict over before the row of `cycle`, as the monitor does with at
    /// most `most`; `None` where the observer restarts.
    pub fn before(&mut self, cycle: u64, most: u32) -> Option<u32> {
        let newest = self.newest.replace(cycle);
        if !std::mem::take(&mut self.told) {
            return Some(0);
        }
        let missing = cycle.checked_sub(newest? + 1)?;
        u32::try_from(missing).ok().filter(|missing| (1..=most).contains(missing))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_few_cycles_are_predicted_over_and_more_are_not() {
        let mut pause = Pause::default();
        assert_eq!([10, 11].map(|cycle| pause.before(cycle, 3)), [Some(0); 2]);
        for (cycle, expected) in [(13, Some(1)), (17, Some(3)), (22, None), (23, None)] {
            // A clock that was set goes on with the next number, and nothing is known of what was before.
            pause.tell();
            assert_eq!(pause.before(cycle, 3), expected, "{cycle}");
        }
        assert_eq!(pause.before(24, 3), Some(0));
    }
}
