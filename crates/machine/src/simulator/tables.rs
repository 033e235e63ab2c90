//! The tables that describe a simulated machine: `config/e-type-plant.toml`.

use super::check;
use super::disturbance::Disturbance;
use crate::controller::ControllerTable;
use crate::hexapod::Geometry;
use crate::plant::{CylinderTable, Friction, Parameters, Spread, SupplyTable, ValveTable};
use crate::sea::Vessel;
use crate::transducer::{Common, Errors};
use serde::Deserialize;

/// The longest text of tables, bytes.
pub const MAX_TEXT: usize = 1 << 20;

/// Text of the default tables, `config/e-type-plant.toml`.
const DEFAULT: &str = include_str!("../../../../config/e-type-plant.toml");

/// All tables of a simulated machine.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tables {
    pub hexapod: Geometry,
    pub sea: SeaTable,
    pub vessel: Vessel,
    pub cylinder: CylinderTable,
    pub friction: Friction,
    pub valve: ValveTable,
    pub supply: SupplyTable,
    pub spread: Spread,
    pub gangway: Gangway,
    pub controller: ControllerTable,
    pub transducer: Common,
    pub c1: Errors,
    pub c2: Errors,
    pub sensors: SensorTable,
    #[serde(default)]
    pub disturbance: Disturbance,
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
}

/// Standard deviations of the sensors other than the position transducers.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SensorTable {
    /// Standard deviation of a chamber's pressure, bar.
    pub pressure: f64,
    /// Standard deviation of the supply pressure, bar.
    pub supply: f64,
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
    #[error("longer than {MAX_TEXT} bytes; tables are a page of text")]
    TooLong,
}

impl Tables {
    /// Reads tables from TOML; every key is required except `[disturbance]`, ripple, warming and
    /// speed_lag.
    ///
    /// # Errors
    /// The first thing wrong with them.
    pub fn parse(text: &str) -> Result<Self, TableError> {
        if text.len() > MAX_TEXT {
            return Err(TableError::TooLong);
        }
        let tables: Self =
            toml::from_str(text).map_err(|error| TableError::Form(error.to_string()))?;
        check::ranges(&tables)?;
        Ok(tables)
    }

    /// The tables of the plant that the controller was designed for.
    pub fn plant(&self) -> Parameters {
        Parameters {
            cylinder: self.cylinder,
            friction: self.friction,
            valve: self.valve,
            supply: self.supply,
            spread: self.spread,
        }
    }
}

impl Default for Tables {
    /// The tables of `config/e-type-plant.toml`.
    fn default() -> Self {
        Self::parse(DEFAULT).expect("a test reads the tables that are built in")
    }
}
