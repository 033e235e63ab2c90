//! The alive counter of a transducer's frames.

/// What the counter of a new frame says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Progress {
    /// As expected after the cycles that passed.
    Advanced,
    /// The counter stands still: the sender repeats itself, the reading is not new.
    Repeated,
    /// The counter advanced, but not by the cycles that passed.
    Jumped,
}

/// Follows one alive counter.
#[derive(Clone, Debug)]
pub struct AliveCounter {
    mask: u64,
    last: Option<(u64, u64)>,
}

impl AliveCounter {
    /// A counter of `bits` bits (1 to 64) that wraps to zero.
    pub fn new(bits: u32) -> Self {
        Self { mask: u64::MAX >> (64 - bits.clamp(1, 64)), last: None }
    }

    /// Takes the counter `value` of the frame of cycle number `cycle`.
    pub fn follow(&mut self, cycle: u64, value: u64) -> Progress {
        let value = value & self.mask;
        let progress = match self.last {
            None => Progress::Advanced,
            Some((_, last)) if value == last => Progress::Repeated,
            Some((since, last)) => {
                let expected = last.wrapping_add(cycle.wrapping_sub(since)) & self.mask;
                if value == expected { Progress::Advanced } else { Progress::Jumped }
            }
        };
        if progress != Progress::Repeated {
            self.last = Some((cycle, value));
        }
        progress
    }

    /// Forgets the last value, after a gap in time.
    pub fn reset(&mut self) {
        self.last = None;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wraps_and_notices_repetition_and_loss() {
        let mut counter = AliveCounter::new(8);
        assert_eq!(counter.follow(1, 254), Progress::Advanced);
        assert_eq!(counter.follow(2, 255), Progress::Advanced);
        assert_eq!(counter.follow(3, 0), Progress::Advanced);
        assert_eq!(counter.follow(4, 0), Progress::Repeated);
        assert_eq!(counter.follow(5, 0), Progress::Repeated);
        assert_eq!(counter.follow(6, 3), Progress::Advanced, "three cycles after the last new one");
        assert_eq!(counter.follow(7, 9), Progress::Jumped);
    }

    #[test]
    fn a_counter_of_full_width_does_not_overflow() {
        let mut counter = AliveCounter::new(64);
        assert_eq!(counter.follow(0, u64::MAX), Progress::Advanced);
        assert_eq!(counter.follow(1, 0), Progress::Advanced);
    }
}
