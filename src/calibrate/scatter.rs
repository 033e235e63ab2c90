//! How healthy residuals of a [`Profile`] scatter, on a part of the recording that it was not
//! fitted to.

use super::fitting::Fitted;
use super::line::Line;
use super::profile::Profile;
use super::resolution::Resolution;
use super::trying::FAULTY;
use crate::sequential::baseline::Baseline;
use crate::sequential::clip::Clip;
use crate::sequential::dependence::Measuring;
use crate::sequential::novelty::{News, Novelty};
use crate::sequential::rate::Of;
use crate::sequential::statistic::{DEAD_BAND, Dependence, History, INDEPENDENT, Scales};
use crate::sequential::velocity::Velocity;
use crate::sequential::{Design, Magnitudes, Pair, PairDesign, Rate, Reference};
use crate::survey::{Row, Surveyor};

/// The first width of the bins of magnitudes, m.
const BIN: f64 = 1e-6;

/// Samples in motion, none repeated, that a rate function is made of at least: the deviation of so many is
/// known to 4 %, and that no sample is more evidence than all of them keeps a detector of few from haste.
const LEAST_SAMPLES: u64 = 300;

/// Of fewer it is said what they are worth: a minute at 50 Hz.
const MANY_SAMPLES: u64 = 3000;

/// A prediction that is off by more than so many deviations of the residual tells no transducer from
/// another: the command does not drive the rod as its drive has it.
const FARTHEST_OFF: f64 = 4.0;

/// Of the deviation that the pair's filter starts from before it is known, m.
const GUESS: f64 = 1e-4;

/// What one cylinder's residuals were.
#[derive(Clone, Debug, PartialEq)]
pub struct Scatter {
    /// Of the residual, and of its square.
    pub rate: Rate,
    pub square_rate: Rate,
    /// How much of a window of residuals is news.
    pub dependence: Dependence,
    /// Standard deviation of the residual, m.
    pub deviation: f64,
    /// What the readings of C1 and of C2 move in, m; 0 where that is not known.
    pub resolution: [f64; 2],
    /// Standard deviation of what both readings differ by from the command's prediction, m: the sum
    /// of the innovations, each with half the weight, times √2. `None` without a drive that predicts.
    pub prediction: Option<f64>,
    pub samples: u64,
    /// m.
    pub largest: f64,
}

impl Scatter {
    /// The detector that these make, with a level that nothing reaches.
    pub fn design(&self, profile: &Profile, sample_time: f64) -> Design {
        let prediction = self.prediction.unwrap_or(0.0);
        let pair = profile
            .drive
            .and_then(|drive| PairDesign::new(drive, sample_time, self.deviation, prediction).ok());
        Design {
            reference: profile.reference.clone(),
            rate: self.rate.clone(),
            square_rate: self.square_rate.clone(),
            dependence: self.dependence,
            deviation: self.deviation,
            resolution: self.resolution,
            pair,
            level: f64::INFINITY,
            sample_time,
            clear: 1,
        }
    }
}

/// Judges the profile of every cylinder that has one.
#[derive(Clone, Debug)]
pub struct Scattering {
    cylinders: Vec<Option<Judged>>,
}

#[derive(Clone, Debug)]
struct Judged {
    line: Line,
    limit: f64,
    reference: Reference,
    velocity: Velocity,
    baseline: Baseline,
    novelty: Novelty,
    pair: Option<Pair>,
    magnitudes: Magnitudes,
    history: History,
    measuring: Measuring,
    sums: Magnitudes,
    resolutions: [Resolution; 2],
}

