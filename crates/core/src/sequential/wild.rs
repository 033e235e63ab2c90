//! Evidence of wild samples, which are outliers.
//!
//! Some samples are off by any amount without a fault, because of a disturbed line or a wrong bit.
//! Whether or not a calibration has seen any, a share π of them is expected. No sample is therefore
//! more evidence than ln(2/π), the improbability of a wild one in that direction, and k of them are
//! at most k times as much. Where more come than were expected, each is less evidence
//! ([`Frequency`]).

use super::parameters::OutlierParameters;
use crate::state::state;

const P: &OutlierParameters = &OutlierParameters::DEFAULT;

/// Expected share of wild samples on a healthy cylinder.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outliers {
    /// Share π.
    pub share: f64,
}

impl Outliers {
    /// What is expected of a bus of which nothing is known: one sample in a hundred.
    pub const USUAL: Self = Self { share: 0.01 };

    /// What calibrations expect that do not say it.
    pub const UNSAID: Self = Self { share: 0.02 };

    /// The least that can be stated: no bus is without any.
    pub const LEAST: Self = Self { share: 0.001 };

    /// Largest evidence of one sample, nats.
    pub fn evidence(self) -> f64 {
        libm::log(2.0 / self.share)
    }

    /// Least level that can be relied on, nats: as many wild samples in a row as stay below 19.3
    /// nats do not reach it, even beside healthy ones.
    pub fn least_level(self) -> f64 {
        let evidence = self.evidence();
        let beneath = libm::floor(P.least_level / evidence);
        P.least_level.max(beneath * evidence + P.beside)
    }

    /// Distance A at which a wild sample is assumed, in deviations of healthy ones. A normal sample
    /// is equally rare there.
    pub fn reach(self) -> f64 {
        libm::sqrt(2.0 * self.evidence())
    }

    /// Largest evidence of one sample for the mean, and for the mean square, where wild ones are
    /// frequent, nats.
    pub fn evidence_of_frequent(self) -> [f64; 2] {
        [P.in_a_row, P.of_any_side].map(|row| self.least_level() / row)
    }
}

/// Frequency of single wild samples among the newest; a residual that stays off is a fault.
#[derive(Clone, Debug)]
pub struct Frequency {
    /// Value beyond which a weighted sample is wild, m.
    farthest: f64,
    /// Share from which wild samples are frequent.
    frequent: f64,
    /// Weight of the newest sample in the share.
    part: f64,
    share: f64,
    /// Direction in which the newest sample was wild; 0 if it was not.
    side: f64,
}

state! {
    Frequency { share, side }
    but { farthest, frequent, part }
}

impl Frequency {
    /// A frequency for samples that count as far as `farthest`, m.
    pub fn new(outliers: Outliers, farthest: f64) -> Self {
        let frequent = P.frequent * outliers.share;
        Self { farthest, frequent, part: frequent / P.counted, share: 0.0, side: 0.0 }
    }

    /// Takes a weighted sample, m.
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

    /// Whether the frequency is high after samples of which every `every`-th is wild, in both
    /// directions, for ten minutes at 50 Hz.
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
