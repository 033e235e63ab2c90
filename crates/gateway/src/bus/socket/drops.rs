//! The kernel's count of frames that found the receive queue full.

/// Follows SO_RXQ_OVFL, which counts from the socket's opening in 32 bits that wrap.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Drops {
    last: u32,
    total: u64,
}

impl Drops {
    /// Takes the count delivered with a frame. The kernel omits it while it is zero.
    pub(super) fn saw(&mut self, count: u32) {
        self.total += u64::from(count.wrapping_sub(self.last));
        self.last = count;
    }

    pub(super) fn total(self) -> u64 {
        self.total
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_on_when_the_kernels_counter_wraps() {
        let mut drops = Drops::default();
        for count in [7, 7, 9, u32::MAX - 1, 3] {
            drops.saw(count);
        }
        assert_eq!(drops.total(), u64::from(u32::MAX) + 4);
    }
}
