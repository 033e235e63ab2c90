//! A residual beyond its threshold that has to stay there, or to be there often: one or two wild samples are no fault.
//!
//! A spike on a cable is off for a sample. Where one sample in two hundred is wild, two follow each other every five minutes
//! on a machine, and three hardly once an hour. Where more are wild, more have to follow each other. The thresholds of
//! the thesis count at once, as they do there.

use super::parameters::{KEPT_EXCEEDED, KEPT_WILD, VerdictParameters};
use crate::state::{state, whole};
use crate::time::{Span, Timestamp};

/// A residual beyond its threshold.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Exceeded {
    /// Time and residual, m, of the first sample.
    at: Timestamp,
    first: f64,
    /// The one of largest magnitude, m.
    largest: f64,
    samples: u32,
}

whole! { Exceeded { at, first, largest, samples } }

/// A residual in a cycle, m.
#[derive(Clone, Copy, Debug)]
pub struct ResidualSample {
    pub residual: f64,
    /// The same without the readings that may be wild.
    pub stands: Option<f64>,
    /// That of the other observer.
    pub other: Option<f64>,
}

/// When a residual exceeded its threshold, and its largest value since, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lasting {
    pub since: Timestamp,
    pub largest: f64,
}

whole! { Lasting { since, largest } }

/// Follows one residual until it has stayed beyond its threshold for some samples, or was there often.
#[derive(Clone, Debug)]
pub struct Persistence {
    exceeded: Option<Exceeded>,
    /// Newest samples beyond the threshold, the oldest first.
    newest: [Option<Lasting>; KEPT_EXCEEDED],
    /// When the newest readings were wild, the oldest first.
    wild: [Option<Timestamp>; KEPT_WILD],
    /// Samples that it has to stay where hardly any is wild.
    samples: u32,
    parameters: &'static VerdictParameters,
}

state! {
    Persistence { exceeded, newest, wild }
    but { samples, parameters }
}

impl Persistence {
    /// For a residual that is a fault once it has stayed beyond its threshold for this number of `samples`, at least 1.
    pub const fn new(samples: u32, parameters: &'static VerdictParameters) -> Self {
        Self {
            exceeded: None,
            newest: [None; KEPT_EXCEEDED],
            wild: [None; KEPT_WILD],
            samples,
            parameters,
        }
    }

    /// Cycles that it takes until a residual that stays is a fault.
    pub const fn waited(&self) -> u32 {
        self.samples.saturating_sub(1)
    }

    /// Whether one sample is enough.
    pub const fn is_immediate(&self) -> bool {
        self.samples <= 1
    }

    /// Whether a residual has exceeded its threshold, and may yet be wild.
    pub const fn is_open(&self) -> bool {
        self.exceeded.is_some()
    }

    /// Whether it did so in the newest cycle.
    pub fn has_begun(&self) -> bool {
        self.exceeded.is_some_and(|it| it.samples == 1)
    }

    /// Whether `residual`, m, is still where the first one was.
    pub fn stays(&self, residual: f64) -> bool {
        let least = |first: f64| self.parameters.stays * first.abs();
        self.exceeded.is_none_or(|it| residual * it.first.signum() >= least(it.first))
    }

    /// Forgets a residual that has not lasted, after a missing sample.
    pub const fn dismiss(&mut self) {
        self.exceeded = None;
    }

    /// Forgets all of them, after a time of which nothing is known. A clock that was set back made samples of an hour before
    /// appear as those of the last moment.
    pub const fn interrupt(&mut self) {
        *self = Self::new(self.samples, self.parameters);
    }

    /// Takes a residual that `exceeds` its threshold or follows one that did, and returns it once it has lasted long enough.
    pub fn take(
        &mut self,
        at: Timestamp,
        sample: ResidualSample,
        exceeds: bool,
    ) -> Option<Lasting> {
        // An error of the model is in both observers: as it swings after a load has doubled, it is no noise of a reading.
        let often = Some(self.parameters.often).filter(|_| !self.is_shared(&sample));
        self.lasting(at, sample, exceeds, often)
    }

    /// Takes a residual of a detector that is raised, and returns whether it `exceeds` its threshold so that it stays raised.
    pub fn goes_on(&mut self, at: Timestamp, sample: ResidualSample, exceeds: bool) -> bool {
        self.is_immediate() && exceeds
            || self.lasting(at, sample, exceeds, Some(self.parameters.again)).is_some()
    }

