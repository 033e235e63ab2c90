//! The data path's side of the recorder: no allocation, lock or system call for a frame.

use super::block::{Block, INCIDENTS};
use crate::appliance::telemetry::Telemetry;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use tertius_core::frame::Frame;
use tertius_core::incident::Incident;
use tertius_core::monitor::Monitor;
use tertius_core::time::{Span, Timestamp};

/// Number of blocks, 2 MB: a disk that stalls for ten seconds loses nothing of a full bus with 1 Mbit/s.
const BLOCKS: usize = 32;

/// Longest time after which a block is handed over, full or not.
const LONGEST: Span = Span::from_nanos(1_000_000_000);

/// Time between two copies of the monitor.
const BETWEEN_STATES: Span = Span::from_nanos(10_000_000_000);

/// Copies frames into blocks, and hands these to the worker.
#[derive(Debug)]
pub(super) struct Tap {
    current: Option<Box<Block>>,
    full: SyncSender<Box<Block>>,
    empty: Receiver<Box<Block>>,
    /// Time of the data path when a block was handed over last.
    handed: Option<Timestamp>,
    /// The same, when the monitor was copied last.
    copied: Option<Timestamp>,
    /// Newest time stamp.
    now: Timestamp,
    /// Number of frames lost since a block was taken last.
    lost: u64,
    /// Incidents that wait for a block.
    incidents: Vec<Incident>,
    /// Number of incidents lost for want of room.
    left_out: u64,
    demand: Arc<AtomicBool>,
    telemetry: Arc<Telemetry>,
}

/// The worker's ends of the two channels.
#[derive(Debug)]
pub(super) struct Work {
    pub full: Receiver<Box<Block>>,
    pub empty: SyncSender<Box<Block>>,
}

/// A tap that begins with `monitor`, and what its worker needs. All blocks are made here, and no other ones later.
pub(super) fn connect(
    telemetry: &Arc<Telemetry>,
    demand: &Arc<AtomicBool>,
    monitor: &Monitor,
) -> (Tap, Work) {
    let (full, filled) = sync_channel(BLOCKS);
    let (emptied, empty) = sync_channel(BLOCKS);
    for _ in 0..BLOCKS {
        // There is room for all of them.
        _ = emptied.try_send(Box::new(Block::new()));
    }
    let mut tap = Tap {
        current: None,
        full,
        empty,
        handed: None,
        copied: None,
        now: Timestamp::default(),
        lost: 0,
        incidents: Vec::with_capacity(INCIDENTS),
        left_out: 0,
        demand: Arc::clone(demand),
        telemetry: Arc::clone(telemetry),
    };
    tap.provide();
    tap.copy(monitor);
    (tap, Work { full: filled, empty: emptied })
}

impl Tap {
    /// Copies a frame with the time stamp `at`.
    #[inline]
    pub fn frame(&mut self, at: Timestamp, frame: &Frame) {
        self.now = at;
        let taken = self.current.as_mut().is_some_and(|block| block.push(at, frame));
        if !taken {
            self.begin_with(at, frame);
        }
    }

    /// Copies a frame into the next block.
    #[cold]
    fn begin_with(&mut self, at: Timestamp, frame: &Frame) {
        self.hand_over(at);
        self.provide();
        let taken = self.current.as_mut().is_some_and(|block| block.push(at, frame));
        if !taken {
            self.lost += 1;
            self.telemetry.recorder_lost(1);
        }
    }

    /// Takes an incident, which follows the frames that have come so far.
    pub fn incident(&mut self, incident: &Incident) {
        if self.incidents.len() == INCIDENTS {
            self.left_out += 1;
            return;
        }
        self.incidents.push(*incident);
    }

    /// Hands over a block that is old enough, empty or not, so that the worker knows the time on a quiet bus. The
    /// next one begins with a copy of `monitor`, if that is due.
    pub fn turned(&mut self, now: Timestamp, monitor: &Monitor) {
        let handed = *self.handed.get_or_insert(now);
        if !is_due(now, handed, LONGEST) {
            return;
        }
        self.provide();
        self.hand_over(now);
        let copied = *self.copied.get_or_insert(now);
        if is_due(now, copied, BETWEEN_STATES) {
            self.provide();
            if self.copy(monitor) {
                self.copied = Some(now);
            }
        }
    }

