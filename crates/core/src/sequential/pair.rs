//! Both readings against the command: which of them has stepped.
//!
//! A Kalman filter follows the rod by the command and both readings, equally. A step on one of them
//! leaves a signature in the two innovations, another one than a step on the other (Willsky and
//! Jones, 1976). It only tells for about half a second: then the filter has followed the step, and
//! in the closed loop the machine has, too.

mod onset;

use super::drive::{Commands, Drive};
use super::parameters::{PairParameters, SequentialParameters};
use super::whitening::{ORDER, Whitening};
use crate::observe::riccati::{self, RiccatiError};
use crate::state::state;
use crate::time;
use nalgebra::{Matrix2x3, Matrix3, Vector2, Vector3};

/// Innovations that are kept, and the length of the signatures: those of
/// [`PairParameters::followed_for`] up to 100 Hz.
pub const KEPT: usize = 128;

/// A: the length beside what the drive says, that velocity's error and its slope.
pub fn dynamics(sample_time: f64, parameters: &PairParameters) -> Matrix3<f64> {
    let left = parameters.slope_left.per_cycle(sample_time);
    Matrix3::new(1.0, sample_time, 0.0, 0.0, 1.0, sample_time, 0.0, 0.0, left)
}

/// C: both transducers read the length.
const BOTH: Matrix2x3<f64> = Matrix2x3::new(1.0, 0.0, 0.0, 1.0, 0.0, 0.0);

/// How well the command predicts the mean of both readings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prediction {
    /// Standard deviation of its errors, m; 0 where it is not known.
    pub deviation: f64,
    /// Prediction of the next one from the ones before; `None` where nobody has measured it.
    pub whitening: Option<Whitening>,
}

impl Prediction {
    /// Nobody has measured it.
    pub const UNKNOWN: Self = Self { deviation: 0.0, whitening: None };
}

/// What the filter runs on.
#[derive(Clone, Debug)]
pub struct PairDesign {
    /// L: of either innovation, since both transducers are alike.
    gain: [f64; 3],
    drive: Drive,
    sample_time: f64,
    parameters: &'static SequentialParameters,
    /// What of the slope is left in the next cycle.
    left: f64,
    /// Cycles until it has followed for a while.
    followed: usize,
    /// Twice the inverse variances of the innovations' sum and difference, 1/m².
    weights: [f64; 2],
    whitening: Whitening,
    /// Evidence that decides whose a fault is, nats.
    decided: f64,
    /// What a unit step on C1, and a ramp of one unit a cycle, leave in both innovations. Those of C2
    /// have them exchanged.
    signatures: [Signature; 2],
}

/// What a fault of C1 leaves in the innovations, by its age in cycles.
#[derive(Clone, Debug)]
struct Signature {
    /// Half of their sum, less what the ones before predict of it.
    plus: [f64; KEPT],
    /// Half of their difference.
    minus: [f64; KEPT],
}

impl Signature {
    fn of(innovations: [[f64; 2]; KEPT], whitening: &Whitening) -> Self {
        let sum = innovations.map(|[g1, g2]| 0.5 * (g1 + g2));
        let before = |age: usize, cycles: usize| if cycles > age { 0.0 } else { sum[age - cycles] };
        Self {
            plus: core::array::from_fn(|age| {
                whitening.unpredicted(sum[age], |ago| before(age, ago))
            }),
            minus: innovations.map(|[g1, g2]| 0.5 * (g1 - g2)),
        }
    }
}

impl PairDesign {
    /// For readings whose difference has the standard deviation `deviation`, m.
    ///
    /// # Errors
    /// If there is no gain.
    pub fn new(
        drive: Drive,
        sample_time: f64,
        deviation: f64,
        prediction: Prediction,
        parameters: &'static SequentialParameters,
    ) -> Result<Self, RiccatiError> {
        let own = &parameters.pair;
        let a = dynamics(sample_time, own);
        let reading = 0.5 * deviation * deviation;
        let solution = riccati::solve(&a, &BOTH, own.process_of(sample_time), [reading; 2])?;
        let sum = 2.0 * solution.covariance[(0, 0)] + reading;
        let off = prediction.deviation;
        let decided = match prediction.whitening {
            Some(_) => own.decided,
            None => own.decided_of_any,
        };
        let whitening = prediction.whitening.unwrap_or(Whitening::NONE);
        let weights = [1.0 / sum.max(off * off), 1.0 / reading];
        let l = solution.gain;
        let respond = |fault: fn(usize) -> f64| {
            let mut error = Vector3::zeros();
            core::array::from_fn(|age| {
                let innovation = Vector2::new(error[0] + fault(age), error[0]);
                error = a * error - l * innovation;
                innovation.into()
            })
        };
        let signatures = [respond(|_| 1.0), respond(|age| age as f64 + 1.0)]
            .map(|innovations| Signature::of(innovations, &whitening));
        let gain = core::array::from_fn(|state| 0.5 * (l[(state, 0)] + l[(state, 1)]));
        let followed = (time::samples(own.followed_for, sample_time) as usize).min(KEPT);
        let left = a[(2, 2)];
        Ok(Self {
            gain,
            drive,
            sample_time,
            parameters,
            left,
            followed,
            weights,
            whitening,
            decided,
            signatures,
        })
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
    /// Velocity by the command until the next cycle, m/s, where it is known.
    velocity: Option<f64>,
    /// A ring.
    innovations: [[f64; 2]; KEPT],
    next: usize,
    held: usize,
}

state! {
    Pair { commands, x, running, velocity, innovations, next, held }
    but { design }
    sound |it| it.next < KEPT && it.held <= KEPT
}

impl Pair {
    pub fn new(design: PairDesign) -> Self {
        let commands = Commands::new(&design.parameters.drive, design.sample_time);
        Self {
            design,
            commands,
            x: [0.0; 3],
            running: false,
            velocity: None,
            innovations: [[0.0; 2]; KEPT],
            next: 0,
            held: 0,
        }
    }

