//! What a cycle is evidence of: the statistics take samples for independent ones.

use super::motion::Motion;
use super::parameters::ResidualParameters;
use super::samples::Sample;

/// What a sample counts for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum News {
    /// Nothing: it says what the one before has said.
    Repeated,
    /// The rod stands or nearly so: one sample says much of what the one before has said.
    AtRest,
    InMotion,
}

/// Follows both readings and what they differ by.
///
/// Where a rod goes whole counts from cycle to cycle, each reading is rounded at the same place between
/// two counts again and again, and the difference of both stays as it is for as long as the speed does.
/// Such samples are no more evidence than one. They are known by both readings moving by what they have
/// moved by in the cycle before; readings with a noise of a count or more hardly ever do. What is as far
/// off as a wild sample, no rounding explains, and each sample of it counts.
#[derive(Clone, Debug)]
pub struct Novelty {
    motion: Motion,
    /// m.
    rounding: f64,
    alike: f64,
    farthest: f64,
    /// The newest readings and their residual, m.
    newest: Option<([f64; 2], f64)>,
    /// What the readings moved by in the newest cycle, m.
    moved: Option<[f64; 2]>,
}

impl Novelty {
    /// For samples every `sample_time` seconds, of healthy residuals of this `deviation`, m, which
    /// rounding alone has not beyond `farthest`, m, when they are weighed.
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

    /// Takes the readings of a cycle, m, and what they differ by.
    #[inline(always)]
    pub fn step(&mut self, lengths: [f64; 2], sample: Sample) -> News {
        match (self.motion.step(lengths), self.repeats(lengths, sample)) {
            (_, true) => News::Repeated,
            (true, false) => News::InMotion,
            (false, false) => News::AtRest,
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

    /// The news of a rod whose readings C1 and C2 are so many counts.
    fn news(counts: impl IntoIterator<Item = [i32; 2]>) -> Vec<News> {
        let mut novelty = Novelty::new(&ResidualParameters::DEFAULT, 0.02, 2e-4, 1e-3);
        let read = |counts: [i32; 2]| counts.map(|count| COUNT * f64::from(count));
        counts
            .into_iter()
            .map(read)
            .map(|read| novelty.step(read, Sample::at_rest(read[0] - read[1])))
            .collect()
    }

    #[test]
    fn the_same_counts_again_and_again_are_news_once() {
        // Two counts a cycle, C1 rounded up; then a cycle in which C2 is, too.
        let counts = (0..20).map(|k| [2 * k + 1, 2 * k]).chain((20..30).map(|k| [2 * k + 1; 2]));
        let news = news(counts);
        assert_eq!(news[..2], [News::AtRest; 2], "there is nothing to compare with");
        assert_eq!(news[2..20], [News::Repeated; 18]);
        assert_eq!(news[20..22], [News::InMotion; 2], "C2 went three counts, and then two again");
        assert_eq!(news[22..], [News::Repeated; 8]);
    }

    #[test]
    fn readings_that_part_steadily_are_news() {
        // C1 is frozen: each cycle it is two counts more off.
        assert!(news((0..30).map(|k| [0, 2 * k]))[11..].iter().all(|it| *it == News::InMotion));
    }

    #[test]
    fn what_no_rounding_explains_is_news_each_time() {
        assert!(news((0..30).map(|k| [2 * k + 3, 2 * k])).iter().all(|it| *it != News::Repeated));
    }

    #[test]
    fn a_rod_that_stands_says_it_once() {
        let news = news((0..40).map(|k| [i32::from(k > 20), 0]));
        assert_eq!(news[2..21], [News::Repeated; 19]);
        assert_eq!(news[21..23], [News::AtRest; 2]);
        assert_eq!(news[23..], [News::Repeated; 17]);
    }

    /// As a PLC sends them that has made metres of counts.
    #[test]
    fn readings_in_floats_repeat_as_those_in_counts_do() {
        let mut novelty = Novelty::new(&ResidualParameters::DEFAULT, 0.02, 2e-4, 1e-3);
        let float = |counts: i32| f64::from((COUNT * f64::from(counts)) as f32);
        let read = |k: i32| [float(2500 + 2 * k), float(2501 + 2 * k)];
        let news = (0..30).map(|k| novelty.step(read(k), Sample::at_rest(read(k)[0] - read(k)[1])));
        assert_eq!(news.filter(|news| *news == News::Repeated).count(), 28);
    }

    #[test]
    fn nothing_outlasts_a_reset() {
        let mut novelty = Novelty::new(&ResidualParameters::DEFAULT, 0.02, 2e-4, 1e-3);
        (0..20).for_each(|_| _ = novelty.step([0.0; 2], Sample::at_rest(0.0)));
        novelty.reset();
        assert_eq!(
            [(); 3].map(|()| novelty.step([0.0; 2], Sample::at_rest(0.0)))[..2],
            [News::AtRest; 2]
        );
        assert_eq!(novelty.step([0.0; 2], Sample::at_rest(0.0)), News::Repeated);
    }
}
