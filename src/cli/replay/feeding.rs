//! The frames of a replay, from the recording to the monitor.

mod overlap;

use super::super::Failure;
use super::super::output::Output;
use super::super::progress::Bar;
use super::super::recorded::RecordedInputs;
use super::super::state::StateFile;
use super::witness::Witness;
use crate::bus::{FrameTaker, Options, Progress, Recording, Statistics, read_ahead};
use crate::frame::Frame;
use crate::monitor::Monitor;
use crate::time::{Span, Timestamp};
use overlap::{Beginnings, STEP_BACK};
use std::ops::ControlFlow;

/// Feeds the whole recording to the monitor and the witness, while the outputs can be written; returns the time
/// from its first frame to its last. With more than one of `threads` it is read ahead. Where the state
/// is `kept`, or was recorded with the `inputs`, the machine goes on after the end.
///
/// # Errors
/// The recording cannot be read, or one of the `inputs` begins within those before it.
pub fn feed(
    recording: &mut Recording,
    threads: usize,
    (monitor, witness): (&mut Monitor, &mut Witness),
    output: &mut Output,
    kept: Option<&mut StateFile>,
    (inputs, options): (&RecordedInputs, &Options),
) -> Result<Span, Failure> {
    let goes_on = kept.is_some() || inputs.state.is_some();
    let (bar, last) = (Bar::new(recording.progress()), output.first);
    let later = Beginnings::new(&inputs.logs, options);
    let (begun, attends, failure) = (false, true, None);
    let mut feeding =
        Feeding { monitor, witness, output, kept, bar, later, last, begun, attends, failure };
    read_ahead(recording, threads, &mut feeding)?;
    let Feeding { monitor, witness, output, bar, last, failure, .. } = feeding;
    witness.glance(monitor);
    // A warning may be raised by the last frame, which no other one follows.
    if let Some(explaining) = &mut output.explaining
        && last.since(output.first) >= explaining.at
    {
        explaining.explained.get_or_insert_with(|| monitor.explain());
    }
    if let Some(failure) = failure {
        return Err(failure);
    }
    if goes_on {
        monitor.standing().for_each(|incident| output.incidents.take(&incident));
    } else {
        monitor.finish(output);
    }
    output.catch_up();
    bar.finish();
    Ok(last.since(output.first))
}

/// A replay that goes on.
struct Feeding<'a> {
    monitor: &'a mut Monitor,
    witness: &'a mut Witness,
    output: &'a mut Output,
    kept: Option<&'a mut StateFile>,
    bar: Bar,
    later: Beginnings<'a>,
    /// Time stamp of the newest frame.
    last: Timestamp,
    begun: bool,
    /// Whether more is done with a frame than to judge it: it is the first one, the witness looks at it, or a time is to be
    /// explained.
    attends: bool,
    failure: Option<Failure>,
}

impl FrameTaker for Feeding<'_> {
    #[inline(always)]
    fn take(&mut self, frame: &Frame) -> ControlFlow<()> {
        if frame.timestamp < self.last && self.begins_again(frame.timestamp) {
            return ControlFlow::Break(());
        }
        self.last = frame.timestamp;
        if self.attends && self.attend(frame).is_break() {
            return ControlFlow::Break(());
        }
        self.monitor.take(frame, self.output);
        ControlFlow::Continue(())
    }

    fn glance(&mut self) {
        self.attends = self.witness.glance(self.monitor) || self.output.explaining.is_some();
    }

    fn pause(&mut self, progress: Progress) -> ControlFlow<()> {
        if self.output.failed() {
            return ControlFlow::Break(());
        }
        self.bar.show(progress);
        ControlFlow::Continue(())
    }
}

impl Feeding<'_> {
    // Out of the way of most frames, which pay one question for it.
    #[cold]
    #[inline(never)]
    fn attend(&mut self, frame: &Frame) -> ControlFlow<()> {
        if !self.begun {
            let begun = begin(self.last, self.monitor, self.output, self.kept.as_deref_mut());
            self.failure = begun.err();
            if self.failure.is_some() {
                return ControlFlow::Break(());
            }
            self.begun = true;
        }
        self.witness.take(frame);
        if let Some(explaining) = &mut self.output.explaining
            && frame.timestamp.since(self.output.first) > explaining.at
        {
            explaining.explained = Some(self.monitor.explain());
            return ControlFlow::Break(());
        }
        ControlFlow::Continue(())
    }

    /// Whether a recording begins at `stamp`, before the newest frame, and therefore within those before it.
    #[cold]
    fn begins_again(&mut self, stamp: Timestamp) -> bool {
        if self.begun && stamp.since(self.last) < STEP_BACK {
            self.failure = self.later.refuse(stamp, self.last).err();
        }
        self.failure.is_some()
    }
}

/// Begins the outputs of a recording whose first frame is stamped `first`.
#[cold]
fn begin(
    first: Timestamp,
    monitor: &Monitor,
    output: &mut Output,
    kept: Option<&mut StateFile>,
) -> Result<(), Failure> {
    output.first = first;
    output.begin = kept.map_or(Ok(first), |kept| kept.begin(first, monitor.newest()))?;
    if let Some(columns) = &mut output.columns {
        columns.begin(first, output.begin);
    }
    Ok(())
}

/// Fails if a part of an input could not be read, although the rest was replayed.
pub fn damage(statistics: &Statistics) -> Result<(), Failure> {
    match statistics.damage.first() {
        Some(damage) => Err(Failure::Failed(damage.to_string())),
        None => Ok(()),
    }
}