    pub fn reset(&mut self) {
        self.commands.clear();
        self.velocity = None;
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
        let PairDesign { gain, drive, sample_time, left, .. } = &self.design;
        self.velocity = drive.velocity(&self.commands);
        let Some(([c1, c2], velocity)) = lengths.zip(self.velocity) else {
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
            left * slope + gain[2] * sum,
        ];
        // Whatever is not finite gets there first.
        if !self.x[0].is_finite() {
            self.lose();
        }
    }

    /// Velocity by the command alone until the next cycle, m/s; `None` before enough commands came.
    pub const fn velocity(&self) -> Option<f64> {
        self.velocity
    }

    /// The newest innovations, m; `None` before the filter has followed for a while.
    pub fn newest(&self) -> Option<[f64; 2]> {
        (self.held >= self.design.followed).then(|| self.ago(0))
    }

    fn ago(&self, cycles: usize) -> [f64; 2] {
        self.innovations[(self.next + KEPT - 1 - cycles) % KEPT]
    }

    /// Evidence of [`Self::compare`] that decides, nats, for either of them.
    pub const fn decided(&self) -> f64 {
        self.design.decided
    }

    /// A step or a ramp that began between `latest` and `earliest` cycles ago: C1's or C2's? The log-
    /// likelihood of C1 less that of C2, nats; `None` if the filter has not followed for so long.
    ///
    /// Each transducer's log-likelihood ratio is (gᵀ S⁻¹ ν)² / 2 gᵀ S⁻¹ g, at its best onset. S is that of
    /// innovations whose difference is white, and whose sum a [`Whitening`] makes so: the same error of the
    /// command is in several of them.
    pub fn compare(&self, form: Form, latest: usize, earliest: usize) -> Option<f64> {
        if earliest + ORDER >= self.held {
            return None;
        }
        let sum = |ago: usize| self.ago(ago).iter().sum::<f64>();
        let mut seen = [[0.0; 2]; KEPT];
        for (ago, seen) in seen[..=earliest].iter_mut().enumerate() {
            let [n1, n2] = self.ago(ago);
            let rest = self.design.whitening.unpredicted(n1 + n2, |cycles| sum(ago + cycles));
            *seen = [rest, n1 - n2];
        }
        let best = (latest..=earliest).fold([0.0_f64; 2], |best, onset| {
            let nats = self.likelihoods(form, &seen[..=onset]);
            core::array::from_fn(|which| best[which].max(nats[which]))
        });
        Some(best[0] - best[1])
    }

    /// Log-likelihood ratios of C1 and of C2 where the fault began with the oldest of what was `seen`: sum,
    /// made white, and difference of the innovations, m, the newest first.
    fn likelihoods(&self, form: Form, seen: &[[f64; 2]]) -> [f64; 2] {
        let PairDesign { weights, whitening, signatures, .. } = &self.design;
        let [sum, difference] = [weights[0] / whitening.left(), weights[1]];
        let Signature { plus, minus } = &signatures[form as usize];
        let (mut together, mut between, mut norm) = (0.0, 0.0, 0.0);
        for ([s, d], (plus, minus)) in seen.iter().rev().zip(plus.iter().zip(minus)) {
            together += sum * plus * s;
            between += difference * minus * d;
            norm += 2.0 * (sum * plus * plus + difference * minus * minus);
        }
        // C2's signature is C1's with both innovations exchanged.
        [together + between, together - between].map(|dot| dot * dot / (2.0 * norm))
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
        Some(
            between
                .min(self.design.parameters.pair.against_both * beyond)
                .max(0.0)
                .copysign(together),
        )
    }
}

#[cfg(test)]
mod tests;
