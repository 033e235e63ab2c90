//! The excursions of a machine's cylinders, and the law that follows from them.
//!
//! Sizes and lengths are pooled, since the transducers are of one kind; how often they occur is the
//! cylinder's own. By the inequality of the means two excursions coincide most often where both
//! transducers share alike, so that it need not be known whose they are.

use super::atoms::atoms;
use super::chains::{
    LEAST_LENGTH_RATIO, LEAST_SIZE_RATIO, half_lengths, half_sizes, halve, most_chains,
};
use super::cylinder::CylinderPopulation;
use super::excursion::Excursion;
use super::law::Law;
use super::quantiles::gamma_quantile;
use super::speeds::CLASSES;
use crate::order_statistics::quantile;

/// Excursions of a machine below which only the plain ones are kept: a few may be wild samples side
/// by side.
const FEW_EXCURSIONS: usize = 12;

/// Least size of a plain one, m.
const PLAIN_SIZE: f64 = 0.25e-3;

/// Least length of a plain one, samples.
const PLAIN_LENGTH: u32 = 6;

/// Quantile of the rate: in one of five cylinders the rate is larger.
const RATE_QUANTILE: f64 = 0.8;

/// Difference of the numbers up and down beyond which the larger one counts, in deviations √n.
const UNLIKE_DIRECTIONS: f64 = 2.5;

/// Deviations by which the busiest class of speed has more than a third, if excursions cluster.
const CLUSTERING_DEVIATIONS: f64 = 3.0;

/// Excursions of a machine below which clustering cannot be seen.
const LEAST_FOR_CLUSTERING: usize = 10;

/// Factor of the chance that is then assumed.
const UNKNOWN_CLUSTERING: f64 = 2.0;

/// Largest chance of one transducer and direction: an excursion begins with every sample.
const LARGEST_CHANCE: f64 = 0.5;

/// Quantile of the sizes that tells the detectors how far sums are clipped.
const CLIP_QUANTILE: f64 = 0.95;

/// What is kept of one cylinder.
#[derive(Clone, Debug)]
pub(super) struct Kept {
    /// Sorted by length.
    pub excursions: Vec<Excursion>,
    /// Number of samples.
    pub judged: u64,
    /// Share of wild samples, those that were dropped as excursions included.
    pub wild_share: f64,
    /// Excursions down and up, those of unknown length included.
    pub directions: [u64; 2],
    pub overlaps: u64,
    /// Number of excursions that were dropped as wild samples side by side.
    pub dropped: u64,
    /// Whether the cylinder can have a law.
    pub has_law: bool,
}

/// The excursions of all cylinders of a machine.
#[derive(Clone, Debug)]
pub struct Population {
    pub(super) cylinders: Vec<Kept>,
    /// Pooled sizes, m, sorted.
    pub(super) sizes: Vec<f64>,
    /// Pooled lengths, samples, sorted.
    pub(super) lengths: Vec<f64>,
    /// Factor of the chance where excursions cluster with the speed, 1 to 3.
    clustering: f64,
}

/// The laws of a machine's cylinders.
#[derive(Clone, Debug, PartialEq)]
pub struct MachineLaw {
    /// Law of each cylinder. `None` where nothing was judged, or more excursions were found than are
    /// kept.
    pub laws: Vec<Option<Law>>,
    /// Share of wild samples of each cylinder.
    pub wild_shares: Vec<f64>,
    /// 95 % quantile of the sizes, m; 0 without excursions.
    pub size_95: f64,
    /// Factor of all chances where excursions cluster with the speed, 1 to 3.
    pub clustering: f64,
}

fn keep(cylinder: &CylinderPopulation) -> Kept {
    let has_law = cylinder.judged() > 0 && !cylinder.too_many();
    let (excursions, wild) = cylinder.screened();
    Kept {
        dropped: (cylinder.excursions().len() - excursions.len()) as u64,
        excursions,
        judged: cylinder.judged(),
        wild_share: cylinder.wild_share(wild),
        directions: cylinder.cut(),
        overlaps: cylinder.overlaps(),
        has_law,
    }
}

impl Kept {
    /// Drops all but plain excursions.
    fn keep_plain(&mut self) {
        let is_plain = |one: &Excursion| one.size >= PLAIN_SIZE && one.length >= PLAIN_LENGTH;
        let (plain, wild): (Vec<_>, Vec<_>) = self.excursions.iter().copied().partition(is_plain);
        let samples: u64 = wild.iter().map(|one| u64::from(one.length)).sum();
        self.wild_share = (self.wild_share + samples as f64 / self.judged.max(1) as f64).min(1.0);
        self.dropped += wild.len() as u64;
        self.excursions = plain;
    }

