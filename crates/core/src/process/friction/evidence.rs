//! Evidence of more Coulomb friction than was learnt, weighed over windows of several widths.
//!
//! With h the directions of a block, r what is left, G = Σ h r and W = Σ h hᵀ over a window of n blocks, and m the
//! column of W of Coulomb's friction: C = n Ω + λ² w wᵀ, w being the other column and λ what of the viscous friction the oil's
//! temperature may change; θ̂ = mᵀC⁻¹G / mᵀC⁻¹m, and the evidence is (θ̂ − ε)² mᵀC⁻¹m / 2 where θ̂ is above ε. Less friction
//! is no fault.

use super::super::evidence::{RESTART, in_turn};
use super::super::parameters::ProcessParameters;
use super::design::{FrictionBlock, FrictionDesign, SCATTERS};
use crate::sequential::statistic::Peak;
use crate::sequential::windows::Sums;
use crate::state::state;

const P: &ProcessParameters = &ProcessParameters::DEFAULT;

/// Blocks that are held.
const MOST_BLOCKS: usize = 512;

/// Blocks between two turns.
const TURN: usize = 4;

/// Widths of the windows, blocks: from 16 to 100 s, at [`ProcessParameters::flow_block`]. What is left over a part of a
/// wave says more than Ω allows for: with windows from 5 s on, two of 96 healthy hours had a false alarm.
const BLOCKS: [usize; 5] = [80, 120, 200, 300, 500];

/// Values of a block that are summed: G as far as it is evidence, the whole of G, and the upper half of W.
const SUMMED: usize = 7;

/// By what evidence is weighed.
#[derive(Clone, Debug)]
pub struct FrictionWeighing {
    /// The upper half of Ω, row by row.
    scatter: [f64; SCATTERS],
}

/// θ̂, bar, and mᵀC⁻¹m.
struct Solved {
    size: f64,
    weight: f64,
}

impl FrictionWeighing {
    /// For the scatter of `design`; `None` if that is no covariance.
    pub fn new(design: &FrictionDesign) -> Option<Self> {
        let [a, b, d] = design.scatter;
        let is_sound = a > 0.0 && d >= 0.0 && a * d >= b * b && (a * d).is_finite();
        is_sound.then_some(Self { scatter: design.scatter })
    }

    /// The most Coulomb friction that a block is evidence of, bar.
    fn farthest(&self) -> f64 {
        let [least, deviations] = P.friction_farthest;
        f64::max(least, deviations * libm::sqrt(self.scatter[0]))
    }

    /// By the part of G that is evidence.
    fn solve(&self, width: usize, sums: [f64; SUMMED]) -> Option<Solved> {
        let [of_coulomb, of_viscous, _, _, w @ ..] = sums;
        self.solved(width, [of_coulomb, of_viscous], w)
    }

    /// By the whole of G.
    fn solve_whole(&self, width: usize, sums: [f64; SUMMED]) -> Option<Solved> {
        let [_, _, of_coulomb, of_viscous, w @ ..] = sums;
        self.solved(width, [of_coulomb, of_viscous], w)
    }

    fn solved(
        &self,
        width: usize,
        g: [f64; 2],
        [squared, mixed, viscous]: [f64; 3],
    ) -> Option<Solved> {
        let [of_coulomb, of_viscous] = g;
        let (n, doubt) = (width as f64, P.friction_viscosity * P.friction_viscosity);
        let [a, b, d] = self.scatter.map(|it| n * it);
        let a = a + doubt * mixed * mixed;
        let b = b + doubt * mixed * viscous;
        let d = d + doubt * viscous * viscous;
        let determinant = a * d - b * b;
        // C⁻¹m without its common factor.
        let along = [d * squared - b * mixed, a * mixed - b * squared];
        let weight = (squared * along[0] + mixed * along[1]) / determinant;
        let product = (of_coulomb * along[0] + of_viscous * along[1]) / determinant;
        let is_known = determinant > 0.0 && weight > 0.0 && weight.is_finite();
        is_known.then(|| Solved { size: product / weight, weight })
    }
}

/// The newest blocks.
#[derive(Clone, Debug, Default)]
pub struct FrictionWindows {
    sums: Sums<MOST_BLOCKS, SUMMED, RESTART>,
}

state! { FrictionWindows { sums } }

impl FrictionWindows {
    pub const fn clear(&mut self) {
        self.sums.clear();
    }

    /// Takes a block, as far as it is evidence; nothing that is not finite, which no sum would ever forget.
    pub fn push(&mut self, block: &FrictionBlock, by: &FrictionWeighing) {
        let FrictionBlock { left, directions: [coulomb, viscous] } = *block;
        let farthest = by.farthest() * coulomb.abs();
        let evident = left.max(-farthest).min(farthest);
        let products = [evident, left].map(|left| [coulomb * left, viscous * left]);
        let squares = [coulomb * coulomb, coulomb * viscous, viscous * viscous];
        let [[a, b], [c, d]] = products;
        let values = [a, b, c, d, squares[0], squares[1], squares[2]];
        if values.iter().all(|it| it.is_finite()) {
            self.sums.push(values);
        }
    }

    /// The window with the most evidence of friction; its width is in blocks.
    pub fn peak(&self, by: &FrictionWeighing) -> Peak {
        self.among(by, &BLOCKS)
    }

    /// The same of the widths whose turn it is: as [`super::super::EvidenceWindows::peaks_in_turn`].
    pub fn peak_in_turn(&self, by: &FrictionWeighing) -> Peak {
        let count = self.sums.count();
        if !count.is_multiple_of(TURN) {
            return Peak::default();
        }
        self.among(by, &BLOCKS[..in_turn(count / TURN).min(BLOCKS.len())])
    }

