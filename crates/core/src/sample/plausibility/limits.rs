//! What readings are held to.

use alloc::vec::Vec;

/// Limits of plausible readings.
#[derive(Clone, Debug)]
pub struct PlausibilityLimits {
    /// Cycles without a new reading after which it is stale.
    pub stale: u32,
    /// Raw codes of a broken wire.
    pub broken_wire_codes: Vec<i64>,
    /// Status bits of a broken wire.
    pub status_mask: u64,
    /// Range of valid raw codes, inclusive.
    pub codes: Option<(i64, i64)>,
    /// Range of valid lengths, inclusive, m.
    pub lengths: (f64, f64),
    /// Cycles of an exactly constant reading under a moving command after which it is frozen.
    pub frozen: u32,
    /// Distance that the other transducer has to move meanwhile, m.
    pub travel: f64,
    /// Way that the command has to go meanwhile where no other transducer is a witness: the integral of the command
    /// over time, m.
    pub driven: f64,
}
