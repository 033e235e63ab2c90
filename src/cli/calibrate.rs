//! `tertius calibrate`: the correction of C2 from a healthy recording.

use super::Failure;
use super::files::Overwriting;
use super::survey::{Field, Surveyed};
use super::tables::{self, InPlace};
use crate::calibrate::{Calibration, Course};
use crate::config::design;
use crate::report::calibration;
use crate::report::page::{self, Differences};
use crate::survey::Recording;
use crate::tables as learnt;
use clap::Args;
use std::path::PathBuf;

/// Fits C1 = a·C2 + b (5-20) of every cylinder on a healthy recording, and shows the band of the
/// difference. Blocks of a minute alternate: each is judged by what the others teach.
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
    /// Writes a page with figures, in one file; the recording is read once more for it
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
    #[command(flatten)]
    place: InPlace,
    #[command(flatten)]
    overwriting: Overwriting,
    /// Fits on the beginning, and tries the fit on this part of the time at the end, %, instead of
    /// blocks that alternate
    #[arg(long, value_name = "PERCENT", value_parser = clap::value_parser!(u8).range(5..=90))]
    held_back: Option<u8>,
    /// False alarms of R3, all cylinders together, that a year of monitoring may bring
    #[arg(long, value_name = "N", default_value_t = 1.0, value_parser = tables::per_year)]
    false_alarms_per_year: f64,
}

impl Calibrate {
    /// Calibrates.
    ///
    /// # Errors
    /// What is wrong with the call or its files; cylinders that were refused.
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
        let result = self.calibration(&surveyed)?;
        let page = calibration::page(&result);
        let settings = &surveyed.machine.loaded.settings;
        let usable = result.usable(settings.comparator.critical);
        let written =
            usable.is_ok().then(|| learnt::calibration::of(&result, env!("CARGO_PKG_VERSION")));
        let written = written.flatten();
        tables::publish(&page, output, written.as_deref())?;
        if let Some(tables) = written {
            self.place.put(&tables, &[], design::unjudging)?;
        }
        if let Some(report) = report {
            report.write(&figures(&surveyed, &result)?)?;
        }
        surveyed.damage()?;
        usable.map_err(Failure::Failed)?;
        // A cylinder without a calibration is a failure, though the others have theirs.
        match &result.refusals()[..] {
            [] => Ok(()),
            refused => Err(Failure::refused(refused)),
        }
    }

    fn calibration(&self, surveyed: &Surveyed) -> Result<Calibration, Failure> {
        let (settings, all) = (&surveyed.machine.loaded.settings, surveyed.window);
        let [fitted, tried] = match self.held_back {
            Some(percent) => all.split(1.0 - f64::from(percent) / 100.0),
            None => [all, all],
        };
        let course = Course { settings, fitted, tried, per_year: self.false_alarms_per_year };
        Calibration::of(&course, surveyed, &surveyed.origin())
    }
}

/// The page of HTML.
fn figures(surveyed: &Surveyed, result: &Calibration) -> Result<String, Failure> {
    let settings = &surveyed.machine.loaded.settings;
    let mut differences = Differences::new(result, settings.machine.sample_time);
    surveyed.read(surveyed.window, &mut differences)?;
    Ok(page::calibration::page(result, &differences, settings.comparator.bound))
}
