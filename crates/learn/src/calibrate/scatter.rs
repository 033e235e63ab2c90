//! Distribution of healthy residuals of a [`Profile`], each judged by what was learnt from another
//! part of the recording.

use super::division::{Division, Halves};
use super::fitting::Fitted;
use super::fluctuating::{self, GatheredExcursions, LearntExcursions};
use super::predicting::{Predicted, Predicting};
use super::profile::Profile;
use super::residuals::{Residual, Residuals, deviation};
use super::spreading::ResidualSpread;
use crate::survey::{Row, Surveyor};
use tertius_config::design;
use tertius_config::settings::CylinderSequential;
use tertius_core::sequential::clip::Clip;
use tertius_core::sequential::dependence::Measuring;
use tertius_core::sequential::pair::Prediction;
use tertius_core::sequential::rate::Of;
use tertius_core::sequential::reference::DOUBTED;
use tertius_core::sequential::samples::{History, Sample};
use tertius_core::sequential::statistic::{Bands, DEAD_BAND, Dependence, INDEPENDENT, Scales};
use tertius_core::sequential::wild::Outliers;
use tertius_core::sequential::{
    Design, Magnitudes, Noise, Pair, PairDesign, Rate, SequentialParameters,
};

/// Initial width of the bins of magnitudes, m.
const BIN: f64 = 1e-6;

/// Fewest samples in motion, none repeated, for a rate function: with this many the deviation is
/// known to 5 %.
const LEAST_SAMPLES: u64 = 200;

/// Number of samples below which a remark says how well the result is known: a minute at 50 Hz.
const MANY_SAMPLES: u64 = 3000;

/// Largest error of a prediction, in deviations of the residual, with which a fault can be located:
/// beyond it the command does not move the rod as the drive assumes.
const FARTHEST_OFF: f64 = 4.0;

/// Distribution of one cylinder's residuals.
#[derive(Clone, Debug, PartialEq)]
pub struct Scatter {
    /// Rate function of the weighted residual.
    pub rate: Rate,
    /// Rate function of the square of the weighted residual.
    pub square_rate: Rate,
    /// Dependence of the residuals in a window.
    pub dependence: Dependence,
    /// Expected wild samples.
    pub outliers: Outliers,
    /// Standard deviation of the residual at any speed, m, without wild samples.
    pub deviation: f64,
    /// Growth of the scatter with the speed, and the resolution of the readings.
    pub spread: ResidualSpread,
    /// Accuracy of the command's prediction; `None` without a drive that predicts.
    pub prediction: Option<Predicted>,
    pub samples: u64,
    /// Largest residual, m.
    pub largest: f64,
    /// Limits by the excursions of transducers that fluctuate; `None` where they do not, or too little is known of it.
    pub excursions: Option<LearntExcursions>,
}

impl Scatter {
    /// The detector from these tables, with a level that nothing reaches.
    pub fn design(&self, profile: &Profile, sample_time: f64) -> Design {
        design::sequential(&self.table(profile, sample_time), sample_time)
    }

    /// The table in a configuration, without a level.
    pub(super) fn table(&self, profile: &Profile, sample_time: f64) -> CylinderSequential {
        let reference = &profile.reference;
        CylinderSequential {
            sample_time: Some(sample_time),
            level: None,
            first: reference.first,
            spacing: reference.spacing,
            nodes: reference.nodes.clone(),
            node_deviations: reference.doubts.iter().map(|doubt| doubt / DOUBTED).collect(),
            samples: profile.samples.clone(),
            velocity: reference.velocity,
            outlier_share: self.outliers.share,
            deviation: self.deviation,
            noise: self.spread.noise.rest,
            timing: self.spread.noise.timing,
            resolution: self.spread.resolution,
            rate_spacing: self.rate.spacing(),
            rate: self.rate.values(),
            square_rate: self.square_rate.values(),
            mean_dependence: self.dependence[0],
            square_dependence: self.dependence[1],
            drive: profile.drive.map(|drive| drive.0),
            prediction: self.prediction.map_or(0.0, |it| it.deviation),
            prediction_correlation: self.prediction.and_then(|it| it.correlation),
            excursions: self.excursions.as_ref().map(LearntExcursions::table),
        }
    }
}

