//! What the pressures of both chambers add up to.
//!
//! P_bot + P_rod = c₀ + c₁ P_S + c₂ (P_bot − P_rod) + c₃ x. With ideal chambers it is P_S; leakage of the valve's edges,
//! ports that do not match the areas, and the lag of the supply's signal are what the coefficients are for. Of a sum
//! that is off, which of both sensors is wrong does not follow.

use crate::sequential::windows::WIDTHS;

/// Number of coefficients.
pub const TERMS: usize = 4;

/// What is known of the chambers.
#[derive(Clone, Debug, PartialEq)]
pub struct ChambersDesign {
    /// c₀, bar, c₁, c₂, and c₃, bar per unit of the spool's position (0 without one).
    pub coefficients: [f64; TERMS],
    /// Standard deviation of the sum beside it, bar.
    pub deviation: f64,
    /// Numbers of dependent samples of mean and spread, see [`super::Weighing`].
    pub dependence: [[f64; WIDTHS.len()]; 2],
}

/// What the sum is compared with: 1, P_S, P_bot − P_rod and x.
pub fn terms([bottom, rod]: [f64; 2], supply: f64, spool: f64) -> [f64; TERMS] {
    [1.0, supply, bottom - rod, spool]
}

impl ChambersDesign {
    /// The sum less what it should be, bar.
    pub fn residual(&self, chambers: [f64; 2], supply: f64, spool: f64) -> f64 {
        let terms = terms(chambers, supply, spool);
        let expected: f64 = terms.iter().zip(self.coefficients).map(|(term, of)| term * of).sum();
        chambers[0] + chambers[1] - expected
    }
}
