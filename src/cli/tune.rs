//! `tertius tune`: the observer's weights and the thresholds from a healthy recording.

use super::Failure;
use super::files::Overwriting;
use super::machine::Machine;
use super::survey::Field;
use super::tables::{self, InPlace};
use crate::config::design;
use crate::report::ReadWith;
use crate::report::{page, tuning};
use crate::tables as learnt;
use crate::tune::course::{SIGMA, TuningCourse, Untuned};
use clap::Args;
use std::path::PathBuf;

/// Chooses the observer's weights and the thresholds of R1 and R2 on a healthy recording, and tells
/// which faults they will find.
#[derive(Args, Debug)]
#[command(
    after_help = "Example:\n  tertius tune field.log.zst --config config/e-type.toml --output \
                  tuning.toml\n\nThe model has to be in the configuration before: see `tertius \
                  identify`."
)]
pub struct Tune {
    #[command(flatten)]
    field: Field,
    /// Writes the tables [observer] and [fde] for the configuration
    #[arg(long, value_name = "FILE.toml")]
    output: Option<PathBuf>,
    /// Writes a page with figures, in one file
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
    #[command(flatten)]
    place: InPlace,
    #[command(flatten)]
    overwriting: Overwriting,
    /// Wanted false alarms of FDE1 and FDE2 in a year of monitoring, all cylinders together
    #[arg(long, value_name = "N", default_value_t = 1.0, value_parser = tables::per_year)]
    false_alarms_per_year: f64,
    /// Keeps the configured weights, and determines only the thresholds
    #[arg(long)]
    keep_weights: bool,
    /// Standard deviation that is the unit of noise (5-17), m; 4 counts in the thesis
    #[arg(long, value_name = "METRES", default_value_t = SIGMA, value_parser = sigma)]
    sigma: f64,
}

fn sigma(text: &str) -> Result<f64, String> {
    let sound = text.parse().ok().filter(|sigma: &f64| sigma.is_finite() && *sigma > 0.0);
    sound.ok_or_else(|| "expected a length in metres, above 0".to_owned())
}

impl Tune {
    /// Runs the command.
    ///
    /// # Errors
    /// A wrong call or file, or a recording with too little data.
    pub fn run(self) -> Result<(), Failure> {
        // Weights are tuned for the model that is configured: it has to be one of this machine.
        Machine::load(&self.field.config, &self.field.set.overrides()?)?;
        let surveyed = self.field.open()?;
        let outputs = [&self.output, &self.report];
        let [output, report] =
            tables::claim("tune", outputs, self.overwriting, &self.field, &surveyed, &self.place)?;
        let settings = &surveyed.machine.loaded.settings;
        let course = TuningCourse {
            settings,
            design: &surveyed.machine.design,
            origin: &surveyed.origin(),
            without: &[],
            per_year: self.false_alarms_per_year,
            keep_weights: self.keep_weights,
            sigma: self.sigma,
        };
        let result = course.run(&surveyed)?;
        let usable = result.usable(settings);
        let written =
            usable.is_ok().then(|| learnt::tuning::of(&result, env!("CARGO_PKG_VERSION")));
        let with = ReadWith::from(&surveyed.machine.loaded);
        tables::publish(&tuning::page(&result, &with), output, written.as_deref())?;
        if let Some(tables) = written {
            self.place.put(&tables, &[], design::judging)?;
        }
        if let Some(report) = report {
            report.write(&page::tuning::page(&result, &with))?;
        }
        surveyed.damage()?;
        usable.map_err(Failure::Failed)
    }
}

impl From<Untuned<Self>> for Failure {
    fn from(untuned: Untuned<Self>) -> Self {
        match untuned {
            Untuned::Recording(failure) => failure,
            Untuned::TooLittle(why) => Self::Failed(why),
        }
    }
}
