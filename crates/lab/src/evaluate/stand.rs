//! The test stand: the simulated machine and the monitor that watches it.

use super::grade::{Cell, Grade};
use tertius_config::settings::Settings;
use tertius_core::monitor::MonitorDesign;
use tertius_dbc::Database;
use tertius_machine::inject::PlaceError;
use tertius_machine::simulator::{Change, Options, Simulator, SimulatorError, Tables};

/// Why a trial could not be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum StandError {
    #[error(transparent)]
    Simulator(#[from] SimulatorError),
    #[error(transparent)]
    Place(#[from] PlaceError),
    #[error("the gateway's frames cannot be read: {0}")]
    Unread(String),
    #[error("the simulated machine does not teach all that is tried: {0}")]
    Untaught(String),
    #[error("{0}")]
    Refused(String),
    #[error("{done} of {of} trials have been done")]
    Unfinished { done: usize, of: usize },
}

/// A test stand, on which many trials can run at once.
#[derive(Clone, Debug)]
pub struct Stand<'a> {
    pub settings: &'a Settings,
    pub database: &'a Database,
    pub design: &'a MonitorDesign,
    tables: [(Grade, Tables); Grade::ALL.len()],
    /// Tables of each grade without the fluctuations of Figure 5-9.
    steady: [(Grade, Tables); Grade::ALL.len()],
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
        let graded = |tables: &Tables| Grade::ALL.map(|grade| (grade, grade.apply(tables)));
        let mut still = tables.clone();
        still.transducer.fluctuation_probability = 0.0;
        let (tables, steady) = (graded(tables), graded(&still));
        Self { settings, database, design, tables, steady }
    }

    /// The machine of `cell`.
    ///
    /// # Errors
    /// If the configuration's machine cannot be simulated, or not in that sea.
    pub fn simulator(&self, cell: Cell, options: &Options) -> Result<Simulator, StandError> {
        self.graded(cell.grade, options)
    }

    /// The machine with transducers of `grade`, in the sea of `options`.
    ///
    /// # Errors
    /// See [`Self::simulator`].
    pub fn graded(&self, grade: Grade, options: &Options) -> Result<Simulator, StandError> {
        self.simulate(&self.tables, grade, options)
    }

    /// The machine with transducers of `grade` that do not fluctuate.
    ///
    /// # Errors
    /// See [`Self::simulator`].
    pub fn steady(&self, grade: Grade, options: &Options) -> Result<Simulator, StandError> {
        self.simulate(&self.steady, grade, options)
    }

    /// The machine with transducers of `grade`, which fluctuate or do not, and spools with the time constant `lag`, s,
    /// or the plant's; with another load and friction if they are `changed`.
    ///
    /// # Errors
    /// See [`Self::simulator`].
    pub(super) fn lagging(
        &self,
        (grade, fluctuates): (Grade, bool),
        lag: Option<f64>,
        changed: Option<(Change, f64)>,
        options: &Options,
    ) -> Result<Simulator, StandError> {
        let tables = if fluctuates { &self.tables } else { &self.steady };
        self.simulate_changed(self.of_grade(tables, grade).clone(), lag, changed, options)
    }

    /// The machine of `tables`, with spools of another time constant, or another load and friction.
    ///
    /// # Errors
    /// See [`Self::simulator`].
    pub(super) fn simulate_changed(
        &self,
        mut tables: Tables,
        lag: Option<f64>,
        changed: Option<(Change, f64)>,
        options: &Options,
    ) -> Result<Simulator, StandError> {
        tables.valve.lag = lag.unwrap_or(tables.valve.lag);
        if let Some((load, friction)) = changed {
            tables.disturbance.load = Some(load);
            tables.rub(friction);
        }
        Ok(Simulator::new(&tables, self.settings, self.database, options)?)
    }

    /// The tables of the machine with transducers of `grade`.
    pub(super) fn tables_of(&self, grade: Grade) -> &Tables {
        self.of_grade(&self.tables, grade)
    }

    /// The same with transducers that do not fluctuate.
    pub(super) fn steady_tables_of(&self, grade: Grade) -> &Tables {
        self.of_grade(&self.steady, grade)
    }

    /// Judged time of which only the largest value counts, s, so that a longer excursion is one warning.
    pub(super) fn block(&self) -> f64 {
        f64::from(self.settings.warning_cycles()) * self.settings.machine.sample_time
    }

    fn of_grade<'b>(&self, tables: &'b [(Grade, Tables)], grade: Grade) -> &'b Tables {
        let of_grade = tables.iter().find(|(known, _)| *known == grade);
        let (_, tables) = of_grade.expect("there are tables for every grade");
        tables
    }

    fn simulate(
        &self,
        tables: &[(Grade, Tables)],
        grade: Grade,
        options: &Options,
    ) -> Result<Simulator, StandError> {
        let tables = self.of_grade(tables, grade);
        Ok(Simulator::new(tables, self.settings, self.database, options)?)
    }

    /// The number of cycles in `seconds`.
    pub fn cycles(&self, seconds: f64) -> u64 {
        (seconds / self.settings.machine.sample_time).ceil() as u64
    }
}
