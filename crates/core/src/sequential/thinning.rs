//! Independence of samples, which the statistics assume: dependent ones are thinned out.

use super::motion::Motion;
use super::parameters::ResidualParameters;
use super::samples::{Independence, Sample};
use crate::state::state;

/// Follows both readings and their difference.
///
/// Where a rod moves by whole counts from cycle to cycle, each reading is repeatedly rounded at the
/// same place between two counts, and the difference of both stays the same for as long as the
/// speed does. Such samples are no more evidence than one. They are recognised by both readings
/// moving by as much as in the previous cycle, which readings with a noise of a count or more
/// hardly ever do. Rounding does not explain a difference as large as a wild sample's, so each such
/// sample counts.
#[derive(Clone, Debug)]
pub struct Thinning {
    motion: Motion,
    /// Difference below which displacements are the same, m.
    rounding: f64,
    /// Difference below which residuals are the same, m.
    alike: f64,
    farthest: f64,
    /// Newest readings and their residual, m.
    newest: Option<([f64; 2], f64)>,
    /// Displacement of the readings in the newest cycle, m.
    moved: Option<[f64; 2]>,
}

state! {
    Thinning { motion, newest, moved }
    but { rounding, alike, farthest }
}

impl Thinning {
    /// A filter for samples every `sample_time` seconds, of healthy residuals of this `deviation`,
    /// m; rounding alone does not bring a weighted residual beyond `farthest`, m.
    pub fn new(
        parameters: &ResidualParameters,
        sample_time: f64,
        deviation: f64,
        farthest: f64,
    ) -> Self {
        Self {
            motion: Motion::new(parameters, sample_time),
            rounding: parameters.rounding,
            alike: parameters.alike * deviation,
            farthest,
            newest: None,
            moved: None,
        }
    }

    pub fn reset(&mut self) {
        self.motion.reset();
        (self.newest, self.moved) = (None, None);
    }

    /// Takes the readings of a cycle, m, and their difference.
    #[inline(always)]
    pub fn step(&mut self, lengths: [f64; 2], sample: Sample) -> Independence {
        match (self.motion.step(lengths), self.repeats(lengths, sample)) {
            (_, true) => Independence::Repeated,
            (true, false) => Independence::InMotion,
            (false, false) => Independence::AtRest,
        }
    }

    fn repeats(&mut self, lengths: [f64; 2], sample: Sample) -> bool {
        let Sample { residual, share, .. } = sample;
        let Some((from, before)) = self.newest.replace((lengths, residual)) else { return false };
        let moved = [lengths[0] - from[0], lengths[1] - from[1]];
        let same = self.moved.replace(moved).is_some_and(|before| {
            before.iter().zip(moved).all(|(before, now)| (now - before).abs() < self.rounding)
        });
        same && (residual - before).abs() < self.alike && (share * residual).abs() <= self.farthest
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const COUNT: f64 = 4e-4;

    /// Weights of the samples of a rod whose readings C1 and C2 are given in counts.
    fn independence(counts: impl IntoIterator<Item = [i32; 2]>) -> Vec<Independence> {
        let mut thinning = Thinning::new(&ResidualParameters::DEFAULT, 0.02, 2e-4, 1e-3);
        let read = |counts: [i32; 2]| counts.map(|count| COUNT * f64::from(count));
        counts
            .into_iter()
            .map(read)
            .map(|read| thinning.step(read, Sample::at_rest(read[0] - read[1])))
            .collect()
    }

    #[test]
    fn the_same_counts_again_and_again_are_thinned_out() {
        // Two counts a cycle, C1 rounded up; then a cycle in which C2 is, too.
        let counts = (0..20).map(|k| [2 * k + 1, 2 * k]).chain((20..30).map(|k| [2 * k + 1; 2]));
        let independence = independence(counts);
        assert_eq!(
            independence[..2],
            [Independence::AtRest; 2],
            "there is nothing to compare with"
        );
        assert_eq!(independence[2..20], [Independence::Repeated; 18]);
        assert_eq!(
            independence[20..22],
            [Independence::InMotion; 2],
            "C2 went three counts, and then two again"
        );
        assert_eq!(independence[22..], [Independence::Repeated; 8]);
    }

    #[test]
    fn readings_that_part_steadily_are_kept() {
        // C1 is frozen: each cycle it is two counts more off.
        assert!(
            independence((0..30).map(|k| [0, 2 * k]))[11..]
                .iter()
                .all(|it| *it == Independence::InMotion)
        );
    }

    #[test]
    fn what_no_rounding_explains_is_kept_each_time() {
        assert!(
            independence((0..30).map(|k| [2 * k + 3, 2 * k]))
                .iter()
                .all(|it| *it != Independence::Repeated)
        );
    }

    #[test]
    fn a_rod_that_stands_says_it_once() {
        let independence = independence((0..40).map(|k| [i32::from(k > 20), 0]));
        assert_eq!(independence[2..21], [Independence::Repeated; 19]);
        assert_eq!(independence[21..23], [Independence::AtRest; 2]);
        assert_eq!(independence[23..], [Independence::Repeated; 17]);
    }

    /// Readings as a PLC sends them that has converted counts to metres.
    #[test]
    fn readings_in_floats_repeat_as_those_in_counts_do() {
        let mut thinning = Thinning::new(&ResidualParameters::DEFAULT, 0.02, 2e-4, 1e-3);
        let float = |counts: i32| f64::from((COUNT * f64::from(counts)) as f32);
        let read = |k: i32| [float(2500 + 2 * k), float(2501 + 2 * k)];
        let independence =
            (0..30).map(|k| thinning.step(read(k), Sample::at_rest(read(k)[0] - read(k)[1])));
        assert_eq!(
            independence.filter(|independence| *independence == Independence::Repeated).count(),
            28
        );
    }

    #[test]
    fn nothing_outlasts_a_reset() {
        let mut thinning = Thinning::new(&ResidualParameters::DEFAULT, 0.02, 2e-4, 1e-3);
        (0..20).for_each(|_| _ = thinning.step([0.0; 2], Sample::at_rest(0.0)));
        thinning.reset();
        assert_eq!(
            [(); 3].map(|()| thinning.step([0.0; 2], Sample::at_rest(0.0)))[..2],
            [Independence::AtRest; 2]
        );
        assert_eq!(thinning.step([0.0; 2], Sample::at_rest(0.0)), Independence::Repeated);
    }
}
