//! How much evidence against a healthy machine its recording seems to hold: the level of the
//! sequential detectors.

use crate::extremes::{Maxima, Tail, common_level, per_second};
use crate::sequential::{Design, Input, Sequential, wild};
use crate::survey::{Row, Surveyor};

/// Reads the recording with the sequential detectors of all cylinders that have one.
#[derive(Clone, Debug)]
pub struct Watch {
    /// By cylinder.
    watched: Vec<Option<Watched>>,
}

#[derive(Clone, Debug)]
struct Watched {
    detector: Sequential,
    maxima: Maxima,
    worst: f64,
}

/// The level h of all cylinders.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Level {
    /// h, nats: at least the largest evidence seen, and what spikes reach ([`wild::least_level`]).
    pub nats: f64,
    /// The largest evidence seen, nats.
    pub worst: f64,
    /// The time that all detectors together have judged, h.
    pub hours: f64,
    /// A tail heavier than an exponential one was found on one cylinder at least.
    pub heavy: bool,
}

impl Watch {
    /// By these `designs`; `block`: cycles that are one warning.
    pub fn new<'a>(designs: impl IntoIterator<Item = Option<&'a Design>>, block: u32) -> Self {
        // With a finite level an alarm would hide what comes after it.
        let watched = |design: &Design| Watched {
            detector: Sequential::new(Design { level: f64::INFINITY, ..design.clone() }),
            maxima: Maxima::new(block),
            worst: 0.0,
        };
        Self { watched: designs.into_iter().map(|design| design.map(watched)).collect() }
    }

    /// The level that is reached `per_year` times a year, all cylinders together; `None` where no
    /// cylinder has a detector, or one has judged too little.
    pub fn level(&self, per_year: f64, sample_time: f64) -> Option<Level> {
        let watched = || self.watched.iter().flatten();
        let tails: Vec<Tail> =
            watched().map(|one| Tail::fit(&one.maxima, sample_time)).collect::<Option<_>>()?;
        if tails.is_empty() {
            return None;
        }
        let worst = watched().map(|one| one.worst).fold(0.0, f64::max);
        Some(Level {
            nats: common_level(&tails, per_second(per_year)).max(worst).max(wild::least_level()),
            worst,
            hours: tails.iter().map(|tail| tail.seconds).sum::<f64>() / 3600.0,
            heavy: tails.iter().any(|tail| tail.heavy),
        })
    }
}

impl Surveyor for Watch {
    fn row(&mut self, row: &Row) {
        let Some(watched) = &mut self.watched[usize::from(row.cylinder) - 1] else { return };
        watched.detector.step(&Input {
            lengths: [row.c1, row.c2],
            velocity: row.v2,
            command: row.u,
            monitored: row.monitored,
            at: row.timestamp,
            at_stop: false,
        });
        if watched.detector.verdict() == crate::verdict::Verdict::Unknown {
            return;
        }
        let [mean, variance] = watched.detector.peaks();
        let nats = mean.nats.max(variance.nats);
        watched.maxima.add(nats);
        watched.worst = watched.worst.max(nats);
    }

    fn gap(&mut self, cylinder: u8) {
        if let Some(watched) = &mut self.watched[usize::from(cylinder) - 1] {
            watched.detector.interrupt();
        }
    }
}
