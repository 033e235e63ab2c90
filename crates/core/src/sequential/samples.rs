//! The newest samples: all, the independent ones, and the independent ones in motion.

use super::clip::Clip;
use super::statistic::DEAD_BAND;
use super::windows::{Few, Sums, VALUES};
use crate::state::state;
use alloc::boxed::Box;

/// Up to this width a window takes every independent sample; wider ones only those in motion, because
/// at rest the count hardly changes and one sample says much of what the one before has said.
pub const AT_REST: usize = 6;

/// Of all samples, in motion or not, so many are held at the most: those of
/// [`KindParameters::newest`](super::parameters::KindParameters::newest) up to 100 Hz.
pub const NEWEST: usize = 128;

/// Of those in motion.
pub const MOVING: usize = 1024;

/// Samples that tell how far the readings are apart now.
const APART_SAMPLES: usize = 4;

/// Sample of one cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Residual beyond its baseline, m.
    pub residual: f64,
    /// Factor with which the residual scatters as one at rest does
    /// ([`super::noise::Noise::share`]).
    pub share: f64,
    /// Variance of the residual due to the uncertainty of its reference and its baseline, m².
    pub doubt: f64,
}

impl Sample {
    /// A sample of a rod at rest where everything is known.
    pub const fn at_rest(residual: f64) -> Self {
        Self { residual, share: 1.0, doubt: 0.0 }
    }

    /// Part of the dead band that applies: the uncertainty is added to it in quadrature.
    #[inline]
    fn band(&self) -> f64 {
        if self.doubt > 0.0 {
            self.share * libm::sqrt(1.0 + self.doubt / (DEAD_BAND * DEAD_BAND))
        } else {
            self.share
        }
    }
}

/// Weight of a sample as evidence.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Independence {
    /// None: it repeats the previous sample.
    Repeated,
    /// Reduced: the rod stands or nearly so, and one sample largely repeats the previous one.
    AtRest,
    InMotion,
}

/// The newest residuals, at most `N`, m; `N` is a power of two.
#[derive(Clone, Debug)]
pub struct Newest<const N: usize> {
    ring: Box<[f64; N]>,
    /// Number of residuals that came.
    count: usize,
    /// So many are held.
    most: usize,
}

state! {
    Newest<N> [const N: usize] { ring, count }
    but { most }
}

impl<const N: usize> Default for Newest<N> {
    fn default() -> Self {
        const { assert!(N.is_power_of_two()) };
        Self { ring: Box::new([0.0; N]), count: 0, most: N }
    }
}

impl<const N: usize> Newest<N> {
    /// Number of residuals that are held.
    #[inline]
    pub fn held(&self) -> usize {
        self.count.min(self.most)
    }

    #[inline]
    fn push(&mut self, residual: f64) {
        self.ring[self.count % N] = residual;
        self.count += 1;
    }

    const fn clear(&mut self) {
        self.count = 0;
    }

    /// The residuals, newest first, m; as many as are [`Self::held`].
    pub fn in_order(&self) -> [f64; N] {
        let mut all = [0.0; N];
        for (place, residual) in all.iter_mut().zip(self.iter()) {
            *place = residual;
        }
        all
    }

    /// The residuals, newest first, m.
    pub fn iter(&self) -> impl Iterator<Item = f64> {
        (1..=self.held()).map(|ago| self.ring[self.count.wrapping_sub(ago) % N])
    }
}

/// The newest samples one by one, and as sums: of the clipped, weighted residual, m; of its square,
/// less the part that its uncertainty explains, m²; of the part of the dead band that applies; and
/// of the cycles since the previous sample.
#[derive(Clone, Debug, Default)]
pub struct History {
    pub all: Newest<NEWEST>,
    /// Independent samples.
    few: Few,
    /// Independent samples in motion.
    pub moving: Newest<MOVING>,
    many: Sums<MOVING>,
    /// Cycle of this sample.
    cycle: u64,
    /// Cycle of the newest independent sample.
    counted: u64,
    /// Cycle of the newest independent sample in motion.
    moved: u64,
}

state! {
    History { all, few, moving, many, cycle, counted, moved }
    sound |it| it.counted <= it.cycle && it.moved <= it.cycle
}

impl History {
    /// A history that holds the `newest` of all samples, [`NEWEST`] at the most.
    pub fn holding(newest: usize) -> Self {
        let all = Newest { most: newest.min(NEWEST), ..Newest::default() };
        Self { all, ..Self::default() }
    }

    /// Takes a sample, clipped by `clip`: a wild one must not count as a mean of many.
    #[inline(always)]
    pub fn push(&mut self, sample: Sample, clip: &Clip, independence: Independence) {
        let Sample { residual, share, doubt } = sample;
        self.all.push(residual);
        self.cycle += 1;
        if independence == Independence::Repeated {
            return;
        }
        let weighed = residual * share;
        let clipped = weighed.clamp(-clip.farthest, clip.farthest);
        let square = weighed * weighed;
        // As `min` does, which asks in four instructions more what is to become of no number.
        let square = if square < clip.square { square } else { clip.square };
        let (square, band) = (square - share * share * doubt, sample.band());
        let values = |cycles: u64| [clipped, square, band, cycles as i64 as f64];
        self.few.push(values(self.cycle - self.counted));
        self.counted = self.cycle;
        if independence == Independence::InMotion {
            self.many.push(values(self.cycle - self.moved));
            self.moved = self.cycle;
            self.moving.push(residual);
        }
    }

    pub const fn clear(&mut self) {
        self.all.clear();
        self.few.clear();
        self.moving.clear();
        self.many.clear();
        (self.counted, self.moved) = (self.cycle, self.cycle);
    }

    /// Distance of the newest few residuals from zero, m, independent or not; `None` if there are
    /// not so many.
    pub fn apart(&self) -> Option<f64> {
        let squares = self.all.iter().take(APART_SAMPLES).map(|residual| residual * residual);
        (self.all.held() >= APART_SAMPLES).then(|| libm::sqrt(squares.sum::<f64>()))
    }

    /// The newest residual, and the one `samples` before it, m; `None` if there are not so many.
    pub fn since(&self, samples: usize) -> Option<[f64; 2]> {
        let before = self.all.iter().nth(samples)?;
        Some([self.all.iter().next()?, before])
    }

    /// Number of cycles that the newest `width` samples that count go back.
    pub fn cycles(&self, width: usize) -> usize {
        self.over(width).map_or(width, |[.., cycles]| cycles as usize)
    }

    /// Number of cycles that the newest `count` samples in motion go back.
    pub fn cycles_of_moving(&self, count: usize) -> usize {
        self.many.over(count).map_or(0, |[.., cycles]| cycles as usize)
    }

    /// Sums of the samples that windows up to [`AT_REST`] take.
    #[inline]
    pub const fn few(&self) -> &Few {
        &self.few
    }

    /// Sums of the samples that wider windows take.
    #[inline]
    pub const fn many(&self) -> &Sums<MOVING> {
        &self.many
    }

    /// The sums over the newest `width` samples that count; `None` if there are not so many.
    pub fn over(&self, width: usize) -> Option<[f64; VALUES]> {
        if width <= AT_REST { self.few.over(width) } else { self.many.over(width) }
    }
}
