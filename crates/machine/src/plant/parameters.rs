//! Parameters of the plant, as in its table.

use super::CYLINDERS;
use super::friction::Friction;
use super::identified::Identified;
use serde::Deserialize;

/// Six cylinders on one supply, alike but for their [`Spread`].
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Parameters {
    pub cylinder: CylinderTable,
    pub friction: Friction,
    pub valve: ValveTable,
    pub supply: SupplyTable,
    pub spread: Spread,
    /// `None`: P_bot + P_rod = P_S.
    #[serde(default)]
    pub chambers: Option<Chambers>,
    /// Cylinders that were identified, in the place of their tables.
    #[serde(skip)]
    pub identified: Vec<Identified>,
}

impl Parameters {
    /// The same with other valves built in, none of which was identified.
    #[must_use]
    pub fn with_valve(&self, valve: ValveTable) -> Self {
        let identified = self.identified.iter().cloned();
        let identified = identified.map(|it| Identified { flow: None, ..it }).collect();
        Self { valve, identified, ..self.clone() }
    }
}

/// Chambers whose pressures do not add up to P_S: P_bot + P_rod − P_S follows P_L and the speed with a lag.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Chambers {
    /// By unequal leakage of the valve's edges, bar per bar of P_L.
    pub leakage: f64,
    /// By ports that do not match the areas, bar per m/s.
    pub mismatch: f64,
    /// Time constant by which the oil is compressed, s.
    pub time: f64,
}

/// Piston and load.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CylinderTable {
    /// Piston area A_p, m².
    pub piston_area: f64,
    /// α of (3-5): the rod side's area over the piston's.
    pub area_ratio: f64,
    /// Stiffness k of (3-9), N/m.
    pub stiffness: f64,
    /// Mass m of (3-9), kg.
    pub load_mass: f64,
    /// α of (3-8), bar/m: the pressure lost per metre that the piston moves while no oil follows.
    pub pressure_rise: f64,
    /// β of (3-8), 1/s.
    pub leakage: f64,
    /// Positions at which the piston meets the cylinder's ends, m.
    pub ends: [f64; 2],
}

/// The servo-valve.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ValveTable {
    /// Time constant from the command to the main spool, s.
    pub lag: f64,
    /// Spool position at which the ports begin to open, part of the full stroke.
    pub overlap: f64,
    /// Part of the flow beyond the overlap that grows with the square of the opening.
    pub progression: f64,
    /// Flow at the edge of the overlap, part of the full flow.
    pub leakage: f64,
    /// Speed outwards of the piston with the valve fully open and no load, m/s.
    pub extend_speed: f64,
    /// Speed inwards of the piston with the valve fully open and no load, m/s.
    pub retract_speed: f64,
}

/// Pump and accumulator.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SupplyTable {
    /// Set point of the supply pressure, bar.
    pub pressure: f64,
    /// Pump flow for each bar below the set point, m³/s.
    pub pump_gain: f64,
    /// Greatest flow of the pump, m³/s.
    pub pump_flow: f64,
    /// Volume of the accumulator's gas at the set point, m³.
    pub gas_volume: f64,
    /// n: the gas keeps P Vⁿ, 1 where it keeps its temperature.
    #[serde(default = "one")]
    pub exponent: f64,
    /// Time constant of the pump's flow, s; 0: it follows at once.
    #[serde(default)]
    pub pump_lag: f64,
}

const fn one() -> f64 {
    1.0
}

/// Differences between the cylinders, each value a part of the common one.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Spread {
    /// Flow outwards and inwards (Figure 3-8).
    pub extend: [f64; CYLINDERS],
    pub retract: [f64; CYLINDERS],
    /// Load: deck and gangway do not weigh on all alike (Figure 4-4).
    pub load: [f64; CYLINDERS],
}
