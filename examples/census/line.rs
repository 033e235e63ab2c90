//! The record of one commissioning.

use crate::plan::{Mishap, Spoilt, Transducers};
use serde::{Deserialize, Serialize};

/// A line of the census.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Line {
    pub number: usize,
    pub seed: u64,
    pub machine: usize,
    pub transducers: Transducers,
    pub length_s: f64,
    pub pair: usize,
    pub calm_first: bool,
    pub mishap: Mishap,
    /// The configuration states that its bus has no spikes.
    pub stated_free: bool,
    pub spoilt: Option<Spoilt>,
    /// The cylinder with the fault in the recording.
    pub faulty: Option<u8>,
    /// `fit`, `partly` or `unfit`.
    pub fitness: String,
    pub refused: Vec<u8>,
    pub sentence: String,
    pub reasons: Vec<String>,
    /// The fault's time was left out of what was learnt.
    pub cut: bool,
    pub levels_nats: Vec<f64>,
    pub bound_mm: Option<f64>,
    pub high_mm: Option<f64>,
    /// Parts of the strokes that are known.
    pub seen: Vec<f64>,
    /// Objection of `check` to the configuration; none: it is sound.
    pub flaw: Option<String>,
    pub faults: Vec<Faults>,
    /// Fault-free hours.
    pub hours: f64,
    /// Number of false alarms of each detector in these hours.
    pub false_alarms: Vec<(String, u64)>,
    /// CPU time of the simulation, of the commissioning, and of the held-out trials, s.
    pub cpu_s: [f64; 3],
}

/// Held-out faults of a kind.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Faults {
    pub kind: String,
    pub tried: u64,
    /// Faults that began while a warning stood.
    pub spoilt: u64,
    /// Delay of each fault that was found, s.
    pub delays_s: Vec<f64>,
    pub right: u64,
    pub undecided: u64,
    pub wrong: u64,
}
