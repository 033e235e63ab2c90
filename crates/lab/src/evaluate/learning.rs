//! What the sequential detectors learn of a grade of transducers, taught as an engineer would:
//! calibrated on one healthy run, with their level from another.

use super::extent::Lessons;
use super::grade::Grade;
use super::machines::ProcessMachine;
use super::stand::{Stand, StandError};
use crate::flaws::listed;
use tertius_config::design::{self, Flaw};
use tertius_config::settings::{Fde, Settings};
use tertius_core::monitor::{Monitor, MonitorDesign};
use tertius_core::observe::commands::LearntCommands;
use tertius_core::sequential::{self, Sequential};
use tertius_dbc::Database;
use tertius_learn::calibrate::watch::{Level, Watch};
use tertius_learn::calibrate::{CalibrationCourse, Recording};
use tertius_learn::survey::{Origin, Survey, Surveyor, Timeline, Window};
use tertius_learn::tune::course::{SIGMA, TuningCourse, Untuned};
use tertius_learn::tune::{Thresholds, Tuning};
use tertius_machine::simulator::{EPOCH, Options};

/// What was learnt.
#[derive(Clone, Debug)]
pub struct Learnt {
    pub grade: Grade,
    /// The monitor with the detectors.
    pub design: MonitorDesign,
    /// Level h, nats.
    pub nats: f64,
    /// What the level was made from; `None` where it is configured.
    pub level: Option<Level>,
    /// Detector design of each cylinder, with a level that nothing reaches.
    pub detectors: Vec<sequential::Design>,
}

/// The same run of a machine in one sea after the other.
#[derive(Clone, Copy)]
struct Run<'a> {
    stand: &'a Stand<'a>,
    grade: Grade,
    /// Whether its transducers fluctuate as in Figure 5-9.
    fluctuates: bool,
    /// Time constant of the spools, s; `None`: the plant's.
    lag: Option<f64>,
    seas: &'a [[f64; 2]],
    settings: &'a Settings,
    seed: u64,
}

impl Recording for Run<'_> {
    type Error = StandError;

    /// Reads the run into `surveyor`; `window` is a part of the time in each sea.
    fn read(&self, window: Window, mut surveyor: impl Surveyor) -> Result<(), StandError> {
        let Self { stand, grade, fluctuates, lag, seas, settings, seed } = *self;
        let design = design::surveying(settings, stand.database).map_err(|flaws| flawed(&flaws))?;
        for sea in seas {
            let options = Options { seed, sea: Some(*sea), ..Options::default() };
            let mut simulator = stand.lagging((grade, fluctuates), lag, None, &options)?;
            let mut monitor = Monitor::new(design.clone());
            let mut survey = Survey::new(EPOCH, window, &mut surveyor);
            for _ in 0..stand.cycles(window.to) {
                simulator.step(&mut |frame| monitor.take(frame, &mut survey));
            }
            (1..=settings.machine.cylinders).for_each(|cylinder| surveyor.gap(cylinder));
        }
        Ok(())
    }
}

impl Run<'_> {
    /// Weights and thresholds by so many `hours` in each sea.
    fn tuning(&self, hours: f64) -> Result<Tuning, StandError> {
        let design =
            design::surveying(self.settings, self.stand.database).map_err(|it| flawed(&it))?;
        let window = Window { from: 0.0, to: 3600.0 * hours };
        let origin = Origin {
            inputs: String::new(),
            timeline: Timeline::default(),
            window,
            remarks: Vec::new(),
        };
        let course = TuningCourse {
            settings: self.settings,
            design: &design,
            origin: &origin,
            without: &[],
            per_year: self.settings.sequential.false_alarms_per_year,
            keep_weights: false,
            sigma: SIGMA,
        };
        course.run(self).map_err(|why| match why {
            Untuned::Recording(error) => error,
            Untuned::TooLittle(why) => StandError::Untaught(why),
        })
    }
}

fn flawed(flaws: &[Flaw]) -> StandError {
    untaught(listed(flaws))
}

fn untaught(error: impl std::fmt::Display) -> StandError {
    StandError::Untaught(error.to_string())
}

/// Hours of a commissioning: 25 minutes, and another recording for the level.
pub(super) const COMMISSIONING: Lessons = Lessons { calibration: 1500.0 / 3600.0, level: 0.5 };

