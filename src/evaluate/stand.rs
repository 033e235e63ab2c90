//! Where trials are made: the simulated machine and the monitor that watches it.

use super::grade::Grade;
use super::plan::Cell;
use crate::config::settings::Settings;
use crate::decode::Database;
use crate::inject::PlaceError;
use crate::monitor::MonitorDesign;
use crate::simulator::{Options, Simulator, SimulatorError, Tables};

/// Why a trial could not be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum StandError {
    #[error(transparent)]
    Simulator(#[from] SimulatorError),
    #[error(transparent)]
    Place(#[from] PlaceError),
}

/// A test stand; many trials can be made on it at once.
#[derive(Clone, Debug)]
pub struct Stand<'a> {
    pub settings: &'a Settings,
    pub database: &'a Database,
    pub design: &'a MonitorDesign,
    tables: [(Grade, Tables); Grade::ALL.len()],
}

impl<'a> Stand<'a> {
    /// A stand for the machine of `tables`, which sends what `settings` and `database` describe and
    /// is watched by a monitor of `design`.
    pub fn new(
        tables: &Tables,
        settings: &'a Settings,
        database: &'a Database,
        design: &'a MonitorDesign,
    ) -> Self {
        let tables = Grade::ALL.map(|grade| (grade, grade.apply(tables)));
        Self { settings, database, design, tables }
    }

    /// The machine of `cell`.
    ///
    /// # Errors
    /// If the configuration's machine cannot be simulated, or not in that sea.
    pub fn simulator(&self, cell: Cell, options: &Options) -> Result<Simulator, StandError> {
        let of_grade = self.tables.iter().find(|(grade, _)| *grade == cell.grade);
        let (_, tables) = of_grade.expect("there are tables for every grade");
        Ok(Simulator::new(tables, self.settings, self.database, options)?)
    }

    /// The cycles that so many seconds have.
    pub fn cycles(&self, seconds: f64) -> u64 {
        (seconds / self.settings.machine.sample_time).ceil() as u64
    }
}
