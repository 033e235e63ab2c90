//! The newest samples, as sums: of all, of those that are news, and of those of them in motion.

use super::clip::Clip;
use super::novelty::News;
use super::statistic::DEAD_BAND;
use super::windows::{Sums, VALUES};

/// Up to this width a window takes every sample that is news; wider ones only those in motion, because
/// at rest the count hardly changes and one sample says much of what the one before has said.
pub const AT_REST: usize = 6;

/// Of all samples, in motion or not, so many are held.
const NEWEST: usize = 64;

/// Samples that tell how far the readings are apart now.
const FEW: usize = 4;

/// What is known of one cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// The residual beyond its baseline, m.
    pub residual: f64,
    /// What it is multiplied by to scatter as one at rest does ([`super::noise::Noise::share`]).
    pub share: f64,
    /// The square of what the residual may be off by, for its reference and its baseline may be, m².
    pub doubt: f64,
}

impl Sample {
    /// Of a rod that stands where all is known.
    pub const fn at_rest(residual: f64) -> Self {
        Self { residual, share: 1.0, doubt: 0.0 }
    }

    /// The share of the dead band that it has: what is not known is added to that, in quadrature.
    #[inline]
    fn band(&self) -> f64 {
        if self.doubt > 0.0 {
            self.share * (1.0 + self.doubt / (DEAD_BAND * DEAD_BAND)).sqrt()
        } else {
            self.share
        }
    }
}

/// The sums of the weighed residual as far as it counts, m, of its square likewise less what its doubt
/// explains, m², and of the share of the dead band that it has; then of the residual itself, m, of its square, m², and of the cycles
/// since the sample before.
#[derive(Clone, Debug, Default)]
pub struct History {
    /// Over all samples.
    pub all: Sums<{ NEWEST + 1 }>,
    /// Over those that do not repeat others.
    news: Sums<{ AT_REST + 1 }>,
    /// Over those of them that are in motion.
    pub moving: Sums<1025>,
    /// Cycles since the newest of each of the two.
    since: [u32; 2],
}

impl History {
    /// Takes a sample, as far as `clip` lets it count: a wild one must not be a mean of many.
    #[inline]
    pub fn push(&mut self, sample: Sample, clip: &Clip, news: News) {
        let Sample { residual, share, doubt } = sample;
        let weighed = residual * share;
        let clipped = weighed.clamp(-clip.farthest, clip.farthest);
        let square = (weighed * weighed).min(clip.square) - share * share * doubt;
        let band = sample.band();
        let values = |cycles| [clipped, square, band, residual, residual * residual, cycles];
        self.all.push(values(1.0));
        self.since = self.since.map(|cycles| cycles.saturating_add(1));
        let [said, moved] = &mut self.since;
        let cycles = |since: &mut u32| f64::from(std::mem::take(since));
        if news != News::Repeated {
            self.news.push(values(cycles(said)));
        }
        if news == News::InMotion {
            self.moving.push(values(cycles(moved)));
        }
    }

    pub fn clear(&mut self) {
        self.all.clear();
        self.news.clear();
        self.moving.clear();
        self.since = [0; 2];
    }

    /// How far the newest few residuals are from none, news or not, m; `None` if there are not so many.
    pub fn apart(&self) -> Option<f64> {
        self.all.over(FEW).map(|[.., squares, _]| squares.max(0.0).sqrt())
    }

    /// The cycles that the newest `width` samples that count go back.
    pub fn cycles(&self, width: usize) -> usize {
        self.over(width).map_or(width, |[.., cycles]| cycles as usize)
    }

    /// The sums over the newest `width` samples that count; `None` if there are not so many.
    #[inline]
    pub fn over(&self, width: usize) -> Option<[f64; VALUES]> {
        if width <= AT_REST { self.news.over(width) } else { self.moving.over(width) }
    }
}
