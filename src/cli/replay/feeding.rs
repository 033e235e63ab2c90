//! The frames of a replay, from the recording to the monitor.

use super::super::Failure;
use super::super::output::Output;
use super::super::progress::Bar;
use super::super::recorded::RecordedInputs;
use super::super::state::StateFile;
use crate::bus::{Recording, Source, Statistics};
use crate::monitor::Monitor;
use crate::time::{Span, Timestamp};

/// Number of frames between two updates of progress and output.
const STRIDE: u64 = 1 << 16;

/// Feeds the whole recording to the monitor, while the outputs can be written; returns the time
/// from its first frame to its last. Where the state is `kept`, or was recorded with the
/// `inputs`, the machine goes on after the end.
pub fn feed(
    recording: &mut Recording,
    monitor: &mut Monitor,
    output: &mut Output,
    mut kept: Option<&mut StateFile>,
    inputs: &RecordedInputs,
) -> Result<Span, Failure> {
    let bar = Bar::new(recording.progress());
    let mut last = output.first;
    let mut frames = 0_u64;
    while let Some(frame) = recording.next_frame()? {
        last = frame.timestamp;
        if frames == 0 {
            begin(last, monitor, output, kept.as_deref_mut())?;
        }
        monitor.take(frame, output);
        frames += 1;
        if frames.is_multiple_of(STRIDE) {
            if output.failed() {
                break;
            }
            bar.show(recording.progress());
        }
    }
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