    fn among(&self, by: &FrictionWeighing, widths: &[usize]) -> Peak {
        let mut peak = Peak::default();
        for width in widths.iter().copied().take_while(|width| *width <= self.sums.held()) {
            let solved = by.solve(width, self.sums.newest(width));
            let beyond = solved.map(|it| ((it.size - P.friction_band).max(0.0), it.weight));
            let nats = beyond.map_or(0.0, |(beyond, weight)| 0.5 * beyond * beyond * weight);
            if nats > peak.nats {
                peak = Peak { nats, width };
            }
        }
        peak
    }

    /// Coulomb friction beyond that learnt over the newest `width` blocks, bar; `None` if there are not so many.
    pub fn size(&self, by: &FrictionWeighing, width: usize) -> Option<f64> {
        by.solve_whole(width, self.sums.over(width)?).map(|it| it.size)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn weighing() -> FrictionWeighing {
        let scatter = [0.04, 0.02, 0.4];
        let design = FrictionDesign { coefficients: [0.0; 4], scatter, area_ratio: 0.5 };
        FrictionWeighing::new(&design).expect("it is a covariance")
    }

    /// Blocks of a rod that swings, with so much more of each friction.
    fn windows(coulomb: f64, viscous: f64) -> FrictionWindows {
        let mut windows = FrictionWindows::default();
        for k in 0..300 {
            let speed = libm::sin(0.157 * f64::from(k));
            let directions = [libm::tanh(20.0 * speed), 8.0 * speed];
            let left = coulomb * directions[0] + viscous * directions[1];
            windows.push(&FrictionBlock { left, directions }, &weighing());
        }
        windows
    }

    #[test]
    fn the_nats_are_those_of_the_formula() {
        let by = weighing();
        let (w, omega) = (windows(1.0, 0.0).sums.newest(300), weighing().scatter);
        let n = nalgebra::Matrix2::new(omega[0], omega[1], omega[1], omega[2]) * 300.0;
        let (m, v) = (nalgebra::Vector2::new(w[4], w[5]), nalgebra::Vector2::new(w[5], w[6]));
        let c = n + P.friction_viscosity.powi(2) * v * v.transpose();
        let inverse = c.try_inverse().expect("it is definite");
        let weight = (m.transpose() * inverse * m)[0];
        let expected = 0.5 * (1.0 - P.friction_band).powi(2) * weight;
        let peak = windows(1.0, 0.0).peak(&by);
        assert_eq!(peak.width, 300);
        assert!((peak.nats / expected - 1.0).abs() < 1e-9, "{peak:?} {expected}");
        let size = windows(1.0, 0.0).size(&by, 300).expect("there are so many");
        assert!((size - 1.0).abs() < 1e-9, "{size}");
        // Where more is no more evidence, the size is the whole of it.
        let large = windows(8.0, 0.0);
        assert!(large.peak(&by).nats < 64.0 * peak.nats);
        let size = large.size(&by, 300).expect("there are so many");
        assert!((size - 8.0).abs() < 1e-9, "{size}");
    }

    #[test]
    fn warm_oil_a_little_friction_and_less_of_it_are_no_fault() {
        let nats = |coulomb, viscous| windows(coulomb, viscous).peak(&weighing()).nats;
        let fault = nats(1.5, 0.0);
        assert!(fault > 30.0, "{fault}");
        for (coulomb, viscous) in
            [(0.0, 0.3), (0.0, -0.3), (0.9 * P.friction_band, 0.0), (-2.0, 0.0)]
        {
            let found = nats(coulomb, viscous);
            assert!(found < 1.0, "{coulomb} {viscous}: {found}");
        }
    }

    /// A load that changes by 10 bar at once: the slow part follows it within three seconds.
    #[test]
    fn a_load_that_changes_suddenly_is_no_friction() {
        let (by, mut windows) = (weighing(), FrictionWindows::default());
        let mut most = 0.0_f64;
        for k in 0..1200_u32 {
            let direction = libm::tanh(20.0 * libm::sin(0.157 * f64::from(k)));
            let age = k % 300;
            let left = 10.0 * libm::exp(-f64::from(age) * 0.2 / P.friction_slow);
            windows.push(&FrictionBlock { left, directions: [direction, direction] }, &by);
            most = most.max(windows.peak(&by).nats);
        }
        assert!(most < 1.0, "{most}");
    }

    #[test]
    fn a_matrix_that_is_no_covariance_is_refused() {
        let of = |scatter| {
            let design = FrictionDesign { coefficients: [0.0; 4], scatter, area_ratio: 0.5 };
            FrictionWeighing::new(&design).is_some()
        };
        assert!(of([1.0, 0.5, 1.0]) && of([1.0, 0.0, 0.0]));
        assert!(!of([0.0, 0.0, 1.0]) && !of([1.0, 2.0, 1.0]));
        assert!(!of([f64::NAN, 0.0, 1.0]) && !of([1.0, f64::INFINITY, 1.0]));
    }

    #[test]
    fn nothing_spoils_the_sums_for_good() {
        let mut spoilt = windows(1.0, 0.0);
        for left in [f64::NAN, f64::INFINITY] {
            spoilt.push(&FrictionBlock { left, directions: [1.0, 1.0] }, &weighing());
        }
        assert_eq!(spoilt.sums.count(), 300);
    }
}
