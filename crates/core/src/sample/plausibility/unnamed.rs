//! Bits of a status to which the configuration gives no meaning.

use crate::state::whole;

/// The bits that a transducer's status had beside those that mean a broken wire.
#[derive(Clone, Copy, Debug, Default)]
pub struct UnnamedBits {
    /// All of them since the start.
    seen: u64,
    /// Those of them that were not reported yet.
    untold: u64,
}

whole! {
    UnnamedBits {}
    bits { seen, untold }
}

impl UnnamedBits {
    /// Whether a status has any other bits than these: new ones, or those of a broken wire.
    #[inline(always)]
    pub const fn lack(&self, status: u64) -> bool {
        status & !self.seen != 0
    }

    /// Whether none of these has a meaning in `mask`.
    pub const fn are_beside(&self, mask: u64) -> bool {
        self.seen & mask == 0
    }

    /// Takes a status of which the bits in `mask` have a meaning.
    pub fn note(&mut self, status: u64, mask: u64) {
        let unnamed = status & !mask;
        self.untold |= unnamed & !self.seen;
        self.seen |= unnamed;
    }

    /// Whether there are bits that were never set before.
    #[inline]
    pub const fn has_news(&self) -> bool {
        self.untold != 0
    }

    /// The bits that were never set before.
    pub fn take_news(&mut self) -> Option<u64> {
        self.has_news().then(|| core::mem::take(&mut self.untold))
    }
}
