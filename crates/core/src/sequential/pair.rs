//! Both readings against the command: which of them has stepped.
//!
//! A Kalman filter follows the rod by the command and both readings, equally. A step on one of them
//! leaves a signature in the two innovations, another one than a step on the other (Willsky and
//! Jones, 1976). It only tells for about half a second: then the filter has followed the step, and
//! in the closed loop the machine has, too.

use super::drive::{Commands, Drive};
use crate::observe::riccati::{self, RiccatiError};
use nalgebra::{Matrix2x3, Matrix3, Vector2, Vector3};

/// Innovations that are kept, and the length of the signatures.
pub const KEPT: usize = 64;

/// Standard deviations of what moves the rod, and its velocity's error, from cycle to cycle: m, m/s
/// and m/s².
pub const PROCESS: [f64; 3] = [6e-5, 2e-4, 3e-3];

/// What a nat against a noise of both is worth.
const AGAINST_BOTH: f64 = 2.0;

/// What of the velocity error's slope is left in the next cycle.
const FADE: f64 = 0.9;

/// A: the length beside what the drive says, that velocity's error and its slope.
pub const fn dynamics(sample_time: f64) -> Matrix3<f64> {
    Matrix3::new(1.0, sample_time, 0.0, 0.0, 1.0, sample_time, 0.0, 0.0, FADE)
}

/// C: both transducers read the length.
const BOTH: Matrix2x3<f64> = Matrix2x3::new(1.0, 0.0, 0.0, 1.0, 0.0, 0.0);

/// What the filter runs on.
#[derive(Clone, Debug)]
pub struct PairDesign {
    /// L: of either innovation, since both transducers are alike.
    gain: [f64; 3],
    drive: Drive,
    sample_time: f64,
    /// Inverse variances of the innovations' sum and difference, 1/m².
    weights: [f64; 2],
    /// What a unit step on C1, and a ramp of one unit a cycle, leave in both innovations. Those of C2
    /// have them exchanged.
    signatures: [[[f64; 2]; KEPT]; 2],
}

impl PairDesign {
    /// For readings whose difference has the `deviation`, m, and whose mean the command predicts to
    /// `prediction`, m (standard deviations; 0 if that is not known).
    ///
    /// # Errors
    /// If there is no gain.
    pub fn new(
        drive: Drive,
        sample_time: f64,
        deviation: f64,
        prediction: f64,
    ) -> Result<Self, RiccatiError> {
        let a = dynamics(sample_time);
        let reading = 0.5 * deviation * deviation;
        let solution = riccati::solve(&a, &BOTH, PROCESS.map(|s| s * s), [reading; 2])?;
        let sum = 2.0 * solution.covariance[(0, 0)] + reading;
        let weights = [1.0 / sum.max(prediction * prediction), 1.0 / reading];
        let l = solution.gain;
        let respond = |fault: fn(usize) -> f64| {
            let mut error = Vector3::zeros();
            core::array::from_fn(|age| {
                let innovation = Vector2::new(error[0] + fault(age), error[0]);
                error = a * error - l * innovation;
                innovation.into()
            })
        };
        let signatures = [respond(|_| 1.0), respond(|age| age as f64 + 1.0)];
        let gain = core::array::from_fn(|state| 0.5 * (l[(state, 0)] + l[(state, 1)]));
        Ok(Self { gain, drive, sample_time, weights, signatures })
    }
}

/// What a fault looks like.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    Step,
    Ramp,
}

/// The filter's state and newest innovations.
#[derive(Clone, Debug)]
pub struct Pair {
    design: PairDesign,
    commands: Commands,
    /// The length, m, the error of the drive's velocity, m/s, and its slope, m/s².
    x: [f64; 3],
    running: bool,
    /// A ring.
    innovations: [[f64; 2]; KEPT],
    next: usize,
    held: usize,
}

impl Pair {
    pub fn new(design: PairDesign) -> Self {
        Self {
            design,
            commands: Commands::default(),
            x: [0.0; 3],
            running: false,
            innovations: [[0.0; 2]; KEPT],
            next: 0,
            held: 0,
        }
    }

    pub fn reset(&mut self) {
        self.commands.clear();
        self.lose();
    }

    /// A cycle without readings or command: what follows is begun anew.
    fn lose(&mut self) {
        self.running = false;
        self.held = 0;
    }

