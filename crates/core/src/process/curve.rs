//! A function of the command, or of the spool's position, by linear pieces, which are short where valves are least
//! linear: near rest.

use alloc::vec::Vec;

/// A piece of a [`Curve`], and the part of it that lies before a command, 0 to 1.
pub type PiecePart = (usize, f64);

/// Values at knots, linear between them. Knot i of n + 1 stands at ± w² times the limit, with w = 2 i/n − 1.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// Place of the last knot, m/s or a unit of the spool; that of the first one is its negative.
    limit: f64,
    values: Vec<f64>,
    /// What every cycle asks of each piece.
    pieces: Vec<Piece>,
    /// Half their number.
    half: f64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Piece {
    ends: [f64; 2],
    /// Values at both.
    values: [f64; 2],
    slope: f64,
}

impl Curve {
    /// The curve with these `values` at its knots, at least two, and the last knot at `limit`.
    pub fn new(limit: f64, values: Vec<f64>) -> Self {
        debug_assert!(values.len() > 1 && limit > 0.0);
        let count = values.len() - 1;
        let piece = |index: usize| {
            let [from, to] = [index, index + 1].map(|index| knot(limit, count, index));
            let [low, high] = [values[index], values[index + 1]];
            let slope = (high - low) / (to - from);
            Piece { ends: ends(limit, count, index), values: [low, high], slope }
        };
        let half = 0.5 * count as f64;
        Self { limit, pieces: (0..count).map(piece).collect(), half, values }
    }

    /// Place of the last knot; that of the first one is its negative.
    pub const fn limit(&self) -> f64 {
        self.limit
    }

    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// The value at `command`; beyond the outermost knots theirs.
    pub fn at(&self, command: f64) -> f64 {
        self.at_place(self.place(command))
    }

    /// Where `command` lies among the pieces.
    #[inline]
    pub fn place(&self, command: f64) -> PiecePart {
        let command = within(command, self.limit);
        let piece = piece_of(self.limit, self.half, command).min(self.pieces.len() - 1);
        (piece, part_of(self.pieces[piece].ends, command))
    }

    /// The value at a place among its own pieces.
    #[inline]
    pub fn at_place(&self, (piece, part): PiecePart) -> f64 {
        let [low, high] = self.pieces[piece].values;
        low + part * (high - low)
    }

    /// The slope of a piece.
    #[inline]
    pub fn slope(&self, piece: usize) -> f64 {
        self.pieces[piece].slope
    }
}

/// Where `command` lies among `pieces` whose outermost knots stand at ± `limit`.
pub fn place(limit: f64, pieces: usize, command: f64) -> PiecePart {
    let command = within(command, limit);
    let piece = piece_of(limit, 0.5 * pieces as f64, command).min(pieces - 1);
    (piece, part_of(ends(limit, pieces, piece), command))
}

/// The nearest to `command` within the limits; what is no number stays so.
#[inline]
fn within(command: f64, limit: f64) -> f64 {
    let below = if command > limit { limit } else { command };
    if below < -limit { -limit } else { below }
}

/// The piece in which a `command` within the limits lies, of twice `half`; at the upper limit one more than the last.
#[inline]
fn piece_of(limit: f64, half: f64, command: f64) -> usize {
    let warped = libm::sqrt(command.abs() / limit).copysign(command);
    // To 32 bits is two instructions, to 64 twelve.
    ((warped + 1.0) * half) as u32 as usize
}

/// The part of a piece with these ends that lies before a command.
#[inline]
fn part_of([low, high]: [f64; 2], command: f64) -> f64 {
    ((command - low) / (high - low)).clamp(0.0, 1.0)
}

/// Where a piece begins and ends.
fn ends(limit: f64, pieces: usize, piece: usize) -> [f64; 2] {
    let count = pieces as f64;
    let low = 2.0 * piece as f64 / count - 1.0;
    [low, low + 2.0 / count].map(|warped| limit * warped * warped.abs())
}

/// Where the knot of `index` among `pieces` stands.
pub fn knot(limit: f64, pieces: usize, index: usize) -> f64 {
    let warped = 2.0 * index as f64 / pieces as f64 - 1.0;
    limit * warped * warped.abs()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_a_line_and_its_pieces_are_short_near_rest() {
        let values = (0..=8).map(|index| 3.0 * knot(0.8, 8, index) + 1.0).collect();
        let curve = Curve::new(0.8, values);
        for command in [-0.8, -0.3, -1e-3, 0.0, 0.01, 0.2, 0.79] {
            assert!((curve.at(command) - 3.0 * command - 1.0).abs() < 1e-12, "{command}");
        }
        assert_eq!([curve.at(-5.0), curve.at(2.0)], [curve.at(-0.8), curve.at(0.8)]);
        let shortest = (1..9).map(|index| knot(0.8, 8, index) - knot(0.8, 8, index - 1));
        assert_eq!(shortest.fold(f64::INFINITY, f64::min), knot(0.8, 8, 5) - knot(0.8, 8, 4));
        assert_eq!([place(0.8, 8, f64::NAN).0, curve.place(f64::NAN).0], [0; 2]);
        for command in [-5.0, -0.8, -0.6, -0.1, -0.0, 1e-9, 0.3, 0.7, 0.8, 2.0] {
            assert_eq!(curve.place(command), place(0.8, 8, command));
        }
    }
}