    /// Chance that an excursion of one direction begins on one transducer, without clustering.
    fn chance(&self) -> f64 {
        let [down, up] = self.directions.map(|count| count as f64);
        let unlike = (up - down).abs() > UNLIKE_DIRECTIONS * (up + down).sqrt();
        let count = if unlike { up.max(down) } else { 0.5 * (up + down) };
        let rate = gamma_quantile(RATE_QUANTILE, count + 1.0) / self.judged.max(1) as f64;
        (0.5 * rate).min(LARGEST_CHANCE)
    }
}

impl Population {
    /// Pools the `cylinders` of a machine. One with more excursions than are kept is left out.
    pub fn new(cylinders: &[CylinderPopulation]) -> Self {
        let mut kept: Vec<Kept> = cylinders.iter().map(keep).collect();
        let count = |kept: &[Kept]| -> usize {
            kept.iter().filter(|one| one.has_law).map(|one| one.excursions.len()).sum()
        };
        if count(&kept) < FEW_EXCURSIONS {
            kept.iter_mut().for_each(Kept::keep_plain);
        }
        for one in &mut kept {
            for excursion in &one.excursions {
                one.directions[usize::from(excursion.positive)] += 1;
            }
        }
        let pool = |of: fn(&Excursion) -> f64| {
            let excursions = kept.iter().filter(|one| one.has_law).flat_map(|one| &one.excursions);
            let mut pooled: Vec<f64> = excursions.map(of).collect();
            pooled.sort_unstable_by(f64::total_cmp);
            pooled
        };
        let (sizes, lengths) = (pool(|one| one.size), pool(|one| f64::from(one.length)));
        let clustering = clustering(sizes.len(), cylinders.iter().zip(&kept));
        Self { cylinders: kept, sizes, lengths, clustering }
    }

    /// Chance of each cylinder, of one transducer and direction, with clustering; 0 of all without
    /// excursions, `None` where there is no law.
    pub(super) fn chances(&self) -> Vec<Option<f64>> {
        let any = !self.sizes.is_empty();
        let chance = |one: &Kept| {
            let chance = (self.clustering * one.chance()).min(LARGEST_CHANCE);
            one.has_law.then_some(if any { chance } else { 0.0 })
        };
        self.cylinders.iter().map(chance).collect()
    }

    /// Mean length of all excursions, samples; 0 of none.
    pub(super) fn mean_length(&self) -> f64 {
        self.lengths.iter().sum::<f64>() / self.lengths.len().max(1) as f64
    }

    /// The laws that follow.
    pub fn law(&self) -> MachineLaw {
        let chances = self.chances();
        let known: Vec<f64> = chances.iter().copied().flatten().collect();
        let mean = known.iter().sum::<f64>() / known.len().max(1) as f64;
        let most = most_chains(self.sizes.len(), mean, self.mean_length());
        let lengths = halve(&self.lengths, most, LEAST_LENGTH_RATIO, half_lengths);
        let sizes = halve(&self.sizes, most, LEAST_SIZE_RATIO, half_sizes);
        let atoms = atoms(self.sizes.len(), &sizes, &lengths);
        let law = |chance: Option<f64>| Some(Law { chance: chance?, atoms: atoms.clone() });
        MachineLaw {
            laws: chances.into_iter().map(law).collect(),
            wild_shares: self.cylinders.iter().map(|one| one.wild_share).collect(),
            size_95: quantile(&sizes, CLIP_QUANTILE),
            clustering: self.clustering,
        }
    }
}

/// The factor of the chance in the busiest of three classes of speed with equal times, of `count`
/// excursions.
fn clustering<'a>(
    count: usize,
    cylinders: impl Iterator<Item = (&'a CylinderPopulation, &'a Kept)>,
) -> f64 {
    if count < LEAST_FOR_CLUSTERING {
        return UNKNOWN_CLUSTERING;
    }
    let mut counts = [0.0; CLASSES];
    for (cylinder, kept) in cylinders.filter(|(_, kept)| kept.has_law) {
        let speeds = kept.excursions.iter().map(|one| one.speed);
        let own = cylinder.speeds().count_by_class(speeds);
        counts.iter_mut().zip(own).for_each(|(count, own)| *count += own);
    }
    let (count, classes) = (count as f64, CLASSES as f64);
    let busiest = counts.into_iter().fold(0.0, f64::max);
    let deviation = (count * (classes - 1.0)).sqrt() / classes;
    let is_chance = busiest <= count / classes + CLUSTERING_DEVIATIONS * deviation;
    if is_chance { 1.0 } else { classes * busiest / count }
}