/// Dependence that all lots have in common: the lower median for each width, since a fault in one
/// place affects at most two of the four lots.
fn common(mut lots: Vec<Dependence>) -> Dependence {
    let middle = (lots.len() - 1) / 2;
    let mut common = lots[0];
    for (what, widths) in common.iter_mut().enumerate() {
        for (index, value) in widths.iter_mut().enumerate() {
            lots.sort_by(|one, other| one[what][index].total_cmp(&other[what][index]));
            *value = lots[middle][what][index];
        }
    }
    common
}

/// Judges the profile of every cylinder that has one.
#[derive(Clone, Debug)]
pub struct Scattering {
    cylinders: Vec<Option<Judged>>,
}

#[derive(Clone, Debug)]
struct Judged {
    residuals: Residuals,
    spread: ResidualSpread,
    noise: Noise,
    bands: Bands,
    pair: Option<Pair>,
    /// Magnitudes of the weighted residuals.
    magnitudes: Magnitudes,
    /// Number of residuals that are not wild, and the sum of their squares, m².
    healthy: (u64, f64),
    /// Largest residual that is not wild, m.
    largest: f64,
    history: History,
    /// Dependence by lots of blocks.
    measuring: Vec<Measuring>,
    division: Division,
    predicting: Predicting,
    excursions: GatheredExcursions,
}

impl Scattering {
    /// A pass over cylinders with these lines, profiles and spreads, judged by the references from
    /// the halves of `division`, sampled every `sample_time` seconds, with the expected `outliers`.
    pub fn new<'a>(
        sample_time: f64,
        outliers: Outliers,
        division: &Division,
        cylinders: impl IntoIterator<Item = Option<(&'a Fitted, &'a (Profile, Halves), ResidualSpread)>>,
    ) -> Self {
        let judged = |(fitted, taught, spread): (&Fitted, &(Profile, Halves), ResidualSpread)| {
            let (profile, halves) = taught;
            let deviation = deviation(fitted);
            let design = |drive| {
                let (prediction, parameters) =
                    (Prediction::UNKNOWN, &SequentialParameters::DEFAULT);
                PairDesign::new(drive, sample_time, deviation, prediction, parameters).ok()
            };
            let ResidualSpread { noise, resolution } = spread;
            Judged {
                residuals: Residuals::new(sample_time, fitted, division.clone(), halves.clone()),
                spread,
                noise: noise.relied_on(),
                bands: Bands::new(noise.rest, DEAD_BAND, resolution, outliers),
                pair: profile.drive.and_then(design).map(Pair::new),
                magnitudes: Magnitudes::new(BIN),
                healthy: (0, 0.0),
                largest: 0.0,
                history: History::default(),
                measuring: vec![Measuring::default(); division.lots()],
                division: division.clone(),
                predicting: Predicting::default(),
                excursions: GatheredExcursions::new(noise.relied_on(), resolution, sample_time),
            }
        };
        Self { cylinders: cylinders.into_iter().map(|all| all.map(judged)).collect() }
    }

    /// The scatter of the cylinder of `index` (from 0); `None` where there were not enough data.
    pub fn result(&self, index: usize) -> Option<Scatter> {
        let Judged { magnitudes, predicting, measuring, spread, bands, healthy, .. } =
            self.cylinders[index].as_ref()?;
        if magnitudes.total() < LEAST_SAMPLES {
            return None;
        }
        let (rest, outliers) = (spread.noise.rest, bands.outliers());
        let rate = Rate::of(magnitudes, Of::Mean, rest, outliers)?;
        let square_rate = Rate::of(magnitudes, Of::Square, rest, outliers)?;
        let deviation = (healthy.1 / healthy.0.max(1) as f64).sqrt().max(rest);
        let scales = Scales::new(rate.clone(), square_rate.clone(), INDEPENDENT, bands.clone());
        Some(Scatter {
            rate,
            square_rate,
            dependence: common(measuring.iter().map(|lot| lot.dependence(&scales)).collect()),
            deviation,
            outliers,
            spread: *spread,
            prediction: predicting.result().filter(|it| it.deviation <= FARTHEST_OFF * deviation),
            samples: magnitudes.total(),
            largest: self.cylinders[index].as_ref()?.largest,
            excursions: None,
        })
    }

    /// Limits of every cylinder by the excursions of its transducers, at this `level`, nats.
    pub fn excursions(&self, level: f64, sample_time: f64) -> Vec<Option<LearntExcursions>> {
        let gathered = self.cylinders.iter().map(|one| Some(&one.as_ref()?.excursions));
        fluctuating::learn(gathered.collect(), level, sample_time)
    }

    /// Why there is no result, or an uncertain one, for the cylinder of `index` (from 0), in words;
    /// `None` where the result is good, or there was nothing to make it from.
    pub fn remark(&self, index: usize) -> Option<String> {
        let samples = self.cylinders[index].as_ref()?.magnitudes.total();
        if samples >= MANY_SAMPLES {
            return None;
        }
        let (told, then) = if samples < LEAST_SAMPLES {
            ("no tables for the sequential detector", format!("it takes {LEAST_SAMPLES}"))
        } else {
            let known = 100.0 / (2.0 * samples as f64).sqrt();
            let then = format!("their scatter is known to {known:.1} %");
            ("too little for a reliable sequential detector", then)
        };
        Some(format!(
            "{told}: where one part has been, the other has {samples} samples in motion, and {then}; \
             record more motion"
        ))
    }
}

