//! What wild samples, outliers, prove.
//!
//! Some samples are off by any amount, and are no fault: a disturbed line, a bit. Whatever a calibration
//! has seen of them, a share π is expected. So no sample is more evidence than it takes for that one to be
//! wild, ln(2/π) to either side, and k of them are no more than k times as much. Where more of them come
//! than were expected, each is less evidence ([`Frequency`]).

use super::parameters::OutlierParameters;

const P: &OutlierParameters = &OutlierParameters::DEFAULT;

/// How many samples of a healthy cylinder may be wild.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outliers {
    /// π.
    pub share: f64,
}

impl Outliers {
    /// What is expected of a bus of which nothing is known: one sample in a hundred.
    pub const USUAL: Self = Self { share: 0.01 };

    /// What calibrations expect that do not say it.
    pub const UNSAID: Self = Self { share: 0.02 };

    /// The least that can be stated: no bus is without any.
    pub const LEAST: Self = Self { share: 0.001 };

    /// What one sample is worth at the most, nats.
    pub fn evidence(self) -> f64 {
        libm::log(2.0 / self.share)
    }

    /// The least level that can be relied on, nats: as many wild samples in a row as are beneath
    /// 19.3 nats do not reach it, also beside healthy ones.
    pub fn least_level(self) -> f64 {
        let evidence = self.evidence();
        let beneath = libm::floor(P.least_level / evidence);
        P.least_level.max(beneath * evidence + P.beside)
    }

    /// A: how far off a wild sample is taken for, in deviations of healthy ones. There a normal one is as
    /// rare.
    pub fn reach(self) -> f64 {
        libm::sqrt(2.0 * self.evidence())
    }

    /// What one sample of the mean, and of the mean square, is worth at the most where wild ones are
    /// frequent, nats.
    pub fn evidence_of_frequent(self) -> [f64; 2] {
        [P.in_a_row, P.of_any_side].map(|row| self.least_level() / row)
    }
}

/// How many of the newest samples were wild, and each alone: what stays off is a fault.
#[derive(Clone, Debug)]
pub struct Frequency {
    /// As far as a sample counts, weighed, m.
    farthest: f64,
    /// The share that is frequent.
    frequent: f64,
    /// What the newest sample counts of the share.
    part: f64,
    share: f64,
    /// To which side the newest sample was wild; 0 of one that was not.
    side: f64,
}

impl Frequency {
    /// Of samples that count as far as `farthest`, m.
    pub fn new(outliers: Outliers, farthest: f64) -> Self {
        let frequent = P.frequent * outliers.share;
        Self { farthest, frequent, part: frequent / P.counted, share: 0.0, side: 0.0 }
    }

    /// Takes a sample, weighed, m.
    #[inline]
    pub fn take(&mut self, weighed: f64) {
        let side = if weighed.abs() > self.farthest { weighed.signum() } else { 0.0 };
        let begins = if side != 0.0 && side != self.side { 1.0 } else { 0.0 };
        self.side = side;
        self.share += (begins - self.share) * self.part;
    }

    #[inline]
    pub fn is_high(&self) -> bool {
        self.share > self.frequent
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wild_samples_in_a_row_do_not_reach_the_level_until_they_are_too_many() {
        for (share, row) in [(0.02, 5.0), (0.01, 4.0), (0.001, 3.0)] {
            let outliers = Outliers { share };
            let (level, each) = (outliers.least_level(), outliers.evidence());
            assert!((P.least_level..22.0).contains(&level), "{share}: {level}");
            assert!((row - 1.0) * each + P.beside <= level + 1e-9, "{share}: {level}");
            assert!(row * each > level + 0.9, "{share}: {level}");
            let [frequent, square] = outliers.evidence_of_frequent();
            assert!(4.0 * frequent < level && 5.0 * frequent > level, "{share}");
            assert!(5.0 * square < level && 6.0 * square > level, "{share}");
        }
    }

    /// Samples that are wild every so many, to both sides, for ten minutes at 50 Hz.
    fn is_high(every: usize) -> bool {
        let mut frequency = Frequency::new(Outliers::USUAL, 3e-4);
        for k in 0..30_000_usize {
            let wild = if k % (2 * every) == 0 { 4e-4 } else { -4e-4 };
            frequency.take(if k.is_multiple_of(every) { wild } else { 1e-4 });
        }
        frequency.is_high()
    }

    #[test]
    fn they_are_frequent_where_more_come_than_expected() {
        assert!([30, 100, 250].into_iter().all(is_high));
        assert!(![500, 1000].into_iter().any(is_high));
    }

    #[test]
    fn what_stays_off_is_one_of_them() {
        let mut frequency = Frequency::new(Outliers::USUAL, 3e-4);
        (0..30_000).for_each(|_| frequency.take(5e-4));
        assert!(!frequency.is_high());
    }
}
