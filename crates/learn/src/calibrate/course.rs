//! A calibration from beginning to end, on a recording that can be read repeatedly.

use super::constancy::{Constancies, LastingStep};
use super::cutting::{Cuts, are_few, places};
use super::watch::{OwnLevel, Watch};
use super::{
    Bound, CalibrationRefusal, Contradiction, CylinderCalibration, Division, Fitting, Gathering,
    Halves, Profile, Profiling, Scatter, Scattering, Spreading, Trying,
};
use crate::relate::{LearntProcess, ProcessRefusal, ProcessRows, SupplyRows};
use crate::survey::{Recording, Timeline, Window};
use tertius_config::settings::{Cylinder, CylinderSequential, Settings, SupplyTable};
use tertius_core::sequential;
use tertius_core::sequential::wild::Outliers;

/// Inputs of a calibration.
#[derive(Clone, Copy, Debug)]
pub struct CalibrationCourse<'a> {
    pub settings: &'a Settings,
    /// Times of the recording's frames; the default where the recording has no pause.
    pub timeline: &'a Timeline,
    /// Part of the recording that is fitted; where it equals `tried`, its blocks alternate
    /// ([`Division`]).
    pub fitted: Window,
    /// Part of the recording on which the fit is validated.
    pub tried: Window,
    /// Wanted false alarms a year, all cylinders together.
    pub per_year: f64,
}

/// Result of a [`CalibrationCourse`].
#[derive(Clone, Debug)]
pub struct Calibrated {
    /// Results of all configured cylinders, from cylinder 1.
    pub cylinders: Vec<CylinderCalibration>,
    /// Bound of R3, see [`super::Calibration::bound`].
    pub bound: Option<Bound>,
    /// What the supply's pressure does, see [`super::Calibration::supply`].
    pub supply: Option<Result<SupplyTable, ProcessRefusal>>,
}

/// Profiles of each cylinder, from all of the recording and from each half.
type Profiles = Vec<Option<(Profile, Halves)>>;

/// What was learnt for the process detectors: of each cylinder, and of the supply.
type LearntRelations = (Vec<LearntProcess>, Option<Result<SupplyTable, ProcessRefusal>>);

/// What was learnt of each cylinder.
struct Taught {
    gathering: Gathering,
    results: Vec<Result<super::Fitted, CalibrationRefusal>>,
    profiles: Profiles,
    /// Over all of the recording, whatever is cut out.
    constancies: Constancies,
    scattering: Scattering,
    trying: Trying,
    sequential: Vec<Option<(Profile, Scatter)>>,
    levels: Vec<Option<OwnLevel>>,
    process: Vec<LearntProcess>,
    supply: Option<Result<SupplyTable, ProcessRefusal>>,
}

