//! Learning from healthy recordings.
//!
//! - [`survey`]: the readings of a recording, cycle by cycle, for the other modules.
//! - [`identify`]: the model (4-1) (chapter 4): census, streaming QR, validation on data held back.
//! - [`extremes`]: extremes of healthy residuals, and how often they occur.
//! - [`calibrate`]: a and b of (5-20), the band of R3, the tables of the sequential detectors.
//! - [`relate`]: what spool and pressures say of each other, for the process detectors.
//! - [`tune`]: Q, R, δ_l and δ_h for a wanted rate of false alarms, and the smallest faults that follow.
//! - [`propose`]: a configuration from a DBC and a recording: which signals are what.
//! - [`tables`]: the results as text that the configuration reads.
//! - [`learnt`]: frames kept of healthy recordings, so that those of several days add up.

pub mod calibrate;
pub mod excursions;
pub mod extremes;
pub mod identify;
pub mod learnt;
mod order_statistics;
pub mod propose;
pub mod relate;
pub mod survey;
pub mod tables;
pub mod tune;