impl Stand<'_> {
    /// Calibrates the detectors to the healthy machine in `seas` and finds their level; detectors
    /// that are configured are taken as they are.
    ///
    /// # Errors
    /// If there is no such machine, or nothing can be learnt from it.
    pub fn learn(
        &self,
        grade: Grade,
        seas: &[[f64; 2]],
        seeds: [u64; 2],
        lessons: Lessons,
    ) -> Result<Learnt, StandError> {
        let ([seed, other], settings) = (seeds, self.settings);
        let run = Run { stand: self, grade, fluctuates: false, lag: None, seas, settings, seed };
        self.calibrated(run, other, lessons)?.conclude(grade, self.database)
    }

    /// As [`Self::learn`], from a machine with spools of the time constant `lag`, s; with them the process detectors, where
    /// the machine sends what they need, and the weights and thresholds of its observers: all that an engineer would have
    /// it learn.
    ///
    /// # Errors
    /// See [`Self::learn`].
    pub fn commission(
        &self,
        machine: ProcessMachine,
        fluctuates: bool,
        seas: &[[f64; 2]],
        seeds: [u64; 2],
        lessons: Lessons,
    ) -> Result<Learnt, StandError> {
        let ([seed, other], settings) = (seeds, self.settings);
        let ProcessMachine { grade, lag } = machine;
        let run = Run { stand: self, grade, fluctuates, lag: Some(lag), seas, settings, seed };
        let mut taught = self.calibrated(run, other, lessons)?;
        let run = Run { seed: other, settings: &taught.settings, ..run };
        let Tuning { search, thresholds, .. } = run.tuning(lessons.level)?;
        let Thresholds { low, high, joint, .. } = thresholds;
        let of = |which: fn(LearntCommands) -> f64| thresholds.commands.map(which);
        let (command, command_change) = (of(|it| it.size), of(|it| it.change));
        taught.settings.fde = Fde { enabled: true, low, high, joint, command, command_change };
        (taught.settings.observer.q, taught.settings.observer.r) =
            (search.weights.q, search.weights.r);
        taught.conclude(grade, self.database)
    }

    /// The calibration by `run`, and the level by the same with the seed `other`.
    fn calibrated(&self, run: Run<'_>, other: u64, lessons: Lessons) -> Result<Taught, StandError> {
        let mut settings = self.settings.clone();
        let time = 3600.0 * lessons.calibration;
        let [fitted, tried] = Window { from: settings.observer.settle, to: time }.split(0.5);
        let per_year = settings.sequential.false_alarms_per_year;
        let sample_time = settings.machine.sample_time;
        let course = CalibrationCourse {
            settings: self.settings,
            timeline: &Timeline::default(),
            fitted,
            tried,
            per_year,
        };
        let calibrated = course.run(&run)?;
        let tables = calibrated.cylinders.into_iter().map(|cylinder| {
            let missing = || format!("cylinder {} has no profile", cylinder.number);
            let table = cylinder.table().filter(|table| table.sequential.is_some());
            table.ok_or_else(|| {
                let refusal = cylinder.result.as_ref().err().map(ToString::to_string);
                StandError::Untaught(refusal.unwrap_or_else(missing))
            })
        });
        settings.cylinder = tables.collect::<Result<_, _>>()?;
        settings.process.supply = calibrated.supply.and_then(Result::ok);
        let design = design::judging(&settings, self.database).map_err(|flaws| flawed(&flaws))?;
        let detectors = detectors(&design)?;
        let level = match settings.sequential.level {
            Some(_) => None,
            None => {
                let mut watch = Watch::new(detectors.iter().map(Some), sample_time);
                let run = Run { seed: other, settings: &settings, ..run };
                run.read(Window { from: 0.0, to: 3600.0 * lessons.level }, &mut watch)?;
                let level = watch.level(per_year);
                Some(level.ok_or_else(|| untaught("too short a run for a level"))?)
            }
        };
        if let Some(level) = &level {
            settings.sequential.level = Some(level.nats);
        }
        Ok(Taught { settings, detectors, level })
    }
}

/// What the runs have taught so far.
struct Taught {
    settings: Settings,
    detectors: Vec<sequential::Design>,
    level: Option<Level>,
}

impl Taught {
    /// The monitor that follows.
    fn conclude(self, grade: Grade, database: &Database) -> Result<Learnt, StandError> {
        let Self { settings, detectors, level } = self;
        let design = design::judging(&settings, database).map_err(|flaws| flawed(&flaws))?;
        Ok(Learnt { grade, design, nats: settings.sequential_level(), level, detectors })
    }
}

/// Detector designs of all cylinders, with a level that nothing reaches.
fn detectors(design: &MonitorDesign) -> Result<Vec<sequential::Design>, StandError> {
    let monitor = Monitor::new(design.clone());
    let unbounded = |detector: &Sequential| sequential::Design {
        level: f64::INFINITY,
        ..detector.design().clone()
    };
    let found: Vec<_> = monitor.sequential().map(|(_, it)| unbounded(it)).collect();
    let all = found.len() == design.cylinders.len();
    if all { Ok(found) } else { Err(untaught("a cylinder has no detector")) }
}
