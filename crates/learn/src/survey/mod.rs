//! The readings of every cylinder in a recording, cycle by cycle: the input of everything that
//! learns.
//!
//! The monitor itself decodes, forms the cycles and judges the quality of each reading, so that
//! learning uses the same data as monitoring. A [`Survey`] is a sink for a monitor of
//! [`design::surveying`](tertius_config::design::surveying). It passes [`Row`]s to a [`Surveyor`]
//! and reports gaps in the data. It keeps only the last cycle of each cylinder, so memory does not
//! grow with the recording.

mod ranking;
mod recording;
mod row;
mod timeline;
mod window;

pub use ranking::{Lull, PAUSE, Ranked, Ranking};
pub use recording::{Frames, Origin, Recording, Rows};
pub use row::Row;
pub use timeline::{LONGEST_PAUSE, Timeline};
pub use window::Window;

use tertius_core::alarm::status::MAX_CYLINDERS;
use tertius_core::monitor::{Notice, Record, Sink};
use tertius_core::time::Timestamp;

/// Receives the rows of a recording.
pub trait Surveyor {
    /// Takes one cylinder in one cycle, in the order of time; rows of one cylinder without a
    /// [`Self::gap`] between them are consecutive cycles.
    fn row(&mut self, row: &Row);

    /// Reports that the next row of `cylinder` does not follow the previous one: cycles are
    /// missing, the clock jumped, the bus was lost, or the window ended. Called once, whether or
    /// not a row follows.
    fn gap(&mut self, cylinder: u8);
}

/// Two surveyors that share one pass over a recording.
impl<A: Surveyor, B: Surveyor> Surveyor for (A, B) {
    fn row(&mut self, row: &Row) {
        self.0.row(row);
        self.1.row(row);
    }

    fn gap(&mut self, cylinder: u8) {
        self.0.gap(cylinder);
        self.1.gap(cylinder);
    }
}

impl<S: Surveyor> Surveyor for &mut S {
    fn row(&mut self, row: &Row) {
        (**self).row(row);
    }

    fn gap(&mut self, cylinder: u8) {
        (**self).gap(cylinder);
    }
}

/// Makes rows and gaps from the records of a monitor.
#[derive(Debug)]
pub struct Survey<S> {
    first: Timestamp,
    window: Window,
    /// Cycle of the newest row of each cylinder; `None` after a gap.
    newest: [Option<u64>; MAX_CYLINDERS],
    surveyor: S,
}

impl<S: Surveyor> Survey<S> {
    /// A survey that counts time from `first`, the recording's first frame, and passes on what is
    /// within `window`.
    pub const fn new(first: Timestamp, window: Window, surveyor: S) -> Self {
        Self { first, window, newest: [None; MAX_CYLINDERS], surveyor }
    }

    /// The surveyor, with what it has learnt.
    pub fn into_surveyor(self) -> S {
        self.surveyor
    }

    fn interrupt(&mut self, index: usize) {
        if self.newest[index].take().is_some() {
            // A monitor has at most MAX_CYLINDERS.
            self.surveyor.gap(index as u8 + 1);
        }
    }
}

impl<S: Surveyor> Sink for Survey<S> {
    fn record(&mut self, record: &Record) {
        let index = usize::from(record.cylinder) - 1;
        let t = record.timestamp.since(self.first).as_seconds();
        if !self.window.holds(t) || row::is_empty(record) {
            return self.interrupt(index);
        }
        if self.newest[index].is_some_and(|newest| newest + 1 != record.cycle) {
            self.interrupt(index);
        }
        self.newest[index] = Some(record.cycle);
        self.surveyor.row(&Row::new(record, t));
    }

    fn notice(&mut self, notice: &Notice) {
        if let Notice::TimeJump { .. } | Notice::Interruption { .. } = notice {
            (0..MAX_CYLINDERS).for_each(|index| self.interrupt(index));
        }
    }
}