    /// Copies the monitor into a block without frames, if there is one.
    fn copy(&mut self, monitor: &Monitor) -> bool {
        let block = self.current.as_mut();
        block.map(|block| block.state = Some(Box::new(monitor.clone()))).is_some()
    }

    /// Has a block to fill, if there is one.
    fn provide(&mut self) {
        if self.current.is_none()
            && let Ok(mut block) = self.empty.try_recv()
        {
            block.lost = std::mem::take(&mut self.lost);
            self.current = Some(block);
        }
    }

    fn hand_over(&mut self, now: Timestamp) {
        let Some(mut block) = self.current.take() else { return };
        block.until = now;
        block.demanded = self.demand.swap(false, Ordering::Relaxed);
        block.incidents.append(&mut self.incidents);
        block.left_out = std::mem::take(&mut self.left_out);
        self.handed = Some(now);
        // The channel has room for all blocks. If the worker has panicked, they are gone one by one, and frames
        // count as lost.
        _ = self.full.try_send(block);
    }
}

/// Whether the time since `last` is over, or the clock was set back.
fn is_due(now: Timestamp, last: Timestamp, time: Span) -> bool {
    let age = now.since(last);
    age >= time || age < Span::ZERO
}

impl Drop for Tap {
    /// Hands over what there is, before the channel closes.
    fn drop(&mut self) {
        self.provide();
        self.hand_over(self.now);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::appliance::telemetry::clock::SystemClock;
    use tertius_config::design;
    use tertius_core::frame::{Id, Kind};
    use tertius_dbc::Database;

    /// A monitor of the default machine.
    fn monitor() -> Monitor {
        let config = include_str!("../../../../../config/e-type.toml");
        let (settings, _) = tertius_config::parse("e-type.toml", config).expect("it is sound");
        let dbc = include_bytes!("../../../../../dbc/e-type.dbc");
        let database = Database::parse(&tertius_dbc::text::from_bytes(dbc)).expect("it is sound");
        Monitor::new(design::judging(&settings, &database).expect("they fit"))
    }

    fn frame(at: i64) -> Frame {
        let id = Id::standard(0x123).expect("11 bits");
        Frame::new(Timestamp::from_nanos(at), id, Kind::Data, &[0; 8])
    }

    #[test]
    fn a_worker_that_stands_still_costs_frames_and_nobody_waits() {
        let telemetry = Arc::new(Telemetry::new(&SystemClock::new()));
        let (mut tap, work) = connect(&telemetry, &Arc::default(), &monitor());
        let frames = 200_000;
        (0..frames).for_each(|at| tap.frame(Timestamp::from_nanos(at), &frame(at)));
        // The worker goes on.
        let mut came = 0;
        while let Ok(mut block) = work.full.try_recv() {
            came += block.frames().count();
            assert_eq!(block.lost, 0, "the first blocks have everything");
            block.clear();
            work.empty.try_send(block).expect("there is room");
        }
        assert!(came > 90_000, "{came}");
        tap.frame(Timestamp::from_nanos(frames), &frame(frames));
        drop(tap);
        let block = work.full.recv().expect("the rest is handed over");
        assert_eq!(came as u64 + block.lost, frames.unsigned_abs());
        assert_eq!(block.frames().map(|it| it.timestamp.as_nanos()).collect::<Vec<_>>(), [frames]);
    }

    #[test]
    fn time_passes_for_the_worker_on_a_quiet_bus() {
        let telemetry = Arc::new(Telemetry::new(&SystemClock::new()));
        let monitor = monitor();
        let (mut tap, work) = connect(&telemetry, &Arc::default(), &monitor);
        for ms in (0..3500).step_by(5) {
            tap.turned(Timestamp::from_nanos(ms * 1_000_000), &monitor);
        }
        let until = work.full.try_iter().map(|block| block.until.as_seconds());
        assert_eq!(until.collect::<Vec<_>>(), [1.0, 2.0, 3.0]);
    }
}
