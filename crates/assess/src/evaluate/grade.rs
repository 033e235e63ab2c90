//! Resolution of the transducers.

use serde::Serialize;
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
