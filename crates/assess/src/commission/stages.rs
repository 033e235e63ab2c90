//! The three stages that learn, each with the tables of the one before.

use super::Task;
use super::holding::{Blocks, Without};
use super::off::{LeftOut, Threshold};
use std::fmt;
use tertius_config::design::{self, Flaw};
use tertius_config::settings::Settings;
use tertius_config::{self as config, MachineNames, edit};
use tertius_core::monitor::MonitorDesign;
use tertius_learn::calibrate;
use tertius_learn::calibrate::{Calibration, Cuts};
use tertius_learn::identify;
use tertius_learn::identify::Outcome;
use tertius_learn::identify::course::Options;
use tertius_learn::survey::{Frames, Recording, Rows};
use tertius_learn::tables;
use tertius_learn::tune;
use tertius_learn::tune::Tuning;
use tertius_learn::tune::course::{SIGMA, Untuned};

/// One of the three stages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    Identify,
    Calibrate,
    Tune,
}

impl fmt::Display for Stage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Identify => "identify",
            Self::Calibrate => "calibrate",
            Self::Tune => "tune",
        })
    }
}

/// A cylinder from which nothing is learnt.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refused {
    /// Cylinder number, counted from 1.
    pub cylinder: u8,
    pub by: Stage,
    pub why: String,
}

/// Result of the stages.
#[derive(Clone, Debug, Default)]
pub struct Taught {
    pub machine: String,
    /// How its cylinders are called.
    pub names: MachineNames,
    /// Text of the configuration with all tables up to the stage that failed.
    pub text: String,
    pub identification: Option<Outcome>,
    pub calibration: Option<Calibration>,
    pub tuning: Option<Tuning>,
    pub refused: Vec<Refused>,
    pub left_out: Vec<LeftOut>,
    /// Why the model says nothing of this machine, so that no observer can judge by it.
    pub does_not_follow: Option<String>,
    /// The stage that failed, and why; later stages were not tried.
    pub failed: Option<(Stage, String)>,
}

impl Taught {
    /// Whether every stage succeeded.
    pub const fn is_whole(&self) -> bool {
        self.failed.is_none() && self.tuning.is_some()
    }

    /// Times that the calibration left out because no healthy cylinder reads so.
    pub fn cuts(&self) -> Cuts {
        self.calibration.as_ref().map(Calibration::cuts).unwrap_or_default()
    }

    /// The cylinders that were refused, in order, each once.
    pub fn refused_cylinders(&self) -> Vec<u8> {
        let mut cylinders: Vec<u8> = self.refused.iter().map(|refused| refused.cylinder).collect();
        cylinders.sort_unstable();
        cylinders.dedup();
        cylinders
    }

    fn refuse(&mut self, by: Stage, refusals: Vec<(u8, String)>) {
        let refused = refusals.into_iter().map(|(cylinder, why)| Refused { cylinder, by, why });
        self.refused.extend(refused);
    }

    pub(super) fn put(&mut self, tables: &str, anew: &[&str]) -> Result<(), String> {
        let text = edit::put(&self.text, tables, anew);
        self.text = text.map_err(|error| format!("the configuration cannot be edited: {error}"))?;
        self.keep_left_out()
    }
}

/// Gives the stages the frames that are not held back.
#[derive(Debug)]
pub(super) struct Lesson<'a, F> {
    pub task: &'a Task<'a>,
    pub frames: &'a F,
    pub blocks: Option<Blocks>,
}

/// A stage failed, or the frames can no longer be read.
enum Stopped<E> {
    Failed(Stage, String),
    Recording(E),
}

