//! How healthy residuals of a [`Profile`] scatter, each judged by what another part of the recording
//! has taught.

use super::division::{Division, Halves};
use super::fitting::Fitted;
use super::predicting::{Predicted, Predicting};
use super::profile::Profile;
use super::residuals::{Residual, Residuals, deviation};
use super::spreading::Spread;
use crate::survey::{Row, Surveyor};
use tertius_core::sequential::clip::Clip;
use tertius_core::sequential::dependence::Measuring;
use tertius_core::sequential::pair::Prediction;
use tertius_core::sequential::rate::Of;
use tertius_core::sequential::samples::{History, Sample};
use tertius_core::sequential::statistic::{Bands, DEAD_BAND, Dependence, INDEPENDENT, Scales};
use tertius_core::sequential::wild::Outliers;
use tertius_core::sequential::{Design, Magnitudes, Noise, Pair, PairDesign, Parameters, Rate};

/// The first width of the bins of magnitudes, m.
const BIN: f64 = 1e-6;

/// Samples in motion, none repeated, that a rate function is made of at least: the deviation of so many is
/// known to 5 %.
const LEAST_SAMPLES: u64 = 200;

/// Of fewer it is said how well it is known: a minute at 50 Hz.
const MANY_SAMPLES: u64 = 3000;

/// A prediction that is off by more than so many deviations of the residual tells no transducer from
/// another: the command does not drive the rod as its drive has it.
const FARTHEST_OFF: f64 = 4.0;

/// What one cylinder's residuals were.
#[derive(Clone, Debug, PartialEq)]
pub struct Scatter {
    /// Of the weighed residual, and of its square.
    pub rate: Rate,
    pub square_rate: Rate,
    /// How much of a window of residuals is news.
    pub dependence: Dependence,
    /// What was expected of wild samples.
    pub outliers: Outliers,
    /// Standard deviation of the residual, m, whatever the speed, wild samples left out.
    pub deviation: f64,
    /// How it goes with the speed, and what the readings move in.
    pub spread: Spread,
    /// `None` without a drive that predicts.
    pub prediction: Option<Predicted>,
    pub samples: u64,
    /// m.
    pub largest: f64,
}

impl Scatter {
    /// The detector that these make, with a level that nothing reaches.
    pub fn design(&self, profile: &Profile, sample_time: f64) -> Design {
        let prediction =
            self.prediction.as_ref().map_or(Prediction::UNKNOWN, Predicted::prediction);
        let pair = profile.drive.and_then(|drive| {
            let parameters = &Parameters::DEFAULT;
            PairDesign::new(drive, sample_time, self.deviation, prediction, parameters).ok()
        });
        Design {
            reference: profile.reference.clone(),
            rate: self.rate.clone(),
            square_rate: self.square_rate.clone(),
            dependence: self.dependence,
            deviation: self.deviation,
            noise: self.spread.noise,
            resolution: self.spread.resolution,
            outliers: self.outliers,
            pair,
            level: f64::INFINITY,
            sample_time,
            clear: 1,
            parameters: &Parameters::DEFAULT,
        }
    }
}

/// What all lots have in common: of each width the lower median, since a fault in one place is in two
/// of four at the most.
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
    spread: Spread,
    noise: Noise,
    bands: Bands,
    pair: Option<Pair>,
    /// Of the weighed residuals.
    magnitudes: Magnitudes,
    /// Of those that are not wild, as they are: their number, their squares, m², and the largest of
    /// all, m.
    healthy: (u64, f64),
    largest: f64,
    history: History,
    /// By lots of blocks.
    measuring: Vec<Measuring>,
    division: Division,
    predicting: Predicting,
}

impl Scattering {
    /// Of cylinders with these lines, profiles and spreads, and what the halves of `division` have taught
    /// of each, sampled every `sample_time` seconds, with so many `outliers`.
    pub fn new<'a>(
        sample_time: f64,
        outliers: Outliers,
        division: Division,
        cylinders: impl IntoIterator<Item = Option<(&'a Fitted, &'a (Profile, Halves), Spread)>>,
    ) -> Self {
        let judged = |(fitted, taught, spread): (&Fitted, &(Profile, Halves), Spread)| {
            let (profile, halves) = taught;
            let deviation = deviation(fitted);
            let design = |drive| {
                let (prediction, parameters) = (Prediction::UNKNOWN, &Parameters::DEFAULT);
                PairDesign::new(drive, sample_time, deviation, prediction, parameters).ok()
            };
            let Spread { noise, resolution } = spread;
            Judged {
                residuals: Residuals::new(sample_time, fitted, division, halves.clone()),
                spread,
                noise: noise.relied_on(),
                bands: Bands::new(noise.rest, DEAD_BAND, resolution, outliers),
                pair: profile.drive.and_then(design).map(Pair::new),
                magnitudes: Magnitudes::new(BIN),
                healthy: (0, 0.0),
                largest: 0.0,
                history: History::default(),
                measuring: vec![Measuring::default(); division.lots()],
                division,
                predicting: Predicting::default(),
            }
        };
        Self { cylinders: cylinders.into_iter().map(|all| all.map(judged)).collect() }
    }

    /// What came of the cylinder of `index` (from 0); `None` where there was too little.
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
        })
    }

    /// Why there is no result for the cylinder of `index` (from 0), or not much of one, for a person;
    /// `None` where there is, or nothing to make it from.
    pub fn remark(&self, index: usize) -> Option<String> {
        let samples = self.cylinders[index].as_ref()?.magnitudes.total();
        if samples >= MANY_SAMPLES {
            return None;
        }
        let (told, then) = if samples < LEAST_SAMPLES {
            ("no tables for the sequential detector", format!("it takes {LEAST_SAMPLES}"))
        } else {
            let known = 100.0 / (2.0 * samples as f64).sqrt();
            let then = format!("what they scatter by is known to {known:.1} %");
            ("little for the sequential detector to go by", then)
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
        if let Some(pair) = &mut self.pair {
            pair.reset();
        }
        self.predicting.interrupt();
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
        let Some((residual, beyond)) = residual.zip(beyond) else { return };
        let share = self.noise.share(residual.velocity);
        let sample = Sample { residual: beyond, share, doubt: residual.doubt };
        self.history.push(sample, &Clip::new(&self.bands), residual.news);
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
