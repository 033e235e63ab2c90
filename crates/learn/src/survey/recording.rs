//! Recordings that what learns reads again and again.

use super::{Survey, Surveyor, Timeline, Window};
use tertius_core::frame::Frame;
use tertius_core::monitor::{Counts, Monitor, MonitorDesign};
use tertius_core::time::Timestamp;

/// A recording that can be read as often as needed, the same each time.
pub trait Recording {
    type Error;

    /// Shows what is within `window` to `surveyor`.
    ///
    /// # Errors
    /// It cannot be read any more.
    fn read(&self, window: Window, surveyor: impl Surveyor) -> Result<(), Self::Error>;

    /// As [`Self::read`], with what the monitor counted on the way; nothing where there was none.
    ///
    /// # Errors
    /// As [`Self::read`].
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

    /// Gives the frames within `window` (seconds since the first one) to `take`, in order.
    ///
    /// # Errors
    /// They cannot be read any more.
    fn frames(&self, window: Window, take: impl FnMut(&Frame)) -> Result<(), Self::Error>;
}

/// Where the rows come from that something is learnt from.
#[derive(Clone, Debug, PartialEq)]
pub struct Origin {
    /// The recordings' names.
    pub inputs: String,
    /// Where its frames are in time.
    pub timeline: Timeline,
    /// What is learnt from.
    pub window: Window,
    /// What could not be read, for people; empty where everything could.
    pub remarks: Vec<String>,
}

/// The rows that a monitor of one design makes of frames.
#[derive(Clone, Debug)]
pub struct Rows<'a, F> {
    pub frames: &'a F,
    pub design: &'a MonitorDesign,
    /// The time stamp of the first frame.
    pub first: Timestamp,
}

/// Before a window the monitor gets to know the platform's state, counters and calm, s.
const LEAD: f64 = 10.0;

/// After it the last cycle closes, s.
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