impl<F: Frames> Lesson<'_, F> {
    /// Runs the stages in turn until one fails; nothing is learnt from `cuts`.
    ///
    /// # Errors
    /// The frames' own.
    pub fn teach(&self, cuts: &Cuts, mut tell: impl FnMut(Stage)) -> Result<Taught, F::Error> {
        let mut taught = Taught { text: self.task.text.to_owned(), ..Taught::default() };
        tell(Stage::Identify);
        let mut result = self.identify(&mut taught, cuts);
        if result.is_ok() {
            tell(Stage::Calibrate);
            result = self.calibrate(&mut taught, cuts);
        }
        if result.is_ok() {
            tell(Stage::Tune);
            let found = taught.cuts().with(cuts);
            // What a calibration with less to go by has not found is left out all the same.
            let cuts = if self.blocks.is_some() { cuts } else { &found };
            result = self.tune(&mut taught, cuts);
        }
        match result {
            Err(Stopped::Recording(error)) => return Err(error),
            Err(Stopped::Failed(stage, why)) => taught.failed = Some((stage, why)),
            Ok(()) => {}
        }
        Ok(taught)
    }

    fn identify(&self, taught: &mut Taught, cuts: &Cuts) -> Result<(), Stopped<F::Error>> {
        let failed = |why| Stopped::Failed(Stage::Identify, why);
        let (settings, design) = self.machine(taught).map_err(failed)?;
        taught.machine.clone_from(&settings.machine.name);
        taught.names = settings.names();
        // What it is worth is tried by the monitor, on blocks that were left out: nothing more is held back.
        let (origin, options) = (self.task.origin, Options { held_back: 0, ..Options::default() });
        let course =
            identify::course::IdentificationCourse { settings: &settings, origin, options };
        let outcome = course.run(&self.recording(&design, cuts)).map_err(Stopped::Recording)?;
        taught.refuse(Stage::Identify, outcome.refusals());
        let learnt = tables::model::of(&outcome, self.task.version, false);
        // Whether the model follows is told by all of the recording; a rehearsal's is tried by the monitor.
        let follows = if self.blocks.is_none() { outcome.follows(false) } else { Ok(()) };
        if outcome.follows_nowhere() {
            taught.does_not_follow = follows.err();
        } else {
            // It is one cylinder whose command is wrong, or which is faulty.
            follows.map_err(failed)?;
        }
        taught.identification = Some(outcome);
        let none = || failed(nothing(taught, "there is no model"));
        let learnt = learnt.ok_or_else(none)?;
        taught.put(&learnt, &tables::model::OF_A_MODEL).map_err(failed)
    }

    fn calibrate(&self, taught: &mut Taught, cuts: &Cuts) -> Result<(), Stopped<F::Error>> {
        let failed = |why| Stopped::Failed(Stage::Calibrate, why);
        let (settings, design) = self.machine(taught).map_err(failed)?;
        let Task { origin, per_year, version, .. } = *self.task;
        let all = origin.window;
        let course = calibrate::CalibrationCourse {
            settings: &settings,
            timeline: &origin.timeline,
            fitted: all,
            tried: all,
            per_year,
        };
        let result = Calibration::of(&course, &self.recording(&design, cuts), origin)
            .map_err(Stopped::Recording)?;
        taught.refuse(Stage::Calibrate, result.refusals());
        let useless = result.usable(settings.comparator.critical).err();
        let learnt = tables::calibration::of(&result, version, useless.is_none());
        let has_c2 = result.has_c2();
        taught.calibration = Some(result);
        taught.any_left(settings.machine.cylinders).map_err(failed)?;
        match learnt {
            Some(learnt) => taught.put(&learnt, &[]).map_err(failed)?,
            None if has_c2 => return Err(failed(nothing(taught, "no cylinder has a calibration"))),
            None => {}
        }
        if let Some(why) = taught.does_not_follow.clone() {
            let why = taught.leave_out(Threshold::OfObservers, Stage::Identify, why);
            why.map_err(|why| Stopped::Failed(Stage::Identify, why))?;
        }
        match useless {
            Some(why) => {
                taught.leave_out(Threshold::OfDifference, Stage::Calibrate, why).map_err(failed)
            }
            None => Ok(()),
        }
    }

    fn tune(&self, taught: &mut Taught, cuts: &Cuts) -> Result<(), Stopped<F::Error>> {
        let failed = |why| Stopped::Failed(Stage::Tune, why);
        let (settings, design) = self.machine(taught).map_err(failed)?;
        let Task { origin, per_year, version, database, .. } = *self.task;
        design::judging(&settings, database).map_err(|flaws| failed(told(&flaws)))?;
        let course = tune::course::TuningCourse {
            settings: &settings,
            design: &design,
            origin,
            without: &taught.refused_cylinders(),
            per_year,
            keep_weights: false,
            sigma: SIGMA,
        };
        let result = course.run(&self.recording(&design, cuts)).map_err(|why| match why {
            Untuned::Recording(error) => Stopped::Recording(error),
            Untuned::TooLittle(why) => failed(why),
        })?;
        let useless = result.usable(&settings).err();
        let learnt = tables::tuning::of(&result, version);
        taught.tuning = Some(result);
        taught.put(&learnt, &[]).map_err(failed)?;
        if let Some(why) = useless {
            taught.leave_out(Threshold::OfObservers, Stage::Tune, why).map_err(failed)?;
        }
        self.machine(taught).map(drop).map_err(failed)
    }

    /// The machine with what has been learnt so far.
    fn machine(&self, taught: &Taught) -> Result<(Settings, MonitorDesign), String> {
        let Task { name, database, .. } = *self.task;
        let (settings, _) = config::parse(name, &taught.text).map_err(|it| it.to_string())?;
        let design = design::surveying(&settings, database).map_err(|flaws| told(&flaws))?;
        Ok((settings, design))
    }

    fn recording<'b>(
        &'b self,
        design: &'b MonitorDesign,
        cuts: &'b Cuts,
    ) -> impl Recording<Error = F::Error> + 'b {
        let first = self.task.origin.timeline.first();
        let recording = Rows { frames: self.frames, design, first };
        Without { recording, blocks: self.blocks.clone(), cuts }
    }
}

/// The flaws of a design, on one line.
pub(super) fn told(flaws: &[Flaw]) -> String {
    let told = flaws.iter().map(|flaw| format!("{}: {}", flaw.key, flaw.message));
    told.collect::<Vec<_>>().join("; ")
}

/// Message that no cylinder is left, and why.
fn nothing(taught: &Taught, what: &str) -> String {
    match taught.refused.len() {
        0 => what.to_owned(),
        _ => format!("{what}, as every cylinder is refused"),
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use tertius_learn::calibrate::{CalibrationRefusal, CylinderCalibration};
    use tertius_learn::relate::LearntProcess;
    use tertius_learn::survey::{Timeline, Window};

    pub fn cylinder(number: u8) -> CylinderCalibration {
        CylinderCalibration {
            sample_time: 0.02,
            number,
            result: Err(CalibrationRefusal::NoSecond),
            tried: None,
            sequential: None,
            level: None,
            contradiction: None,
            process: Some(LearntProcess {
                number,
                spool: None,
                chambers: None,
                flow: None,
                friction: None,
            }),
            left_out: Vec::new(),
            remarks: Vec::new(),
        }
    }

    pub fn calibration(cylinders: Vec<CylinderCalibration>) -> Calibration {
        Calibration {
            machine: String::new(),
            inputs: String::new(),
            timeline: Timeline::default(),
            fitted: Window::ALL,
            tried: Window::ALL,
            cylinders,
            bound: None,
            supply: None,
            remarks: Vec::new(),
        }
    }
}
