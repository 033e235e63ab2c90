//! The tail of block maxima: peaks over a threshold with an exponential or a generalised Pareto
//! distribution of their excesses (Coles, *An Introduction to Statistical Modeling of Extreme
//! Values*, chapter 4).

use super::maxima::Maxima;
use super::pareto::Pareto;

/// Fewest blocks to which a tail is fitted.
pub const LEAST_BLOCKS: u64 = 50;

/// One block in this many is part of the tail.
const TAIL: u64 = 5;

/// The same of a tail that begins where it may.
const TAILS: [u64; 4] = [TAIL, 10, 20, 40];

/// Fewest blocks of a tail that is made of fewer.
pub const LEAST_PEAKS: u64 = 25;

/// Most blocks in a tail; of a long recording they are the outermost ones.
const MOST: usize = 500;

/// Least gain of twice the log-likelihood by a second parameter: χ² with one degree of freedom, one
/// side, 5 %.
const SIGNIFICANT: f64 = 2.706;

/// Multiple of the judged time up to which a heavy tail is believed.
const SEEN: f64 = 2.0;

/// Tail of one detector's residual: how often it exceeds a level.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tail {
    /// Level above which the tail applies.
    pub floor: f64,
    /// Number of blocks beyond the floor.
    pub peaks: usize,
    /// Judged time, s.
    pub seconds: f64,
    /// Mean excess beyond the floor, which determines the exponential tail.
    pub mean: f64,
    /// Largest residual seen.
    pub worst: f64,
    pub pareto: Pareto,
    /// Whether the Pareto tail is heavier than the exponential one, beyond chance; it then applies
    /// as far as the recording reaches, and an exponential one from there.
    pub heavy: bool,
}

/// Whether most of `excesses`, in order, differ. Where readings move in steps that are large beside
/// their noise, peaks are a few values repeated, and the zeros among the excesses would look like
/// the steep beginning of a heavy tail.
fn distinct(excesses: &[f64]) -> bool {
    let values = excesses.chunk_by(|one, next| (one - next).abs() < 1e-9).count();
    2 * values > excesses.len()
}

impl Tail {
    /// The tail of `maxima` of cycles of `sample_time` seconds; `None` with fewer than
    /// [`LEAST_BLOCKS`], or if all that is kept is one run.
    pub fn fit(maxima: &Maxima, sample_time: f64) -> Option<Self> {
        Self::among(maxima, sample_time, &[TAIL])
    }

    /// As [`Self::fit`], but farther out where the largest blocks lie closer together than an exponential tail has them.
    /// Their scale is then that of something else, as of the ends of a rod's way, at each of which a line is off: an
    /// exponential tail of it would reach far beyond all that was ever seen.
    pub fn fit_farther(maxima: &Maxima, sample_time: f64) -> Option<Self> {
        Self::among(maxima, sample_time, &TAILS)
    }

    fn among(maxima: &Maxima, sample_time: f64, tails: &[u64]) -> Option<Self> {
        if maxima.blocks() < LEAST_BLOCKS {
            return None;
        }
        let largest = maxima.largest();
        let mut found = None;
        for share in tails {
            let peaks = maxima.blocks() / share;
            if found.is_some() && peaks < LEAST_PEAKS {
                break;
            }
            let peaks = (peaks as usize).min(MOST).min(largest.len() - 1);
            let (tail, is_bounded) = Self::of(maxima, &largest[..=peaks], sample_time)?;
            found = Some(tail);
            if !is_bounded {
                break;
            }
        }
        found
    }

    /// The tail of the `largest` blocks, of which the last one is the floor, and whether it is lighter than an exponential
    /// one, beyond chance.
    fn of(maxima: &Maxima, largest: &[f64], sample_time: f64) -> Option<(Self, bool)> {
        let (floor, peaks) = largest.split_last().filter(|(_, peaks)| !peaks.is_empty())?;
        let excesses: Vec<f64> = peaks.iter().map(|peak| peak - floor).collect();
        let peaks = excesses.len();
        let mean = excesses.iter().sum::<f64>() / peaks as f64;
        let exponential = Pareto { shape: 0.0, scale: mean, likelihood: f64::NEG_INFINITY };
        let pareto = Pareto::fit(&excesses).unwrap_or(exponential);
        let gain = 2.0 * (pareto.likelihood + peaks as f64 * (mean.ln() + 1.0));
        let is_other = gain > SIGNIFICANT && distinct(&excesses);
        let tail = Self {
            floor: *floor,
            peaks,
            seconds: (maxima.blocks() * u64::from(maxima.block())) as f64 * sample_time,
            mean,
            worst: maxima.worst(),
            pareto,
            heavy: pareto.shape > 0.0 && is_other,
        };
        Some((tail, pareto.shape < 0.0 && is_other))
    }

    /// Rate at which blocks exceed `level`, 1/s; the rate of all peaks where `level` is not above
    /// the floor.
    pub fn rate(&self, level: f64) -> f64 {
        let excess = level - self.floor;
        let all = self.peaks as f64 / self.seconds;
        if excess <= 0.0 { all } else { all * self.log_beyond(excess).exp() }
    }