impl CalibrationCourse<'_> {
    /// Reads `recording` six times: for a census, the line, the profile along the stroke, the
    /// validation, the scatter, and the resulting detectors; and once more where spool or pressures are named. If a few minutes of it contradict the
    /// detectors, they are cut out and all readings are repeated.
    ///
    /// # Errors
    /// The recording's own.
    pub fn run<R: Recording>(&self, recording: &R) -> Result<Calibrated, R::Error> {
        let none = Cuts::none(usize::from(self.settings.machine.cylinders));
        let taught = self.teach(recording, &none)?;
        let (cuts, cut) = self.cuts(&taught);
        let mut taught = if cut { self.teach(recording, &cuts)? } else { taught };
        (taught.process, taught.supply) = self.process(recording, &cuts, &taught)?;
        Ok(self.conclude(taught, &cuts))
    }

    /// What spool and pressures of every cylinder say of each other, and the supply's pressure of what all rods take;
    /// nothing where the configuration does not name them.
    fn process<R: Recording>(
        &self,
        recording: &R,
        cuts: &Cuts,
        taught: &Taught,
    ) -> Result<LearntRelations, R::Error> {
        let settings = self.settings;
        if !ProcessRows::are_named(settings) && !SupplyRows::are_named(settings) {
            return Ok((Vec::new(), None));
        }
        let (mut rows, mut supply) = (ProcessRows::new(settings), SupplyRows::new(settings));
        recording.read(self.whole(), cuts.around((&mut rows, &mut supply)))?;
        let ranking = self.timeline.ranking();
        let supply = SupplyRows::are_named(settings)
            .then(|| supply.learn(&ranking, settings.process_level()));
        let gain =
            |fitted: &Result<super::Fitted, _>| fitted.as_ref().map_or(1.0, |it| it.line.gain);
        let gains: Vec<f64> = taught.results.iter().map(gain).collect();
        Ok((rows.learn(settings, &ranking, &gains), supply))
    }

    fn division(&self) -> Division {
        Division::new(self.fitted, self.tried, self.timeline.ranking())
    }

    const fn outliers(&self) -> Outliers {
        Outliers { share: self.settings.sequential.outlier_share }
    }

    /// Window of everything that is read.
    fn whole(&self) -> Window {
        let Self { fitted, tried, .. } = self;
        Window { from: fitted.from.min(tried.from), to: fitted.to.max(tried.to) }
    }

    fn teach<R: Recording>(&self, recording: &R, cuts: &Cuts) -> Result<Taught, R::Error> {
        let Self { settings, tried, .. } = *self;
        let (sample_time, division) = (settings.machine.sample_time, self.division());
        let (gathering, results) = self.lines(recording, cuts)?;
        let fits = || results.iter().map(|result| result.as_ref().ok());
        let lines = results.iter().enumerate().map(|(index, result)| match result {
            Ok(fitted) => Some(fitted.line),
            Err(refusal) if refusal.may_be_a_step() => gathering.line(index),
            Err(_) => None,
        });
        let mut constancies = Constancies::new(self.timeline.ranking(), lines);
        let profiles = self.profiles(recording, (cuts, &mut constancies), &results)?;
        let halves = fits().zip(&profiles).map(|(fit, taught)| {
            let (_, halves) = taught.as_ref()?;
            Some((fit?, halves))
        });
        let mut spreading = Spreading::new(sample_time, &division, halves);
        let mut trying = Trying::new(fits(), settings.warning_cycles());
        let both = (&mut trying, &mut spreading);
        recording.read(tried, cuts.around(both))?;
        let spread = fits()
            .zip(&profiles)
            .enumerate()
            .map(|(index, (fit, taught))| Some((fit?, taught.as_ref()?, spreading.result(index)?)));
        let mut scattering = Scattering::new(sample_time, self.outliers(), &division, spread);
        recording.read(tried, cuts.around(&mut scattering))?;
        let level = sequential::level(
            self.per_year,
            settings.machine.cylinders,
            settings.machine.sample_time,
        );
        let mut excursions = scattering.excursions(level, sample_time);
        let mut judge = |(i, taught): (usize, &Option<(Profile, Halves)>)| {
            let scatter = scattering.result(i)?;
            let scatter = Scatter { excursions: excursions[i].take(), ..scatter };
            judged(taught.as_ref()?.0.clone(), scatter)
        };
        let sequential: Vec<_> = profiles.iter().enumerate().map(&mut judge).collect();
        let mut taught = Taught {
            gathering,
            results,
            profiles,
            constancies,
            scattering,
            trying,
            sequential,
            levels: Vec::new(),
            process: Vec::new(),
            supply: None,
        };
        taught.levels = self.levels(recording, cuts, &taught)?;
        Ok(taught)
    }

    /// Profile of each cylinder along its stroke; `constancies` share the pass.
    fn profiles<R: Recording>(
        &self,
        recording: &R,
        (cuts, constancies): (&Cuts, &mut Constancies),
        results: &[Result<super::Fitted, CalibrationRefusal>],
    ) -> Result<Profiles, R::Error> {
        let machine = &self.settings.machine;
        let fits = results.iter().map(|result| result.as_ref().ok());
        let mut profiling =
            Profiling::new(self.division(), machine.stroke, machine.sample_time, fits);
        recording.read(self.whole(), (cuts.around(&mut profiling), constancies))?;
        Ok((0..results.len()).map(|index| profiling.result(index)).collect())
    }

    /// a and b of every cylinder, and the data that they were fitted to.
    #[expect(clippy::type_complexity, reason = "it is used once")]
    fn lines<R: Recording>(
        &self,
        recording: &R,
        cuts: &Cuts,
    ) -> Result<(Gathering, Vec<Result<super::Fitted, CalibrationRefusal>>), R::Error> {
        let settings = self.settings;
        let [low, high] = settings.machine.stroke;
        let configured = |n| {
            let calibration = settings.comparator_of(n);
            (calibration != (1.0, 0.0)).then_some(calibration)
        };
        let numbers = 1..=settings.machine.cylinders;
        let mut gathering = Gathering::new(high - low, numbers.clone().map(configured).collect());
        recording.read(self.fitted, cuts.around(&mut gathering))?;
        let judge = |n: u8| {
            if settings.has_c2(n) {
                gathering.judge(usize::from(n) - 1)
            } else {
                Err(CalibrationRefusal::NoSecond)
            }
        };
        let lines: Vec<_> = numbers.map(judge).collect();
        let mut fitting = Fitting::new(lines.iter().map(|line| line.as_ref().ok().copied()));
        recording.read(self.fitted, cuts.around(&mut fitting))?;
        let results = lines.into_iter().enumerate().map(|(i, line)| {
            fitting
                .result(i)
                .unwrap_or_else(|| Err(line.err().unwrap_or(CalibrationRefusal::Absent)))
        });
        let results = results.collect();
        Ok((gathering, results))
    }

    /// Levels that the resulting detectors need for this recording.
    fn levels<R: Recording>(
        &self,
        recording: &R,
        cuts: &Cuts,
        taught: &Taught,
    ) -> Result<Vec<Option<OwnLevel>>, R::Error> {
        let sample_time = self.settings.machine.sample_time;
        let design = |both: &Option<(Profile, Scatter)>| {
            both.as_ref().map(|(profile, scatter)| scatter.design(profile, sample_time))
        };
        let designs: Vec<_> = taught.sequential.iter().map(design).collect();
        let crossed = designs.iter().zip(&taught.profiles).map(|(design, taught)| {
            let halves = taught.as_ref().map(|(_, halves)| halves);
            design.as_ref().zip(halves)
        });
        let mut watch = Watch::crossed(crossed, &self.division(), cuts, sample_time);
        recording.read(self.tried, &mut watch)?;
        Ok(watch.levels(self.per_year))
    }

    /// Parts to be cut out, and whether there are any. A fault occurs in one or two places;
    /// evidence that recurs belongs to the machine, and is reported.
    fn cuts(&self, taught: &Taught) -> (Cuts, bool) {
        let mut cuts = Cuts::none(taught.levels.len());
        let (mut any, length) = (false, self.whole().length());
        for (index, level) in taught.levels.iter().enumerate() {
            let Some(level) = level.as_ref().filter(|it| it.contradiction().is_some()) else {
                continue;
            };
            let places = places(level.beyond());
            if !places.is_empty() && are_few(&places, length) {
                any = true;
                places.into_iter().for_each(|place| cuts.add(index, place));
            }
        }
        (cuts, any)
    }

    fn conclude(&self, taught: Taught, cuts: &Cuts) -> Calibrated {
        let Taught { gathering, results, scattering, trying, sequential, levels, .. } = taught;
        let (process, supply) = (taught.process, taught.supply);
        let settings = self.settings;
        let sample_time = settings.machine.sample_time;
        let step = |index| taught.constancies.step(index, cuts.of(index));
        let steps: Vec<Option<LastingStep>> = (0..results.len()).map(step).collect();
        // What contradicts is no measure for the others.
        let contradicts = |index: usize| {
            let level = levels[index].as_ref();
            steps[index].is_some() || level.is_some_and(|it| it.contradiction().is_some())
        };
        let bound = trying.bound(self.per_year, sample_time, |index| !contradicts(index));
        let by_rate = sequential::level(self.per_year, settings.machine.cylinders, sample_time);
        // What one part has taught and another one confirmed is no reason for a lower level.
        let given = |nats: &f64| self.division().alternates() || *nats > by_rate;
        let learnt =
            (1..).zip(results).zip(trying.into_cylinders()).zip(sequential.into_iter().zip(levels));
        let cylinder = |(((number, result), tried), (sequential, level)): Learnt| {
            let index = usize::from(number) - 1;
            let contradiction = level.as_ref().and_then(Contradiction::of);
            // Only of cylinders that have a calibration, or were refused one as a step has them refused.
            let result = match steps[index] {
                Some(LastingStep { between: [from, to], size }) => {
                    Err(CalibrationRefusal::Steps { from, to, size_mm: size * 1e3 })
                }
                None => result,
            };
            let mut remarks = Vec::new();
            let learnt = || process.get(index).into_iter().flat_map(LearntProcess::remarks);
            if result == Err(CalibrationRefusal::NoSecond) {
                remarks.push(ALONE.to_owned());
                remarks.extend(learnt());
            }
            if result.is_ok() {
                remarks.extend(gathering.remarks(index));
                remarks.extend(scattering.remark(index));
                remarks.extend(cuts.told(index));
                remarks.extend(level.as_ref().and_then(OwnLevel::remark));
                remarks.extend(learnt());
            }
            CylinderCalibration {
                sample_time,
                number,
                result,
                tried,
                sequential: sequential.filter(|_| contradiction.is_none()),
                level: level.and_then(|level| level.nats()).filter(given),
                contradiction,
                process: process.get(index).cloned(),
                left_out: cuts.of(index).to_vec(),
                remarks,
            }
        };
        Calibrated { cylinders: learnt.map(cylinder).collect(), bound, supply }
    }
}

