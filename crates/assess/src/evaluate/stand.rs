//! The test stand: the simulated machine and the monitor that watches it.

use super::grade::Grade;
use super::hexapod::DeckWitness;
use super::learning::Learnt;
use super::plan::Cell;
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
}

/// A test stand, on which many trials can run at once.
#[derive(Clone, Debug)]
pub struct Stand<'a> {
    pub settings: &'a Settings,
    pub database: &'a Database,
    pub design: &'a MonitorDesign,
    /// Monitors with sequential detectors, for the grades that were learnt.
    pub monitors: Vec<Learnt>,
    /// Monitors with the sets of weights that are compared.
    pub weighed: Vec<MonitorDesign>,
    /// Monitors with the process detectors that were taught.
    pub taught: Vec<MonitorDesign>,
    /// Monitors whose frames a controller hears, for the grades that were learnt.
    pub handing: Vec<(Grade, MonitorDesign)>,
    /// Monitors with the sequential detectors and those of the process, for the drifts in the loop.
    pub sided: Vec<MonitorDesign>,
    /// The configuration without C2, and its monitor.
    pub single: Option<(Settings, MonitorDesign)>,
    /// Monitors of machines with a sensor on their deck, in the order of the study's grades.
    pub decked: Vec<MonitorDesign>,
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
        Self {
            settings,
            database,
            design,
            monitors: Vec::new(),
            weighed: Vec::new(),
            taught: Vec::new(),
            handing: Vec::new(),
            sided: Vec::new(),
            single: None,
            decked: Vec::new(),
            tables,
            steady,
        }
    }

    /// The monitor that has learnt `grade`.
    ///
    /// # Errors
    /// Nothing was learnt of it.
    pub fn learnt(&self, grade: Grade) -> Result<&Learnt, StandError> {
        let learnt = self.monitors.iter().find(|learnt| learnt.grade == grade);
        learnt.ok_or_else(|| StandError::Untaught(format!("{} was not learnt", grade.name())))
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

    /// The machine with transducers of `grade` that do not fluctuate, and with a sensor on its deck of this `witness`.
    pub(super) fn decked(
        &self,
        grade: Grade,
        witness: DeckWitness,
        changed: Option<(Change, f64)>,
        options: &Options,
    ) -> Result<Simulator, StandError> {
        let mut tables = self.of_grade(&self.steady, grade).clone();
        if let DeckWitness::Sensor(accuracy) = witness {
            let top = &mut tables.sensors.top;
            (top.noise, top.wander) = (accuracy, accuracy);
            top.wander_time = if top.wander_time > 0.0 { top.wander_time } else { 60.0 };
        }
        self.simulate_changed(tables, None, changed, options)
    }

    fn simulate_changed(
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
