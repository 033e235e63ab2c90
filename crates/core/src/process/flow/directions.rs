//! The ways in which faults of the hydraulics move a rod.

use super::super::curve::{Curve, PiecePart};
use super::super::parameters::{DIRECTIONS, ProcessParameters};
use super::passage::Passage;

/// Places in the upper half of a symmetric matrix of them.
pub const HALF: usize = DIRECTIONS * (DIRECTIONS + 1) / 2;

/// These places, row by row.
pub fn upper() -> impl Iterator<Item = (usize, usize)> {
    (0..DIRECTIONS).flat_map(|i| (i..DIRECTIONS).map(move |j| (i, j)))
}

/// A way in which the rod and the oil may part. Sizes are speeds in m/s, but for [`Self::Gain`] (a part of the flow)
/// and [`Self::Pressing`] (m/bar).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// Oil passes the piston: the speed that is lost at a load of 24 bar.
    Leakage,
    /// The valve passes oil as if its spool stood further out.
    Null,
    /// The oil's density and the supply make more or less of the flow; no fault.
    Gain,
    /// The ports open later on either side.
    DeadBand,
    /// Worn edges: the speed that the valve loses in its middle at 24 bar.
    ValveLeakage,
    /// Compressibility; no fault.
    Pressing,
}

impl Direction {
    /// Whether oil passes where it should not: there is none of it below zero.
    pub const fn is_leakage(self) -> bool {
        matches!(self, Self::Leakage | Self::ValveLeakage)
    }
}

/// Those that are faults.
pub const FAULTS: [Direction; 4] =
    [Direction::Leakage, Direction::Null, Direction::DeadBand, Direction::ValveLeakage];

/// Those that may explain a residual.
pub const CANDIDATES: [Direction; 5] = [
    Direction::Leakage,
    Direction::Null,
    Direction::Gain,
    Direction::DeadBand,
    Direction::ValveLeakage,
];

/// Load for which the sizes of leakages are given, bar.
pub const LEAKAGE_LOAD: f64 = 24.0;

/// The directions at one passage of oil.
#[derive(Clone, Copy, Debug)]
pub struct Along {
    /// f(x̄) √…, m/s.
    pub speed: f64,
    /// f's slope there beside its mean slope, times √….
    bend: f64,
    /// Whether oil flows out of the valve, and how far its spool is from the middle, as a speed at the mean slope, m/s.
    side: f64,
    opening: f64,
    /// P̄_L beside 24 bar.
    load: f64,
}

impl Along {
    /// By f, its mean slope, and the passage with its place among f's pieces.
    pub fn new(curve: &Curve, slope: f64, passage: &Passage, at: PiecePart) -> Self {
        let (piece, _) = at;
        Self {
            speed: curve.at_place(at) * passage.root,
            bend: curve.slope(piece) / slope * passage.root,
            side: if passage.position < 0.0 { -1.0 } else { 1.0 },
            opening: passage.position * slope,
            load: passage.load / LEAKAGE_LOAD,
        }
    }

    /// Speed of the rod with a fault of size 1, in the order of [`Direction`] without the last one, which is of a whole
    /// block.
    #[inline]
    pub fn speeds(&self) -> [f64; DIRECTIONS - 1] {
        let near = self.opening / ProcessParameters::DEFAULT.edges;
        // About exp(−near²), which takes longer.
        let left = (1.0 - 0.25 * near * near).max(0.0);
        let edges = (left * left) * (left * left);
        [-self.load, self.bend, self.speed, -self.side * self.bend, -self.load * edges]
    }
}
