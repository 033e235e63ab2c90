//! What a healthy cylinder seldom exceeds.

use crate::sequential::parameters::ExcursionParameters;
use crate::sequential::windows::WIDTHS;

/// Number of boxes: from 0.28 mm on every eighth of a millimetre.
pub const BOXES: usize = 13;

/// Strays, samples of a run outside of its box, that are looked for: none, one, two.
pub const STRAYS: usize = 3;

/// Number of clips: in the first windows a sample counts as much as noise, in the others as much as one or two excursions.
pub const CLIPS: usize = 3;

/// Limits of one cylinder, each of which a healthy one exceeds less often than wanted.
#[derive(Clone, Debug, PartialEq)]
pub struct ExcursionLimits {
    /// Evidence of a value that is at its limit, nats: that of the wanted rate.
    pub level: f64,
    /// Standard deviation of C1 − C2 at rest, outside of excursions, m.
    pub rest: f64,
    /// Longest excursion, samples.
    pub longest: u16,
    /// Lower and upper end of each box of |C1 − C2|, m.
    pub boxes: [[f64; 2]; BOXES],
    /// Samples in a row in each box, with 0, 1 and 2 strays; `None` where no run is too long.
    pub runs: [[Option<u16>; STRAYS]; BOXES],
    /// Values beyond which a sample counts no more, m, in ascending order.
    pub clips: [f64; CLIPS],
    /// Sums of the weighted, clipped residual, m, for each clip and each of [`WIDTHS`].
    pub sums: [[f64; WIDTHS.len()]; CLIPS],
    /// Sums of its square, clipped by the first clip, m².
    pub squares: [f64; WIDTHS.len()],
    /// Numbers of samples that are off, and elsewhere than the one before.
    pub elsewhere: [f64; WIDTHS.len()],
}

impl ExcursionLimits {
    /// The boxes of which the `first` begins at this difference, m, and that have this `width`, m; the last one has no upper end.
    pub fn boxes(first: f64, width: f64) -> [[f64; 2]; BOXES] {
        let low = |index: usize| first + ExcursionParameters::DEFAULT.spacing * index as f64;
        core::array::from_fn(|index| {
            [low(index), if index + 1 == BOXES { f64::INFINITY } else { low(index) + width }]
        })
    }
}
