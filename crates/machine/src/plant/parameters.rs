//! What the plant is made of, as it stands in a table.

use super::CYLINDERS;
use super::friction::Friction;
use serde::Deserialize;

/// Six cylinders on one supply, alike but for their [`Spread`].
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Parameters {
    pub cylinder: CylinderTable,
    pub friction: Friction,
    pub valve: ValveTable,
    pub supply: SupplyTable,
    pub spread: Spread,
}

/// Piston and load.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CylinderTable {
    /// A_p, m².
    pub piston_area: f64,
    /// α of (3-5): the rod side's area over the piston's.
    pub area_ratio: f64,
    /// k of (3-9), N/m.
    pub stiffness: f64,
    /// m of (3-9), kg.
    pub load_mass: f64,
    /// α of (3-8), bar/m: what the pressure loses where the piston moves and no oil follows.
    pub pressure_rise: f64,
    /// β of (3-8), 1/s.
    pub leakage: f64,
    /// Where the piston meets the cylinder's ends, m.
    pub ends: [f64; 2],
}

/// The servo-valve.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ValveTable {
    /// From command to main spool, s.
    pub lag: f64,
    /// Spool position at which the ports begin to open, part of the full stroke.
    pub overlap: f64,
    /// Of the flow beyond the overlap, the part that grows with the square of the opening.
    pub progression: f64,
    /// Flow at the edge of the overlap, part of the full flow.
    pub leakage: f64,
    /// The piston's speed with the valve fully open and no load, m/s.
    pub extend_speed: f64,
    pub retract_speed: f64,
}

/// Pump and accumulator.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SupplyTable {
    /// Set point, bar.
    pub pressure: f64,
    /// m³/s for each bar below the set point.
    pub pump_gain: f64,
    /// The most that the pump gives, m³/s.
    pub pump_flow: f64,
    /// Of the accumulator's gas at the set point, m³.
    pub gas_volume: f64,
}

/// What the cylinders have of their own, each a part of the common value.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Spread {
    /// Flow outwards and inwards (Figure 3-8).
    pub extend: [f64; CYLINDERS],
    pub retract: [f64; CYLINDERS],
    /// Load: deck and gangway do not weigh on all alike (Figure 4-4).
    pub load: [f64; CYLINDERS],
}
