//! The last frames, in memory.

use super::packer::Piece;
use crate::time::{Span, Timestamp};
use std::collections::VecDeque;
use std::sync::Arc;

/// Most bytes of a ring, and of a recording. They share their pieces, and all of them end with the newest, so that
/// this bounds them together.
pub(super) const MOST_BYTES: usize = 16 << 20;

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
        self.bytes += piece.bytes.len();
        self.pieces.push_back(piece);
        while let Some(oldest) = self.pieces.front() {
            let age = now.since(oldest.until);
            let is_needed = Span::ZERO <= age && age <= self.keep;
            if is_needed && self.bytes <= MOST_BYTES {
                break;
            }
            self.bytes -= oldest.bytes.len();
            self.pieces.pop_front();
        }
    }

    /// The pieces with everything from `from` on, as far as it is there.
    pub fn since(&self, from: Timestamp) -> Vec<Arc<Piece>> {
        self.pieces.iter().filter(|piece| piece.until >= from).cloned().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn piece(second: i64, bytes: usize) -> Arc<Piece> {
        let until = Timestamp::from_nanos(second * 1_000_000_000);
        Arc::new(Piece { ends: None, until, frames: 1, lost: 0, bytes: vec![0; bytes].into() })
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
    fn a_storm_shortens_it_instead_of_filling_the_memory() {
        let mut ring = Ring::new(Span::from_seconds(1000.0));
        (1..=10).for_each(|second| ring.push(piece(second, MOST_BYTES / 4)));
        assert_eq!(seconds(&ring, 0), [7, 8, 9, 10]);
        ring.push(piece(11, MOST_BYTES + 1));
        assert!(seconds(&ring, 0).is_empty());
    }
}
