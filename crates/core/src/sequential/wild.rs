//! What wild samples prove.
//!
//! Some samples are off by any amount, and are no fault: a disturbed line, a bit. Whatever a
//! calibration has seen of them, this share is expected. So no sample is more evidence than it takes
//! for that one to be wild, ln(2/π) to either side, and k of them are no more than k times as much.

/// π: the share of samples that may be wild on a healthy cylinder.
pub const SHARE: f64 = 0.02;

/// Wild samples in a row, to one side, as which a level counts at least: five reach it, also where one of
/// them is not quite as far off, and four beside healthy ones do not.
const IN_A_ROW: f64 = 4.75;

/// The least level that can be relied on, nats, however calm the recording was that it is learnt from.
///
/// Where both transducers of a pair have a share π of wild samples, twice as many of their differences are
/// wild as the rate functions have. Five in a row to one side come once in some days then; but five
/// anywhere, to either side, which is what a lower level would be reached by, every few hours.
pub fn least_level() -> f64 {
    IN_A_ROW * libm::log(2.0 / SHARE)
}

/// A: how far off a wild sample is taken for, in deviations of healthy ones. There a normal one is as
/// rare.
pub fn reach() -> f64 {
    libm::sqrt(2.0 * libm::log(2.0 / SHARE))
}