#[cfg(test)]
mod tests {
    use super::super::quantiles::poisson_quantile;
    use super::super::segment::Segment;
    use super::super::summary::Summary;
    use super::*;

    /// Samples of a quarter of an hour.
    const QUARTER: u32 = 45_000;

    /// An excursion of 0.4 mm and 10 samples.
    const PLAIN: Excursion =
        Excursion { at: 0, size: 0.4e-3, length: 10, positive: true, speed: 0.0 };

    /// A cylinder of a quarter of an hour at speeds from 0 to 0.3 m/s, with these `excursions`.
    fn cylinder(excursions: &[Excursion]) -> CylinderPopulation {
        let mut cylinder = CylinderPopulation::default();
        for k in 0..QUARTER {
            let velocity = 0.3 * f64::from(k % 300) / 300.0;
            cylinder.take(&Segment::Core { residual: 0.0, velocity });
        }
        for one in excursions {
            cylinder.take(&Segment::Excursion(*one));
        }
        cylinder
    }

    /// So many excursions up and down, at all speeds alike.
    fn both(up: u32, down: u32) -> Vec<Excursion> {
        let of = |count: u32, positive| {
            (0..count).map(move |k| {
                let speed = 0.3 * (f64::from(k) + 0.5) / f64::from(count);
                Excursion { positive, speed, ..PLAIN }
            })
        };
        of(up, true).chain(of(down, false)).collect()
    }

    fn chances(cylinders: &[CylinderPopulation]) -> Vec<f64> {
        let laws = Population::new(cylinders).law().laws;
        laws.into_iter().map(|law| law.expect("it was judged").chance).collect()
    }

    #[test]
    fn the_chance_is_of_one_direction_and_transducer() {
        // Gamma quantiles of 26 and 1 (SciPy); half of them are of either transducer.
        let cylinders = [cylinder(&both(25, 25)), cylinder(&[])];
        let [often, never] = chances(&cylinders)[..] else { panic!("two cylinders") };
        assert!((often * 2.0 * 45_000.0 - 30.165_790_326).abs() < 1e-6, "{often}");
        assert!((never * 2.0 * 45_000.0 - 1.609_437_912).abs() < 1e-6, "{never}");
        // One direction alone: 50 − 0 is beyond 2.5 √50, 33 − 17 is not.
        let of = |up, down| 2.0 * 45_000.0 * chances(&[cylinder(&both(up, down))])[0];
        assert!((of(50, 0) - gamma_quantile(0.8, 51.0)).abs() < 1e-9);
        assert!((of(33, 17) - gamma_quantile(0.8, 26.0)).abs() < 1e-9);
    }

    #[test]
    fn without_excursions_there_is_a_law_without_atoms() {
        let MachineLaw { laws, size_95, .. } = Population::new(&[cylinder(&[])]).law();
        assert_eq!(laws, [Some(Law { chance: 0.0, atoms: Vec::new() })]);
        assert!(size_95.abs() < 1e-12);
        // Nothing judged: unknown.
        let nothing = Population::new(&[CylinderPopulation::default()]);
        assert_eq!(nothing.law().laws, [None]);
        assert_eq!(Summary::new(&nothing).per_minute(0.02).to_bits(), 0);
        assert!(Population::new(&[]).law().laws.is_empty());
    }

    #[test]
    fn of_few_only_the_plain_ones_are_kept() {
        let short = Excursion { length: 5, ..PLAIN };
        let small = Excursion { size: 0.24e-3, ..PLAIN };
        let few = [cylinder(&[short, small, PLAIN]), cylinder(&[short; 8])];
        let population = Population::new(&few);
        assert_eq!(
            (population.lengths.clone(), Summary::new(&population).dropped),
            (vec![10.0], 10)
        );
        let wild = population.law().wild_shares;
        assert!((wild[1] - 40.0 / 45_000.0).abs() < 1e-12, "{wild:?}");
        // Nothing is known of how they cluster: it is twice as often.
        let chance = gamma_quantile(0.8, 1.5) / 90_000.0;
        assert!((chances(&few)[0] - 2.0 * chance).abs() < 1e-12);
        assert!((population.law().clustering - 2.0).abs() < 1e-12);
        let many = [cylinder(&[short, small, PLAIN]), cylinder(&[short; 9])];
        assert_eq!(Population::new(&many).lengths.len(), 12);
    }

