//! The observers that weights give.

use tertius_core::observe::model::Model;
use tertius_core::observe::observer::ObserverDesign;
use tertius_core::observe::riccati::RiccatiError;

/// What is known of one cylinder.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CylinderModel {
    /// Cylinder number, counted from 1.
    pub number: u8,
    pub model: Model,
    /// Command at which the cylinder rests, m/s.
    pub command_offset: f64,
    /// Whether C1 and C2 are configured.
    pub transducers: [bool; 2],
    /// Whether the velocities of C1 and C2 are configured.
    pub velocities: [bool; 2],
    /// Most missing cycles over which the observers predict; after more they restart.
    pub max_gap: u32,
}

/// Diagonals of Q and R.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weights {
    pub q: [f64; 3],
    pub r: [f64; 2],
}

/// The observers of C1 and C2 of each of `cylinders`; `settle` is the number of cycles before they
/// judge.
///
/// # Errors
/// A model and weights without a gain, with the cylinder's number.
pub fn designs(
    cylinders: &[CylinderModel],
    weights: Weights,
    settle: u32,
) -> Result<Vec<[ObserverDesign; 2]>, (u8, RiccatiError)> {
    let one = |cylinder: &CylinderModel| {
        let of = |velocity| {
            let Weights { q, r } = weights;
            ObserverDesign::new(&cylinder.model, q, r, velocity, settle, cylinder.max_gap)
                .map_err(|error| (cylinder.number, error))
        };
        let [first, second] = cylinder.velocities;
        Ok([of(first)?, of(second)?])
    };
    cylinders.iter().map(one).collect()
}