impl Surveyor for Scattering {
    fn row(&mut self, row: &Row) {
        if let Some(judged) = self.cylinders[usize::from(row.cylinder) - 1].as_mut() {
            judged.take(row);
        }
    }

    fn gap(&mut self, cylinder: u8) {
        if let Some(judged) = self.cylinders[usize::from(cylinder) - 1].as_mut() {
            judged.interrupt();
        }
    }
}

impl Judged {
    fn interrupt(&mut self) {
        self.residuals.interrupt();
        self.history.clear();
        self.excursions.interrupt();
        if let Some(pair) = &mut self.pair {
            pair.reset();
        }
        self.predicting.restart();
    }

    fn take(&mut self, row: &Row) {
        if !row.monitored {
            self.residuals.leave();
            return self.interrupt();
        }
        let residual = self.residuals.take(row);
        let beyond = residual.and_then(|residual| residual.beyond);
        let weighed =
            |it: &Residual| it.beyond.map(|beyond| self.noise.share(it.velocity) * beyond);
        if residual.as_ref().and_then(weighed).is_some_and(|it| it.abs() > self.bands.farthest()) {
            self.predicting.disturb();
        }
        if let Some(pair) = &mut self.pair {
            pair.step(row.c1.zip(beyond).map(|(c1, beyond)| [c1, c1 - beyond]), row.u);
            match pair.newest() {
                Some(innovations) => self.predicting.take(innovations),
                None => self.predicting.interrupt(),
            }
        }
        let Some((residual, beyond)) = residual.zip(beyond) else {
            return self.excursions.interrupt();
        };
        self.excursions.take(beyond, residual.velocity);
        let share = self.noise.share(residual.velocity);
        let sample = Sample { residual: beyond, share, doubt: residual.doubt };
        self.history.push(sample, &Clip::new(&self.bands), residual.independence);
        if residual.in_motion().is_some() {
            let weighed = sample.share * beyond;
            self.magnitudes.add(weighed);
            self.measuring[self.division.lot(row.t)].take(&self.history, &self.bands);
            self.largest = self.largest.max(beyond.abs());
            if weighed.abs() <= self.bands.farthest() {
                self.healthy = (self.healthy.0 + 1, self.healthy.1 + beyond * beyond);
            }
        }
    }
}
