//! Reads the tables of a simulated machine.

use super::check;
use super::tables::{MAX_TEXT, TableError, Tables};
use crate::plant::{self, CYLINDERS, Identified};

/// Text of the default tables, `config/e-type-plant.toml`.
const DEFAULT: &str = include_str!("../../../../config/e-type-plant.toml");

impl Tables {
    /// Reads tables from TOML; every key is required except `[chambers]`, `[thermal]`, `[signals]`, `[disturbance]`,
    /// ripple, warming, speed_lag, the gangway's length, and of the sensors spool, spool_full, valve_age and top.
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

    /// These tables with the valves and the friction in `text`, which `identify --nonlinear` wrote, in the place of their
    /// own.
    ///
    /// # Errors
    /// What is wrong with the text, or a cylinder that is not there.
    pub fn identified_by(self, text: &str) -> Result<Self, TableError> {
        if text.len() > MAX_TEXT {
            return Err(TableError::TooLong);
        }
        let identified =
            plant::identified(text, self.sensors.spool_full).map_err(TableError::Identified)?;
        let strange = identified.iter().find(|it| !(1..=CYLINDERS).contains(&it.number.into()));
        if let Some(Identified { number, .. }) = strange {
            let what =
                format!("has a cylinder {number}, and the simulated machine has {CYLINDERS}");
            return Err(TableError::Identified(what));
        }
        Ok(Self { identified, ..self })
    }
}

impl Default for Tables {
    /// The tables of `config/e-type-plant.toml`.
    fn default() -> Self {
        Self::parse(DEFAULT).expect("a test reads the tables that are built in")
    }
}
