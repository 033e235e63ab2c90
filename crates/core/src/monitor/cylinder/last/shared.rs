//! What both transducers are off by alike.

use crate::state::whole;
use crate::time::Timestamp;

/// What both transducers are off by alike. Their difference is zero and both observers follow, so that it stands until the
/// readings return, or rest on the stop as before.
#[derive(Clone, Copy, Debug)]
pub struct SharedDeparture {
    /// m, signed.
    pub off: f64,
    /// What its newest part was compared with, m.
    pub limit: f64,
    pub since: Timestamp,
    /// Whether both have jumped, as no rod does. Otherwise the cylinder may not follow its valve, which a process detector may
    /// explain.
    pub is_jump: bool,
}

whole! { SharedDeparture { off, limit, since, is_jump } }

impl SharedDeparture {
    /// Takes another error. `None`: what is left would not have been found.
    pub fn and(self, error: f64, limit: f64) -> Option<Self> {
        let off = self.off + error;
        (off.abs() > limit).then_some(Self { off, limit, ..self })
    }

    /// m.
    pub const fn size(&self) -> f64 {
        self.off.abs()
    }
}
