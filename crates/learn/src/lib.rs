//! What is learnt from healthy recordings.
//!
//! - [`survey`]: the readings of a recording, cycle by cycle, for what learns from it.
//! - [`identify`]: the model (4-1) (chapter 4): census, streaming QR, validation on data held back.
//! - [`extremes`]: how large a healthy residual gets, and how seldom.
//! - [`calibrate`]: a and b of (5-20), the band of R3, the tables of the sequential detectors.
//! - [`tune`]: Q, R, δ_l and δ_h for a wanted rate of false alarms, and the smallest faults that follow.
//! - [`tables`]: all of it as text that the configuration reads.
//! - [`learnt`]: what is kept of healthy recordings, so that those of several days add up.

pub mod calibrate;
pub mod extremes;
pub mod identify;
pub mod learnt;
pub mod survey;
pub mod tables;
pub mod tune;
