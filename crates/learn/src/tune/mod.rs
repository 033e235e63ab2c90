//! The observer's weights and the thresholds of R1 and R2, from a healthy recording.
//!
//! ```text
//! rows ─┬→ store ─ stretches ─→ search ─ Q, R ─→ evidence (all rows) ─ tails ─→ δ_l, δ_h
//!       │    └──────────────────────────────────── sensitivity ←──────────────────┘
//!       └→ commands ─ largest ones ─→ evidence
//! ```
//!
//! The thesis tuned Q and R by hand, until the innovation was small and a step showed sharply in
//! it. Here a number measures this ([`criterion`]): the smallest step and the smallest incipient
//! fault (5-18) that can be told from the healthy innovation at the wanted rate of false alarms,
//! provided that the response to a step is over before another detector could take it for an event
//! of its own. [`mod@search`] minimises it on [`store`]d stretches of the recording; [`evidence`]
//! then reads the whole recording, and [`sensitivity`] computes what the thresholds find.
//! [`mod@course`] runs all of this in turn.

mod commands;
pub mod course;
pub mod criterion;
pub mod cycle;
mod drawn;
pub mod evidence;
mod joint;
mod model;
mod pause;
pub mod response;
pub mod search;
pub mod sensitivity;
pub mod store;
mod usable;

pub use commands::Commands;
pub use criterion::{Criterion, Score};
pub use evidence::{Detector, Evidence};
pub use model::{CylinderModel, Weights, designs};
pub use search::{Search, search};
pub use store::Store;
pub use usable::{OF_A_LEVEL, WOULD_HAVE_WARNED};

use crate::survey::{Timeline, Window};
use tertius_core::observe::commands::LearntCommands;

/// Result for a machine.
#[derive(Clone, Debug)]
pub struct Tuning {
    pub machine: String,
    /// Names of the recordings.
    pub inputs: String,
    /// Times of the recordings' frames.
    pub timeline: Timeline,
    pub window: Window,
    /// Sample time, s.
    pub sample_time: f64,
    /// How long an observer settles, and R1 and R2 are no fault together after a rare command, s.
    pub settle: f64,
    pub search: Search,
    pub thresholds: Thresholds,
    /// Results of every transducer that is monitored, by cylinder.
    pub detectors: Vec<Detector>,
    /// Level of the sequential detectors; `None` where there are none, or the recording is too
    /// short.
    pub sequential: Option<crate::calibrate::watch::Level>,
    /// Levels at other rates: false alarms a year, and m.
    pub ladder: Vec<(f64, f64)>,
    /// Standard deviation that is the unit of noise amplitudes, m.
    pub sigma: f64,
    pub remarks: Vec<String>,
}

/// δ_h of the thesis, m; no smaller one is proposed.
pub const LEAST_HIGH: f64 = 1e-3;

/// δ_l and δ_h, and the rate that they were made for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Thresholds {
    /// Lower threshold δ_l, m.
    pub low: f64,
    /// Upper threshold δ_h, m.
    pub high: f64,
    /// R1 or R2 that is a fault where C1 − C2 shows it, too, m; `None` where `high` is no larger, or no sequential detector is
    /// calibrated.
    pub joint: Option<f64>,
    /// Commands that they were made with; `None` where none moved a rod.
    pub commands: Option<LearntCommands>,
    /// False alarms of the whole machine in a year of monitoring.
    pub per_year: f64,
    /// Judged time in the recording of the detector with the least, h.
    pub hours: f64,
}
