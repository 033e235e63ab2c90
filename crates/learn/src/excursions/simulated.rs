//! Tests of segmentation and law on simulated transducers: noise, rounding, and excursions that are
//! known.

use super::law::Law;
use super::summary::Coincidences;
use super::*;

/// Counts of both readings, m.
const COUNT: f64 = 0.1085e-3;

/// Noise of each reading, m.
const NOISE: f64 = 0.05e-3;

/// Deviation of the difference at rest, m, with rounding.
const REST: f64 = 0.0838e-3;

/// Size of an excursion: four counts, m.
const SIZE: f64 = 4.0 * COUNT;

/// Samples of a quarter of an hour.
const QUARTER: usize = 45_000;

/// Uniform numbers by splitmix64 (Steele, Lea and Flood 2014), and normal ones by Box and Muller. Of a
/// plain xorshift the number that follows a small one is small, so that excursions would have one sign.
struct Random(u64);

impl Random {
    const fn new(seed: u64) -> Self {
        Self(seed << 32)
    }

    /// Between 0 and 1, never 0.
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut bits = self.0;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        bits ^= bits >> 31;
        ((bits >> 11) as f64 + 0.5) / (1_u64 << 53) as f64
    }

    fn normal(&mut self) -> f64 {
        let (radius, angle) = (-2.0 * self.uniform().ln(), std::f64::consts::TAU * self.uniform());
        radius.sqrt() * angle.cos()
    }
}

/// A transducer that fluctuates: samples that are left of an excursion, its offset, m, and how many there
/// were.
#[derive(Default)]
struct Transducer {
    left: u32,
    offset: f64,
    begun: u64,
}

impl Transducer {
    fn offset(&mut self, chance: f64, random: &mut Random) -> f64 {
        if self.left == 0 && random.uniform() < chance {
            self.left = 10;
            self.begun += 1;
            self.offset = if random.uniform() < 0.5 { SIZE } else { -SIZE };
        }
        if self.left == 0 {
            return 0.0;
        }
        self.left -= 1;
        self.offset
    }
}

/// What two transducers do.
#[derive(Clone, Copy)]
struct Plant {
    /// Chance of an excursion with each reading of a transducer that is in none.
    excursions: f64,
    /// Chance of a spike of a reading.
    spikes: f64,
    /// Whether the rod moves, so that each rounding is another one.
    moves: bool,
}

/// A healthy machine as in figure 5-9 of the thesis: four counts for 0.2 s.
const THESIS: Plant = Plant { excursions: 5e-4, spikes: 0.0, moves: false };

/// One without excursions.
const CALM: Plant = Plant { excursions: 0.0, ..THESIS };

/// A cylinder as found, and the number of excursions that there were.
struct Simulated {
    population: CylinderPopulation,
    begun: u64,
}

impl Plant {
    /// Noise and rounding of a reading that is `offset` off, m.
    fn reading(&self, offset: f64, random: &mut Random) -> f64 {
        let place = if self.moves { COUNT * random.uniform() } else { 0.0 };
        ((place + offset + NOISE * random.normal()) / COUNT).round() * COUNT - place
    }

    /// `samples` of two transducers, beyond which `extra` is added to the difference, m.
    fn simulate(&self, seed: u64, samples: usize, extra: impl Fn(usize) -> f64) -> Simulated {
        let mut random = Random::new(seed);
        let mut transducers = [Transducer::default(), Transducer::default()];
        let mut segmentation = Segmentation::new(REST, 0.0);
        let mut population = CylinderPopulation::default();
        for place in 0..samples {
            let [c1, c2] = [0, 1].map(|which: usize| {
                let mut offset = transducers[which].offset(self.excursions, &mut random);
                if random.uniform() < self.spikes {
                    offset += if random.uniform() < 0.5 { SIZE } else { -SIZE };
                }
                self.reading(offset, &mut random)
            });
            let difference = c1 - c2 + extra(place);
            segmentation.push(difference, 0.0, |segment| population.take(&segment));
        }
        segmentation.finish(|segment| population.take(&segment));
        Simulated { population, begun: transducers.iter().map(|one| one.begun).sum() }
    }

    /// Twelve cylinders of a quarter of an hour.
    fn cylinders(&self) -> Vec<Simulated> {
        (1..=12).map(|seed| self.simulate(seed, QUARTER, |_| 0.0)).collect()
    }
}

