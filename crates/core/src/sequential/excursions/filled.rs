//! How near the newest samples are to a limit.

use crate::sequential::statistic::Peak;
use crate::state::whole;

/// Evidence of the newest samples, as a part of what is too much.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Filled {
    /// 1 at the limit.
    pub part: f64,
    /// Samples that it is from.
    pub width: usize,
}

whole! { Filled { part, width } }

impl Filled {
    #[inline]
    pub fn raise(&mut self, part: f64, width: usize) {
        if part > self.part {
            *self = Self { part, width };
        }
    }

    pub const fn peak(self, level: f64) -> Peak {
        Peak { nats: self.part * level, width: self.width }
    }
}
