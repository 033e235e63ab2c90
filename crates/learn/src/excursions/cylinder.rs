//! Excursions in the difference of one cylinder, with the time that they are counted in.

use super::excursion::Excursion;
use super::quantiles::poisson_quantile;
use super::segment::Segment;
use super::speeds::SpeedTimes;

/// Most excursions of a cylinder that are kept: half a megabyte. One a second in four hours is not
/// what a healthy transducer does.
pub const MOST_EXCURSIONS: usize = 16_384;

/// Share of wild samples beyond which some of them lie side by side by chance.
const MANY_WILD: f64 = 5e-4;

/// Number of ways in which three wild samples within five follow each other, both directions.
const WILD_TRIPLES: f64 = 20.0;

/// Longest entry that may be wild samples side by side, samples.
const LONGEST_WILD: u32 = 6;

/// Chance that there are not more such entries than are dropped.
const WILD_QUANTILE: f64 = 0.99;

/// Excursions, wild samples and core of one cylinder, collected of a [`Segmentation`]'s results.
///
/// [`Segmentation`]: super::Segmentation
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CylinderPopulation {
    excursions: Vec<Excursion>,
    /// Number of samples.
    judged: u64,
    /// Number of core samples.
    core: u64,
    /// Number of wild samples.
    wild: u64,
    /// Number of samples of candidates in which nothing counts.
    unexplained: u64,
    /// Number of excursions of unknown length: down, up.
    cut: [u64; 2],
    /// Number of pairs of excursions that overlap.
    overlaps: u64,
    /// Number of excursions found, those that are not kept included.
    found: u64,
    speeds: SpeedTimes,
}

impl CylinderPopulation {
    /// Takes what the segmentation has found.
    pub fn take(&mut self, segment: &Segment) {
        match segment {
            Segment::Core { velocity, .. } => {
                self.core += 1;
                self.judge(*velocity);
            }
            Segment::Off { velocity, .. } => self.judge(*velocity),
            Segment::Wild { samples } => self.wild += u64::from(*samples),
            Segment::Excursion(excursion) => self.keep(*excursion),
            Segment::Overlap(both) => {
                for excursion in both {
                    self.keep(*excursion);
                }
                self.overlaps += 1;
            }
            Segment::Cut { positive } => self.cut[usize::from(*positive)] += 1,
            Segment::Overlong { .. } => {}
            Segment::Unexplained { samples } => self.unexplained += u64::from(*samples),
        }
    }

    fn judge(&mut self, velocity: f64) {
        self.judged += 1;
        self.speeds.add(velocity);
    }

    fn keep(&mut self, excursion: Excursion) {
        self.found += 1;
        if self.excursions.len() < MOST_EXCURSIONS {
            self.excursions.push(excursion);
        }
    }

    /// Excursions in the order in which they were found, `MOST_EXCURSIONS` at most.
    pub fn excursions(&self) -> &[Excursion] {
        &self.excursions
    }

    /// Number of samples T.
    pub const fn judged(&self) -> u64 {
        self.judged
    }

    /// Number of core samples.
    pub const fn core(&self) -> u64 {
        self.core
    }

    /// Number of wild samples.
    pub const fn wild(&self) -> u64 {
        self.wild
    }

    /// Number of samples that were off, of which no excursion was made.
    pub const fn unexplained(&self) -> u64 {
        self.unexplained
    }

    /// Number of excursions within which the stream began or ended: down, up.
    pub const fn cut(&self) -> [u64; 2] {
        self.cut
    }

    /// Number of pairs of excursions that overlap.
    pub const fn overlaps(&self) -> u64 {
        self.overlaps
    }

    /// Whether more excursions were found than are kept: the cylinder has no law.
    pub fn too_many(&self) -> bool {
        self.found > self.excursions.len() as u64
    }

    pub(super) const fn speeds(&self) -> &SpeedTimes {
        &self.speeds
    }

    /// Excursions without those that may be wild samples side by side, the shortest first, and the
    /// number of wild samples with those.
    pub(super) fn screened(&self) -> (Vec<Excursion>, u64) {
        let mut excursions = self.excursions.clone();
        excursions.sort_unstable_by(Excursion::shorter_first);
        let short = excursions.partition_point(|one| one.length <= LONGEST_WILD);
        let (samples, share) = (self.judged as f64, self.wild_share(self.wild));
        let mut dropped = 0;
        if share > MANY_WILD {
            // Half of the wild samples are of either direction.
            let mean = WILD_TRIPLES * samples * (0.5 * share).powi(3);
            dropped = poisson_quantile(WILD_QUANTILE, mean, short as u32) as usize;
        }
        let wild = excursions.drain(..dropped).map(|one| u64::from(one.length)).sum::<u64>();
        (excursions, self.wild + wild)
    }

    /// Share of all samples that `wild` samples are.
    pub(super) fn wild_share(&self, wild: u64) -> f64 {
        (wild as f64 / self.judged.max(1) as f64).min(1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn excursion(length: u32) -> Segment {
        Segment::Excursion(Excursion { at: 0, size: 4e-4, length, positive: true, speed: 0.0 })
    }

    #[test]
    fn the_shortest_are_dropped_where_many_are_wild() {
        let of = |wild: u32| {
            let mut population = CylinderPopulation::default();
            for _ in 0..45_000 {
                population.take(&Segment::Core { residual: 0.0, velocity: 0.0 });
            }
            for length in [7, 3, 10, 5, 3, 4, 6] {
                population.take(&excursion(length));
            }
            (0..wild).for_each(|_| population.take(&Segment::Wild { samples: 1 }));
            let (kept, wild) = population.screened();
            (kept.iter().map(|one| one.length).collect::<Vec<_>>(), wild)
        };
        assert_eq!(of(22), (vec![3, 3, 4, 5, 6, 7, 10], 22));
        // 2 % are wild: 20 × 45,000 × 1e-6 = 0.9, and 4 are the 99 % quantile.
        assert_eq!(of(900), (vec![6, 7, 10], 900 + 15));
        // None that is longer than six.
        assert_eq!(of(9000).0, [7, 10]);
    }

    #[test]
    fn no_more_are_kept_than_fit() {
        let mut population = CylinderPopulation::default();
        (0..MOST_EXCURSIONS).for_each(|_| population.take(&excursion(10)));
        assert!(!population.too_many());
        population.take(&excursion(10));
        assert!(population.too_many());
        assert_eq!(population.excursions().len(), MOST_EXCURSIONS);
    }
}
