//! Least squares of a profile along the stroke: hat functions whose bend is chosen by the data, a
//! term in velocity, and a separate constant for every half minute, which follows the temperature.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use tertius_core::sequential::reference::Place;

/// Error of one look at a place, m, however many samples it has: they share the same bend, the same
/// motion of the rod and the same rounding.
const LOOK: f64 = 2e-5;

/// Largest effect of the velocity: the difference of the sampling times of two devices, s.
const TIMING: f64 = 3e-3;

/// Candidates for the bend of the profile from node to node, m.
const BENDS: [f64; 5] = [0.5e-4, 0.8e-4, 1.3e-4, 2e-4, 3e-4];

/// Weighted sums of the samples in one cell.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    weight: f64,
    /// Sums of both hats, and of the velocity.
    first: [f64; 3],
    /// Sums of the products of these.
    second: [[f64; 3]; 3],
    /// Sum of the residual.
    residual: f64,
    /// Sums of the products of the residual with both hats, and with the velocity.
    with: [f64; 3],
}

/// Sums of the samples of half a minute, cell by cell.
#[derive(Clone, Debug)]
pub(super) struct Look(Vec<Sums>);

/// Normal equations of many looks: the nodes, and the velocity as the last unknown.
#[derive(Clone, Debug)]
pub(super) struct Equations {
    matrix: DMatrix<f64>,
    right: DVector<f64>,
    /// Sums of the hats, weighted as the looks are.
    hats: DVector<f64>,
    /// Standard deviation of a look's own constant, m.
    own: f64,
}

/// Solution of the equations.
#[derive(Clone, Debug)]
pub(super) struct Solution {
    /// Values of the nodes, m.
    pub nodes: Vec<f64>,
    /// Standard deviation of each node, apart from what all have in common, which the baseline
    /// follows, m.
    pub deviations: Vec<f64>,
    /// Coefficient of the velocity, s.
    pub velocity: f64,
    /// Weight of the data at each node.
    hats: DVector<f64>,
}

impl Look {
    pub(super) fn new(cells: usize) -> Self {
        Self(vec![Sums::default(); cells])
    }

    /// Adds a residual, m, with this `weight`, 1/m².
    pub(super) fn add(&mut self, place: Place, velocity: f64, residual: f64, weight: f64) {
        let sums = &mut self.0[place.cell];
        let values = [1.0 - place.part, place.part, velocity];
        sums.weight += weight;
        sums.residual += weight * residual;
        for (i, value) in values.into_iter().enumerate() {
            let weighed = weight * value;
            sums.first[i] += weighed;
            sums.with[i] += weighed * residual;
            for (sum, other) in sums.second[i].iter_mut().zip(values) {
                *sum += weighed * other;
            }
        }
    }

    pub(super) fn clear(&mut self) {
        self.0.fill(Sums::default());
    }
}

impl Equations {
    /// Equations for `cells`; the standard deviation of a look's common error is `own`, m.
    pub(super) fn new(cells: usize, own: f64) -> Self {
        let unknowns = cells + 2;
        Self {
            matrix: DMatrix::zeros(unknowns, unknowns),
            right: DVector::zeros(unknowns),
            hats: DVector::zeros(cells + 1),
            own,
        }
    }

    /// Adds a look: however many samples a cell has, it counts as seen once.
    pub(super) fn take(&mut self, look: &Look) {
        let speed = self.right.len() - 1;
        let (mut total, mut residual) = (1.0 / (self.own * self.own), 0.0);
        let mut first = vec![0.0; speed + 1];
        let mut touched = Vec::new();
        for (cell, sums) in look.0.iter().enumerate().filter(|(_, sums)| sums.weight > 0.0) {
            let once = 1.0 / (1.0 + LOOK * LOOK * sums.weight);
            let places = [cell, cell + 1, speed];
            for (i, place) in places.into_iter().enumerate() {
                first[place] += once * sums.first[i];
                self.right[place] += once * sums.with[i];
                for (j, other) in places.into_iter().enumerate() {
                    self.matrix[(place, other)] += once * sums.second[i][j];
                }
            }
            total += once * sums.weight;
            residual += once * sums.residual;
            touched.extend([cell, cell + 1]);
        }
        touched.push(speed);
        touched.dedup();
        // Its own constant is solved for and taken out.
        for &one in &touched {
            self.right[one] -= first[one] * residual / total;
            for &other in &touched {
                self.matrix[(one, other)] -= first[one] * first[other] / total;
            }
        }
        self.hats.iter_mut().zip(first).for_each(|(hats, first)| *hats += first);
    }

