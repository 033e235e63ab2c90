//! `tertius commission`: from a healthy recording to a configuration that can be used.

use super::Failure;
use super::files::{self, Claimed, Inputs, Mark, Overwriting};
use super::learnt_file::Prepared;
use super::survey::{Field, Surveyed};
use super::tables;
use super::update::{Study, Update};
use crate::commission::{Commissioned, Fitness, Stage, Step, Task, Taught, Threshold};
use crate::config::{self, design};
use crate::failure::print;
use crate::report::ReadWith;
use crate::report::{commission, page};
use crate::survey::Recording;
use clap::Args;
use std::fs;
use std::io::IsTerminal;
use std::path::{Path, PathBuf};

/// Commissions a machine from a healthy recording: identifies, calibrates, tunes, and tries the
/// result on blocks that were held back. Tables that are fit for use are put into the
/// configuration.
#[derive(Args, Debug)]
#[command(after_help = "Example:\n  tertius commission monday.log.zst tuesday.log.zst --config \
                  config/e-type.toml --report commissioning.html\n\nThe configuration is changed \
                  in place: comments and order stay, and a copy of the previous file is kept beside it. A \
                  result that is not fit for use is not written; the exit code is then 1, and the reasons \
                  are given. The exit code is 3 if it is written without the detectors whose threshold would be too large \
                  to find a fault.\n\nRecordings of several days add up if each call says so:\n  tertius commission \
                  wednesday.log.zst --config config/e-type.toml --update")]
pub struct Commission {
    #[command(flatten)]
    field: Field,
    /// Shows what would change in the configuration, and changes nothing
    #[arg(long, conflicts_with = "output")]
    dry_run: bool,
    /// Writes a new, complete configuration, and leaves the given one as it is
    #[arg(long, value_name = "FILE.toml")]
    output: Option<PathBuf>,
    /// Writes a page with figures, in one file; reads the recording once more for it
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
    /// Uses the tables of the other cylinders if some are refused
    #[arg(long)]
    accept_refused: bool,
    /// Learns from this recording together with what NAME.learnt, beside the configuration
    /// NAME.toml, keeps of earlier ones, and adds this recording to that file. Leaves out what does
    /// not look healthy by the present tables; refuses a recording with a lasting fault
    #[arg(long, conflicts_with_all = ["output", "accept_refused"])]
    update: bool,
    /// Discards what --update has kept, and starts again with this recording
    #[arg(long, requires = "update")]
    fresh: bool,
    /// Wanted false alarms in a year of monitoring: of R1 and R2, of R3, and of the sequential
    /// detectors, all cylinders together
    #[arg(long, value_name = "N", default_value_t = 1.0, value_parser = tables::per_year)]
    false_alarms_per_year: f64,
    #[command(flatten)]
    overwriting: Overwriting,
}

impl Commission {
    /// Runs the command.
    ///
    /// # Errors
    /// A wrong call or file, or a machine or cylinder that is not fit for use.
    pub fn run(self) -> Result<(), Failure> {
        let surveyed = self.field.open()?;
        surveyed.whole()?;
        let [output, report] = self.claim(&surveyed)?;
        let config = &self.field.config;
        let study = if self.update {
            let update = Update { fresh: self.fresh, all: true };
            let Some(study) = Study::adding(surveyed, config, update)? else { return Ok(()) };
            study
        } else {
            Study::alone(surveyed)
        };
        let machine = &study.surveyed.machine;
        let before = machine.loaded.document.effective();
        let task = Task {
            name: &config.display().to_string(),
            text: before,
            database: &machine.database,
            origin: &study.origin(),
            cuts: &study.cuts,
            per_year: self.false_alarms_per_year,
            version: env!("CARGO_PKG_VERSION"),
        };
        let result = task.run(&study, show)?;
        print(&commission::page(&result, &ReadWith::from(&machine.loaded)))?;
        if let Some(report) = report {
            report.write(&figures(&study, &result)?)?;
        }
        self.judge(&result)?;
        self.write(&study, &result.taught, output)?;
        limited(&result)
    }

