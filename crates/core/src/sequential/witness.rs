//! Tests, from the other cylinders, whether a noise may come from the sampling.
//!
//! A transducer whose noise has grown and a sampling time that has begun to scatter look alike on
//! one cylinder. But the time is common to all: if it were the cause, the residuals of the others
//! would also scatter, and more at higher speed. A noise is therefore a transducer's if the others
//! contradict the claim. Where they cannot, because they stand or move too slowly, nobody is
//! blamed.

use super::noise::Noise;
use super::parameters::{SamplingParameters, WitnessParameters};
use super::samples::NEWEST;
use super::wild::Outliers;
use crate::state::whole;

const P: &WitnessParameters = &WitnessParameters::DEFAULT;

/// Cycles that are kept: as many as of the newest samples.
const KEPT: usize = NEWEST;

/// The newest cycles of a cylinder: the residual, m, and the velocity, m/s, 0 where there is no
/// information.
#[derive(Clone, Debug)]
pub struct Witness {
    ring: [[f64; 2]; KEPT],
    count: usize,
}

whole! { Witness { ring, count } }

impl Default for Witness {
    fn default() -> Self {
        Self { ring: [[0.0; 2]; KEPT], count: 0 }
    }
}

/// The claim that a noise comes from the sampling.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Claim {
    /// Number of newest cycles that the noise covers.
    pub cycles: usize,
    /// Mean square of the time between the samples of C1 and C2 that would explain it, s²; infinite
    /// where no time does.
    pub square: f64,
}

impl Witness {
    /// Takes a cycle.
    #[inline(always)]
    pub const fn push(&mut self, residual: f64, velocity: f64) {
        self.ring[self.count % KEPT] = [residual, velocity];
        self.count = self.count.wrapping_add(1);
    }

    /// Forgets the cycles, which say nothing about later ones.
    pub const fn reset(&mut self) {
        self.ring = [[0.0; 2]; KEPT];
    }

    fn newest(&self, cycles: usize) -> impl Iterator<Item = [f64; 2]> {
        let one = |ago| self.ring[self.count.wrapping_sub(ago) % KEPT];
        (1..=cycles.min(KEPT)).map(one).filter(|[_, velocity]| *velocity != 0.0)
    }

    /// The claim for the newest `cycles`, with the healthy `noise`: a lower bound, since the larger
    /// it is, the less likely the others' residuals are. Both samples belong to one cycle of
    /// `sample_time` seconds.
    pub fn claim(&self, cycles: usize, noise: &Noise, sample_time: f64) -> Claim {
        let (mut count, mut energy, mut squares) = (0.0_f64, 0.0, 0.0);
        for [residual, velocity] in self.newest(cycles) {
            count += 1.0;
            energy += residual * residual;
            squares += velocity * velocity;
        }
        let at_rest = noise.rest * noise.rest * (count + P.luck * libm::sqrt(2.0 * count));
        let square = (energy - at_rest) / squares;
        let possible = square <= sample_time * sample_time;
        Claim { cycles, square: if possible { square } else { f64::INFINITY } }
    }

    /// Log-likelihood of `claim` less that of the healthy `noise`, nats, with this share of
    /// `outliers`.
    pub fn evidence(&self, claim: &Claim, noise: &Noise, outliers: Outliers) -> f64 {
        let timing = libm::sqrt((P.part * claim.square).max(noise.timing * noise.timing));
        let claimed = Noise { timing, ..*noise };
        // As much as it takes for a sample to be wild.
        let most = outliers.evidence();
        let nats = |[residual, velocity]: [f64; 2]| {
            let [healthy, claimed] = [noise, &claimed].map(|noise| noise.variance(velocity));
            let less = residual * residual * (1.0 / healthy - 1.0 / claimed);
            (0.5 * (less - libm::log(claimed / healthy))).min(most)
        };
        self.newest(claim.cycles).map(nats).sum()
    }
}