    /// Whether the other observer sees the residual, too.
    fn is_shared(&self, sample: &ResidualSample) -> bool {
        let shared = self.parameters.shared * sample.residual.abs();
        sample.other.is_some_and(|it| it.abs() > shared)
    }

    /// Takes a residual, and returns it once it has stayed, or was beyond its threshold as `often` within the window.
    fn lasting(
        &mut self,
        at: Timestamp,
        sample: ResidualSample,
        exceeds: bool,
        often: Option<usize>,
    ) -> Option<Lasting> {
        let residual = sample.residual;
        let stands = sample.stands.unwrap_or(residual);
        let before = self.exceeded.filter(|_| self.stays(stands));
        if let (Some(wild), None) = (self.exceeded, before) {
            self.wild.rotate_left(1);
            self.wild[KEPT_WILD - 1] = Some(wild.at);
        }
        let began =
            exceeds.then_some(Exceeded { at, first: stands, largest: residual, samples: 0 });
        self.exceeded = before.or(began);
        let needed = self.needed(at);
        let exceeded = self.exceeded.as_mut()?;
        exceeded.samples += 1;
        if residual.abs() > exceeded.largest.abs() {
            exceeded.largest = residual;
        }
        let Exceeded { at: since, largest, samples, .. } = *exceeded;
        let lasting = if samples >= needed {
            Lasting { since, largest }
        } else if exceeds {
            self.often(at, residual, often?)?
        } else {
            return None;
        };
        self.dismiss();
        Some(lasting)
    }

    /// Samples that a residual has to stay where readings are wild as often as the newest ones.
    fn needed(&self, at: Timestamp) -> u32 {
        let within = |seconds: &&f64| {
            self.wild[0].is_some_and(|first| at.since(first) < Span::from_seconds(**seconds))
        };
        self.samples + self.parameters.frequent.iter().filter(within).count() as u32
    }

