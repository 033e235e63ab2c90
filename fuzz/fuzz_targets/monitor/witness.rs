//! Sees what a monitor says, and checks what must hold of it whatever came in.

use tertius::alarm::register::PLACES;
use tertius::alarm::status::MAX_CYLINDERS;
use tertius::alarm::{OwnFrame, State, Warning};
use tertius::frame::Frame;
use tertius::monitor::{Counts, Notice, Record, Sink};
use tertius::time::Timestamp;

use super::machine::OWN;

const STATUS_PERIOD: i64 = 100_000_000;
const REPEAT: i64 = 1_000_000_000;

/// Anything said, in order.
#[derive(Debug, PartialEq)]
pub enum Said {
    Record(Record),
    Warning(Warning),
    Frame(Frame),
    Notice(Notice),
}

#[derive(Default)]
pub struct Witness {
    pub said: Vec<Said>,
    standing: [[bool; PLACES]; MAX_CYLINDERS],
    newest: Option<Timestamp>,
    /// Nanoseconds that pass with the next call.
    passing: i64,
    records: u64,
    warnings: u64,
    statuses: u64,
    repeats: u64,
    all_records: u64,
}

impl Witness {
    /// The next call brings time forward by at most `nanos`.
    pub fn expect_after(&mut self, nanos: i64) {
        self.passing = nanos;
        (self.records, self.warnings, self.statuses, self.repeats) = (0, 0, 0, 0);
    }

    /// What one call may say at most.
    pub fn check_bounds(&self, gap_cycles: u64) {
        let places = (MAX_CYLINDERS * PLACES) as u64;
        assert!(self.records <= MAX_CYLINDERS as u64 * (gap_cycles + 4));
        assert!(self.warnings <= self.records * PLACES as u64);
        assert!(self.statuses <= (self.passing / STATUS_PERIOD) as u64 + 2);
        assert!(self.repeats <= ((self.passing / REPEAT) as u64 + 2) * places + self.warnings);
    }

    /// What must hold in the end.
    pub fn check_counts(&self, counts: &Counts) {
        assert!(self.all_records <= (counts.cycles + counts.missing) * MAX_CYLINDERS as u64);
        assert!(counts.incomplete <= counts.cycles);
    }

    fn see(&mut self, at: Timestamp) {
        assert!(self.newest.is_none_or(|newest| at >= newest), "said out of order");
        self.newest = Some(at);
    }
}

impl Sink for Witness {
    fn record(&mut self, record: &Record) {
        self.records += 1;
        self.all_records += 1;
        assert!((1..=MAX_CYLINDERS).contains(&usize::from(record.cylinder)));
        let numbers = [record.c1, record.c2, record.c2_corrected, record.command];
        let numbers = numbers.into_iter().chain(record.estimates).chain(record.residuals);
        assert!(numbers.flatten().all(f64::is_finite));
        self.said.push(Said::Record(*record));
    }

    fn warning(&mut self, warning: &Warning) {
        self.warnings += 1;
        self.see(warning.timestamp);
        let standing = &mut self.standing[usize::from(warning.cylinder) - 1][warning.place];
        assert_eq!(*standing, warning.state != State::Raised);
        *standing = warning.state != State::Cleared;
        self.said.push(Said::Warning(*warning));
    }

    fn transmit(&mut self, frame: &OwnFrame) {
        let frame = frame.as_frame();
        let [status, warning, ..] = *OWN;
        assert!(frame.id == status || frame.id == warning, "{} is not ours", frame.id);
        assert_eq!(frame.length(), 8);
        self.statuses += u64::from(frame.id == status);
        self.repeats += u64::from(frame.id == warning);
        self.see(frame.timestamp);
        self.said.push(Said::Frame(frame.clone()));
    }

    fn notice(&mut self, notice: &Notice) {
        match notice {
            Notice::TimeJump { at, .. } => self.newest = Some(*at),
            Notice::Gap { at, .. }
            | Notice::Interruption { at }
            | Notice::Restart { at, .. }
            | Notice::Timing { at, .. }
            | Notice::Device { at, .. } => self.see(*at),
        }
        self.said.push(Said::Notice(*notice));
    }
}
