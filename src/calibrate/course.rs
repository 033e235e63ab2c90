//! A calibration from beginning to end, on whatever can be read again and again.

use super::{
    Bound, CylinderCalibration, Fitting, Gathering, Profile, Profiling, Refusal, Scatter,
    Scattering, Spreading, Trying,
};
use crate::config::settings::{Cylinder, CylinderSequential, Settings};
use crate::sequential;
use crate::survey::{Surveyor, Window};
use crate::tune::sequential::{Level, Watch};

/// A recording that can be read as often as needed, the same each time.
pub trait Recording {
    type Error;

    /// Shows what is within `window` to `surveyor`.
    ///
    /// # Errors
    /// It cannot be read any more.
    fn read(&self, window: Window, surveyor: impl Surveyor) -> Result<(), Self::Error>;
}

/// What a calibration is made with.
#[derive(Clone, Copy, Debug)]
pub struct Course<'a> {
    pub settings: &'a Settings,
    /// The part that is fitted, and the part on which the fit is tried.
    pub fitted: Window,
    pub tried: Window,
    /// False alarms that a year may bring, all cylinders together.
    pub per_year: f64,
}

/// What came of a [`Course`].
#[derive(Clone, Debug)]
pub struct Calibrated {
    /// Of every configured cylinder, from 1.
    pub cylinders: Vec<CylinderCalibration>,
    /// See [`super::Calibration::bound`].
    pub bound: Option<Bound>,
    /// See [`super::Calibration::level`].
    pub level: Option<Level>,
}

impl Course<'_> {
    /// Reads `recording` six times: what is in it, the line, what bends along it, the trial, the scatter,
    /// and the detectors that follow.
    ///
    /// # Errors
    /// The recording's own.
    pub fn run<R: Recording>(&self, recording: &R) -> Result<Calibrated, R::Error> {
        let Self { settings, fitted, tried, per_year } = *self;
        let sample_time = settings.machine.sample_time;
        let (gathering, results) = self.lines(recording)?;
        let fits = || results.iter().map(|result| result.as_ref().ok());
        let mut profiling = Profiling::new(settings.machine.stroke, sample_time, fits());
        recording.read(fitted, &mut profiling)?;
        let profiles: Vec<Option<Profile>> =
            (0..results.len()).map(|i| profiling.result(i)).collect();
        let known = || fits().zip(&profiles).map(|(fit, profile)| fit.zip(profile.as_ref()));
        let mut spreading = Spreading::new(sample_time, known());
        let mut trying = Trying::new(fits(), settings.warning_cycles());
        recording.read(tried, (&mut trying, &mut spreading))?;
        let spread = known().enumerate().map(|(index, known)| {
            let ((fit, profile), spread) = known.zip(spreading.result(index))?;
            Some((fit, profile, spread))
        });
        let mut scattering = Scattering::new(sample_time, spread);
        recording.read(tried, &mut scattering)?;
        let bound = trying.bound(per_year, sample_time);
        let sequential: Vec<Option<(Profile, Scatter)>> = (0..)
            .zip(profiles)
            .map(|(i, profile)| judged(profile?, scattering.result(i)?))
            .collect();
        let level = self.level(recording, &sequential)?;
        let learnt = (1..).zip(results).zip(trying.into_cylinders()).zip(sequential);
        let cylinder = |(((number, result), tried), sequential): (((u8, Result<_, _>), _), _)| {
            let index = usize::from(number) - 1;
            let mut remarks = Vec::new();
            if result.is_ok() {
                remarks.extend(gathering.remarks(index));
                remarks.extend(scattering.remark(index));
            }
            CylinderCalibration { sample_time, number, result, tried, sequential, remarks }
        };
        Ok(Calibrated { cylinders: learnt.map(cylinder).collect(), bound, level })
    }

    /// a and b of every cylinder, and what there was to make them from.
    #[expect(clippy::type_complexity, reason = "it is used once")]
    fn lines<R: Recording>(
        &self,
        recording: &R,
    ) -> Result<(Gathering, Vec<Result<super::Fitted, Refusal>>), R::Error> {
        let settings = self.settings;
        let [low, high] = settings.machine.stroke;
        let configured = |n| {
            let calibration = settings.comparator_of(n);
            (calibration != (1.0, 0.0)).then_some(calibration)
        };
        let numbers = 1..=settings.machine.cylinders;
        let mut gathering = Gathering::new(high - low, numbers.clone().map(configured).collect());
        recording.read(self.fitted, &mut gathering)?;
        let second = settings.signals.cylinder.c2.is_some();
        let judge = |n: u8| {
            if second { gathering.judge(usize::from(n) - 1) } else { Err(Refusal::NoSecond) }
        };
        let lines: Vec<_> = numbers.map(judge).collect();
        let mut fitting = Fitting::new(lines.iter().map(|line| line.as_ref().ok().copied()));
        recording.read(self.fitted, &mut fitting)?;
        let results = lines.into_iter().enumerate().map(|(i, line)| {
            fitting.result(i).unwrap_or_else(|| Err(line.err().unwrap_or(Refusal::Absent)))
        });
        let results = results.collect();
        Ok((gathering, results))
    }

    /// The level, where the residuals ask for a higher one than the wanted rate does by itself.
    fn level<R: Recording>(
        &self,
        recording: &R,
        sequential: &[Option<(Profile, Scatter)>],
    ) -> Result<Option<Level>, R::Error> {
        let Self { settings, tried, per_year, .. } = *self;
        let sample_time = settings.machine.sample_time;
        let designs: Vec<_> = sequential
            .iter()
            .map(|both| {
                both.as_ref().map(|(profile, scatter)| scatter.design(profile, sample_time))
            })
            .collect();
        let mut watch = Watch::new(designs.iter().map(Option::as_ref), settings.warning_cycles());
        recording.read(tried, &mut watch)?;
        let by_rate = sequential::level(per_year, settings.machine.cylinders, sample_time);
        Ok(watch.level(per_year, sample_time).filter(|level| level.nats > by_rate))
    }
}

/// A drive that has been tried and does not predict is none.
fn judged(profile: Profile, scatter: Scatter) -> Option<(Profile, Scatter)> {
    let drive = profile.drive.filter(|_| scatter.prediction.is_some());
    Some((Profile { drive, ..profile }, scatter))
}

impl CylinderCalibration {
    /// The cylinder's table of a configuration; `None` where it was refused.
    pub fn table(&self) -> Option<Cylinder> {
        let line = self.result.as_ref().ok()?.line;
        Some(Cylinder {
            n: self.number,
            c2_gain: line.gain,
            c2_offset: line.offset,
            theta: None,
            gamma: None,
            command_offset: None,
            sample_time: None,
            sequential: self.sequential.as_ref().map(|(profile, scatter)| {
                let reference = &profile.reference;
                CylinderSequential {
                    sample_time: Some(self.sample_time),
                    first: reference.first,
                    spacing: reference.spacing,
                    nodes: reference.nodes.clone(),
                    samples: profile.samples.clone(),
                    velocity: reference.velocity,
                    deviation: scatter.deviation,
                    noise: scatter.spread.noise.rest,
                    timing: scatter.spread.noise.timing,
                    resolution: scatter.spread.resolution,
                    rate_spacing: scatter.rate.spacing(),
                    rate: scatter.rate.values(),
                    square_rate: scatter.square_rate.values(),
                    mean_dependence: scatter.dependence[0],
                    square_dependence: scatter.dependence[1],
                    drive: profile.drive.map(|drive| drive.0),
                    prediction: scatter.prediction.unwrap_or_default(),
                }
            }),
        })
    }
}
