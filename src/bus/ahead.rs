//! Reading ahead: a thread of its own reads a recording while its frames are worked on.

use super::format::blank_frame;
use super::progress::Progress;
use super::recording::Recording;
use super::source::{Source, SourceError};
use crate::frame::Frame;
use std::ops::ControlFlow;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread;

/// Frames of a batch: enough that handing one over costs nothing, and few enough to stay in a processor's cache.
const BATCH: usize = 1024;

/// Batches, those that are read and worked on included.
const BATCHES: usize = 4;

/// Frames in the order of the recording.
struct Batch {
    /// [`BATCH`] frames, of which the first `length` are read.
    frames: Vec<Frame>,
    length: usize,
    /// Progress after the last of them.
    progress: Progress,
}

/// Passes all frames of `recording` to `take`, in their order and a batch at a time, with the progress after it, until
/// `take` breaks. What the recording gives does not depend on how many `threads` there are: with one, reading and
/// taking are done in turn, with more, a second one reads at most 4,096 frames ahead. Of a pipe or socket a batch is a
/// single frame, and nothing is read ahead, as the next one may be long in coming.
///
/// # Errors
/// Why the recording cannot be read on, after the frames before were taken.
pub fn read_ahead(
    recording: &mut Recording,
    threads: usize,
    mut take: impl FnMut(&[Frame], Progress) -> ControlFlow<()>,
) -> Result<(), SourceError> {
    if threads < 2 || recording.progress().total.is_none() {
        return read_in_turn(recording, take);
    }
    let (to_taker, from_reader) = sync_channel::<Batch>(BATCHES);
    let (to_reader, from_taker) = sync_channel::<Batch>(BATCHES);
    let progress = recording.progress();
    for _ in 0..BATCHES {
        let batch = Batch { frames: vec![blank_frame(); BATCH], length: 0, progress };
        // There is room for all of them, and the other end is held below.
        let _ = to_reader.send(batch);
    }
    thread::scope(|scope| {
        let reader = scope.spawn(move || read(recording, &from_taker, &to_taker));
        for batch in &from_reader {
            let flow = take(&batch.frames[..batch.length], batch.progress);
            // A reader that is at the end takes none back.
            let _ = to_reader.send(batch);
            if flow.is_break() {
                break;
            }
        }
        // A reader that waits to hand over or to take back now ends.
        drop((from_reader, to_reader));
        reader.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    })
}

fn read_in_turn(
    recording: &mut Recording,
    mut take: impl FnMut(&[Frame], Progress) -> ControlFlow<()>,
) -> Result<(), SourceError> {
    let mut progress = recording.progress();
    let mut frames = 0_usize;
    while let Some(frame) = recording.next_frame()? {
        if take(std::slice::from_ref(frame), progress).is_break() {
            break;
        }
        frames += 1;
        if frames.is_multiple_of(BATCH) {
            progress = recording.progress();
        }
    }
    Ok(())
}

/// Reads all frames into batches `empty`, and passes these on as `full`, until the taker ends.
fn read(
    recording: &mut Recording,
    empty: &Receiver<Batch>,
    full: &SyncSender<Batch>,
) -> Result<(), SourceError> {
    while let Ok(mut batch) = empty.recv() {
        let read = fill(&mut batch, recording);
        let is_last = !matches!(read, Ok(true));
        if batch.length > 0 && full.send(batch).is_err() || is_last {
            return read.map(|_| ());
        }
    }
    Ok(())
}

/// Reads frames into `batch`; returns false at the recording's end.
fn fill(batch: &mut Batch, recording: &mut Recording) -> Result<bool, SourceError> {
    batch.length = 0;
    for place in &mut batch.frames {
        let Some(frame) = recording.next_frame()? else {
            return Ok(false);
        };
        place.clone_from(frame);
        batch.length += 1;
    }
    batch.progress = recording.progress();
    Ok(true)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bus::Options;
    use std::fmt::Write as _;
    use std::fs;
    use std::path::PathBuf;

    /// Each frame as text, and what broke the reading off.
    fn frames(path: &PathBuf, threads: usize, most: usize) -> (Vec<String>, Option<String>) {
        let mut recording = Recording::open(&[path], Options::default()).expect("it is there");
        let mut taken = Vec::new();
        let result = read_ahead(&mut recording, threads, |frames, _| {
            for frame in frames {
                if taken.len() == most {
                    return ControlFlow::Break(());
                }
                taken.push(format!("{frame:?}"));
            }
            ControlFlow::Continue(())
        });
        (taken, result.err().map(|error| error.to_string()))
    }

    fn log(lines: usize) -> String {
        let mut text = String::new();
        for n in 0..lines {
            let data = &"00112233445566778899AABBCCDDEEFF"[..2 * (n % 9)];
            writeln!(text, "({}.{:06}) can0 {:03X}#{data}", 1_700_000_000 + n, n, n % 0x800)
                .expect("it is memory");
        }
        text
    }

    #[test]
    fn two_threads_give_what_one_gives() {
        let folder = tempfile::tempdir().expect("it can be made");
        let path = folder.path().join("a.log");
        for lines in [1, BATCH - 1, BATCH, BATCH + 1, 3 * BATCH, BATCHES * BATCH + 7, 20_000] {
            fs::write(&path, log(lines)).expect("it can be written");
            let one = frames(&path, 1, usize::MAX);
            assert_eq!(one.0.len(), lines);
            assert_eq!(frames(&path, 2, usize::MAX), one, "{lines}");
        }
    }

    #[test]
    fn a_taker_that_breaks_off_ends_the_reading() {
        let folder = tempfile::tempdir().expect("it can be made");
        let path = folder.path().join("a.log");
        fs::write(&path, log(30 * BATCH)).expect("it can be written");
        for most in [0, 1, BATCH, 5 * BATCH + 3] {
            let (taken, error) = frames(&path, 2, most);
            assert_eq!((taken.len(), error), (most, None));
        }
    }

    /// An interface that becomes ambiguous in the middle.
    #[test]
    fn an_error_comes_after_the_frames_before_it() {
        let folder = tempfile::tempdir().expect("it can be made");
        let path = folder.path().join("a.log");
        let lines = log(2 * BATCH) + &log(4 * BATCH).replace("can0", "can1");
        fs::write(&path, lines).expect("it can be written");
        let one = frames(&path, 1, usize::MAX);
        assert!(one.1.as_ref().is_some_and(|error| error.contains("--interface")), "{one:?}");
        assert_eq!(frames(&path, 2, usize::MAX), one);
    }
}
