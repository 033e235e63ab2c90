//! What is known of the forces on a rod, and what a block leaves beside it.

use super::forces::{FORCE_TERMS, ForceBlock};

/// Places in the upper half of Ω.
pub const SCATTERS: usize = 3;

/// What is known of the forces on a rod.
#[derive(Clone, Debug, PartialEq)]
pub struct FrictionDesign {
    /// c₁ to c₄: bar/m, bar s²/m, bar s/m and bar.
    pub coefficients: [f64; FORCE_TERMS],
    /// Ω: the long-run covariance of what a block leaves, bar, times each of [`FrictionBlock::directions`]: the upper
    /// half, row by row.
    pub scatter: [f64; SCATTERS],
    /// α of (3-5).
    pub area_ratio: f64,
}

/// What is left of the load pressure over a block of cycles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrictionBlock {
    /// Pressure beyond that expected, bar.
    pub left: f64,
    /// The pressure that 1 bar of Coulomb's friction adds, bar, and that of as much viscous friction as was learnt.
    pub directions: [f64; 2],
}

impl FrictionDesign {
    /// What a block leaves.
    pub fn block(&self, block: &ForceBlock) -> FrictionBlock {
        let [.., viscous, _] = self.coefficients;
        let terms = block.terms.iter().zip(self.coefficients);
        let expected: f64 = terms.map(|(term, of)| term * of).sum();
        let [.., speed, direction] = block.terms;
        FrictionBlock {
            left: block.load - expected,
            directions: [direction, viscous.max(0.0) * speed],
        }
    }
}
