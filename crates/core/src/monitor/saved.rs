//! The state of a monitor, which another monitor of the same design takes up.
//!
//! A recording that is cut at any place gives what the whole recording gives: a monitor that takes up the state at
//! the cut does with the next frame what the other one would have done. The file of a state says what it belongs to,
//! and is refused elsewhere:
//!
//! ```text
//! "tertius state\n"   14 bytes
//! shape               8 bytes, of the fields of all types in it
//! program             its version: length in a byte, text
//! design              8 bytes, checksum of the design
//! begin               8 bytes, time stamp of the first frame of all, ns
//! state               length in 8 bytes, as many bytes
//! checksum            8 bytes, CRC-64/XZ of all before it
//! ```
//!
//! Numbers are little-endian.

use super::page::Station;
use super::{Monitor, MonitorDesign};
use crate::state::{StateError, StateReader, StateWriter, Stateful, Whole, state};
use crate::time::{Span, Timestamp};
use alloc::string::String;
use alloc::vec::Vec;
use core::fmt::{self, Write};
use crc::{CRC_64_XZ, Crc, Digest};
use thiserror::Error;

state! {
    Monitor {
        keeps, clock, sync_watch, gate, sampling, pending, incomplete, missing_run, heard, monitored_once, opened_once, register,
        incidents, encoder, counts, last, next_status, last_status, next_due,
    }
    parts { stations, cylinders, silence, tilt, supply }
    but { subscriptions, by_timers, has_process, gap_cycles, sends_estimates }
    sound |it| it.is_sound()
}

const MAGIC: [u8; 14] = *b"tertius state\n";
const PROGRAM: &str = env!("CARGO_PKG_VERSION");
const CRC: Crc<u64> = Crc::<u64>::new(&CRC_64_XZ);

/// Longest file of a state, bytes: ten times that of a machine with everything.
pub const MAX_STATE: usize = 8 << 20;

/// Room for the state of a machine with everything, bytes.
const USUAL: usize = 1 << 19;

/// Farthest from the newest frame that anything falls due, or has opened: what is due is done one by one.
const FARTHEST: Span = Span::from_nanos(2 * 3600 * 1_000_000_000);

/// Checksum of the design of a monitor: of all that its configuration, DBC and EDS files, and the constants of the
/// program, make of it, whatever comments and order they have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DesignChecksum(u64);

/// The state of a monitor between two frames.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SavedState {
    design: DesignChecksum,
    begin: Timestamp,
    state: Vec<u8>,
}

/// Why a state is not taken up.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum StateRefusal {
    #[error("it is not the state of a monitor")]
    Other,
    #[error("it is longer than {MAX_STATE} bytes")]
    TooLong,
    #[error("its content has another checksum: it was changed or truncated")]
    Damaged,
    #[error(
        "another tertius ({0}) wrote it, whose state has other fields than that of this one ({PROGRAM})"
    )]
    Version(String),
    #[error(
        "it is of another design: the configuration, its DBC or EDS files, or the estimates that were asked for, \
         were others"
    )]
    Design,
    #[error("its content is not a state: {0}")]
    Content(#[from] StateError),
}

impl MonitorDesign {
    pub fn checksum(&self) -> DesignChecksum {
        let mut text = Checked(CRC.digest());
        // The text of a design has all of its numbers in full; a checksum takes any text.
        _ = write!(text, "{self:?}");
        DesignChecksum(text.0.finalize())
    }
}

/// A checksum of the text that is written to it.
struct Checked(Digest<'static, u64>);

impl Write for Checked {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        self.0.update(text.as_bytes());
        Ok(())
    }
}

impl SavedState {
    /// The state of `monitor`, which was made from the design of this checksum, and whose first frame of all had the
    /// time stamp `begin`.
    pub fn of(monitor: &Monitor, design: DesignChecksum, begin: Timestamp) -> Self {
        let mut writer = StateWriter::with_capacity(USUAL);
        monitor.save_state(&mut writer);
        Self { design, begin, state: writer.finish() }
    }