    /// One cycle: `lengths` of C1 and of C2 as C1 would have it, m, and u(k), m/s.
    #[inline]
    pub fn step(&mut self, lengths: Option<[f64; 2]>, command: Option<f64>) {
        match command {
            Some(command) => self.commands.push(command),
            None => self.commands.clear(),
        }
        let PairDesign { gain, drive, sample_time, .. } = &self.design;
        let Some(([c1, c2], velocity)) = lengths.zip(drive.velocity(&self.commands)) else {
            return self.lose();
        };
        if !self.running {
            self.x = [0.5 * (c1 + c2), 0.0, 0.0];
            self.running = true;
        }
        let [length, error, slope] = self.x;
        let innovation = [c1 - length, c2 - length];
        self.innovations[self.next % KEPT] = innovation;
        self.next = (self.next + 1) % KEPT;
        self.held = (self.held + 1).min(KEPT);
        // A x + L ν + B u, without what is 0 in A ([`dynamics`]), both columns of L being the same.
        let sum = innovation[0] + innovation[1];
        self.x = [
            length + sample_time * error + gain[0] * sum + sample_time * velocity,
            error + sample_time * slope + gain[1] * sum,
            FADE * slope + gain[2] * sum,
        ];
        // Whatever is not finite gets there first.
        if !self.x[0].is_finite() {
            self.lose();
        }
    }

    /// The newest innovations, m; `None` before the filter has followed for a while.
    pub fn newest(&self) -> Option<[f64; 2]> {
        (self.held == KEPT).then(|| self.ago(0))
    }

    fn ago(&self, cycles: usize) -> [f64; 2] {
        self.innovations[(self.next + KEPT - 1 - cycles) % KEPT]
    }

    /// A step or a ramp that began between `latest` and `earliest` cycles ago: C1's or C2's? The log-
    /// likelihood of C1 less that of C2, nats; `None` if the filter has not followed for so long.
    ///
    /// Each transducer's log-likelihood ratio is (gᵀ S⁻¹ ν)² / 2 gᵀ S⁻¹ g, at its best onset.
    pub fn compare(&self, form: Form, latest: usize, earliest: usize) -> Option<f64> {
        if earliest >= self.held {
            return None;
        }
        let best = |which: usize| {
            (latest..=earliest).map(|onset| self.likelihood(form, which, onset)).fold(0.0, f64::max)
        };
        Some(best(0) - best(1))
    }

    fn likelihood(&self, form: Form, which: usize, onset: usize) -> f64 {
        let PairDesign { weights: [sum, difference], signatures, .. } = &self.design;
        let signature = &signatures[form as usize];
        let (mut dot, mut norm) = (0.0, 0.0);
        for (age, [g1, g2]) in signature.iter().enumerate().take(onset + 1) {
            let (mut g1, mut g2) = (*g1, *g2);
            if which == 1 {
                (g1, g2) = (g2, g1);
            }
            let [n1, n2] = self.ago(onset - age);
            let (plus, minus) = (0.5 * (g1 + g2), 0.5 * (g1 - g2));
            dot += sum * plus * (n1 + n2) + difference * minus * (n1 - n2);
            norm += 2.0 * (sum * plus * plus + difference * minus * minus);
        }
        dot * dot / (2.0 * norm)
    }

    /// Whose noise the innovations ν of the newest `cycles` are: the log-likelihood of C1 less that of
    /// C2, nats, as far as either is more likely than both or neither; `None` if the filter has not
    /// followed for so long.
    ///
    /// A part f of the difference d = ν1 − ν2 is the fault, the rest healthy. If C1 is noisy, the
    /// sum s = ν1 + ν2 follows f d, and −f d if it is C2. Around these it varies as much as healthy
    /// sums do, or, where the rod itself moves without a command, as the innocent one shows. If
    /// both are noisy, it follows neither, and varies as it does; since two faults at once are less
    /// likely beforehand, evidence against them counts twice.
    pub fn energy(&self, cycles: usize) -> Option<f64> {
        if cycles > self.held {
            return None;
        }
        let (mut energies, mut differences) = ([0.0; 2], 0.0);
        for [n1, n2] in (0..cycles).map(|age| self.ago(age)) {
            energies = [energies[0] + n1 * n1, energies[1] + n2 * n2];
            differences += (n1 - n2) * (n1 - n2);
        }
        // Healthy variances of s and of d.
        let [sum, difference] = self.design.weights.map(|weight| 2.0 / weight);
        let count = cycles as f64;
        let part = (1.0 - count * difference / differences.max(f64::MIN_POSITIVE)).max(0.0);
        let innocent = 4.0 * energies[0].min(energies[1]) / count;
        let around = (sum + part * difference).max(innocent);
        let together = energies[0] - energies[1];
        let between = 2.0 * part * together.abs() / around;
        // Σ s², and what is left of it around the guilty one's f d.
        let sums = 2.0 * (energies[0] + energies[1]) - differences;
        let left = sums - 2.0 * part * together.abs() + part * part * differences;
        let free = (sums / count).max(sum);
        let beyond = 0.5 * (count * libm::log(free / around) + sums / free - left / around);
        Some(between.min(AGAINST_BOTH * beyond).max(0.0).copysign(together))
    }
}