    /// Sum of these equations and `other`.
    pub(super) fn with(&self, other: &Self) -> Self {
        Self {
            matrix: &self.matrix + &other.matrix,
            right: &self.right + &other.right,
            hats: &self.hats + &other.hats,
            own: self.own,
        }
    }

    /// The bend with the largest restricted likelihood, m; `None` without data.
    pub(super) fn bend(&self) -> Option<f64> {
        let likelihood = |bend: f64| -> Option<f64> {
            let factor = self.factor(bend)?;
            let explained = self.right.dot(&factor.solve(&self.right));
            let bends = self.hats.len().saturating_sub(2) as f64;
            Some(0.5 * (explained - factor.ln_determinant()) - bends * bend.ln())
        };
        let known = BENDS.into_iter().filter_map(|bend| Some((bend, likelihood(bend)?)));
        known.max_by(|one, other| one.1.total_cmp(&other.1)).map(|(bend, _)| bend)
    }

    /// The solution with second differences of `bend`, m; `None` without data.
    pub(super) fn solve(&self, bend: f64) -> Option<Solution> {
        let factor = self.factor(bend)?;
        let solution = factor.solve(&self.right);
        let count = self.hats.len();
        let covariance = factor.inverse();
        let covariance = covariance.view((0, 0), (count, count));
        let hats = &self.hats / self.hats.sum();
        let common = covariance * &hats;
        let mean = hats.dot(&common);
        let deviation = |i: usize| (covariance[(i, i)] - 2.0 * common[i] + mean).max(0.0).sqrt();
        let solved = Solution {
            nodes: solution.as_slice()[..count].to_vec(),
            deviations: (0..count).map(deviation).collect(),
            velocity: solution[count],
            hats,
        };
        let finite = |values: &[f64]| values.iter().all(|value| value.is_finite());
        (finite(solution.as_slice()) && finite(&solved.deviations)).then_some(solved)
    }

    fn factor(&self, bend: f64) -> Option<Cholesky<f64, Dyn>> {
        let count = self.hats.len();
        let mut matrix = self.matrix.clone();
        let weight = 1.0 / (bend * bend);
        for i in 1..count - 1 {
            for (j, a) in [(i - 1, 1.0), (i, -2.0), (i + 1, 1.0)] {
                for (k, b) in [(i - 1, 1.0), (i, -2.0), (i + 1, 1.0)] {
                    matrix[(j, k)] += weight * a * b;
                }
            }
        }
        matrix[(count, count)] += 1.0 / (TIMING * TIMING);
        (self.hats.sum() > 0.0).then(|| matrix.cholesky()).flatten()
    }
}

impl Solution {
    /// This solution, shifted to the mean of `other` where this one was fitted, since half a
    /// recording has its own temperature.
    pub(super) fn beside(mut self, other: &Self) -> Self {
        let both = self.nodes.iter().zip(&other.nodes);
        let off: f64 = both.zip(&self.hats).map(|((one, other), hat)| hat * (other - one)).sum();
        self.nodes.iter_mut().for_each(|node| *node += off);
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};
    use tertius_core::sequential::Reference;

    const CELLS: usize = 20;

