//! What leaves the monitor.

use crate::alarm::{Detector, OwnFrame, Warning};
use crate::estimate::Estimate;
use crate::observe::observer::Restart;
use crate::sample::Quality;
use crate::sequential::{Apart, Dwell};
use crate::time::{Span, Timestamp};
use alloc::vec::Vec;

/// Everything known of one cylinder in one cycle; `None` where there was nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Record {
    /// The opening of the cycle.
    pub timestamp: Timestamp,
    /// The number of the cycle; missing ones are counted, so that numbers in a row are cycles in a
    /// row.
    pub cycle: u64,
    /// From 1.
    pub cylinder: u8,
    /// The readings as they came, m.
    pub c1: Option<f64>,
    pub c2: Option<f64>,
    /// Their velocities, m/s.
    pub velocities: [Option<f64>; 2],
    /// What C1 and C2 are worth.
    pub qualities: [Quality; 2],
    /// Bottom, rod and load pressure, bar; only in a monitor whose design has them wired.
    pub pressures: [Option<f64>; 3],
    /// P_S, bar, and the position of the main spool in its own unit; likewise.
    pub supply: Option<f64>,
    pub spool: Option<f64>,
    /// Ĉ2 = a·C2 + b, m.
    pub c2_corrected: Option<f64>,
    /// u(k), m/s.
    pub command: Option<f64>,
    /// C x̂ of both observers before the correction, m.
    pub estimates: [Option<f64>; 2],
    /// R1, R2 and R3, m, signed.
    pub residuals: [Option<f64>; 3],
    /// FDE1 and FDE2 judged this cycle.
    pub judged: [bool; 2],
    /// Neither FDE1 nor FDE2 judged this cycle.
    pub gated: bool,
    /// The platform is in a monitored state, whether or not an observer has settled.
    pub monitored: bool,
}

/// Something to tell beside warnings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Notice {
    /// Cycles were missing for longer than the observers predict over.
    Gap { at: Timestamp, length: Span },
    /// Time stamps went backwards, or so far forwards that it is no pause any more.
    TimeJump { at: Timestamp, by: Span },
    /// The bus was lost: bus-off, or the interface went down. Frames may be missing without a trace.
    Interruption { at: Timestamp },
    /// The observer of one transducer starts anew.
    Restart { at: Timestamp, cylinder: u8, detector: Detector, reason: Restart },
    /// C1 and C2 are sampled further apart in time, in most cylinders, than when they were calibrated:
    /// a matter of time and of no transducer. `None`: as calibrated again.
    Timing { at: Timestamp, apart: Option<Apart> },
}

/// Takes what the monitor gives, in the order of time. What is not wanted need not be implemented.
pub trait Sink {
    /// Whether [`Self::record`] does anything: a record is made for nobody else.
    fn wants_records(&self) -> bool {
        true
    }

    /// A cycle of one cylinder is complete.
    fn record(&mut self, record: &Record) {
        _ = record;
    }

    fn warning(&mut self, warning: &Warning) {
        _ = warning;
    }

    /// The estimated length of a cylinder in the cycle that opened at `at`; `None`: nothing is known of
    /// it. Only of a monitor that estimates ([`Estimates`](super::Estimates)).
    fn estimate(&mut self, at: Timestamp, cylinder: u8, estimate: Option<&Estimate>) {
        _ = (at, cylinder, estimate);
    }

    /// A rod has come to rest on its stop.
    fn dwell(&mut self, cylinder: u8, dwell: &Dwell) {
        _ = (cylinder, dwell);
    }

    /// A frame to send.
    fn transmit(&mut self, frame: &OwnFrame) {
        _ = frame;
    }

    fn notice(&mut self, notice: &Notice) {
        _ = notice;
    }
}

/// Warnings, and nothing else.
impl Sink for Vec<Warning> {
    fn wants_records(&self) -> bool {
        false
    }

    fn warning(&mut self, warning: &Warning) {
        self.push(*warning);
    }
}
