//! The last frames, in memory.

use super::packer::Piece;
use std::collections::VecDeque;
use std::sync::Arc;
use tertius_core::time::{Span, Timestamp};

/// Most bytes of a ring, and of a recording. They share their pieces, and all of them end with the newest, so that
/// this bounds them together.
pub const MOST_BYTES: usize = 16 << 20;

/// Pieces of the last seconds.
#[derive(Debug)]
pub(super) struct Ring {
    pieces: VecDeque<Arc<Piece>>,
    keep: Span,
    bytes: usize,
}

impl Ring {
    /// A ring of the last `keep`.
    pub fn new(keep: Span) -> Self {
        Self { pieces: VecDeque::new(), keep, bytes: 0 }
    }

    /// Adds the newest piece. Older ones go, and so do those from the future, after the clock was set back.
    pub fn push(&mut self, piece: Arc<Piece>) {
        let now = piece.until;
        self.bytes += piece.size();
        self.pieces.push_back(piece);
        while let Some(oldest) = self.pieces.front() {
            let age = now.since(oldest.until);
            let is_needed = Span::ZERO <= age && age <= self.keep;
            if is_needed && self.bytes <= MOST_BYTES {
                break;
            }
            self.bytes -= oldest.size();
            self.pieces.pop_front();
        }
    }

    /// The pieces with everything from `from` on, as far as it is there. They begin with a state of the monitor
    /// where there is one before `from`.
    pub fn since(&self, from: Timestamp) -> Vec<Arc<Piece>> {
        let wanted = self.pieces.iter().take_while(|piece| piece.until < from).count();
        let mut until_wanted = self.pieces.iter().take(wanted + 1);
        let begin = until_wanted.rposition(|piece| piece.state.is_some()).unwrap_or(wanted);
        self.pieces.iter().skip(begin).cloned().collect()
    }

    /// All pieces, from the first state of the monitor on.
    pub fn whole(&self) -> Vec<Arc<Piece>> {
        let begin = self.pieces.iter().position(|piece| piece.state.is_some());
        self.pieces.iter().skip(begin.unwrap_or(0)).cloned().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn with_state(second: i64) -> Arc<Piece> {
        let mut piece = Arc::into_inner(piece(second, 100)).expect("there is one");
        piece.state = Some(Box::default());
        Arc::new(piece)
    }

    fn piece(second: i64, bytes: usize) -> Arc<Piece> {
        let until = Timestamp::from_nanos(second * 1_000_000_000);
        Arc::new(Piece {
            ends: None,
            until,
            frames: 1,
            lost: 0,
            bytes: vec![0; bytes].into(),
            state: None,
        })
    }

    fn seconds(ring: &Ring, from: i64) -> Vec<i64> {
        let pieces = ring.since(Timestamp::from_nanos(from * 1_000_000_000));
        pieces.iter().map(|piece| piece.until.as_nanos() / 1_000_000_000).collect()
    }

    #[test]
    fn it_keeps_the_last_seconds_and_no_others() {
        let mut ring = Ring::new(Span::from_seconds(3.0));
        (1..=10).for_each(|second| ring.push(piece(second, 100)));
        assert_eq!(seconds(&ring, 0), [7, 8, 9, 10]);
        assert_eq!(seconds(&ring, 9), [9, 10]);
        // The clock was set back.
        ring.push(piece(2, 100));
        assert_eq!(seconds(&ring, 0), [2]);
        assert_eq!(ring.bytes, 100);
    }

    #[test]
    fn what_is_taken_from_it_begins_with_a_state() {
        let mut ring = Ring::new(Span::from_seconds(100.0));
        let pieces = (1..=10).map(|n| if n % 4 == 0 { with_state(n) } else { piece(n, 100) });
        pieces.for_each(|piece| ring.push(piece));
        assert_eq!(seconds(&ring, 9), [8, 9, 10]);
        assert_eq!(seconds(&ring, 8), [8, 9, 10]);
        assert_eq!(seconds(&ring, 7), [4, 5, 6, 7, 8, 9, 10]);
        assert_eq!(seconds(&ring, 2)[0], 2, "there is none before");
        assert_eq!(ring.whole().len(), 7);
    }

    #[test]
    fn a_storm_shortens_it_instead_of_filling_the_memory() {
        let mut ring = Ring::new(Span::from_seconds(1000.0));
        (1..=10).for_each(|second| ring.push(piece(second, MOST_BYTES / 4)));
        assert_eq!(seconds(&ring, 0), [7, 8, 9, 10]);
        ring.push(piece(11, MOST_BYTES + 1));
        assert!(seconds(&ring, 0).is_empty());
    }
}
