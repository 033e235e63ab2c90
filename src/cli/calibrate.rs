//! `tertius calibrate`: the correction of C2 from a healthy recording.

use super::Failure;
use super::files::Overwriting;
use super::learnt_file::Prepared;
use super::survey::Field;
use super::tables::{self, InPlace};
use super::update::{Study, Update};
use crate::calibrate::{Calibration, CalibrationCourse};
use crate::commission::holding::Without;
use crate::config::{design, edit};
use crate::report::ReadWith;
use crate::report::calibration;
use crate::report::page::{self, Differences};
use crate::survey::Recording;
use crate::tables as learnt;
use clap::Args;
use std::path::PathBuf;

/// Fits C1 = a·C2 + b (5-20) of every cylinder on a healthy recording, and shows the band of the
/// difference. Blocks of a minute alternate between two halves, each of which is judged by what the
/// other teaches.
#[derive(Args, Debug)]
#[command(
    after_help = "Example:\n  tertius calibrate field.log.zst --config config/e-type.toml --output \
                  calibration.toml"
)]
pub struct Calibrate {
    #[command(flatten)]
    field: Field,
    /// Writes the tables [comparator] and [[cylinder]] for the configuration
    #[arg(long, value_name = "FILE.toml")]
    output: Option<PathBuf>,
    /// Writes a page with figures, in one file; reads the recording once more for it
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
    #[command(flatten)]
    place: InPlace,
    #[command(flatten)]
    overwriting: Overwriting,
    /// Learns from this recording together with what NAME.learnt, beside the configuration
    /// NAME.toml, keeps of earlier ones, and adds this recording to that file. Leaves out what does
    /// not look healthy by the present tables; refuses a recording with a lasting fault
    #[arg(long, requires = "into", conflicts_with_all = ["held_back", "output"])]
    update: bool,
    /// Discards what --update has kept, and starts again with this recording
    #[arg(long, requires = "update")]
    fresh: bool,
    /// Fits on the beginning and validates on this part of the time at the end, %, instead of on
    /// alternating blocks
    #[arg(long, value_name = "PERCENT", value_parser = clap::value_parser!(u8).range(5..=90))]
    held_back: Option<u8>,
    /// Wanted false alarms of R3 in a year of monitoring, all cylinders together
    #[arg(long, value_name = "N", default_value_t = 1.0, value_parser = tables::per_year)]
    false_alarms_per_year: f64,
}

impl Calibrate {
    /// Runs the command.
    ///
    /// # Errors
    /// A wrong call or file, or cylinders that were refused.
    pub fn run(self) -> Result<(), Failure> {
        let surveyed = self.field.open()?;
        let outputs = [&self.output, &self.report];
        let [output, report] = tables::claim(
            "calibrate",
            outputs,
            self.overwriting,
            &self.field,
            &surveyed,
            &self.place,
        )?;
        let study = if self.update {
            if !self.place.is(&self.field.config) {
                return Err(Failure::Wrong(
                    "--update: --into has to be the configuration itself, whose tables judge the recording"
                        .to_owned(),
                ));
            }
            let update = Update { fresh: self.fresh, all: false };
            let Some(study) = Study::adding(surveyed, &self.field.config, update)? else {
                return Ok(());
            };
            study
        } else {
            Study::alone(surveyed)
        };
        let result = self.calibration(&study)?;
        let page = calibration::page(&result, &ReadWith::from(&study.surveyed.machine.loaded));
        let settings = &study.surveyed.machine.loaded.settings;
        let usable = result.usable(settings.comparator.critical);
        let written = usable
            .is_ok()
            .then(|| learnt::calibration::of(&result, env!("CARGO_PKG_VERSION"), true));
        let written = written.flatten();
        tables::publish(&page, output, written.as_deref())?;
        let written_nothing = written.is_none();
        // What is kept has no cylinder that contradicts it.
        let whole = result.refusals().is_empty();
        if let Some(tables) = written.filter(|_| whole || !self.update) {
            self.put(&study, &result, &tables)?;
        }
        if let Some(report) = report {
            report.write(&figures(&study, &result)?)?;
        }
        study.surveyed.damage()?;
        usable.map_err(Failure::Failed)?;
        if !result.has_c2() && written_nothing {
            return Err(Failure::Failed(
                "there is nothing to calibrate: no cylinder has a C2, and no process detector was learnt".to_owned(),
            ));
        }
        // A cylinder without a calibration is a failure, though the others have theirs.
        match &result.refusals()[..] {
            [] => Ok(()),
            refused => Err(Failure::refused(refused)),
        }
    }

    /// Puts the tables into the configuration, and keeps the data that they were made from.
    fn put(&self, study: &Study, result: &Calibration, tables: &str) -> Result<(), Failure> {
        let mut prepared = None;
        let judged_by = study.surveyed.machine.loaded.document.effective();
        let in_force = edit::put(judged_by, tables, &[])
            .map_err(|error| Failure::Failed(format!("nothing was changed: {error}")))?;
        self.place.put_after(tables, &[], design::unjudging, |_| {
            prepared = study.prepare(&in_force, &result.cuts())?;
            Ok(())
        })?;
        prepared.map_or(Ok(()), Prepared::settle)
    }

    fn calibration(&self, study: &Study) -> Result<Calibration, Failure> {
        let (settings, all) = (&study.surveyed.machine.loaded.settings, study.window);
        let [fitted, tried] = match self.held_back {
            Some(percent) => all.split(1.0 - f64::from(percent) / 100.0),
            None => [all, all],
        };
        let (origin, per_year) = (study.origin(), self.false_alarms_per_year);
        let course =
            CalibrationCourse { settings, timeline: &origin.timeline, fitted, tried, per_year };
        let recording = Without { recording: study, blocks: None, cuts: &study.cuts };
        Calibration::of(&course, &recording, &origin)
    }
}

/// The page of HTML.
fn figures(study: &Study, result: &Calibration) -> Result<String, Failure> {
    let settings = &study.surveyed.machine.loaded.settings;
    let mut differences = Differences::new(result, settings.machine.sample_time);
    study.read(study.window, &mut differences)?;
    let with = ReadWith::from(&study.surveyed.machine.loaded);
    Ok(page::calibration::page(result, &differences, settings.comparator.bound, &with))
}