impl Claim {
    /// Whether the claim is wrong by the other cylinders' evidence for it, nats, or they are too
    /// few to be asked.
    pub fn is_contradicted(&self, others: impl Iterator<Item = f64>) -> bool {
        let (mut count, mut sum, mut most) = (0, 0.0, [f64::NEG_INFINITY; 2]);
        for nats in others {
            (count, sum) = (count + 1, sum + nats);
            most = if nats > most[0] { [nats, most[0]] } else { [most[0], nats.max(most[1])] };
        }
        let (heard, next) = if count < P.many { (sum, most[0]) } else { (sum - most[0], most[1]) };
        let contradicted = heard < -P.contradicted && next < P.borne_out;
        let few = count + 1 < SamplingParameters::DEFAULT.least_cylinders;
        self.square == f64::INFINITY || few || contradicted
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    const TS: f64 = 0.02;
    const HEALTHY: Noise = Noise { rest: 1.5e-4, timing: 2e-4 };

    /// Cylinders with these noises, m, sampled with these jitters, s, for the last 50 cycles. Each
    /// moves up and down at up to `speed`, m/s, at a different phase.
    fn machine(seed: u64, noises: [f64; 6], jitters: [f64; 6], speed: f64) -> [Witness; 6] {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
        std::array::from_fn(|cylinder| {
            let (mut witness, place) = (Witness::default(), 2.0 * normal());
            for k in 0..100 {
                let velocity = speed * (0.015 * f64::from(k) + place).cos();
                let fault = if k < 50 { 0.0 } else { noises[cylinder] * normal() };
                let time = if k < 50 { 0.0 } else { jitters[cylinder] * normal() };
                let healthy = HEALTHY.variance(velocity).sqrt() * normal();
                witness.push(healthy + fault + time * velocity, velocity);
            }
            witness
        })
    }

    /// Whether the others contradict the first one's claim.
    fn contradicted(machine: &[Witness]) -> bool {
        let claim = machine[0].claim(50, &HEALTHY, TS);
        claim.is_contradicted(
            machine[1..].iter().map(|other| other.evidence(&claim, &HEALTHY, Outliers::USUAL)),
        )
    }

    /// Number of contradicted claims out of 200 machines.
    fn count(machine: impl Fn(u64) -> [Witness; 6]) -> usize {
        (0..200).filter(|seed| contradicted(&machine(*seed))).count()
    }

    const NONE: [f64; 6] = [0.0; 6];
    const ONE: [f64; 6] = [3e-4, 0.0, 0.0, 0.0, 0.0, 0.0];

    #[test]
    fn noise_of_one_is_its_own_and_so_is_that_of_two() {
        let one = count(|seed| machine(seed, ONE, NONE, 0.4));
        let two = count(|seed| machine(seed, [3e-4, 0.0, 0.0, 3e-4, 0.0, 0.0], NONE, 0.4));
        assert!(one >= 190 && two >= 180, "{one} and {two} of 200");
    }

    #[test]
    fn what_has_begun_on_all_is_nobodys() {
        for jitter in [3e-4, 1e-3, 3e-3, 8e-3] {
            let wrong = count(|seed| machine(seed, NONE, [jitter; 6], 0.4));
            assert!(wrong <= 1, "{jitter} s: {wrong} of 200");
        }
        for jitter in [1e-3, 3e-3] {
            let half = [jitter, jitter, jitter, 0.0, 0.0, 0.0];
            let wrong = count(|seed| machine(seed, NONE, half, 0.4));
            assert!(wrong <= 40, "{jitter} s on half of them: {wrong} of 200");
        }
    }

    #[test]
    fn others_that_stand_say_nothing_and_neither_do_two_alone() {
        let mut standing = machine(1, ONE, NONE, 0.4);
        standing[1..].fill(Witness::default());
        assert!(!contradicted(&standing));
        assert!(contradicted(&standing[..2]), "there is no majority");
    }

    /// Sampling times cause no noise of a rod that stands, or hardly moves.
    #[test]
    fn noise_at_rest_is_its_own() {
        for velocity in [0.0, 1e-3] {
            let mut standing: [Witness; 6] = Default::default();
            (0..50).for_each(|k| standing[0].push(if k % 2 == 0 { 6e-4 } else { -6e-4 }, velocity));
            assert!(contradicted(&standing), "{velocity} m/s");
        }
        // What chance makes of a healthy one is no claim at all.
        let claim = machine(2, NONE, NONE, 1e-3)[0].claim(50, &HEALTHY, TS);
        assert!(claim.square < 0.0, "{claim:?}");
    }
}