    /// Claims the files that are written, the configuration among them.
    fn claim(&self, surveyed: &Surveyed) -> Result<[Option<Claimed>; 2], Failure> {
        let config = self.field.config.as_path();
        let logs = self.field.logs.iter().map(PathBuf::as_path);
        let inputs = Inputs::new(logs.chain(surveyed.machine.files(config)));
        let wanted = [
            (self.output.as_deref(), Mark::Whole),
            (self.report.as_deref(), Mark::Page("commission")),
        ];
        let claimed = inputs.claim(wanted, self.overwriting)?;
        if self.output.is_none() && !self.dry_run {
            // Before minutes are spent on it.
            let before = surveyed.machine.loaded.document.text();
            let own = [(Some(config), Mark::Text(before))];
            Inputs::default().claim(own, Overwriting::default())?;
        }
        Ok(claimed)
    }

    /// Whether the result is written.
    fn judge(&self, result: &Commissioned) -> Result<(), Failure> {
        let verdict = &result.verdict;
        match &verdict.fitness {
            Fitness::Fit => Ok(()),
            Fitness::Partly { cylinders, .. } if cylinders.is_empty() || self.accept_refused => {
                Ok(())
            }
            Fitness::Partly { .. } | Fitness::Unfit => {
                // The reasons are on the page.
                Err(Failure::Failed(format!("{}; nothing was written", verdict.sentence)))
            }
        }
    }

    fn write(
        &self,
        study: &Study,
        taught: &Taught,
        output: Option<Claimed>,
    ) -> Result<(), Failure> {
        let config = self.field.config.as_path();
        let document = &study.surveyed.machine.loaded.document;
        // An override is of this call, and not of the file.
        let (before, after) = (document.text(), &document.without_overrides(&taught.text));
        let Some(path) = self.output.as_deref() else {
            tables::approve(config, after, design::judging)?;
            if self.dry_run {
                return tables::show(config, before, after);
            }
            let prepared = study.prepare(&taught.text, &taught.cuts())?;
            tables::replace(config, before, after)?;
            return prepared.map_or(Ok(()), Prepared::settle);
        };
        let moved = moved(config, path, after)?;
        tables::approve(path, &moved, design::judging)?;
        output.map_or(Ok(()), |output| output.write(&moved))
    }
}

/// An exit code of its own where detectors are left out, so that a script does not take the machine for wholly fit.
fn limited(result: &Commissioned) -> Result<(), Failure> {
    match &result.verdict.fitness {
        Fitness::Partly { without, .. } if !without.is_empty() => {
            let detectors = Threshold::listed(without);
            Err(Failure::Limited(format!(
                "{detectors} left out and switched off; the reason is above, under \"why\""
            )))
        }
        _ => Ok(()),
    }
}

/// The configuration `text` of the file `original` as it has to be in the file `path`.
fn moved(original: &Path, path: &Path, text: &str) -> Result<String, Failure> {
    let (from, to) = (files::folder(original), files::folder(path));
    if files::is_same_folder(from, to) {
        return Ok(text.to_owned());
    }
    let folder = fs::canonicalize(from).map_err(|error| Failure::creating(path, &error))?;
    config::relocate(text, &folder.display().to_string()).map_err(|error| {
        Failure::Failed(format!("{} cannot be edited: {error}", original.display()))
    })
}

/// The page of HTML.
fn figures(study: &Study, result: &Commissioned) -> Result<String, Failure> {
    let settings = &study.surveyed.machine.loaded.settings;
    let sample_time = settings.machine.sample_time;
    let calibration = result.taught.calibration.as_ref();
    let mut differences = calibration.map(|it| page::Differences::new(it, sample_time));
    if let Some(differences) = &mut differences {
        study.read(study.window, differences)?;
    }
    let with = ReadWith::from(&study.surveyed.machine.loaded);
    Ok(page::commission::page(result, differences.as_ref(), settings.comparator.bound, &with))
}

/// Shows on a terminal which step has begun.
fn show(step: Step) {
    if std::io::stderr().is_terminal() {
        tell!("{}", progress(step));
    }
}

const fn progress(step: Step) -> &'static str {
    match step {
        Step::Learn(Stage::Identify) => "identifying the model",
        Step::Learn(Stage::Calibrate) => "calibrating C2",
        Step::Learn(Stage::Tune) => "tuning weights and thresholds",
        Step::Rehearse(Stage::Identify) => "for the trial, without what is held back: identifying",
        Step::Rehearse(Stage::Calibrate) => "for the trial: calibrating",
        Step::Rehearse(Stage::Tune) => "for the trial: tuning",
        Step::Try => "trying it on what was held back, healthy and with faults",
    }
}
