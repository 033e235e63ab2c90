//! The newest samples: of all, of those that are news, and of those of them in motion.

use super::clip::Clip;
use super::novelty::News;
use super::windows::{Few, Sums, VALUES};

/// Up to this width a window takes every sample that is news; wider ones only those in motion, because
/// at rest the count hardly changes and one sample says much of what the one before has said.
pub const AT_REST: usize = 6;

/// Of all samples, in motion or not, so many are held.
const NEWEST: usize = 64;

/// Of those that are news, as many as a window takes at rest, and of those in motion.
const NEWS: usize = AT_REST.next_power_of_two();
const MOVING: usize = 1024;

/// Samples that tell how far the readings are apart now.
const FEW: usize = 4;

/// What is known of one cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// The residual beyond its baseline, m.
    pub residual: f64,
    /// What it is multiplied by to scatter as one at rest does ([`super::noise::Noise::share`]).
    pub share: f64,
}

impl Sample {
    /// Of a rod that stands.
    pub const fn at_rest(residual: f64) -> Self {
        Self { residual, share: 1.0 }
    }
}

/// What is looked at when there is an alarm.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Past {
    /// m.
    residual: f64,
    /// Since the sample before.
    cycles: u32,
}

/// The newest `N` samples at most; `N` is a power of two.
#[derive(Clone, Debug)]
pub struct Newest<const N: usize> {
    ring: [Past; N],
    next: usize,
    held: usize,
}

impl<const N: usize> Default for Newest<N> {
    fn default() -> Self {
        const { assert!(N.is_power_of_two()) };
        Self { ring: [Past::default(); N], next: 0, held: 0 }
    }
}

impl<const N: usize> Newest<N> {
    /// Samples that are held.
    pub const fn held(&self) -> usize {
        self.held
    }

    #[inline]
    fn push(&mut self, past: Past) {
        self.ring[self.next % N] = past;
        self.next = (self.next + 1) % N;
        self.held = (self.held + 1).min(N);
    }

    const fn clear(&mut self) {
        self.held = 0;
    }

    fn newest(&self) -> impl Iterator<Item = &Past> {
        (1..=self.held).map(|ago| &self.ring[self.next.wrapping_sub(ago) % N])
    }

    /// The residuals, the newest first, m.
    pub fn residuals(&self) -> impl Iterator<Item = f64> {
        self.newest().map(|past| past.residual)
    }

    /// The cycles that the newest `count` go back.
    pub fn cycles(&self, count: usize) -> usize {
        self.newest().take(count).map(|past| past.cycles as usize).sum()
    }
}

/// The newest samples, one by one; and as sums: of the weighed residual as far as it counts, m, of its
/// square likewise, m², and of the share by which it was weighed.
#[derive(Clone, Debug, Default)]
pub struct History {
    pub all: Newest<NEWEST>,
    /// Those that do not repeat others, …
    news: Newest<NEWS>,
    few: Few<AT_REST, { 2 * AT_REST }>,
    /// … and those of them that are in motion.
    pub moving: Box<Newest<MOVING>>,
    many: Sums<MOVING>,
    /// Of this sample, and of the newest of each of the two.
    cycle: u64,
    newest: [u64; 2],
}

impl History {
    /// Takes a sample, as far as `clip` lets it count: a wild one must not be a mean of many.
    #[inline]
    pub fn push(&mut self, sample: Sample, clip: &Clip, news: News) {
        let Sample { residual, share } = sample;
        self.all.push(Past { residual, cycles: 1 });
        self.cycle += 1;
        if news == News::Repeated {
            return;
        }
        let weighed = residual * share;
        let clipped = weighed.clamp(-clip.farthest, clip.farthest);
        let square = (weighed * weighed).min(clip.square);
        let values = [clipped, square, share];
        let cycle = self.cycle;
        let past = |newest: &mut u64| Past {
            residual,
            cycles: (cycle - std::mem::replace(newest, cycle)) as u32,
        };
        let [said, moved] = &mut self.newest;
        self.news.push(past(said));
        self.few.push(values);
        if news == News::InMotion {
            self.moving.push(past(moved));
            self.many.push(values);
        }
    }

    pub fn clear(&mut self) {
        self.all.clear();
        self.moving.clear();
        self.news.clear();
        self.few.clear();
        self.many.clear();
        self.newest = [self.cycle; 2];
    }

    /// How far the newest few residuals are from none, news or not, m; `None` if there are not so many.
    pub fn apart(&self) -> Option<f64> {
        let squares = self.all.residuals().take(FEW).map(|residual| residual * residual);
        (self.all.held() >= FEW).then(|| squares.sum::<f64>().sqrt())
    }

    /// The cycles that the newest `width` samples that count go back.
    pub fn cycles(&self, width: usize) -> usize {
        let of_few = width <= AT_REST;
        let held = if of_few { self.news.held() } else { self.moving.held() };
        match (width <= held, of_few) {
            (true, true) => self.news.cycles(width),
            (true, false) => self.moving.cycles(width),
            (false, _) => width,
        }
    }

    /// The sums over the newest `width` samples that count, for widths up to [`AT_REST`]: over the newest
    /// sample, over the newest two, and so on; and how many of these there are.
    #[inline]
    pub fn few(&self) -> ([[f64; VALUES]; AT_REST], usize) {
        (self.few.sums(), self.few.held())
    }

    /// The same for wider windows.
    #[inline]
    pub const fn many(&self) -> &Sums<MOVING> {
        &self.many
    }

    /// The sums over the newest `width` samples that count; `None` if there are not so many.
    pub fn over(&self, width: usize) -> Option<[f64; VALUES]> {
        if width > AT_REST {
            return self.many.over(width);
        }
        let (sums, held) = self.few();
        (width <= held).then(|| sums[width - 1])
    }
}
