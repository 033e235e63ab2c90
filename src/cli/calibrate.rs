//! `tertius calibrate`: the correction of C2 from a healthy recording.

use super::Failure;
use super::page::PageFile;
use super::survey::{Field, Surveyed};
use super::tables;
use crate::calibrate::{
    Calibration, CylinderCalibration, Fitting, Gathering, Profile, Profiling, Refusal, Scattering,
    Trying,
};
use crate::report::calibration;
use crate::report::page::{self, Differences};
use crate::sequential;
use crate::tune::sequential::Watch;
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
        let output = self.output.as_deref();
        tables::refuse_overwriting(&[output, self.report.as_deref()], &self.field, &surveyed)?;
        let report = self.report.as_deref().map(PageFile::prepare).transpose()?;
        let result = self.calibration(&surveyed)?;
        let page = calibration::page(&result);
        let written = calibration::tables(&result, env!("CARGO_PKG_VERSION"));
        tables::publish(&page, output, written.as_deref())?;
        if let Some(report) = report {
            report.write(&figures(&surveyed, &result)?)?;
        }
        surveyed.damage()?;
        conclude(&result)
    }

    /// Reads the recording five times: what is in it, the line, what bends along it, the trial, and the
    /// detectors that follow.
    fn calibration(&self, surveyed: &Surveyed) -> Result<Calibration, Failure> {
        let settings = &surveyed.machine.loaded.settings;
        let part = 1.0 - f64::from(self.held_back) / 100.0;
        let [fitted, tried] = surveyed.window.split(part);
        let [low, high] = settings.machine.stroke;
        let configured = |n| {
            let calibration = settings.comparator_of(n);
            (calibration != (1.0, 0.0)).then_some(calibration)
        };
        let numbers = 1..=settings.machine.cylinders;
        let mut gathering = Gathering::new(high - low, numbers.clone().map(configured).collect());
        surveyed.read(fitted, &mut gathering)?;
        let second = settings.signals.cylinder.c2.is_some();
        let judge = |n: u8| {
            if second { gathering.judge(usize::from(n) - 1) } else { Err(Refusal::NoSecond) }
        };
        let lines: Vec<_> = numbers.clone().map(judge).collect();
        let mut fitting = Fitting::new(lines.iter().map(|line| line.as_ref().ok().copied()));
        surveyed.read(fitted, &mut fitting)?;
        let results: Vec<_> = lines
            .into_iter()
            .enumerate()
            .map(|(i, line)| {
                fitting.result(i).unwrap_or_else(|| Err(line.err().unwrap_or(Refusal::Absent)))
            })
            .collect();
        let fits = || results.iter().map(|result| result.as_ref().ok());
        let sample_time = settings.machine.sample_time;
        let mut profiling = Profiling::new(settings.machine.stroke, sample_time, fits());
        surveyed.read(fitted, &mut profiling)?;
        let profiles: Vec<Option<Profile>> =
            (0..results.len()).map(|i| profiling.result(i)).collect();
        let known = fits().zip(&profiles).map(|(fit, profile)| fit.zip(profile.as_ref()));
        let mut scattering = Scattering::new(sample_time, known);
        let mut trying = Trying::new(fits(), tables::block(settings));
        surveyed.read(tried, (&mut trying, &mut scattering))?;
        let bound = trying.bound(self.false_alarms_per_year, sample_time);
        let sequential = profiles
            .into_iter()
            .enumerate()
            .map(|(i, profile)| profile.zip(scattering.result(i)))
            .collect::<Vec<_>>();
        let designs: Vec<_> = sequential
            .iter()
            .map(|both| {
                both.as_ref().map(|(profile, scatter)| scatter.design(profile, sample_time))
            })
            .collect();
        let mut watch = Watch::new(designs.iter().map(Option::as_ref), tables::block(settings));
        surveyed.read(tried, &mut watch)?;
        let per_year = self.false_alarms_per_year;
        let by_rate = sequential::level(per_year, settings.machine.cylinders, sample_time);
        let level = watch.level(per_year, sample_time).filter(|level| level.nats > by_rate);
        let cylinders = numbers.zip(results).zip(trying.into_cylinders()).zip(sequential);
        let cylinder = |(((number, result), tried), sequential): (((u8, Result<_, _>), _), _)| {
            CylinderCalibration {
                number,
                sequential,
                remarks: if result.is_ok() {
                    let index = usize::from(number) - 1;
                    let mut remarks = gathering.remarks(index);
                    remarks.extend(scattering.remark(index));
                    remarks
                } else {
                    vec![]
                },
                result,
                tried,
            }
        };
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
            cylinders: cylinders.map(cylinder).collect(),
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