    fn log_beyond(&self, excess: f64) -> f64 {
        if !self.heavy {
            return -excess / self.mean;
        }
        let edge = self.edge();
        self.pareto.log_beyond(excess.min(edge)) - (excess - edge).max(0.0) / self.mean
    }

    /// The excess up to which a heavy tail is believed: what occurs once in about the judged time,
    /// and no more than was seen. Two populations of values, such as readings that are sometimes a
    /// few counts off, look like a heavy tail, which would grow without bound far beyond the data.
    fn edge(&self) -> f64 {
        let many = (SEEN * self.peaks as f64).max(1.0);
        self.pareto.excess(many.ln()).min(self.worst - self.floor).max(0.0)
    }

    /// The level that is exceeded `rate` times a second; at least the floor.
    pub fn level(&self, rate: f64) -> f64 {
        let many = (self.peaks as f64 / (self.seconds * rate)).max(1.0);
        if !self.heavy {
            return self.floor + self.mean * many.ln();
        }
        let edge = self.edge();
        let farther = many.ln() + self.pareto.log_beyond(edge);
        let within = || self.pareto.excess(many.ln());
        self.floor + if farther > 0.0 { edge + self.mean * farther } else { within() }
    }

    /// The standard error of [`Self::level`] from the number of peaks alone (delta method).
    pub fn error(&self, rate: f64) -> f64 {
        let (many, peaks) =
            ((self.peaks as f64 / (self.seconds * rate)).max(1.0), self.peaks as f64);
        if !self.heavy {
            return self.mean * many.ln() / peaks.sqrt();
        }
        let Pareto { shape, scale, .. } = self.pareto;
        let within = many.ln().min(-self.pareto.log_beyond(self.edge()));
        let beyond = self.mean * (many.ln() - within) / peaks.sqrt();
        let grown = (shape * within).exp();
        let by_scale = (grown - 1.0) / shape;
        let by_shape = scale * (grown * within - by_scale) / shape;
        // The inverse of the expected information, for ξ and σ.
        let variance = (1.0 + shape) / peaks
            * ((1.0 + shape) * by_shape * by_shape - 2.0 * scale * by_shape * by_scale
                + 2.0 * scale * scale * by_scale * by_scale);
        variance.max(0.0).sqrt().hypot(beyond)
    }
}

