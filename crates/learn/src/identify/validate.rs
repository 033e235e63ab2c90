//! Validation of models on data that they were not identified on.

use super::correlate::{Correlator, Whiteness};
use super::moments::Spread;
use super::shaper::{Sample, Shaper};
use crate::survey::Row;
use nalgebra::{Vector2, Vector3};
use tertius_core::observe::model::Model;
use tertius_core::observe::observer::ObserverDesign;

/// Number of samples kept for figures: a minute at 50 Hz.
pub const EXCERPT: usize = 3000;

/// A model that is tried on a cylinder.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// Cylinder that it was identified on.
    pub of: u8,
    pub model: Model,
    /// Load pressure at rest of that cylinder, bar.
    pub pressure_offset: f64,
    /// Observer of the model, where it has one.
    pub observer: Option<ObserverDesign>,
}

/// Accuracy with which one signal is reproduced.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SignalScore {
    measured: Spread,
    error: Spread,
}

/// Accuracy of position and velocity of one model on one cylinder.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Fit {
    /// Accuracy of the position, m.
    pub position: SignalScore,
    /// Accuracy of the velocity, m/s.
    pub velocity: SignalScore,
}

impl SignalScore {
    pub(super) fn add(&mut self, measured: f64, predicted: f64) {
        self.measured.add(measured);
        self.error.add(measured - predicted);
    }

    /// Variance accounted for, %: 100 (1 − var(y − ŷ) / var(y)); 100 is perfect, below 0 is worse
    /// than the mean. NaN without data or where the model ran away.
    pub fn vaf(&self) -> f64 {
        100.0 * (1.0 - self.error.variance() / self.measured.variance())
    }

    /// Root mean square of the error, in the signal's unit.
    pub fn rms(&self) -> f64 {
        self.error.rms()
    }

    /// The largest error, in the signal's unit.
    pub const fn largest(&self) -> f64 {
        self.error.largest
    }

    pub const fn count(&self) -> u64 {
        self.error.count
    }
}

/// One cycle for figures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shown {
    pub sample: Sample,
    /// l and l̇ of the open-loop simulation.
    pub simulated: [f64; 2],
    /// l and l̇ predicted from the previous cycle by the observer.
    pub predicted: Option<[f64; 2]>,
}

#[derive(Clone, Debug)]
struct Trial {
    candidate: Candidate,
    /// State of the open-loop simulation.
    free: Vector3<f64>,
    /// State of the observer.
    led: Vector3<f64>,
    simulated: Fit,
    predicted: Fit,
    residuals: [Correlator; 2],
}

/// Tries models on one cylinder.
#[derive(Clone, Debug)]
pub struct Validator {
    shaper: Shaper,
    /// Command at which the cylinder rests, m/s.
    command_offset: f64,
    trials: Vec<Trial>,
    /// Index of the trial that is shown in figures.
    shown: usize,
    excerpt: Vec<Shown>,
    running: Option<u32>,
    starts: u64,
}

/// Result of one model on one cylinder.
#[derive(Clone, Debug, PartialEq)]
pub struct TriedModel {
    /// Cylinder that the model was identified on.
    pub of: u8,
    /// Open-loop accuracy: from the first sample on by the commands alone.
    pub simulated: Fit,
    /// Accuracy of the observer's prediction from each cycle to the next.
    pub predicted: Fit,
    /// Whiteness of the observer's prediction errors of position and velocity.
    pub whiteness: [Option<Whiteness>; 2],
}

/// Results of a cylinder's validation.
#[derive(Clone, Debug, PartialEq)]
pub struct Trials {
    pub tried: Vec<TriedModel>,
    /// Number of times a simulation started: once, and after each gap.
    pub starts: u64,
    /// Beginning of the signals, with the cylinder's own model.
    pub excerpt: Vec<Shown>,
}

impl Validator {
    /// A validator of samples by `shaper`; figures show the candidate of cylinder `own`.
    pub fn new(shaper: Shaper, command_offset: f64, own: u8, candidates: &[Candidate]) -> Self {
        let trial = |candidate: &Candidate| Trial {
            candidate: candidate.clone(),
            free: Vector3::zeros(),
            led: Vector3::zeros(),
            simulated: Fit::default(),
            predicted: Fit::default(),
            residuals: [Correlator::new(), Correlator::new()],
        };
        Self {
            shaper,
            command_offset,
            trials: candidates.iter().map(trial).collect(),
            shown: candidates.iter().position(|candidate| candidate.of == own).unwrap_or(0),
            excerpt: Vec::new(),
            running: None,
            starts: 0,
        }
    }

    pub fn row(&mut self, row: &Row) {
        match self.shaper.take(row) {
            Some(sample) => self.step(sample),
            None => self.stop(),
        }
    }

    pub fn gap(&mut self) {
        self.shaper.gap();
        self.stop();
    }

    fn stop(&mut self) {
        if self.running.take().is_some() {
            let correlators = self.trials.iter_mut().flat_map(|trial| &mut trial.residuals);
            correlators.for_each(Correlator::gap);
        }
    }

    fn step(&mut self, sample: Sample) {
        let followed = self.running.map_or(0, |followed| followed.saturating_add(1));
        if self.running.is_none() {
            self.starts += 1;
            self.trials.iter_mut().for_each(|trial| trial.start(&sample));
        }
        self.running = Some(followed);
        let input = sample.u - self.command_offset;
        for (index, trial) in self.trials.iter_mut().enumerate() {
            let (simulated, predicted) = trial.step(&sample, input, followed);
            if index == self.shown && self.excerpt.len() < EXCERPT {
                self.excerpt.push(Shown { sample, simulated, predicted });
            }
        }
    }

    pub fn finish(self) -> Trials {
        let tried = |trial: Trial| TriedModel {
            of: trial.candidate.of,
            simulated: trial.simulated,
            predicted: trial.predicted,
            whiteness: trial.residuals.map(|correlator| correlator.whiteness()),
        };
        let tried = self.trials.into_iter().map(tried).collect();
        Trials { tried, starts: self.starts, excerpt: self.excerpt }
    }
}

impl Trial {
    fn start(&mut self, sample: &Sample) {
        let pressure = sample.p.map_or(0.0, |p| p - self.candidate.pressure_offset);
        self.free = Vector3::new(sample.l, sample.v, pressure);
        self.led = Vector3::new(sample.l, sample.raw_v.unwrap_or(0.0), 0.0);
    }

    fn step(&mut self, sample: &Sample, input: f64, followed: u32) -> ([f64; 2], Option<[f64; 2]>) {
        let Candidate { model, observer, .. } = &self.candidate;
        let simulated = [self.free[0], self.free[1]];
        self.simulated.position.add(sample.l, self.free[0]);
        self.simulated.velocity.add(sample.v, self.free[1]);
        self.free = model.a * self.free + model.b * input;
        let Some(ObserverDesign { a, b, l, settle, .. }) = observer else {
            return (simulated, None);
        };
        let predicted = [self.led[0], self.led[1]];
        let velocity = sample.raw_v.unwrap_or(sample.v);
        let errors = Vector2::new(sample.l - self.led[0], velocity - self.led[1]);
        if followed >= *settle {
            self.predicted.position.add(sample.l, self.led[0]);
            self.predicted.velocity.add(velocity, self.led[1]);
            for (correlator, error) in self.residuals.iter_mut().zip(&errors) {
                correlator.add(*error, input);
            }
        }
        // (4-9); the gain of a velocity that is not recorded is zero.
        self.led = a * self.led + b * input + l * errors;
        (simulated, Some(predicted))
    }
}
