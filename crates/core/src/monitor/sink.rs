//! Output of the monitor.

use crate::alarm::{Detector, OwnFrame, Warning};
use crate::estimate::Estimate;
use crate::frame::{BusNumber, Id};
use crate::incident::Incident;
use crate::observe::observer::Restart;
use crate::sample::device::DeviceNews;
use crate::sample::dispute::Doubt;
use crate::sample::{DeviceRole, Quality, Transducer};
use crate::sequential::{Apart, Dwell};
use crate::time::{Span, Timestamp};
use alloc::vec::Vec;

/// Data of one cylinder in one cycle; `None` where there were none.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Record {
    /// Opening of the cycle.
    pub timestamp: Timestamp,
    /// Number of the cycle; missing ones are counted, so that consecutive numbers are consecutive
    /// cycles.
    pub cycle: u64,
    /// Cylinder number, counted from 1.
    pub cylinder: u8,
    /// Reading of C1 as received, m.
    pub c1: Option<f64>,
    /// Reading of C2 as received, m.
    pub c2: Option<f64>,
    /// Velocities by C1 and C2, m/s.
    pub velocities: [Option<f64>; 2],
    /// Qualities of C1 and C2.
    pub qualities: [Quality; 2],
    /// Bottom, rod and load pressure, bar; only from a monitor whose design includes them.
    pub pressures: [Option<f64>; 3],
    /// Supply pressure P_S, bar; only from a monitor whose design includes it.
    pub supply: Option<f64>,
    /// Position of the main spool in its own unit; only from a monitor whose design includes it.
    pub spool: Option<f64>,
    /// Corrected reading Ĉ2 = a·C2 + b, m.
    pub c2_corrected: Option<f64>,
    /// Command u(k), m/s.
    pub command: Option<f64>,
    /// Predictions C x̂ of both observers before the correction, m.
    pub estimates: [Option<f64>; 2],
    /// Residuals R1, R2 and R3, m, signed.
    pub residuals: [Option<f64>; 3],
    /// Whether FDE1 and FDE2 judged this cycle.
    pub judged: [bool; 2],
    /// Whether neither FDE1 nor FDE2 judged this cycle.
    pub gated: bool,
    /// Whether the platform is in a monitored state, even if no observer has settled.
    pub monitored: bool,
}

/// An event other than a warning.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Notice {
    /// Cycles were missing for longer than the observers predict over.
    Gap { at: Timestamp, length: Span },
    /// Time stamps went backwards, or too far forwards for a pause.
    TimeJump { at: Timestamp, by: Span },
    /// A bus was lost: bus-off, or the interface went down. Frames may be missing without a trace. `None`: all of the
    /// machine's buses, or its only one.
    Interruption { at: Timestamp, bus: Option<BusNumber> },
    /// A bus has fallen silent while another one is heard, or is heard again. What it carries is unknown meanwhile, and
    /// nobody is to blame.
    Silence { at: Timestamp, bus: BusNumber, silent: bool },
    /// Frames of a message cannot be relied on, or can be again. What they carry is unknown meanwhile where they contradict each
    /// other, and no transducer is to blame.
    Doubt { at: Timestamp, id: Id, bus: BusNumber, doubt: Doubt, is_over: bool },
    /// The observer of one transducer restarts.
    Restart { at: Timestamp, cylinder: u8, detector: Detector, reason: Restart },
    /// In most cylinders, C1 and C2 are sampled further apart in time than when they were
    /// calibrated; no transducer is at fault. `None`: as calibrated again.
    Timing { at: Timestamp, apart: Option<Apart> },
    /// A status of a transducer has bits, never set before, to which the configuration gives no meaning. Its readings are judged
    /// as without them.
    UnnamedStatus { at: Timestamp, cylinder: u8, transducer: Transducer, bits: u64 },
    /// A CANopen device said something of itself or of the network that is no fault of its readings.
    Device { at: Timestamp, cylinder: u8, role: DeviceRole, node: u8, news: DeviceNews },
}

/// Receives the monitor's output in the order of time. Methods that are not needed need not be
/// implemented.
pub trait Sink {
    /// Whether [`Self::record`] does anything; otherwise no records are made.
    fn wants_records(&self) -> bool {
        true
    }

    /// Takes the completed cycle of one cylinder.
    fn record(&mut self, record: &Record) {
        _ = record;
    }

    fn warning(&mut self, warning: &Warning) {
        _ = warning;
    }

    /// Takes an incident that was opened, revised or closed, after the warnings of that cycle.
    fn incident(&mut self, incident: &Incident) {
        _ = incident;
    }

    /// Takes the estimated length of a cylinder in the cycle that opened at `at`; `None`: it is not
    /// known. Called only by a monitor that estimates ([`Estimates`](super::Estimates)).
    fn estimate(&mut self, at: Timestamp, cylinder: u8, estimate: Option<&Estimate>) {
        _ = (at, cylinder, estimate);
    }

    /// Takes the dwell of a rod that has come to rest on its stop.
    fn dwell(&mut self, cylinder: u8, dwell: &Dwell) {
        _ = (cylinder, dwell);
    }

    /// Takes a frame to send.
    fn transmit(&mut self, frame: &OwnFrame) {
        _ = frame;
    }

    fn notice(&mut self, notice: &Notice) {
        _ = notice;
    }
}

/// Collects the warnings and ignores everything else.
impl Sink for Vec<Warning> {
    fn wants_records(&self) -> bool {
        false
    }

    fn warning(&mut self, warning: &Warning) {
        self.push(*warning);
    }
}
