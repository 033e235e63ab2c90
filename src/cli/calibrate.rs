//! `tertius calibrate`: the correction of C2 from a healthy recording.

use super::Failure;
use super::files::Overwriting;
use super::survey::{Field, Surveyed};
use super::tables::{self, InPlace};
use crate::calibrate::{Calibrated, Calibration, Course};
use crate::monitor::MonitorDesign;
use crate::report::calibration;
use crate::report::page::{self, Differences};
use clap::Args;
use std::path::PathBuf;

/// Fits C1 = a·C2 + b (5-20) of every cylinder on the first part of a healthy recording, and shows
/// the band of the difference on the second.
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
    /// The part of the time at the end on which the fit is tried, %
    #[arg(long, value_name = "PERCENT", default_value_t = 50, value_parser = clap::value_parser!(u8).range(5..=90))]
    held_back: u8,
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
        let written = calibration::tables(&result, env!("CARGO_PKG_VERSION"));
        tables::publish(&page, output, written.as_deref())?;
        if let Some(tables) = written {
            self.place.put(&tables, &[], MonitorDesign::unjudging)?;
        }
        if let Some(report) = report {
            report.write(&figures(&surveyed, &result)?)?;
        }
        surveyed.damage()?;
        conclude(&result)
    }

    fn calibration(&self, surveyed: &Surveyed) -> Result<Calibration, Failure> {
        let settings = &surveyed.machine.loaded.settings;
        let part = 1.0 - f64::from(self.held_back) / 100.0;
        let [fitted, tried] = surveyed.window.split(part);
        let course = Course { settings, fitted, tried, per_year: self.false_alarms_per_year };
        let Calibrated { cylinders, bound, level } = course.run(surveyed)?;
        let mut remarks = surveyed.remarks();
        remarks.extend(bound.filter(|b| b.level >= settings.comparator.critical).map(|b| {
            format!(
                "the bound of {:.2} mm is not below comparator.critical, {:.2} mm, where the machine \
                 itself trips: the configuration will be refused with it",
                b.level * 1e3,
                settings.comparator.critical * 1e3
            )
        }));
        Ok(Calibration {
            machine: settings.machine.name.clone(),
            inputs: surveyed.inputs(),
            first: surveyed.first,
            fitted,
            tried,
            cylinders,
            bound,
            level,
            remarks,
        })
    }
}

/// The page of HTML.
fn figures(surveyed: &Surveyed, result: &Calibration) -> Result<String, Failure> {
    let settings = &surveyed.machine.loaded.settings;
    let mut differences = Differences::new(result, settings.machine.sample_time);
    surveyed.read(surveyed.window, &mut differences)?;
    Ok(page::calibration::page(result, &differences, settings.comparator.bound))
}

/// A cylinder without a calibration is a failure, though the others have theirs.
fn conclude(result: &Calibration) -> Result<(), Failure> {
    let refused: Vec<String> = result
        .cylinders
        .iter()
        .filter_map(|cylinder| {
            let refusal = cylinder.result.as_ref().err()?;
            Some(format!("cylinder {}: {refusal}", cylinder.number))
        })
        .collect();
    if refused.is_empty() { Ok(()) } else { Err(Failure::Failed(refused.join("\ntertius: "))) }
}
