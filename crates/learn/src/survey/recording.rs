//! Recordings that can be read repeatedly.

use super::{Survey, Surveyor, Timeline, Window};
use tertius_core::frame::Frame;
use tertius_core::monitor::{Counts, Monitor, MonitorDesign};
use tertius_core::time::Timestamp;

/// A recording that can be read as often as needed, with the same rows each time.
pub trait Recording {
    type Error;

    /// Passes the rows within `window` to `surveyor`.
    ///
    /// # Errors
    /// The recording can no longer be read.
    fn read(&self, window: Window, surveyor: impl Surveyor) -> Result<(), Self::Error>;

    /// Reads as [`Self::read`] does and returns what the monitor counted; `None` where there was no
    /// monitor.
    ///
    /// # Errors
    /// See [`Self::read`].
    fn read_counted(&self, window: Window, surveyor: impl Surveyor) -> Result<Counts, Self::Error> {
        self.read(window, surveyor)?;
        Ok(Counts::default())
    }
}

impl<R: Recording> Recording for &R {
    type Error = R::Error;

    fn read(&self, window: Window, surveyor: impl Surveyor) -> Result<(), Self::Error> {
        (**self).read(window, surveyor)
    }

    fn read_counted(&self, window: Window, surveyor: impl Surveyor) -> Result<Counts, Self::Error> {
        (**self).read_counted(window, surveyor)
    }
}

/// Frames that can be read as often as needed, the same each time.
pub trait Frames {
    type Error;

    /// Passes the frames within `window` (seconds since the first one) to `take`, in order.
    ///
    /// # Errors
    /// The frames can no longer be read.
    fn frames(&self, window: Window, take: impl FnMut(&Frame)) -> Result<(), Self::Error>;
}

/// Origin of the rows that something is learnt from.
#[derive(Clone, Debug, PartialEq)]
pub struct Origin {
    /// Names of the recordings.
    pub inputs: String,
    /// Times of the recordings' frames.
    pub timeline: Timeline,
    /// Window that is learnt from.
    pub window: Window,
    /// Remarks on what could not be read; empty where everything could.
    pub remarks: Vec<String>,
}

/// The rows that a monitor of one design makes of frames.
#[derive(Clone, Debug)]
pub struct Rows<'a, F> {
    pub frames: &'a F,
    pub design: &'a MonitorDesign,
    /// Time stamp of the first frame.
    pub first: Timestamp,
}

/// Time before a window in which the monitor learns the platform's state, counters and calm, s.
const LEAD: f64 = 10.0;

/// Time after a window in which its last cycle closes, s.
const TRAIL: f64 = 1.0;

impl<F: Frames> Recording for Rows<'_, F> {
    type Error = F::Error;

    fn read(&self, window: Window, surveyor: impl Surveyor) -> Result<(), F::Error> {
        self.read_counted(window, surveyor).map(drop)
    }

    fn read_counted(&self, window: Window, surveyor: impl Surveyor) -> Result<Counts, F::Error> {
        let mut monitor = Monitor::new(self.design.clone());
        let mut survey = Survey::new(self.first, window, surveyor);
        let fed = Window { from: window.from - LEAD, to: window.to + TRAIL };
        let mut newest = None;
        self.frames.frames(fed, |frame| {
            let at = frame.timestamp;
            if newest.is_some_and(|newest| Timeline::is_pause(at.since(newest))) {
                monitor.interrupt(at, &mut survey);
            }
            newest = newest.max(Some(at));
            monitor.take(frame, &mut survey);
        })?;
        monitor.finish(&mut survey);
        Ok(*monitor.counts())
    }
}