fn excursions(cylinders: &[Simulated]) -> impl Iterator<Item = Excursion> {
    cylinders.iter().flat_map(|one| one.population.excursions().iter().copied())
}

/// Lengths of what is found, sorted, samples.
fn lengths(cylinders: &[Simulated]) -> Vec<u32> {
    let mut lengths: Vec<u32> = excursions(cylinders).map(|one| one.length).collect();
    lengths.sort_unstable();
    lengths
}

/// The same cylinders with a rod that stands, whose rounding is always the same, and one that moves.
fn both_ways(plant: Plant) -> [Vec<Simulated>; 2] {
    [false, true].map(|moves| Plant { moves, ..plant }.cylinders())
}

#[test]
fn excursions_are_found_with_their_size_and_length() {
    for cylinders in both_ways(THESIS) {
        for Simulated { population, begun } in &cylinders {
            let found = population.excursions().len() as u64;
            // Two of a quarter of an hour may cancel, or split one.
            assert!((30..=60).contains(&found) && found.abs_diff(*begun) <= 2, "{found} {begun}");
            assert_eq!(population.judged(), QUARTER as u64);
            assert!(population.wild() <= 10 && !population.too_many());
        }
        let lengths = lengths(&cylinders);
        let count = lengths.len();
        // All but what overlaps: a sample that noise puts on the other side of an edge.
        let exact = lengths.iter().filter(|length| (9..=11).contains(*length)).count();
        assert!(lengths[count / 2] == 10 && 100 * exact >= 98 * count, "{lengths:?}");
        assert!(lengths[count - 1] <= 20, "{lengths:?}");
        let mut sizes: Vec<f64> = excursions(&cylinders).map(|one| one.size).collect();
        sizes.sort_unstable_by(f64::total_cmp);
        let within = sizes.iter().filter(|size| (0.35e-3..0.45e-3).contains(*size)).count();
        assert!(10 * within >= 9 * count, "{within} of {count}");
        assert!(sizes[0] > 0.2e-3 && sizes[count - 3] < 0.5e-3, "{sizes:?}");
    }
}

#[test]
fn the_core_alone_has_no_excursions() {
    for cylinders in both_ways(CALM) {
        let lengths = lengths(&cylinders);
        assert!(lengths.len() <= 1 && lengths.iter().all(|length| *length <= 3), "{lengths:?}");
        for Simulated { population, .. } in &cylinders {
            assert!(population.judged() - population.core() < 100);
        }
    }
}

#[test]
fn spikes_are_wild() {
    for cylinders in both_ways(Plant { spikes: 0.01, ..CALM }) {
        for Simulated { population, .. } in &cylinders {
            assert!(population.excursions().len() <= 6, "{:?}", population.excursions());
            // 900 spikes, of which a fifth is drowned by noise or lies beside another one.
            assert!((450..=900).contains(&population.wild()), "{}", population.wild());
            // Three wild samples within five may look like an excursion; the law drops them.
            let (kept, _) = population.screened();
            assert!(kept.len() <= 4 && kept.iter().all(|one| one.length <= 7), "{kept:?}");
        }
        let lengths = lengths(&cylinders);
        assert!(lengths.len() <= 12 * 3, "{lengths:?}");
        let short = lengths.iter().filter(|length| **length <= 5).count();
        assert!(10 * short >= 9 * lengths.len(), "{lengths:?}");
    }
}

/// A profile that is 0.2 mm off in one place, 2.4 deviations of the noise: of 1080 passes few look as if
/// they had edges.
#[test]
fn a_ramp_is_no_excursion() {
    // To 0.2 mm within 2 s, 2 s there, and back, every 10 s.
    let ramp = |place: usize| {
        let phase = (place % 500) as f64 / 100.0;
        0.2e-3 * phase.min(3.0 - phase).clamp(0.0, 1.0)
    };
    for moves in [false, true] {
        let plant = Plant { moves, ..CALM };
        let cylinders: Vec<Simulated> =
            (1..=12).map(|seed| plant.simulate(seed, QUARTER, ramp)).collect();
        let lengths = lengths(&cylinders);
        assert!(lengths.len() <= 90, "{lengths:?}");
        // None is as long as the ramp.
        assert!(lengths.iter().all(|length| *length < 50), "{lengths:?}");
        let off: u64 = cylinders.iter().map(|one| one.population.unexplained()).sum();
        assert!(off > 1080 * 90, "{off}");
    }
}

