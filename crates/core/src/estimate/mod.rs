//! The virtual third sensor: each cylinder's length with its standard deviation, every cycle.
//!
//! ```text
//! C1 ─────────→ filter ─┐
//! C2 ─→ scale → filter ─┴─ those that are trusted ─→ carrier ─→ length, σ, valid
//! u(k) ─→ dynamics ──────────────────────────────────→ (alone)
//! ```
//!
//! Each transducer has a Kalman filter of its own ([`filter`]), so that what a transducer did before it
//! was blamed is in its own filter only, and goes with it. What is told is the mean of those that are
//! trusted, or the other one alone. Where neither is read the command carries the length on
//! ([`dynamics`]), and its standard deviation grows by what the same prediction was wrong by while
//! there were readings to compare it with ([`growth`]): no figure of the model is believed. Where it is
//! blame that leaves nobody, it goes on from a second before: what the blamed did meanwhile is in what
//! was told last.
//!
//! Lengths are on the scale of C1. How far C1 itself is from the rod is known to nobody here.
//!
//! *Undecided* means that one of the two lies by an unknown amount. The mean of both is then wrong by
//! half of their difference, to one side or the other, and so half of the difference is the standard
//! deviation of a choice between them. It is part of σ always, and at its largest of the last second
//! while somebody is suspected.

mod carrier;
pub mod dynamics;
pub mod filter;
pub mod growth;
mod mean;
pub mod parameters;
pub mod scale;
pub mod sensor;

pub use dynamics::{Drive, Dynamics};
pub use parameters::Parameters;
pub use scale::Scale;
pub use sensor::{Design, Input, VirtualSensor};

/// What an estimate is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    Both,
    C1,
    C2,
    /// The command alone.
    Model,
}

impl Source {
    /// As tables have it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Both => "both",
            Self::C1 => "c1",
            Self::C2 => "c2",
            Self::Model => "model",
        }
    }
}

/// The length of a cylinder in one cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// m, on the scale of C1.
    pub position: f64,
    /// Its standard deviation, m.
    pub sigma: f64,
    pub source: Source,
    /// There is evidence for it, σ is within its bound, and the length within the stroke.
    pub valid: bool,
}