/// The one level that all `tails` together exceed `rate` times a second; infinite where there is no
/// such number.
///
/// The rates are added up: detectors that exceed their levels together all count, which is on the
/// safe side.
pub fn common_level(tails: &[Tail], rate: f64) -> f64 {
    let together = |level: f64| tails.iter().map(|tail| tail.rate(level)).sum::<f64>();
    let mut low = tails.iter().map(|tail| tail.floor).fold(0.0, f64::max);
    let mut high = tails.iter().map(|t| t.level(rate / tails.len() as f64)).fold(low, f64::max);
    if !high.is_finite() {
        return f64::INFINITY;
    }
    // At `high` each detector has no more than its equal share.
    for _ in 0..200 {
        let middle = f64::midpoint(low, high);
        if together(middle) > rate { low = middle } else { high = middle }
    }
    high
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Maxima whose excesses are the quantiles of a Pareto distribution.
    fn maxima(shape: f64, scale: f64) -> Maxima {
        let mut maxima = Maxima::new(50);
        for k in 0..2000 {
            let beyond = (f64::from(k) + 0.5) / 2000.0;
            let value: f64 =
                if shape == 0.0 { -beyond.ln() } else { (beyond.powf(-shape) - 1.0) / shape };
            (0..50).for_each(|_| maxima.add(scale * value));
        }
        maxima
    }

    #[test]
    fn an_exponential_tail_is_extrapolated_as_one() {
        let tail = Tail::fit(&maxima(0.0, 1e-4), 0.02).expect("2000 blocks");
        assert!(!tail.heavy && (tail.mean / 1e-4 - 1.0).abs() < 0.02, "{tail:?}");
        // Of 2000 s one is beyond ln 2000 scales; once in 2e6 s it is ln 1000 scales more.
        for (rate, scales) in [(1.0 / 2000.0, 2000_f64.ln()), (0.5e-6, 2e6_f64.ln())] {
            let level = tail.level(rate);
            assert!((level / (1e-4 * scales) - 1.0).abs() < 0.02, "{level}");
            assert!((tail.rate(level) / rate - 1.0).abs() < 1e-9);
        }
    }

    #[test]
    fn a_heavy_tail_is_known_and_goes_as_far_as_the_evidence() {
        let tail = Tail::fit(&maxima(0.5, 1e-4), 0.02).expect("2000 blocks");
        assert!(tail.heavy && (tail.pareto.shape - 0.5).abs() < 0.05, "{tail:?}");
        for blocks in [10_f64, 100.0, 1000.0] {
            let rate = 1.0 / blocks;
            let (level, exact) = (tail.level(rate), 1e-4 * (blocks.powf(0.5) - 1.0) / 0.5);
            assert!((level / exact - 1.0).abs() < 0.1, "{level} {exact}");
            assert!((tail.rate(level) / rate - 1.0).abs() < 1e-9);
        }
        // What comes once in 4000 s may be the largest of 2000 s; once in 2e6 s is 500 times rarer.
        let [seen, rare] = [1.0 / 4000.0, 0.5e-6].map(|rate| tail.level(rate));
        let longest = 1.01 * tail.mean * 500_f64.ln();
        assert!(rare > seen + 0.5 * longest && rare < seen + longest, "{seen} {rare}");
        assert!((tail.rate(rare) / 0.5e-6 - 1.0).abs() < 1e-9);
        assert!(tail.error(seen) > 0.0 && tail.error(0.5e-6) < rare);
    }

    /// Readings that are sometimes off by some counts are two populations, whatever their tail
    /// looks like: they are not extrapolated to metres.
    #[test]
    fn two_crowds_are_no_metres() {
        let mut maxima = Maxima::new(1);
        for k in 0..900_u32 {
            let spread = 1e-6 * f64::from(k * 7919 % 997) / 10.0;
            maxima.add(if k % 7 == 0 { 5e-4 } else { 2e-4 } + spread);
        }
        let tail = Tail::fit(&maxima, 1.0).expect("900 blocks");
        assert!(tail.level(per_day(1.0 / 365.0)) < 4e-3, "{tail:?}");
    }

    /// At the ends of its way, one block in eight, a rod is where the line is off by half a millimetre. That is no scale
    /// of a tail: an exponential one of it would reach millimetres beyond what was seen.
    #[test]
    fn the_ends_of_the_way_are_no_tail() {
        let mut maxima = Maxima::new(1);
        for k in 0..2400_u32 {
            let part = (f64::from(k * 7919 % 2401) + 0.5) / 2401.0;
            let spread = -2e-5 * part.ln();
            maxima.add(if k % 8 == 0 { 8e-4 } else { 3e-4 } + spread);
        }
        assert!(Tail::fit(&maxima, 1.0).expect("2400 blocks").level(per_day(1.0 / 365.0)) > 3e-3);
        let tail = Tail::fit_farther(&maxima, 1.0).expect("2400 blocks");
        assert!(tail.floor > 8e-4 && (1.5e-5..3e-5).contains(&tail.mean), "{tail:?}");
        // Once a year is 13,000 times as rare as what was seen: 9.5 nats.
        let level = tail.level(per_day(1.0 / 365.0));
        assert!((1.0e-3..1.4e-3).contains(&level), "{level}");
    }

    /// A bounded tail is not trusted, since it was never seen that nothing lies beyond.
    #[test]
    fn a_light_tail_is_extrapolated_as_an_exponential() {
        let tail = Tail::fit(&maxima(-0.3, 1e-4), 0.02).expect("2000 blocks");
        assert!(!tail.heavy && tail.pareto.shape < -0.2, "{tail:?}");
        assert!(tail.level(1e-8) > 1.5 * tail.worst);
    }

    #[test]
    fn detectors_share_a_rate() {
        let one = Tail::fit(&maxima(0.0, 1e-4), 0.02).expect("2000 blocks");
        let other = Tail::fit(&maxima(0.0, 2e-4), 0.02).expect("2000 blocks");
        let rate = per_day(1.0);
        let all = common_level(&[one, other, one], rate);
        let together = 2.0 * one.rate(all) + other.rate(all);
        assert!((together / rate - 1.0).abs() < 1e-6, "{together}");
        assert!(all > other.level(rate) && all < other.level(rate / 3.0));
        let twelve = common_level(&[one; 12], rate);
        assert!((twelve - one.level(rate / 12.0)).abs() < 1e-9 * twelve);
    }

    fn per_day(events: f64) -> f64 {
        events / 86_400.0
    }

    /// Residuals of one or two counts are no heavy tail.
    #[test]
    fn residuals_in_steps_are_extrapolated_as_an_exponential() {
        let mut maxima = Maxima::new(1);
        (0..1000).for_each(|k| maxima.add(if k % 50 == 0 { 2e-4 } else { 1e-4 }));
        let tail = Tail::fit(&maxima, 1.0).expect("1000 blocks");
        assert!(!tail.heavy && tail.level(1e-8) < 1e-3, "{tail:?}");
    }

    #[test]
    fn little_evidence_is_none_and_constant_residuals_have_no_tail() {
        let mut maxima = Maxima::new(2);
        (0..98).for_each(|_| maxima.add(1e-4));
        assert_eq!(Tail::fit(&maxima, 0.02), None);
        (0..2).for_each(|_| maxima.add(1e-4));
        let tail = Tail::fit(&maxima, 0.02).expect("50 blocks");
        assert_eq!((tail.floor, tail.mean, tail.heavy), (1e-4, 0.0, false));
        assert_eq!((tail.level(1e-9), tail.rate(2e-4)), (1e-4, 0.0));
    }
}
