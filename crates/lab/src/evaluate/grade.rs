//! Resolution of the transducers.

use serde::Serialize;
use tertius_config::Settings;
use tertius_machine::simulator::Tables;

/// A grade of transducers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Grade {
    /// Readings of one count (5-3), and now and then off by four counts for a while (Figure 5-9).
    Fine,
    /// Readings in steps of four counts: Figure 5-9 taken as the resolution.
    Coarse,
}

/// Transducers in one sea.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell {
    pub grade: Grade,
    /// Significant wave height, m, and peak period, s.
    pub sea: [f64; 2],
}

/// Standard deviation of the noise before rounding, counts: half a count, as 5e-5 m on the E-type.
const NOISE: f64 = 0.4608;

/// Counts in a step of the coarse transducers.
const COUNTS: f64 = 4.0;

impl Grade {
    pub const ALL: [Self; 2] = [Self::Fine, Self::Coarse];

    pub const fn name(self) -> &'static str {
        match self {
            Self::Fine => "fine",
            Self::Coarse => "coarse",
        }
    }

    /// That of the transducers which the sequential detectors of `settings` were taught, on the machine of `tables`; `None` where there are
    /// no such detectors.
    pub fn taught(settings: &Settings, tables: &Tables) -> Option<Self> {
        let fitted = (1..=settings.machine.cylinders).filter_map(|n| settings.sequential_of(n));
        let resolution =
            fitted.map(|it| it.resolution[0].max(it.resolution[1])).reduce(f64::max)?;
        let [low, high] = tables.transducer.range;
        let is_coarse = resolution > 0.5 * COUNTS * (high - low) / tables.transducer.counts;
        Some(if is_coarse { Self::Coarse } else { Self::Fine })
    }

    /// The machine of `tables` with transducers of this grade.
    pub fn apply(self, tables: &Tables) -> Tables {
        let mut tables = tables.clone();
        let [low, high] = tables.transducer.range;
        tables.transducer.noise = NOISE * (high - low) / tables.transducer.counts;
        if self == Self::Coarse {
            tables.transducer.counts = (tables.transducer.counts / COUNTS).max(2.0);
            tables.transducer.fluctuation_probability = 0.0;
        }
        tables
    }
}
