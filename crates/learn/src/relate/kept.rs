//! What is kept of a recording that may be longer than there is room for.

use crate::survey::Ranking;

/// What follows what came before it, or does not.
pub trait Consecutive: Clone {
    /// Parts it from what came before.
    fn part(&mut self);
}

/// Every n-th piece of rows, counted anew after each pause, so that what is kept of a file does not depend on what was
/// recorded before it: all of them, or of a longer recording every other one, or every fourth, and so on.
#[derive(Clone, Debug)]
pub struct Pieces<R> {
    /// The most rows that are kept, and those of a piece.
    most: usize,
    piece: usize,
    rows: Vec<R>,
    /// Number of each piece that is kept, and the index of its first row.
    begun: Vec<(u64, usize)>,
    stride: u64,
    /// Number of the newest piece, from 0, and the rows that it has had.
    newest: Option<(u64, usize)>,
}

impl<R: Consecutive> Pieces<R> {
    /// None yet, and at `most` so many rows, in pieces of `piece`.
    pub const fn new(most: usize, piece: usize) -> Self {
        Self { most, piece, rows: Vec::new(), begun: Vec::new(), stride: 1, newest: None }
    }

    pub fn rows(&self) -> &[R] {
        &self.rows
    }

    /// Puts rows of these times, s, into the order of this `ranking`.
    pub fn rank(&mut self, ranking: &Ranking, time: impl Fn(&R) -> f64) {
        self.rows.sort_by_key(|row| ranking.rank(time(row)));
    }

    pub const fn pause(&mut self) {
        self.newest = None;
    }

    pub fn push(&mut self, mut row: R) {
        let (number, had) = match self.newest {
            None => (0, 0),
            Some((number, had)) if had == self.piece => (number + 1, 0),
            Some(newest) => newest,
        };
        self.newest = Some((number, had + 1));
        if number.is_multiple_of(self.stride) && self.rows.len() == self.most {
            self.halve();
        }
        // Of more pauses than there is room for, the first.
        if !number.is_multiple_of(self.stride) || self.rows.len() == self.most {
            return;
        }
        if had == 0 {
            self.begun.push((number, self.rows.len()));
            if self.stride > 1 {
                // The piece before it may be missing.
                row.part();
            }
        }
        self.rows.push(row);
    }

    fn halve(&mut self) {
        // Where there are only first pieces, no stride leaves any of them out.
        if self.begun.iter().all(|(number, _)| *number == 0) {
            return;
        }
        self.stride = self.stride.saturating_mul(2);
        let ends = self.begun.iter().skip(1).map(|(_, begin)| *begin).chain([self.rows.len()]);
        let spans: Vec<_> = self.begun.iter().copied().zip(ends).collect();
        let (mut rows, mut begun) = (Vec::with_capacity(self.rows.len()), Vec::new());
        for ((number, begin), end) in spans {
            if number.is_multiple_of(self.stride) {
                begun.push((number, rows.len()));
                rows.extend_from_slice(&self.rows[begin..end]);
            }
        }
        begun.iter().for_each(|(_, begin)| rows[*begin].part());
        (self.rows, self.begun) = (rows, begun);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Clone, Copy, Debug, PartialEq)]
    struct Numbered {
        number: u32,
        follows: bool,
    }

    impl Consecutive for Numbered {
        fn part(&mut self) {
            self.follows = false;
        }
    }

    /// The rows that are kept of files in this order, each with the numbers of its rows.
    fn kept(most: usize, files: &[std::ops::Range<u32>]) -> Vec<Numbered> {
        let mut pieces = Pieces::new(most, 3000);
        for file in files {
            pieces.pause();
            for number in file.clone() {
                pieces.push(Numbered { number, follows: number != file.start });
            }
        }
        assert!(pieces.rows.len() <= most);
        pieces.rows
    }

    #[test]
    fn files_in_either_order_keep_the_same_pieces() {
        let (one, other) = (0..40_000_u32, 100_000..125_500);
        for most in [100_000, 40_000, 20_000] {
            let mut there = kept(most, &[one.clone(), other.clone()]);
            let mut back = kept(most, &[other.clone(), one.clone()]);
            there.sort_by_key(|row| row.number);
            back.sort_by_key(|row| row.number);
            assert_eq!(there, back);
            assert!(there.len() >= most.min(65_500) / 2, "{} of {most}", there.len());
            // A row follows the one before where that is kept, too.
            for (last, row) in there.iter().zip(&there[1..]) {
                assert!(row.number == last.number + 1 || !row.follows, "{row:?}");
            }
        }
    }
}