    /// The newest samples beyond the threshold, where `count` of them are frequent enough for noise.
    fn often(&mut self, at: Timestamp, residual: f64, count: usize) -> Option<Lasting> {
        self.newest.rotate_left(1);
        self.newest[KEPT_EXCEEDED - 1] = Some(Lasting { since: at, largest: residual });
        let since = self.newest[KEPT_EXCEEDED - count]?.since;
        let larger =
            |one: f64, it: Lasting| if it.largest.abs() > one.abs() { it.largest } else { one };
        let largest = self.newest.iter().flatten().fold(0.0, |one, it| larger(one, *it));
        let is_often = at.since(since) < Span::from_seconds(self.parameters.window);
        is_often.then_some(Lasting { since, largest })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::vec::Vec;

    const CYCLE: i64 = 20_000_000;
    const P: &VerdictParameters = &VerdictParameters::DEFAULT;

    /// Cycles, from 0, in which `residuals`, mm, have lasted for this number of `samples` beyond 1 mm, each with the first and
    /// the largest of them.
    fn lasted_for(samples: u32, residuals: &[f64]) -> Vec<(usize, i64, f64)> {
        let (mut persistence, mut found) = (Persistence::new(samples, P), Vec::new());
        for (cycle, residual) in residuals.iter().enumerate() {
            let at = Timestamp::from_nanos(cycle as i64 * CYCLE);
            let sample = ResidualSample { residual: *residual, stands: None, other: None };
            let lasting = persistence.take(at, sample, residual.abs() > 1.0);
            found.extend(lasting.map(|it| (cycle, it.since.as_nanos() / CYCLE, it.largest)));
        }
        found
    }

    fn lasted(residuals: &[f64]) -> Vec<(usize, i64, f64)> {
        lasted_for(P.lasting, residuals)
    }

    #[test]
    fn what_stays_is_told_with_its_first_and_largest_sample() {
        // An observer follows a step.
        assert_eq!(lasted(&[0.1, 1.3, 1.0, 0.8, 0.6]), [(3, 1, 1.3)]);
        assert_eq!(lasted(&[-1.1, -1.4, -1.2]), [(2, 0, -1.4)]);
        assert_eq!(lasted(&[f64::INFINITY; 3]), [(2, 0, f64::INFINITY)]);
    }

    #[test]
    fn one_and_two_wild_samples_are_let_pass() {
        for wild in [&[4.0, 0.1, 0.0][..], &[4.0, -4.0, 4.0, 0.0], &[4.0, 4.0, -0.9, 0.1, 1.5, 0.2]]
        {
            assert_eq!(lasted(wild), [], "{wild:?}");
        }
        // A step right behind a spike begins anew.
        assert_eq!(lasted(&[40.0, 2.0, 2.0, 2.0]), [(3, 1, 2.0)]);
    }

    #[test]
    fn noise_is_told_by_how_often_it_is_beyond() {
        // Every second sample, up and down.
        let noise: Vec<f64> = (0..30).map(|k| [0.2, 1.5, 0.1, -1.8][k % 4]).collect();
        assert_eq!(lasted(&noise)[0], (13, 1, -1.8));
        // Every third one: six of sixteen.
        let spikes: Vec<f64> = (0..60).map(|k| [0.2, 0.1, 4.0][k % 3]).collect();
        assert_eq!(lasted(&spikes), []);
    }

    /// Where spikes are frequent, three of them in a row are no fault either; a step is found a sample later.
    #[test]
    fn where_readings_are_often_wild_more_have_to_follow_each_other() {
        for (apart, needed) in [(250, 3), (100, 4), (30, 5)] {
            let mut residuals: Vec<f64> =
                (0..10 * apart).map(|k| [0.0, 9.0][k % apart / (apart - 1)]).collect();
            assert_eq!(lasted(&residuals), [], "every {apart}th");
            residuals.extend([0.0, 2.0, 2.0, 2.0, 2.0, 2.0]);
            let first = lasted(&residuals)[0];
            assert_eq!(first.0 as i64 - first.1 + 1, needed, "every {apart}th");
            // After a quiet time it is as before.
            residuals.truncate(10 * apart);
            residuals.extend([0.0; 1000]);
            residuals.extend([2.0; 3]);
            assert_eq!(lasted(&residuals).len(), 1, "every {apart}th");
        }
    }

    #[test]
    fn a_clock_that_was_set_back_makes_nothing_frequent() {
        let mut persistence = Persistence::new(P.lasting, P);
        let take = |persistence: &mut Persistence, cycle: i64, residual: f64| {
            let at = Timestamp::from_nanos(cycle * CYCLE);
            let sample = ResidualSample { residual, stands: None, other: None };
            persistence.take(at, sample, residual > 1.0).is_some()
        };
        for k in 0..600 {
            take(&mut persistence, 10_000 + k, [0.0, 9.0][k as usize % 30 / 29]);
        }
        persistence.interrupt();
        let found = (0..9).position(|cycle| take(&mut persistence, cycle, 2.0));
        assert_eq!(found, Some(2), "as at the start");
    }

    #[test]
    fn a_single_wild_sample_keeps_nothing_raised_and_noise_does() {
        let goes_on = |residuals: &[f64]| {
            let mut persistence = Persistence::new(P.lasting, P);
            let taken = residuals.iter().zip(0..).filter(|(residual, cycle)| {
                let at = Timestamp::from_nanos(cycle * CYCLE);
                let sample = ResidualSample { residual: **residual, stands: None, other: None };
                persistence.goes_on(at, sample, residual.abs() > 1.0)
            });
            taken.count()
        };
        assert_eq!(goes_on(&(0..300).map(|k| [0.0, 9.0][k % 20 / 19]).collect::<Vec<_>>()), 0);
        assert_eq!(goes_on(&[1.5, 1.4, 1.3, 0.2]), 1);
        let noise: Vec<f64> = (0..30).map(|k| [0.2, 1.5, 0.1, -0.3][k % 4]).collect();
        assert!(goes_on(&noise) >= 4);
    }

    /// A load that doubles lets the rod swing: both observers see it.
    #[test]
    fn swings_that_the_other_observer_sees_are_no_noise() {
        let told = |other: f64| {
            let mut persistence = Persistence::new(P.lasting, P);
            (0..60).any(|k| {
                let residual = [0.2, 1.5, 0.1, -1.8][k as usize % 4];
                let sample =
                    ResidualSample { residual, stands: None, other: Some(other * residual) };
                let at = Timestamp::from_nanos(k * CYCLE);
                persistence.take(at, sample, residual.abs() > 1.0).is_some()
            })
        };
        assert!(told(0.1) && !told(0.9));
    }

    #[test]
    fn where_one_sample_is_enough_it_is_a_fault_at_once() {
        assert_eq!(lasted_for(1, &[0.1, 4.0, 0.0]), [(1, 1, 4.0)]);
    }
}