#[cfg(test)]
mod tests {
    use super::super::drive::FEATURES;
    use super::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    const TS: f64 = 0.02;
    const SIGMA: f64 = 7e-5;

    /// The rod goes as fast as the command of this cycle says.
    fn ideal() -> Drive {
        let mut coefficients = [0.0; FEATURES];
        coefficients[0] = 1.0;
        Drive(coefficients)
    }

    fn design() -> PairDesign {
        PairDesign::new(ideal(), TS, SIGMA * 2.0_f64.sqrt(), 0.0).expect("there is a gain")
    }

    /// A rod that follows its command, read with noise and `fault`s from cycle 200 to 210.
    fn follow(seed: u64, fault: impl Fn(usize, f64) -> [f64; 2]) -> Pair {
        followed(seed, 210, fault)
    }

    /// The same until cycle `end`.
    fn followed(seed: u64, end: usize, fault: impl Fn(usize, f64) -> [f64; 2]) -> Pair {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
        let mut pair = Pair::new(design());
        let mut length = 0.0;
        for k in 0..=end {
            let u = 0.3 * (k as f64 * 0.02).sin();
            let wild = normal();
            let faults = if k < 200 { [0.0; 2] } else { fault(k - 200, wild) };
            pair.step(Some(faults.map(|fault| length + fault + SIGMA * normal())), Some(u));
            length += TS * u;
        }
        pair
    }

    #[test]
    fn the_transducer_that_steps_is_told() {
        for seed in 0..20 {
            for size in [5e-4, -5e-4] {
                let one = follow(seed, |_, _| [size, 0.0])
                    .compare(Form::Step, 10, 13)
                    .expect("it follows");
                assert!(one > 5.0, "{seed}: {one:?}");
                let two = follow(seed, |_, _| [0.0, size])
                    .compare(Form::Step, 10, 13)
                    .expect("it follows");
                assert!(two < -5.0, "{seed}: {two:?}");
            }
        }
    }

    #[test]
    fn the_transducer_that_is_noisy_is_told() {
        for seed in 0..20 {
            let one = followed(seed, 225, |_, wild| [4e-4 * wild, 0.0]).energy(26);
            assert!(one.is_some_and(|nats| nats > 6.0), "{seed}: {one:?}");
            let two = followed(seed, 225, |_, wild| [0.0, 4e-4 * wild]).energy(26);
            assert!(two.is_some_and(|nats| nats < -6.0), "{seed}: {two:?}");
        }
    }

    /// Two that are noisy alike, as coarser ones in the place of both: it is neither alone.
    #[test]
    fn two_noisy_transducers_are_nobodys_noise() {
        let mut rng = ChaCha8Rng::seed_from_u64(7);
        let others: Vec<f64> = StandardNormal.sample_iter(&mut rng).take(400).collect();
        let decided = |cycles: usize| {
            let both = (0..200).filter(|seed| {
                let other = |age: usize| others[age + *seed as usize];
                let noises = |age, wild| [4e-4 * wild, 4e-4 * other(age)];
                let nats = followed(*seed, 199 + cycles, noises).energy(cycles);
                nats.expect("it follows").abs() > 6.0
            });
            both.count()
        };
        let decided = [11, 26, 50].map(decided);
        assert!(decided.iter().all(|decided| *decided < 8), "{decided:?} of 200");
    }

    /// Healthy differences have no cause in a transducer, however the rod moves.
    #[test]
    fn healthy_innovations_are_nobodys_noise() {
        for seed in 0..50 {
            for moved in [0.0, 2e-3] {
                let pair = follow(seed, |age, _| [moved * (age as f64).cos(); 2]);
                let nats = pair.energy(40).expect("it follows");
                assert!(nats.abs() < 4.0, "{seed} {moved}: {nats}");
            }
        }
    }

    #[test]
    fn a_rod_that_moves_by_itself_blames_neither() {
        let evidence =
            follow(3, |_, _| [2e-3, 2e-3]).compare(Form::Step, 10, 13).expect("it follows");
        assert!(evidence.abs() < 5.0, "{evidence:?}");
    }

    #[test]
    fn after_a_gap_nothing_is_compared() {
        let mut pair = follow(1, |_, _| [1e-3, 0.0]);
        pair.step(None, Some(0.0));
        assert_eq!(pair.compare(Form::Step, 10, 13), None);
        assert_eq!((pair.newest(), pair.energy(11)), (None, None));
    }
}
