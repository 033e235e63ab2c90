//! Disturbances of the process and of the wiring of all transducers, which are no fault of a single
//! one.

use super::load_steps::LoadSteps;
use crate::plant::{CYLINDERS, ValveTable};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use serde::Deserialize;

/// Table of disturbances; an entry that is absent does not happen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Disturbance {
    /// Load of all cylinders, multiplied by `part`.
    pub load: Option<Change>,
    /// Loads of single cylinders change suddenly.
    pub load_steps: Option<LoadSteps>,
    /// Flow of the pump, multiplied by `part`.
    pub pump: Option<Change>,
    /// Spools stick.
    pub sticking: Option<Sticking>,
    /// Valves of the plant, where they differ from those that the controller's look-up tables were
    /// measured on.
    pub valve: Option<ValveTable>,
    /// Spikes: single samples that are off.
    pub spikes: Option<Spikes>,
    /// Sampling times beside those that are usual.
    pub sampling: Option<Sampling>,
}

/// Spikes: single samples of each transducer are off, up or down, at random.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Spikes {
    /// From and until, s after the first cycle.
    pub time: [f64; 2],
    /// Share of the samples of C1 and of C2 with a spike, 0 to 1.
    pub share: [f64; 2],
    /// Size of a spike, counts.
    pub counts: f64,
}

/// Sampling times that differ from the usual ones.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sampling {
    /// From and until, s after the first cycle.
    pub time: [f64; 2],
    /// Constant delay of the samples of each C2, s.
    #[serde(default)]
    pub skew: f64,
    /// Standard deviation of a random shift of the samples of each C2, s.
    #[serde(default)]
    pub jitter: f64,
    /// Standard deviation of a random shift that C1 and C2 of a cylinder share, s.
    #[serde(default)]
    pub shared_jitter: f64,
}

/// Disturbance of one reading.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Misread {
    /// Delay of the sample, s.
    pub late: f64,
    /// Error of the sample, counts.
    pub counts: f64,
}

/// A quantity that is a multiple of its usual value.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Change {
    /// From and until, s after the first cycle.
    pub time: [f64; 2],
    pub part: f64,
}

/// Stiction of a spool: it stays until its command is further away than `band`, and then goes there.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sticking {
    /// From and until, s after the first cycle.
    pub time: [f64; 2],
    /// Width of the band, part of the spool's full stroke.
    pub band: f64,
}

impl Disturbance {
    /// Factor of the loads at `time`, s.
    pub fn load(&self, time: f64) -> f64 {
        part(self.load, time)
    }

    /// Missing part of the pump's flow at `time`, s: 0 to 1.
    pub fn pump_lost(&self, time: f64) -> f64 {
        1.0 - part(self.pump, time)
    }

    /// Spool positions at `time`, s, that follow from those `before` and the `wanted` ones, where each spool
    /// has a fault that makes it stick in a band of its own, too.
    pub fn spools(
        &self,
        time: f64,
        before: &[f64; CYLINDERS],
        wanted: &[f64; CYLINDERS],
        bands: &[f64; CYLINDERS],
    ) -> [f64; CYLINDERS] {
        let band = self.sticking.filter(|it| is_in(it.time, time)).map_or(0.0, |it| it.band);
        std::array::from_fn(|leg| {
            let (before, wanted) = (before[leg], wanted[leg]);
            if (wanted - before).abs() < band.max(bands[leg]) { before } else { wanted }
        })
    }

    /// Disturbances of C1 and C2 of a cylinder at `time`, s.
    pub fn readings(&self, time: f64, rng: &mut ChaCha8Rng) -> [Misread; 2] {
        let sampling = self.sampling.filter(|it| is_in(it.time, time));
        let spikes = self.spikes.filter(|it| is_in(it.time, time));
        let shared = match sampling {
            Some(it) if it.shared_jitter > 0.0 => it.shared_jitter * normal(rng),
            _ => 0.0,
        };
        std::array::from_fn(|which| {
            let mut misread = Misread { late: shared, counts: 0.0 };
            if let Some(it) = sampling.filter(|_| which == 1) {
                misread.late += it.skew + it.jitter * normal(rng);
            }
            if let Some(it) = spikes
                && rng.random::<f64>() < it.share[which]
            {
                misread.counts = if rng.random::<bool>() { it.counts } else { -it.counts };
            }
            misread
        })
    }
}

