//! Score of a set of weights.

use super::model::{CylinderModel, Weights, designs};
use super::response;
use super::store::Store;
use crate::extremes::{Maxima, Tail, common_level};
use tertius_core::observe::observer::ObserverDesign;

/// Requirements for an observer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Criterion {
    /// Wanted false alarms of the whole machine, 1/s.
    pub rate: f64,
    /// Sample time Ts, s.
    pub sample_time: f64,
    /// Cycles that count as one warning.
    pub block: u32,
    /// Cycles within which a step has to be found.
    pub horizon: usize,
    /// Cycles after which nine tenths of a step have to be gone from the residual.
    pub sharp: usize,
    /// Cycles before an observer judges.
    pub settle: u32,
}

/// Score of an observer, for the worst cylinder.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Score {
    /// Level that healthy residuals exceed at the wanted rate, by exponential tails, m.
    pub threshold: f64,
    /// Largest innovation after a unit step within the horizon, at least 1.
    pub peak: f64,
    /// Largest innovation of an incipient fault (5-18) of [`INCIPIENT`] within the horizon,
    /// averaged over its onset within a cycle, m.
    pub incipient: f64,
    /// Cycles until the response to a step stays below a tenth.
    pub settled: usize,
    /// Value to be minimised: the factor by which a step of [`STEP`] and the incipient fault would
    /// have to be larger for both to be seen; at 1 and below they are. Infinite where the response
    /// is not sharp.
    pub times: f64,
}

/// Step that is to be seen, (5-15), m.
pub const STEP: f64 = 1e-3;

/// Incipient fault that is to be seen, φ in m and b of (5-18): that of section 5-4-4.
pub const INCIPIENT: (f64, f64) = (0.07, 1.0);

impl Criterion {
    /// The score of `weights` on `store`; `None` where a cylinder has no observer with them, or
    /// there is too little to judge.
    pub fn score(
        &self,
        cylinders: &[CylinderModel],
        store: &Store,
        weights: Weights,
    ) -> Option<Score> {
        let designs = designs(cylinders, weights, self.settle).ok()?;
        let (mut peak, mut incipient, mut settled) = (f64::INFINITY, f64::INFINITY, 0);
        let mut tails = Vec::new();
        for (index, (cylinder, designs)) in cylinders.iter().zip(&designs).enumerate() {
            for (transducer, design) in designs.iter().enumerate() {
                if !cylinder.transducers[transducer] {
                    continue;
                }
                let response = response::step(design, self.horizon.max(1));
                peak = peak.min(response.iter().fold(0.0, |peak, value| peak.max(value.abs())));
                let slow =
                    response::incipient(design, INCIPIENT, self.sample_time, self.horizon.max(1));
                incipient = incipient.min(slow);
                settled = settled.max(response::settled(design, 2 * self.sharp + 1));
                tails.extend(self.tail(store, index, transducer, design));
            }
        }
        if tails.is_empty() {
            return None;
        }
        // The search compares: the heaviest of few peaks would decide alone with a Pareto tail.
        tails.iter_mut().for_each(|tail| tail.heavy = false);
        let threshold = common_level(&tails, self.rate);
        let times = (threshold / (peak * STEP)).max(threshold / incipient);
        let times = if settled <= self.sharp { times } else { f64::INFINITY };
        Some(Score { threshold, peak, incipient, settled, times })
    }

    fn tail(
        &self,
        store: &Store,
        index: usize,
        transducer: usize,
        design: &ObserverDesign,
    ) -> Option<Tail> {
        let mut maxima = Maxima::new(self.block);
        for stretch in store.stretches(index) {
            let residuals = Store::residuals(stretch, design, transducer);
            residuals.flatten().for_each(|residual| maxima.add(residual));
        }
        Tail::fit(&maxima, self.sample_time)
    }
}
