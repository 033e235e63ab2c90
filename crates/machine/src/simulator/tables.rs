//! The tables that describe a simulated machine: `config/e-type-plant.toml`.

use super::beside::SignalTable;
use super::disturbance::Disturbance;
use super::top::TopTable;
use crate::controller::ControllerTable;
use crate::hexapod::Geometry;
use crate::plant::{
    CYLINDERS, Chambers, CylinderTable, Friction, Identified, Parameters, Spread, SupplyTable,
    ValveTable,
};
use crate::sea::Vessel;
use crate::transducer::{Common, Errors};
use serde::Deserialize;

/// The longest text of tables, bytes.
pub const MAX_TEXT: usize = 1 << 20;

/// All tables of a simulated machine.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tables {
    #[serde(with = "GeometryTable")]
    pub hexapod: Geometry,
    pub sea: SeaTable,
    pub vessel: Vessel,
    pub cylinder: CylinderTable,
    pub friction: Friction,
    pub valve: ValveTable,
    pub supply: SupplyTable,
    pub spread: Spread,
    #[serde(default)]
    pub chambers: Option<Chambers>,
    #[serde(default)]
    pub thermal: Option<Thermal>,
    pub gangway: Gangway,
    pub controller: ControllerTable,
    pub transducer: Common,
    pub c1: Errors,
    pub c2: Errors,
    pub sensors: SensorTable,
    /// Signals beside those that a configuration names.
    #[serde(default = "SignalTable::of_the_e_type")]
    pub signals: SignalTable,
    #[serde(default)]
    pub disturbance: Disturbance,
    /// Cylinders that were identified, see [`Tables::identified_by`].
    #[serde(skip)]
    pub identified: Vec<Identified>,
}

/// [`Geometry`] as a table.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, remote = "Geometry")]
struct GeometryTable {
    base_radius: f64,
    base_half_angle: f64,
    top_radius: f64,
    top_half_angle: f64,
    neutral_height: f64,
    reach: [f64; 2],
}

/// The default sea.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SeaTable {
    /// Significant wave height, m.
    pub height: f64,
    /// Peak period, s.
    pub period: f64,
    /// Peakedness γ of JONSWAP.
    pub peakedness: f64,
}

/// Slewing of the gangway, which moves its weight from cylinder to cylinder.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Gangway {
    /// Largest addition to a cylinder's load, as a part of the load.
    pub load: f64,
    /// Period of one turn, s.
    pub period: f64,
    /// From the middle of the deck to the gangway's tip, m.
    #[serde(default = "gangway_length")]
    pub length: f64,
}

/// Length of a gangway whose table does not say, m: the E-type's, assumed.
const fn gangway_length() -> f64 {
    20.0
}

/// What the spool's signal is when the valve is fully open, where the table does not say: it is in %.
const fn spool_full() -> f64 {
    100.0
}

/// Standard deviations of the sensors other than the position transducers.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SensorTable {
    /// Standard deviation of a chamber's pressure, bar.
    pub pressure: f64,
    /// Standard deviation of the supply pressure, bar.
    pub supply: f64,
    /// Standard deviation of a spool's position, part of its stroke.
    #[serde(default)]
    pub spool: f64,
    /// A spool's signal at full stroke, in the signal's own unit.
    #[serde(default = "spool_full")]
    pub spool_full: f64,
    /// How long before the Sync each valve samples its spool and pressures, s; by default at the Sync.
    #[serde(default)]
    pub valve_age: [f64; CYLINDERS],
    /// The attitude sensor on the deck, which is there where the configuration names its signals.
    #[serde(default)]
    pub top: TopTable,
}

/// Oil that warms up and cools down again: each value is the largest change, as a part of the usual.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Thermal {
    /// Viscous friction.
    pub viscosity: f64,
    /// β of (3-8).
    pub leakage: f64,
    /// Flow of the valves.
    pub flow: f64,
    /// Overlap of the valves' spools, their dead band; default none.
    #[serde(default)]
    pub overlap: f64,
    /// Time from warm to warm, s.
    pub period: f64,
}

impl Thermal {
    /// The present part, −1 to 1, of each change at `time`, s: 0 at first, when tables are learnt.
    pub fn part(&self, time: f64) -> f64 {
        (time * std::f64::consts::TAU / self.period).sin()
    }
}

/// Why tables are refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TableError {
    /// The text is not TOML, or has an unknown or missing key or a value of the wrong type; with
    /// its line.
    #[error("{0}")]
    Form(String),
    #[error("{key} is {value}, expected {low} to {high}")]
    Range { key: String, value: f64, low: f64, high: f64 },
    #[error("{key} is [{}, {}], expected the lower one first", .value[0], .value[1])]
    Order { key: &'static str, value: [f64; 2] },
    #[error("{0}")]
    Identified(String),
    #[error("longer than {MAX_TEXT} bytes; tables are a page of text")]
    TooLong,
}

impl Tables {
    /// Multiplies all friction by `factor`.
    pub fn rub(&mut self, factor: f64) {
        let of_table = &mut self.friction;
        for force in [&mut of_table.coulomb, &mut of_table.stiction, &mut of_table.viscous] {
            *force *= factor;
        }
        for friction in self.identified.iter_mut().filter_map(|it| it.friction.as_mut()) {
            for force in [&mut friction.coulomb, &mut friction.stiction, &mut friction.viscous] {
                *force *= factor;
            }
        }
    }

    /// The tables of the plant that the controller was designed for.
    pub fn plant(&self) -> Parameters {
        Parameters {
            cylinder: self.cylinder,
            friction: self.friction,
            valve: self.valve,
            supply: self.supply,
            spread: self.spread,
            chambers: self.chambers,
            identified: self.identified.clone(),
        }
    }
}