    /// Time stamp of the first frame of all.
    pub const fn begin(&self) -> Timestamp {
        self.begin
    }

    /// A monitor of `design` that goes on.
    ///
    /// # Errors
    /// The design is another one, or the content is not a state.
    pub fn resume(&self, design: MonitorDesign) -> Result<Monitor, StateRefusal> {
        if design.checksum() != self.design {
            return Err(StateRefusal::Design);
        }
        let mut monitor = Monitor::new(design);
        let mut reader = StateReader::new(&self.state);
        monitor.resume(&mut reader)?;
        reader.finish()?;
        Ok(monitor)
    }

    /// The state as a file.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut file = StateWriter::with_capacity(self.state.len() + 64);
        file.put(MAGIC);
        file.put(Monitor::SHAPE.to_le_bytes());
        file.put([PROGRAM.len() as u8]);
        file.put_all(PROGRAM.as_bytes());
        file.put(self.design.0.to_le_bytes());
        self.begin.save(&mut file);
        self.state.len().save(&mut file);
        file.put_all(&self.state);
        let mut bytes = file.finish();
        let checksum = CRC.checksum(&bytes);
        bytes.extend(checksum.to_le_bytes());
        bytes
    }

    /// Reads a file.
    ///
    /// # Errors
    /// It is another file, damaged, too long, or of a program whose state has other fields.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, StateRefusal> {
        if bytes.len() > MAX_STATE {
            return Err(StateRefusal::TooLong);
        }
        if !bytes.starts_with(&MAGIC) {
            return Err(StateRefusal::Other);
        }
        let (content, checksum) = bytes.split_last_chunk().ok_or(StateRefusal::Damaged)?;
        if CRC.checksum(content) != u64::from_le_bytes(*checksum) {
            return Err(StateRefusal::Damaged);
        }
        let mut reader = StateReader::new(&content[MAGIC.len().min(content.len())..]);
        let shape = u64::from_le_bytes(reader.take()?);
        let [length] = reader.take()?;
        let program = String::from_utf8_lossy(reader.take_all(length.into())?).into_owned();
        if shape != Monitor::SHAPE {
            return Err(StateRefusal::Version(program));
        }
        let design = DesignChecksum(u64::from_le_bytes(reader.take()?));
        let begin = Timestamp::read(&mut reader)?;
        let length = usize::read(&mut reader)?;
        let state = reader.take_all(length)?.to_vec();
        reader.finish()?;
        Ok(Self { design, begin, state })
    }
}

impl Monitor {
    /// Time stamp of the newest frame, or the time to which the monitor has advanced since.
    pub const fn newest(&self) -> Option<Timestamp> {
        self.last
    }

    fn save_state(&self, into: &mut StateWriter) {
        Stateful::save(self, into);
    }

    /// Whether what the parts say of each other agrees.
    fn is_sound(&self) -> bool {
        let pending = self.cylinders.iter().filter(|cylinder| cylinder.pending).count();
        let number = self.clock.number();
        let pages = || self.stations.iter().flat_map(|station: &Station| &station.pages);
        pending == self.pending
            && pages().all(|page| page.slot.is_of_cycles_until(number))
            && self.times_are_near(pages().filter_map(|page| page.slot.kept_since()))
    }

    /// Whether everything that falls due does so soon, and nothing where no time has passed yet.
    fn times_are_near(&self, mut kept: impl Iterator<Item = Timestamp>) -> bool {
        let mut cycle = self.clock.times();
        let Some(last) = self.last else {
            return cycle.next().is_none()
                && kept.next().is_none()
                && self.register.standing() == 0;
        };
        let is_near = |at: Timestamp| {
            let apart = at.since(last);
            apart <= FARTHEST && apart.as_nanos() >= -FARTHEST.as_nanos()
        };
        cycle.chain(kept).all(is_near)
            && self.register.times().all(is_near)
            && [self.next_due, self.next_status].into_iter().all(is_near)
    }
}