    /// Residuals of a rod that moves up and down between `ends`, m, of a stroke of 2 m; `bent`
    /// along it.
    fn looks(
        equations: &mut Equations,
        seed: u64,
        looks: u32,
        ends: [f64; 2],
        bent: fn(f64) -> f64,
    ) {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
        for _ in 0..looks {
            let (mut look, own) = (Look::new(CELLS), 5e-5 * normal());
            for k in 0..1500 {
                let phase = 0.0157 * f64::from(k);
                let middle = 0.5 * (ends[0] + ends[1]);
                let length = middle + 0.5 * (ends[1] - ends[0]) * phase.sin();
                let velocity = 0.4 * phase.cos();
                let residual = own + bent(length) + 3e-4 * velocity + 1e-4 * normal();
                let place = Reference::place(0.0, 0.1, CELLS + 1, length).expect("it is inside");
                look.add(place, velocity, residual, 1e8);
            }
            equations.take(&look);
        }
    }

    fn solved(looked: &[(u32, [f64; 2])], bent: fn(f64) -> f64, seed: u64) -> (f64, Solution) {
        let mut equations = Equations::new(CELLS, 3e-4);
        for (many, ends) in looked {
            looks(&mut equations, seed, *many, *ends, bent);
        }
        let bend = equations.bend().expect("there are looks");
        (bend, equations.solve(bend).expect("there are looks"))
    }

    #[test]
    fn the_bend_is_the_datas() {
        let bend = |bent| solved(&[(30, [0.1, 1.9])], bent, 1).0;
        assert_eq!(bend(|_| 1e-3), BENDS[0]);
        // Second differences of 0.3 mm at the most, 0.2 mm by and large.
        assert!((1.3e-4..=3e-4).contains(&bend(|x| 3e-4 * (10.0 * x).sin())));
    }

    /// The errors match their standard deviations where the rod was often, once and never.
    #[test]
    fn a_profile_knows_its_own_doubt() {
        let bent: fn(f64) -> f64 = |x| 2e-4 * (5.0 * x).sin();
        let (mut squares, mut most) = (0.0, 0.0_f64);
        for seed in 0..20 {
            let looked = [(30, [0.5, 1.1]), (1, [0.3, 1.5])];
            let (_, Solution { nodes, deviations, velocity, hats }) = solved(&looked, bent, seed);
            assert!((velocity - 3e-4).abs() < 3e-5, "{velocity}");
            let off = |i: usize| nodes[i] - bent(0.1 * i as f64);
            let mean: f64 = (0..=CELLS).map(|i| hats[i] * off(i)).sum();
            for (i, deviation) in deviations.iter().enumerate() {
                let ratio = (off(i) - mean) / deviation;
                squares += ratio * ratio;
                most = most.max(ratio.abs());
            }
            let [often, once, never] = [8, 14, 20].map(|i| deviations[i]);
            assert!(often < 1.5e-5 && (1.5e-5..6e-5).contains(&once), "{often} {once}");
            assert!(never > 2e-4, "{never}");
        }
        let rms = (squares / (20.0 * (CELLS + 1) as f64)).sqrt();
        assert!((0.5..1.2).contains(&rms) && most < 4.0, "{rms} {most}");
    }

    /// What is seen for half a minute within one look counts as one look.
    #[test]
    fn a_long_look_is_one_look() {
        let doubt = |looked: &[(u32, [f64; 2])]| solved(looked, |_| 0.0, 3).1.deviations[8];
        let (one, nine) = (doubt(&[(1, [0.5, 1.1])]), doubt(&[(9, [0.5, 1.1])]));
        assert!((2.0..4.0).contains(&(one / nine)), "{one} {nine}");
        assert!(one > 0.4 * LOOK, "{one}");
    }

    #[test]
    fn half_a_recording_is_put_beside_the_whole() {
        let level = |offset: f64| Solution {
            nodes: vec![offset, offset + 1e-4],
            deviations: vec![0.0; 2],
            velocity: 0.0,
            hats: DVector::from_vec(vec![0.25, 0.75]),
        };
        let nodes = level(3e-4).beside(&level(1e-4)).nodes;
        assert!((nodes[0] - 1e-4).abs() < 1e-15 && (nodes[1] - 2e-4).abs() < 1e-15);
    }

    #[test]
    fn of_nothing_nothing_is_known() {
        let equations = Equations::new(CELLS, 3e-4);
        assert!(equations.bend().is_none() && equations.solve(1e-4).is_none());
    }
}
