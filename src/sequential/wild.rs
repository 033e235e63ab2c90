//! What wild samples prove.
//!
//! Some samples are off by any amount, and are no fault: a disturbed line, a bit. Whatever a
//! calibration has seen of them, this share is expected. So no sample is more evidence than it takes
//! for that one to be wild, ln(2/π) to either side, and k of them are no more than k times as much.

/// π: the share of samples that may be wild on a healthy cylinder.
pub const SHARE: f64 = 0.02;

/// A: how far off a wild sample is taken for, in deviations of healthy ones. There a normal one is as
/// rare.
pub fn reach() -> f64 {
    (2.0 * (2.0 / SHARE).ln()).sqrt()
}
