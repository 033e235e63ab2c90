//! Frames that are a little out of order, as several buses bring them.

use std::collections::VecDeque;

use tertius_core::frame::Frame;
use tertius_core::time::Timestamp;

/// Most frames that are held back: what four full buses of 1 Mbit/s carry in half a second.
const MOST_HELD: usize = 1 << 14;

/// Sorts frames that are a little out of order.
#[derive(Debug, Default)]
pub struct Sorter {
    /// Frames in the order of their time stamps, equal ones as they came.
    held: VecDeque<Frame>,
}

impl Sorter {
    /// Takes a frame to be sorted in.
    pub fn put(&mut self, frame: &Frame) {
        let after = self.held.iter().rposition(|known| known.timestamp <= frame.timestamp);
        self.held.insert(after.map_or(0, |place| place + 1), frame.clone());
    }

    /// The next frame, if none that is still to come is before it: all up to `until` have come.
    pub fn take(&mut self, until: Timestamp) -> Option<Frame> {
        let first = self.held.front()?;
        let due = first.timestamp <= until || self.held.len() > MOST_HELD;
        due.then(|| self.held.pop_front()).flatten()
    }

    /// Time stamp of the newest frame that is held back.
    pub fn newest(&self) -> Option<Timestamp> {
        self.held.back().map(|frame| frame.timestamp)
    }

    /// The next frame, whatever is still to come.
    pub fn take_any(&mut self) -> Option<Frame> {
        self.held.pop_front()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tertius_core::frame::{Id, Kind};

    fn frame(at_ms: i64, id: u32) -> Frame {
        let id = Id::standard(id).expect("11 bits");
        Frame::new(Timestamp::from_nanos(at_ms * 1_000_000), id, Kind::Data, &[])
    }

    #[test]
    fn frames_come_in_the_order_of_their_stamps_and_equal_ones_as_they_came() {
        let mut sorter = Sorter::default();
        for (at, id) in [(5, 1), (3, 2), (5, 3), (4, 4), (5, 5), (9, 6)] {
            sorter.put(&frame(at, id));
        }
        let until = Timestamp::from_nanos(5_000_000);
        let taken: Vec<u32> =
            std::iter::from_fn(|| sorter.take(until)).map(|frame| frame.id.value()).collect();
        assert_eq!(taken, [2, 4, 1, 3, 5]);
        assert_eq!(sorter.newest(), Some(Timestamp::from_nanos(9_000_000)));
    }

    #[test]
    fn what_is_held_back_is_bounded() {
        let mut sorter = Sorter::default();
        (0..=MOST_HELD).for_each(|_| sorter.put(&frame(7, 1)));
        let never = Timestamp::from_nanos(0);
        assert!(sorter.take(never).is_some());
        assert!(sorter.take(never).is_none());
    }
}
