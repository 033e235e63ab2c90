//! Reading ahead: a thread of its own reads a recording while its frames are worked on.

mod batch;

use batch::Batch;

use super::format::blank_frame;
use super::progress::Progress;
use super::recording::Recording;
use super::source::{Source, SourceError};
use std::ops::ControlFlow;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread;
use tertius_core::frame::Frame;

/// Frames of a batch: enough that handing one over costs nothing, and few enough to stay in a processor's cache.
const BATCH: usize = 1024;

/// Batches, those that are read and worked on included.
const BATCHES: usize = 4;

/// What was read, and the progress after it.
type Read = (Batch, Progress);

/// Frames between two pauses of the taker.
const STRIDE: usize = 64 * BATCH;

/// What is done with the frames of a recording; either ends the reading by breaking.
pub trait FrameTaker {
    /// Takes the next frame.
    fn take(&mut self, frame: &Frame) -> ControlFlow<()>;

    /// Is called every 1,024 frames.
    fn glance(&mut self) {}

    /// Is called every 65,536 frames with the progress so far.
    fn pause(&mut self, progress: Progress) -> ControlFlow<()>;
}

/// Passes all frames of `recording` to `taker`, in their order. What it gets does not depend on how many `threads` there
/// are: with one, reading and taking are done in turn, with more, a second one reads at most 4,096 frames ahead. Of a
/// pipe nothing is read ahead, as the next frame may be long in coming.
///
/// # Errors
/// Why the recording cannot be read on, after the frames before were taken.
pub fn read_ahead(
    recording: &mut Recording,
    threads: usize,
    taker: &mut impl FrameTaker,
) -> Result<(), SourceError> {
    if threads < 2 || recording.progress().total.is_none() {
        return read_in_turn(recording, taker);
    }
    let (to_taker, from_reader) = sync_channel::<Read>(BATCHES);
    let (to_reader, from_taker) = sync_channel::<Batch>(BATCHES);
    for _ in 0..BATCHES {
        // There is room for all of them, and the other end is held below.
        let _ = to_reader.send(Batch::new(BATCH, blank_frame()));
    }
    thread::scope(|scope| {
        let reader = scope.spawn(move || read(recording, &from_taker, &to_taker));
        for ((mut batch, progress), n) in from_reader.iter().zip(1..) {
            let mut flow = batch.try_for_each(|frame| taker.take(frame));
            taker.glance();
            if flow.is_continue() && (BATCH * n).is_multiple_of(STRIDE) {
                flow = taker.pause(progress);
            }
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

fn read_in_turn(recording: &mut Recording, taker: &mut impl FrameTaker) -> Result<(), SourceError> {
    loop {
        for _ in 0..STRIDE / BATCH {
            for _ in 0..BATCH {
                let Some(frame) = recording.next_frame()? else { return Ok(()) };
                if taker.take(frame).is_break() {
                    return Ok(());
                }
            }
            taker.glance();
        }
        if taker.pause(recording.progress()).is_break() {
            return Ok(());
        }
    }
}

/// Reads all frames into batches `empty`, and passes these on as `full`, until the taker ends.
fn read(
    recording: &mut Recording,
    empty: &Receiver<Batch>,
    full: &SyncSender<Read>,
) -> Result<(), SourceError> {
    while let Ok(mut batch) = empty.recv() {
        let read = fill(&mut batch, recording);
        let is_last = !matches!(read, Ok(true));
        if batch.len() > 0 && full.send((batch, recording.progress())).is_err() || is_last {
            return read.map(|_| ());
        }
    }
    Ok(())
}

/// Reads frames into `batch`; returns false at the recording's end.
fn fill(batch: &mut Batch, recording: &mut Recording) -> Result<bool, SourceError> {
    batch.clear();
    while batch.len() < BATCH {
        let Some(frame) = recording.next_frame()? else {
            return Ok(false);
        };
        batch.push(frame);
    }
    Ok(true)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Options;
    use std::fmt::Write as _;
    use std::fs;
    use std::path::PathBuf;

    /// Takes frames as text, until it has `most`.
    struct Collector {
        taken: Vec<String>,
        most: usize,
    }

    impl FrameTaker for Collector {
        fn take(&mut self, frame: &Frame) -> ControlFlow<()> {
            if self.taken.len() == self.most {
                return ControlFlow::Break(());
            }
            let Frame { timestamp, bus, id, kind, .. } = frame;
            self.taken.push(format!("{timestamp} {bus} {id} {kind:?} {:02X?}", frame.data()));
            ControlFlow::Continue(())
        }

        fn pause(&mut self, progress: Progress) -> ControlFlow<()> {
            self.taken.push(format!("{:?}", progress.total));
            ControlFlow::Continue(())
        }
    }

    /// Each frame of a recording as text, at most `most` of them, and what broke the reading off.
    fn frames(
        mut recording: Recording,
        threads: usize,
        most: usize,
    ) -> (Vec<String>, Option<String>) {
        let mut collector = Collector { taken: Vec::new(), most };
        let result = read_ahead(&mut recording, threads, &mut collector);
        (collector.taken, result.err().map(|error| error.to_string()))
    }

    fn open(paths: &[PathBuf]) -> Recording {
        Recording::open(paths, Options::default()).expect("it is there")
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
        let paths = [folder.path().join("a.log")];
        for lines in [1, BATCH - 1, BATCH, BATCH + 1, BATCHES * BATCH + 7, 2 * STRIDE + 1] {
            fs::write(&paths[0], log(lines)).expect("it can be written");
            let one = frames(open(&paths), 1, usize::MAX);
            assert_eq!(one.0.len(), lines + lines / STRIDE);
            assert!(frames(open(&paths), 2, usize::MAX) == one, "{lines}");
        }
    }

    #[test]
    fn a_taker_that_breaks_off_ends_the_reading() {
        let folder = tempfile::tempdir().expect("it can be made");
        let paths = [folder.path().join("a.log")];
        fs::write(&paths[0], log(30 * BATCH)).expect("it can be written");
        for most in [0, 1, BATCH, 5 * BATCH + 3] {
            let (taken, error) = frames(open(&paths), 2, most);
            assert_eq!((taken.len(), error), (most, None));
        }
    }

    #[test]
    fn an_error_comes_after_the_frames_before_it() {
        let folder = tempfile::tempdir().expect("it can be made");
        let paths = ["a.log", "b.log"].map(|name| folder.path().join(name));
        let broken_off = |threads| {
            for path in &paths {
                fs::write(path, log(2 * BATCH + 9)).expect("it can be written");
            }
            let recording = open(&paths[..]);
            fs::remove_file(&paths[1]).expect("it is there");
            frames(recording, threads, usize::MAX)
        };
        let (taken, error) = broken_off(1);
        assert_eq!(taken.len(), 2 * BATCH + 9);
        assert!(error.as_ref().is_some_and(|error| error.contains("b.log")), "{error:?}");
        assert!(broken_off(2) == (taken, error));
    }
}
