//! Output of a replay for people and scripts: lines of JSON, tables of residuals, a page of text.

pub mod alignment;
pub mod calibration;
#[cfg(feature = "parquet")]
pub mod columns;
pub mod commission;
pub mod coverage;
pub mod csv;
pub(crate) mod device;
pub mod doubtful;
pub mod episode;
pub mod estimates;
pub mod evaluation;
pub mod explanation;
pub mod human;
pub mod identification;
pub mod incidents;
pub mod jsonl;
pub mod judgement;
pub mod nonlinear;
mod notice;
mod number;
pub mod pace;
pub mod page;
pub mod read_with;
pub mod residuals;
pub mod sheet;
pub mod stamps;
pub mod stops;
pub mod tuning;
pub mod verdict;
mod wording;
pub mod zone;

pub(crate) use tertius_core::text::counted;

pub use episode::{Episode, Episodes};
pub use estimates::{EstimateRow, EstimateTable};
pub use incidents::Incidents;
pub use judgement::Judgement;
pub use pace::{OffPace, RecordedPace};
pub use read_with::ReadWith;
pub use residuals::{ResidualRow, ResidualTable};
pub use stops::Stops;
pub use verdict::Blanks;
pub use wording::{bad_lines, capitalised, times};
pub use zone::Zone;

use serde::Serialize;
use tertius_config::{Fingerprints, MachineNames};
use tertius_core::monitor::{Counts, cylinder::Tally};
use tertius_recordings::Statistics;

/// Everything that a summary is made from.
#[derive(Clone, Copy, Debug)]
pub struct Summary<'a> {
    /// Duration from the first to the last frame, s.
    pub duration: f64,
    /// The same without the jumps of the time stamps, as between two recordings of different days, s: of what was in
    /// between nothing is known.
    pub recorded: f64,
    /// Sample time, s.
    pub sample_time: f64,
    /// How cylinders and transducers are called.
    pub names: &'a MachineNames,
    /// What it was judged by.
    pub fingerprints: &'a Fingerprints,
    /// Whether the machine has a model of its own; otherwise R1 and R2 are those of the thesis's.
    pub has_model: bool,
    /// Detectors that the configuration switches off, in words; `None` if all judge.
    pub switched_off: Option<&'a str>,
    /// Whether FDE1 and FDE2 judge.
    pub observes: bool,
    pub judgement: &'a Judgement,
    /// What of the cycle is other than the configuration says; empty where all is as it says.
    pub remarks: &'a [String],
    pub statistics: &'a Statistics,
    pub counts: &'a Counts,
    pub tallies: &'a [Tally],
    /// Longest times in which the observers did not judge.
    pub blanks: &'a Blanks,
    /// Jumps of the alive counters of C1 and C2 of each cylinder.
    pub counter_jumps: &'a [[u64; 2]],
    pub episodes: &'a Episodes,
    pub incidents: &'a Incidents,
    pub stops: &'a Stops<'a>,
}

/// Identities as fields of JSON.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub(crate) struct IdentityFields<'a> {
    /// Identity of the configuration, and of the calibration in it.
    configuration: String,
    calibration: Option<String>,
    /// Day (UTC) of the newest recording that the calibration was learnt from.
    calibration_recorded: Option<&'a str>,
}

impl<'a> From<&'a Fingerprints> for IdentityFields<'a> {
    fn from(it: &'a Fingerprints) -> Self {
        Self {
            configuration: it.configuration.to_string(),
            calibration: it.calibration.map(|calibration| calibration.to_string()),
            calibration_recorded: it.recorded.as_deref(),
        }
    }
}

impl Summary<'_> {
    /// What it was judged by, in words.
    pub fn judged_by(&self) -> String {
        let foreign = "; no [model], so that R1 and R2 are by that of the thesis, Table 4-1";
        format!("{}{}", self.fingerprints, if self.has_model { "" } else { foreign })
    }

    /// Number of frames that the monitor does not use.
    pub fn ignored_frames(&self) -> u64 {
        self.statistics.frames.saturating_sub(self.counts.used)
    }
}
