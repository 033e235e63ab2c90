//! Selects the pieces to drop when there are too many.

use super::Piece;
use crate::survey::{Row, Surveyor, Timeline};
use std::collections::BTreeMap;

/// Length of a cell of the stroke, m: the distance between a profile's nodes.
const CELL: f64 = 0.1;

/// Fewest rows with which a rod has visited a cell: half a second at 50 Hz.
const LEAST_ROWS: u32 = 25;

/// Records which cells of the stroke the rods visit in each piece.
#[derive(Clone, Debug)]
pub struct Visiting {
    /// Start of each piece, s, in order.
    begins: Vec<f64>,
    /// Number of rows of a cylinder in a cell, for each piece.
    rows: Vec<BTreeMap<(u8, i32), u32>>,
}

impl Visiting {
    /// A record of these pieces, which are in the order of time, with rows timed by `timeline`.
    pub fn new(pieces: &[Piece], timeline: &Timeline) -> Self {
        let begins: Vec<f64> = pieces.iter().map(|it| timeline.seconds(it.first())).collect();
        Self { rows: vec![BTreeMap::new(); begins.len()], begins }
    }

    /// The indices of the pieces that are kept, so that their sizes `bytes` total at most `most`.
    /// The piece whose cells were visited in the most others is dropped first; of equal ones, the
    /// oldest.
    pub fn keep(&self, bytes: &[usize], most: usize) -> Vec<usize> {
        let cells: Vec<Vec<(u8, i32)>> = self.rows.iter().map(visited).collect();
        let mut counts: BTreeMap<(u8, i32), u32> = BTreeMap::new();
        for cell in cells.iter().flatten() {
            *counts.entry(*cell).or_default() += 1;
        }
        let mut kept: Vec<usize> = (0..bytes.len()).collect();
        let mut total: usize = bytes.iter().sum();
        while total > most {
            let worth = |index: usize| -> f64 {
                cells[index].iter().map(|cell| 1.0 / f64::from(counts[cell])).sum()
            };
            let worths = kept.iter().enumerate().map(|(place, index)| (place, worth(*index)));
            let least = worths.min_by(|one, other| one.1.total_cmp(&other.1));
            let Some((place, _)) = least else { break };
            let gone = kept.remove(place);
            total -= bytes[gone];
            for cell in &cells[gone] {
                *counts.entry(*cell).or_default() -= 1;
            }
        }
        kept
    }
}

fn visited(rows: &BTreeMap<(u8, i32), u32>) -> Vec<(u8, i32)> {
    rows.iter().filter(|(_, count)| **count >= LEAST_ROWS).map(|(cell, _)| *cell).collect()
}

impl Surveyor for Visiting {
    fn row(&mut self, row: &Row) {
        // A cycle opens a little before its first frame that is kept, or after.
        let behind = self.begins.partition_point(|begin| *begin <= row.t);
        let rows = behind.checked_sub(1).and_then(|piece| self.rows.get_mut(piece));
        if let (Some(rows), Some(length)) = (rows, row.c1.filter(|_| row.monitored)) {
            *rows.entry((row.cylinder, (length / CELL).floor() as i32)).or_default() += 1;
        }
    }

    fn gap(&mut self, _: u8) {}
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pieces of one cylinder that was in these cells.
    fn visiting(cells: &[&[i32]]) -> Visiting {
        let rows = |cells: &&[i32]| cells.iter().map(|cell| ((1, *cell), 500)).collect();
        Visiting { begins: vec![0.0; cells.len()], rows: cells.iter().map(rows).collect() }
    }

    #[test]
    fn what_was_seen_once_stays() {
        let visiting = visiting(&[&[4, 5], &[4, 5, 9], &[4, 5], &[5, 6], &[5, 6]]);
        assert_eq!(visiting.keep(&[10; 5], 100), [0, 1, 2, 3, 4]);
        assert_eq!(visiting.keep(&[10; 5], 49), [1, 2, 3, 4]);
        assert_eq!(visiting.keep(&[10; 5], 20), [1, 4]);
        assert_eq!(visiting.keep(&[10; 5], 0), [] as [usize; 0]);
    }
}