    #[test]
    fn where_they_cluster_with_the_speed_the_busiest_class_counts() {
        let fast = |count: usize| -> Vec<Excursion> {
            let mut all = both(30, 30);
            all.iter_mut().take(count).for_each(|one| one.speed = 0.29);
            all
        };
        // A third of 60 and three deviations are 31.
        let of = |count| Population::new(&[cylinder(&fast(count))]).law().clustering;
        assert!((of(0) - 1.0).abs() < 1e-12);
        // 25 and 35 of 60 are fast.
        assert!((of(5) - 1.0).abs() < 1e-12, "{}", of(5));
        assert!((of(15) - 1.75).abs() < 1e-9, "{}", of(15));
        assert!((of(60) - 3.0).abs() < 1e-9, "{}", of(60));
    }

    #[test]
    fn files_in_another_order_give_the_same_law() {
        let all: Vec<Excursion> = (0..300_u32)
            .map(|k| Excursion {
                at: u64::from(k),
                size: 1e-6 * f64::from(300 + k * 7919 % 211),
                length: 3 + k * 104_729 % 19,
                positive: k % 3 == 0,
                speed: 1e-3 * f64::from(k * 31 % 300),
            })
            .collect();
        let law = |order: &[Excursion]| {
            let mut cylinder = cylinder(order);
            // Some of the shortest are dropped.
            (0..900).for_each(|_| cylinder.take(&Segment::Wild { samples: 1 }));
            Population::new(&[cylinder]).law()
        };
        let reversed: Vec<Excursion> = all.iter().rev().copied().collect();
        assert_eq!(law(&all), law(&reversed));
    }

    #[test]
    fn one_that_fluctuates_without_end_has_no_law() {
        let many =
            vec![Excursion { length: 300, ..PLAIN }; super::super::cylinder::MOST_EXCURSIONS + 1];
        let population = Population::new(&[cylinder(&many), cylinder(&both(10, 10))]);
        let laws = population.law().laws;
        assert!(laws[0].is_none() && laws[1].is_some());
        assert_eq!(population.lengths, [10.0; 20]);
    }

    /// Chains: an entry of 20 samples becomes two of 10 if two are expected to meet.
    #[test]
    fn a_chain_is_not_a_length() {
        let mut all = both(25, 25);
        let chain = Excursion { length: 20, ..PLAIN };
        // 50 × 2 × 3.4e-4 × 13 = 0.44, of which 3 are the 99 % quantile.
        assert_eq!(poisson_quantile(0.99, 0.44, 50), 3);
        let longest = |all: &[Excursion]| {
            let law = Population::new(&[cylinder(all)]).law().laws.swap_remove(0)?;
            let seen = law.atoms.iter().filter(|atom| atom.weight > 0.02);
            seen.map(|atom| atom.length).max()
        };
        all.push(chain);
        assert_eq!(longest(&all), Some(10));
        all.extend([chain; 3]);
        assert_eq!(longest(&all), Some(20));
    }

    #[test]
    fn nothing_that_is_found_panics() {
        let odd =
            Excursion { at: u64::MAX, size: 1e-300, length: 1, positive: false, speed: 1e300 };
        let largest = Excursion { size: 1e3, length: 1104, ..PLAIN };
        for count in 0..40 {
            let mut all = vec![odd; count];
            all.extend(vec![largest; count / 3]);
            let mut cylinder = cylinder(&all);
            (0..count).for_each(|_| cylinder.take(&Segment::Wild { samples: u32::MAX }));
            let population = Population::new(&[cylinder, CylinderPopulation::default()]);
            let law = population.law();
            for atom in law.laws.iter().flatten().flat_map(|law| &law.atoms) {
                assert!(atom.size > 0.0 && atom.size.is_finite() && atom.length >= 1, "{atom:?}");
                assert!((0.0..=1.0).contains(&atom.weight), "{atom:?}");
            }
            assert!(Summary::new(&population).coincidences.expected.is_finite());
        }
    }
}