/// What is not learnt of a cylinder without C2.
const ALONE: &str = "it has no C2, so nothing of C1 - C2 is learnt: no correction, no part in the bound of R3, no \
                     sequential detector, and no process detector by the flow; drifts of C1, and steps below δ_h, are not \
                     found";

/// Everything learnt of one cylinder.
type Learnt = (
    ((u8, Result<super::Fitted, CalibrationRefusal>), Option<super::TriedBand>),
    (Option<(Profile, Scatter)>, Option<OwnLevel>),
);

/// Drops a drive that does not predict in the validation.
fn judged(profile: Profile, scatter: Scatter) -> Option<(Profile, Scatter)> {
    let drive = profile.drive.filter(|_| scatter.prediction.is_some());
    Some((Profile { drive, ..profile }, scatter))
}

impl CylinderCalibration {
    /// Whether the cylinder has a C2 that could be calibrated.
    pub fn has_c2(&self) -> bool {
        self.result != Err(CalibrationRefusal::NoSecond)
    }

    /// The cylinder's table in a configuration; `None` where it was refused, or has no C2 and nothing else was learnt.
    pub fn table(&self) -> Option<Cylinder> {
        let process = self.process.as_ref().and_then(|learnt| learnt.table(self.sample_time));
        if !self.has_c2() {
            let alone = Cylinder { c2: false, ..Cylinder::new(self.number) };
            return process.map(|process| Cylinder { process: Some(process), ..alone });
        }
        let line = self.result.as_ref().ok()?.line;
        Some(Cylinder {
            c2_gain: line.gain,
            c2_offset: line.offset,
            process,
            sequential: self.sequential.as_ref().map(|(profile, scatter)| CylinderSequential {
                level: self.level,
                ..scatter.table(profile, self.sample_time)
            }),
            ..Cylinder::new(self.number)
        })
    }
}