impl Scattering {
    /// Of cylinders with these lines and profiles, sampled every `sample_time` seconds.
    pub fn new<'a>(
        sample_time: f64,
        cylinders: impl IntoIterator<Item = Option<(&'a Fitted, &'a Profile)>>,
    ) -> Self {
        let judged = |(fitted, profile): (&Fitted, &Profile)| {
            let deviation = if fitted.rms > 0.0 { fitted.rms } else { GUESS };
            let design = |drive| PairDesign::new(drive, sample_time, deviation, 0.0).ok();
            Judged {
                line: fitted.line,
                limit: FAULTY * fitted.limit,
                reference: profile.reference.clone(),
                velocity: Velocity::new(sample_time),
                baseline: Baseline::new(sample_time, deviation),
                // How far healthy residuals go is what is being learnt.
                novelty: Novelty::new(sample_time, deviation, f64::INFINITY),
                pair: profile.drive.and_then(design).map(Pair::new),
                magnitudes: Magnitudes::new(BIN),
                history: History::default(),
                measuring: Measuring::default(),
                sums: Magnitudes::new(BIN),
                resolutions: Default::default(),
            }
        };
        Self { cylinders: cylinders.into_iter().map(|both| both.map(judged)).collect() }
    }

    /// What came of the cylinder of `index` (from 0); `None` where there was too little.
    pub fn result(&self, index: usize) -> Option<Scatter> {
        let Judged { magnitudes, sums, pair, measuring, resolutions, .. } =
            self.cylinders[index].as_ref()?;
        if magnitudes.total() < LEAST_SAMPLES {
            return None;
        }
        let rate = Rate::of(magnitudes, Of::Mean)?;
        let square_rate = Rate::of(magnitudes, Of::Square)?;
        let deviation = magnitudes.deviation();
        let resolution = [0, 1].map(|which: usize| resolutions[which].count());
        let scales =
            Scales::new(rate.clone(), square_rate.clone(), INDEPENDENT, deviation, DEAD_BAND)
                .rounded(resolution);
        Some(Scatter {
            rate,
            square_rate,
            dependence: measuring.dependence(&scales),
            deviation,
            resolution,
            prediction: pair
                .as_ref()
                .filter(|_| sums.total() > 0)
                .map(|_| sums.deviation())
                .filter(|off| *off <= FARTHEST_OFF * deviation),
            samples: magnitudes.total(),
            largest: magnitudes.largest(),
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
            let most = (2.0 * (samples + 1) as f64).ln();
            let then = format!("no single one can be more than {most:.1} nats of evidence");
            ("little for the sequential detector to go by", then)
        };
        Some(format!(
            "{told}: where the first part has been, the second has {samples} samples in motion, and \
             {then}; record more motion"
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
        self.velocity.reset();
        self.baseline.reset();
        self.novelty.reset();
        self.history.clear();
        self.resolutions.iter_mut().for_each(Resolution::interrupt);
        if let Some(pair) = &mut self.pair {
            pair.reset();
        }
    }

    fn take(&mut self, row: &Row) {
        if !row.monitored {
            return self.interrupt();
        }
        let velocity = self.velocity.step(row.c2, row.v2);
        let healthy = |(c1, c2): &(f64, f64)| self.line.error(*c2, *c1).abs() <= self.limit;
        let both = row.c1.zip(row.c2).filter(healthy);
        let residual = both
            .zip(velocity)
            .and_then(|((c1, c2), velocity)| self.reference.residual(c1, c2, velocity));
        let baseline = self.baseline.value();
        if let Some(pair) = &mut self.pair {
            let beyond = residual.zip(baseline).map(|(residual, baseline)| residual - baseline);
            pair.step(row.c1.zip(beyond).map(|(c1, beyond)| [c1, c1 - beyond]), row.u);
            if let Some([n1, n2]) = pair.newest() {
                self.sums.add((n1 + n2) * std::f64::consts::FRAC_1_SQRT_2);
            }
        }
        let (Some((c1, c2)), Some(residual)) = (both, residual) else { return };
        self.baseline.follow(residual);
        self.resolutions[0].add(c1);
        self.resolutions[1].add(c2);
        let news = self.novelty.step([c1, c2], residual);
        let Some(baseline) = baseline else { return };
        // Nothing is clipped: what is beyond all others was left out above.
        self.history.push(residual - baseline, &Clip::NONE, news);
        if news == News::InMotion {
            self.magnitudes.add(residual - baseline);
            self.measuring.take(&self.history);
        }
    }
}