fn normal(rng: &mut ChaCha8Rng) -> f64 {
    StandardNormal.sample(rng)
}

fn is_in([from, until]: [f64; 2], time: f64) -> bool {
    (from..until).contains(&time)
}

fn part(change: Option<Change>, time: f64) -> f64 {
    change.filter(|change| is_in(change.time, time)).map_or(1.0, |change| change.part)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;

    #[test]
    fn a_sticking_spool_goes_only_where_it_is_far_from() {
        let sticking = Some(Sticking { time: [1.0, 2.0], band: 0.02 });
        let disturbance = Disturbance { sticking, ..Disturbance::default() };
        for (time, before, wanted, expected) in [
            (0.5, 0.1, 0.105, 0.105),
            (1.5, 0.1, 0.119, 0.1),
            (1.5, 0.1, 0.081, 0.1),
            (1.5, 0.1, 0.121, 0.121),
            (2.5, 0.1, 0.105, 0.105),
        ] {
            let spools = disturbance.spools(
                time,
                &[before; CYLINDERS],
                &[wanted; CYLINDERS],
                &[0.0; CYLINDERS],
            );
            assert_eq!(spools, [expected; CYLINDERS], "{time} {wanted}");
        }
    }

    #[test]
    fn without_a_table_nothing_happens() {
        let none = Disturbance::default();
        assert_eq!((none.load(7.0), none.pump_lost(7.0)), (1.0, 0.0));
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        assert_eq!(none.readings(7.0, &mut rng), [Misread::default(); 2]);
    }

    #[test]
    fn readings_are_off_by_chance_in_their_time() {
        let disturbance = Disturbance {
            spikes: Some(Spikes { time: [1.0, 2.0], share: [0.1, 0.0], counts: 4.0 }),
            sampling: Some(Sampling {
                time: [1.0, 2.0],
                skew: 3e-4,
                jitter: 2e-4,
                shared_jitter: 0.0,
            }),
            ..Disturbance::default()
        };
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let mut read = |time, which: usize| -> Vec<Misread> {
            (0..10_000).map(|_| disturbance.readings(time, &mut rng)[which]).collect()
        };
        assert!(read(0.5, 0).iter().chain(&read(2.0, 1)).all(|it| *it == Misread::default()));
        let (c1, c2) = (read(1.5, 0), read(1.5, 1));
        assert!(c1.iter().all(|it| it.late == 0.0) && c2.iter().all(|it| it.counts == 0.0));
        let count = |counts| c1.iter().filter(|it| it.counts == counts).count();
        assert!([4.0, -4.0].into_iter().all(|counts| (430..570).contains(&count(counts))));
        let mean = c2.iter().map(|it| it.late).sum::<f64>() / 1e4;
        let square = c2.iter().map(|it| (it.late - mean).powi(2)).sum::<f64>() / 1e4;
        assert!((mean - 3e-4).abs() < 1e-5 && (square.sqrt() - 2e-4).abs() < 1e-5);
    }

    #[test]
    fn a_shared_jitter_moves_both_samples_alike() {
        let sampling = Sampling { time: [0.0, 1.0], skew: 0.0, jitter: 0.0, shared_jitter: 1e-3 };
        let disturbance = Disturbance { sampling: Some(sampling), ..Disturbance::default() };
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let late: Vec<[f64; 2]> = (0..10_000)
            .map(|_| disturbance.readings(0.5, &mut rng).map(|misread| misread.late))
            .collect();
        assert!(late.iter().all(|[c1, c2]| c1 == c2));
        let square = late.iter().map(|[c1, _]| c1 * c1).sum::<f64>() / 1e4;
        assert!((square.sqrt() - 1e-3).abs() < 3e-5, "{square}");
    }
}
