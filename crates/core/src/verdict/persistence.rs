//! A residual beyond its threshold that has to stay there, or to be there often: one or two wild samples are no fault.
//!
//! A spike on a cable is off for a sample. Where one sample in a hundred is wild, two follow each other about once a minute
//! on a machine, and three hardly once an hour. Without a sequential detector a threshold is all that finds a step, and
//! counts at once, as in the thesis.

use super::parameters::VerdictParameters;
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

/// Newest samples beyond the threshold that are kept.
const OFTEN: usize = 7;

/// Follows one residual until it has stayed beyond its threshold for some samples, or was there often.
#[derive(Clone, Debug)]
pub struct Persistence {
    exceeded: Option<Exceeded>,
    /// Newest samples beyond the threshold, the oldest first.
    newest: [Option<Lasting>; OFTEN],
    /// Samples that it has to stay.
    samples: u32,
    parameters: &'static VerdictParameters,
}

state! {
    Persistence { exceeded, newest }
    but { samples, parameters }
}

impl Persistence {
    /// Of a residual that is a fault after so many `samples` beyond its threshold, at least 1.
    pub const fn new(samples: u32, parameters: &'static VerdictParameters) -> Self {
        Self { exceeded: None, newest: [None; OFTEN], samples, parameters }
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

    /// Forgets what has not lasted, after a sample that is not known.
    pub const fn dismiss(&mut self) {
        self.exceeded = None;
    }

    /// Takes a residual that `exceeds` its threshold or follows one that did; returns what has lasted long enough.
    pub fn take(
        &mut self,
        at: Timestamp,
        sample: ResidualSample,
        exceeds: bool,
    ) -> Option<Lasting> {
        let ResidualSample { residual, stands, other } = sample;
        // What the other observer sees half of is an error of the model, whose swings are no noise of a reading.
        let is_shared = other.is_some_and(|it| it.abs() > 0.5 * residual.abs());
        let stands = stands.unwrap_or(residual);
        let before = self.exceeded.filter(|_| self.stays(stands));
        let began =
            exceeds.then_some(Exceeded { at, first: stands, largest: residual, samples: 0 });
        self.exceeded = before.or(began);
        let exceeded = self.exceeded.as_mut()?;
        exceeded.samples += 1;
        if residual.abs() > exceeded.largest.abs() {
            exceeded.largest = residual;
        }
        let Exceeded { at: since, largest, samples, .. } = *exceeded;
        let lasting = if samples >= self.samples {
            Lasting { since, largest }
        } else if exceeds && !is_shared {
            self.often(at, residual)?
        } else {
            return None;
        };
        self.dismiss();
        self.newest = [None; OFTEN];
        Some(lasting)
    }

    /// What has exceeded the threshold so often that it is noise.
    fn often(&mut self, at: Timestamp, residual: f64) -> Option<Lasting> {
        self.newest.rotate_left(1);
        self.newest[OFTEN - 1] = Some(Lasting { since: at, largest: residual });
        let since = self.newest[0]?.since;
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

    /// Cycles, from 0, in which a residual of so many mm has lasted for so many samples beyond 1 mm, with the first of it and
    /// the largest.
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

    #[test]
    fn where_one_sample_is_enough_it_is_a_fault_at_once() {
        assert_eq!(lasted_for(1, &[0.1, 4.0, 0.0]), [(1, 1, 4.0)]);
    }
}