/// A level of one excursion from each of `begins`, for 10 samples.
fn levels(begins: [usize; 2]) -> impl Fn(usize) -> f64 {
    move |place| {
        let on = begins.iter().filter(|begin| (**begin..**begin + 10).contains(&place)).count();
        on as f64 * SIZE
    }
}

#[test]
fn two_on_each_others_end_are_one_of_twice_the_length() {
    let (mut one_alone, mut exact) = (0, 0);
    for seed in 1..=100 {
        let Simulated { population, .. } = CALM.simulate(seed, 200, levels([100, 110]));
        // Noise that puts two successive samples below half divides one in a hundred.
        let [one] = population.excursions() else { continue };
        one_alone += 1;
        exact += u32::from((one.at, one.length) == (100, 20));
        assert!((18..=22).contains(&one.length) && (one.size - SIZE).abs() < 0.1e-3, "{one:?}");
    }
    assert!(one_alone >= 95 && exact >= 90, "{one_alone} {exact}");
}

#[test]
fn two_that_overlap_by_half_are_two() {
    let (mut two, mut exact, mut sizes) = (0, 0, 0.0);
    for seed in 1..=100 {
        let Simulated { population, .. } = CALM.simulate(seed, 200, levels([100, 105]));
        if population.overlaps() == 0 {
            continue;
        }
        two += 1;
        for (excursion, begin) in population.excursions().iter().zip([100, 105]) {
            exact += u32::from((excursion.at, excursion.length) == (begin, 10));
            assert!((8..=12).contains(&excursion.length), "{excursion:?}");
            assert!((excursion.size - SIZE).abs() < 0.15e-3, "{excursion:?}");
            sizes += excursion.size;
        }
    }
    assert!(two >= 90 && 10 * exact >= 9 * 2 * two, "{two} {exact}");
    assert!((sizes / f64::from(2 * two) - 0.41e-3).abs() < 0.02e-3, "{sizes}");
}

/// A chain of two is learnt as two, not as an excursion of twice the length: test of the whole way.
#[test]
fn the_law_of_six_cylinders() {
    let chain = |place: usize| if (2000..2020).contains(&place) { SIZE } else { 0.0 };
    let mut cylinders: Vec<CylinderPopulation> =
        (1..=5).map(|seed| THESIS.simulate(seed, QUARTER, |_| 0.0).population).collect();
    cylinders.push(THESIS.simulate(6, QUARTER, chain).population);
    let longest = |one: &CylinderPopulation| one.excursions().iter().map(|it| it.length).max();
    assert!(cylinders.iter().filter_map(longest).max() >= Some(18));
    let population = Population::new(&cylinders);
    let MachineLaw { laws, size_95, wild_shares, clustering } = population.law();
    assert_eq!((laws.len(), wild_shares.len(), clustering), (6, 6, 1.0));
    assert!((0.43e-3..0.47e-3).contains(&size_95), "{size_95}");
    for law in laws {
        let Law { chance, atoms } = law.expect("all were judged");
        assert!((2e-4..4e-4).contains(&chance), "{chance}");
        let beyond = |limit| -> f64 {
            atoms.iter().filter(|atom| atom.length > limit).map(|atom| atom.weight).sum()
        };
        // The longest part, of one in twenty, ends at 11; the tail has 1 of n + 1, which is about 290.
        assert!((0.002..0.005).contains(&beyond(11)), "{} {}", beyond(11), beyond(13));
        assert!((atoms.iter().map(|atom| atom.weight).sum::<f64>() - 1.0).abs() < 1e-12);
    }
    let summary = Summary::new(&population);
    assert!((2.5..3.5).contains(&summary.per_minute(0.02)), "{}", summary.per_minute(0.02));
    assert_eq!((summary.lengths[0], summary.coincidences.are_too_many()), (10.0, false));
}

/// How often both transducers are off at once follows from how often one is. Some fewer are seen, since
/// overlaps of a few samples look like a chain.
#[test]
fn coincidences_are_as_many_as_computed() {
    let often = Plant { excursions: 3e-3, ..THESIS };
    let cylinders: Vec<CylinderPopulation> =
        (1..=12).map(|seed| often.simulate(seed, QUARTER, |_| 0.0).population).collect();
    let Coincidences { seen, expected, most } =
        Summary::new(&Population::new(&cylinders)).coincidences;
    let ratio = seen as f64 / expected;
    assert!(seen > 20 && seen <= most && (0.5..1.3).contains(&ratio), "{seen} {expected} {most}");
}
