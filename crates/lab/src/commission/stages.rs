//! The three stages that learn, each with the tables of the one before.

use super::holding::{Blocks, Without};
use super::task::Task;
use super::taught::{Stage, Taught, Threshold};
use crate::flaws::listed;
use tertius_config as config;
use tertius_config::design;
use tertius_config::settings::Settings;
use tertius_core::monitor::MonitorDesign;
use tertius_learn::calibrate;
use tertius_learn::calibrate::{Calibration, Cuts};
use tertius_learn::identify;
use tertius_learn::identify::course::Options;
use tertius_learn::survey::{Frames, Recording, Rows};
use tertius_learn::tables;
use tertius_learn::tune;
use tertius_learn::tune::course::{SIGMA, Untuned};

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
        design::judging(&settings, database).map_err(|flaws| failed(listed(&flaws)))?;
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
        let design = design::surveying(&settings, database).map_err(|flaws| listed(&flaws))?;
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

/// Message that no cylinder is left, and why.
fn nothing(taught: &Taught, what: &str) -> String {
    match taught.refused.len() {
        0 => what.to_owned(),
        _ => format!("{what}, as every cylinder is refused"),
    }
}
