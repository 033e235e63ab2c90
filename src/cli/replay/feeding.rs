//! The frames of a replay, from the recording to the monitor.

use super::super::Failure;
use super::super::output::Output;
use super::super::progress::Bar;
use super::super::recorded::RecordedInputs;
use super::super::state::StateFile;
use crate::bus::{Recording, Statistics, read_ahead};
use crate::monitor::Monitor;
use crate::time::{Span, Timestamp};
use std::ops::ControlFlow;

/// Number of frames between two updates of progress and output.
const STRIDE: usize = 1 << 16;

/// Feeds the whole recording to the monitor, while the outputs can be written; returns the time
/// from its first frame to its last. With more than one of `threads` it is read ahead. Where the state
/// is `kept`, or was recorded with the `inputs`, the machine goes on after the end.
pub fn feed(
    recording: &mut Recording,
    threads: usize,
    monitor: &mut Monitor,
    output: &mut Output,
    mut kept: Option<&mut StateFile>,
    inputs: &RecordedInputs,
) -> Result<Span, Failure> {
    let bar = Bar::new(recording.progress());
    let (mut last, mut begun, mut since_shown) = (output.first, Ok(false), 0);
    read_ahead(recording, threads, |frames, progress| {
        if let (Ok(false), [first, ..]) = (&begun, frames) {
            begun = begin(first.timestamp, monitor, output, kept.as_deref_mut()).map(|()| true);
        }
        if begun.is_err() {
            return ControlFlow::Break(());
        }
        for frame in frames {
            monitor.take(frame, output);
            last = frame.timestamp;
        }
        since_shown += frames.len();
        if since_shown >= STRIDE {
            since_shown = 0;
            if output.failed() {
                return ControlFlow::Break(());
            }
            bar.show(progress);
        }
        ControlFlow::Continue(())
    })?;
    begun?;
    if kept.is_some() || inputs.state.is_some() {
        monitor.standing().for_each(|incident| output.incidents.take(&incident));
    } else {
        monitor.finish(output);
    }
    bar.finish();
    Ok(last.since(output.first))
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
