//! `tertius calibrate`: the correction of C2 from a healthy recording.

use super::Failure;
use super::files::Overwriting;
use super::survey::{Field, Surveyed};
use super::tables::{self, InPlace};
use crate::calibrate::{Bound, Calibrated, Calibration, Course, LARGEST_BOUND, LEAST_BOUND};
use crate::monitor::MonitorDesign;
use crate::report::calibration;
use crate::report::page::{self, Differences};
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
        let usable = usable(&result, settings.comparator.critical);
        let written =
            usable.is_ok().then(|| calibration::tables(&result, env!("CARGO_PKG_VERSION")));
        let written = written.flatten();
        tables::publish(&page, output, written.as_deref())?;
        if let Some(tables) = written {
            self.place.put(&tables, &[], MonitorDesign::unjudging)?;
        }
        if let Some(report) = report {
            report.write(&figures(&surveyed, &result)?)?;
        }
        surveyed.damage()?;
        usable.and_then(|()| conclude(&result))
    }

    fn calibration(&self, surveyed: &Surveyed) -> Result<Calibration, Failure> {
        let settings = &surveyed.machine.loaded.settings;
        let all = surveyed.window;
        let [fitted, tried] = match self.held_back {
            Some(percent) => all.split(1.0 - f64::from(percent) / 100.0),
            None => [all, all],
        };
        let course = Course { settings, fitted, tried, per_year: self.false_alarms_per_year };
        let Calibrated { cylinders, bound } = course.run(surveyed)?;
        let mut remarks = surveyed.remarks();
        let own = || cylinders.iter().any(|cylinder| cylinder.level.is_some());
        remarks.extend(settings.sequential.level.filter(|_| own()).map(|level| {
            format!(
                "sequential.level of the configuration, {level} nats, goes before the level of each \
                 cylinder; take it out"
            )
        }));
        let bound = bound.map(|bound| Bound { level: bound.level.max(LEAST_BOUND), ..bound });
        Ok(Calibration {
            machine: settings.machine.name.clone(),
            inputs: surveyed.inputs(),
            first: surveyed.first,
            fitted,
            tried,
            cylinders,
            bound,
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

/// A bound that is no warning before the machine itself trips is none, and none is written.
fn usable(result: &Calibration, critical: f64) -> Result<(), Failure> {
    let most = LARGEST_BOUND * critical;
    let Some(bound) = result.bound.filter(|bound| bound.level > most) else { return Ok(()) };
    Err(Failure::Failed(format!(
        "for {} false alarms a year R3 would take a bound of {:.2} mm, and with more than {:.2} mm, a \
         tenth of comparator.critical, it hardly warns before the machine trips. The largest |C1 - \
         C2| beyond the line is {:.2} mm; with {:.2} mm, the thesis's, this recording speaks of about \
         {:.0} a year (--false-alarms-per-year). Is it of a healthy machine? Look at C1 - C2 over time \
         (`replay --residuals`)",
        bound.per_year,
        bound.level * 1e3,
        most * 1e3,
        bound.worst * 1e3,
        LEAST_BOUND * 1e3,
        bound.often.ceil(),
    )))
}

/// A cylinder without a calibration is a failure, though the others have theirs.
fn conclude(result: &Calibration) -> Result<(), Failure> {
    let refused: Vec<String> = result
        .cylinders
        .iter()
        .filter_map(|cylinder| {
            let refusal = cylinder.result.as_ref().err().map(ToString::to_string);
            let told = refusal.or_else(|| cylinder.contradiction.map(|it| it.to_string()))?;
            Some(format!("cylinder {}: {told}", cylinder.number))
        })
        .collect();
    if refused.is_empty() { Ok(()) } else { Err(Failure::Failed(refused.join("\ntertius: "))) }
}
