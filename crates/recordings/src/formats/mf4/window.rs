//! Frames that a logger wrote late, in the order of time.
//!
//! A logger that keeps the frames of each message together, and writes them when their buffer is full, has them out of order in
//! one group. Those of one message are in order all the same. Where they are not, the clock was set back, and what follows is
//! later whatever its time stamps are.

use std::collections::{HashMap, VecDeque};

use tertius_core::frame::{Frame, Id};
use tertius_core::time::Timestamp;

/// Frames among which one that comes late is put into its place: some seconds of a full machine, 400 KiB.
const MOST: usize = 4096;
/// Most messages that are followed.
const MESSAGES: usize = 4096;

/// Frames that wait for those that come late, with their channels.
#[derive(Debug, Default)]
pub struct Window {
    /// The earliest first.
    frames: VecDeque<(Frame, u64)>,
    /// Those of the clock before it was set back, which go first.
    before: VecDeque<(Frame, u64)>,
    /// Time stamp of the newest frame of each message and channel.
    newest: HashMap<(Id, u64), Timestamp>,
}

impl Window {
    /// Whether one has to be taken before the next one is put.
    pub fn is_full(&self) -> bool {
        self.frames.len() >= MOST || !self.before.is_empty()
    }

    /// Takes the next frame of the file.
    pub fn put(&mut self, frame: Frame, channel: u64) {
        let (at, message) = (frame.timestamp, (frame.id, channel));
        if self.newest.get(&message).is_some_and(|newest| at < *newest) {
            self.before.append(&mut self.frames);
            self.newest.clear();
        }
        if self.newest.len() < MESSAGES || self.newest.contains_key(&message) {
            self.newest.insert(message, at);
        }
        let is_newest = self.frames.back().is_none_or(|(last, _)| last.timestamp <= at);
        let place = if is_newest {
            self.frames.len()
        } else {
            self.frames.partition_point(|(other, _)| other.timestamp <= at)
        };
        self.frames.insert(place, (frame, channel));
    }

    /// The frame that is next, and its channel.
    pub fn take(&mut self) -> Option<(Frame, u64)> {
        self.before.pop_front().or_else(|| self.frames.pop_front())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tertius_core::frame::Kind;

    /// What comes out when frames of these milliseconds and identifiers are put in.
    fn ordered(frames: impl IntoIterator<Item = (i64, u32)>) -> Vec<(i64, u32)> {
        let (mut window, mut out) = (Window::default(), Vec::new());
        let mut take = |window: &mut Window| {
            let taken = window.take();
            out.extend(taken.iter().map(|(frame, channel)| {
                assert_eq!(*channel, u64::from(frame.id.value()) & 1);
                (frame.timestamp.as_nanos() / 1_000_000, frame.id.value())
            }));
            taken.is_some()
        };
        for (at, id) in frames {
            while window.is_full() {
                take(&mut window);
            }
            let at = Timestamp::from_nanos(1_000_000 * at);
            let frame = Frame::new(at, Id::standard(id).expect("11 bits"), Kind::Data, &[]);
            window.put(frame, u64::from(id) & 1);
        }
        while take(&mut window) {}
        out
    }

    #[test]
    fn what_comes_late_is_put_into_its_place_and_what_is_alike_stays_as_it_came() {
        let blocks = (0..9).flat_map(|block| {
            let of = move |id: u32| (0..25).map(move |k| (20 * (25 * block + k), id));
            of(0x211).chain(of(0x201)).chain(of(0x200))
        });
        let expected = (0..225).flat_map(|k| [0x211, 0x201, 0x200].map(|id| (20 * k, id)));
        assert_eq!(ordered(blocks), expected.collect::<Vec<_>>());
    }

    #[test]
    fn a_clock_that_was_set_back_goes_on_behind_what_was_before() {
        let cycle = |at: i64| [1, 2, 3].map(|id| (at + i64::from(id), id));
        for set_back in [50, 3000, 100_000] {
            let before = (0..500).flat_map(|k| cycle(100_000 + 20 * k));
            let after = (0..500).flat_map(|k| cycle(110_000 - set_back + 20 * k));
            let all: Vec<_> = before.chain(after).collect();
            assert_eq!(ordered(all.clone()), all, "{set_back} ms");
        }
    }

    #[test]
    fn frames_wait_in_bounded_memory() {
        let late = (0..3 * MOST as i64).map(|k| (k, 7)).chain([(0, 8)]);
        let mut expected: Vec<_> = (0..3 * MOST as i64).map(|k| (k, 7)).collect();
        // Later than by as many as wait it is where it came, before those.
        expected.insert(2 * MOST + 1, (0, 8));
        assert_eq!(ordered(late), expected);
        let many = (0..0x800).chain(0..0x800).map(|id| (0, id));
        assert_eq!(ordered(many.clone()), many.collect::<Vec<_>>());
    }
}
