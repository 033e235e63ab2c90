//! From estimates to the results for a model.

use super::census::Census;
use super::estimate::{Estimate, Estimator, OffsetRule};
use super::outcome::{CylinderOutcome, Identified, Observability};
use super::refusal::IdentificationRefusal;
use super::shaper::{Shaper, Shaping};
use super::stages::Each;
use super::validate::{Candidate, Validator};
use tertius_core::observe::model::Model;
use tertius_core::observe::observer::ObserverDesign;

/// Weights of the observer, and the cycles before it judges.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ObserverWeights {
    pub q: [f64; 3],
    pub r: [f64; 2],
    pub settle: u32,
}

/// Estimators of the cylinders that `census` accepts; for the others, the reason.
pub fn estimators(
    census: &Census,
    shaping: Shaping,
) -> (Each<Estimator>, Vec<Result<(), IdentificationRefusal>>) {
    let judged: Vec<_> = (0..census.cylinders().len()).map(|index| census.judge(index)).collect();
    let estimator = |(index, judged): (usize, &Result<(), IdentificationRefusal>)| {
        let sources = census.sources(index);
        judged.is_ok().then(|| Estimator::new(Shaper::new(shaping, sources), sources.pressure))
    };
    (Each(judged.iter().enumerate().map(estimator).collect()), judged)
}

/// Results of the estimators, cylinder by cylinder; not yet validated.
pub fn cylinders(
    census: &Census,
    judged: Vec<Result<(), IdentificationRefusal>>,
    estimators: &Each<Estimator>,
    rule: OffsetRule,
    shaping: Shaping,
    weights: &ObserverWeights,
) -> Vec<CylinderOutcome> {
    let one = |(index, judged): (usize, Result<(), IdentificationRefusal>)| {
        let sources = census.sources(index);
        let estimator = estimators.0[index].as_ref();
        let result = judged.and_then(|()| {
            let estimate = estimator.ok_or(IdentificationRefusal::Absent)?.estimate(rule)?;
            Ok(identified(estimate, shaping.sample_time, sources.velocity, weights))
        });
        let mut remarks = if result.is_ok() { census.remarks(index) } else { Vec::new() };
        if let Ok(own) = &result {
            remarks.extend(own.remarks());
        }
        // A cylinder has a number of one byte.
        CylinderOutcome { number: index as u8 + 1, sources, result, trials: None, remarks }
    };
    judged.into_iter().enumerate().map(one).collect()
}

fn identified(
    estimate: Estimate,
    sample_time: f64,
    velocity: bool,
    weights: &ObserverWeights,
) -> Identified {
    let model = estimate.model(sample_time);
    let [l, v, p, _] = estimate.sizes;
    Identified {
        poles: model.poles(),
        velocity_gain: model.velocity_gain(),
        observability: Observability::new(&model, [l, v, p]),
        no_observer: design(&model, velocity, weights).err(),
        estimate,
        model,
    }
}

fn design(
    model: &Model,
    velocity: bool,
    weights: &ObserverWeights,
) -> Result<ObserverDesign, String> {
    let ObserverWeights { q, r, settle } = *weights;
    // Nothing is predicted over here: a gap starts a new trial.
    ObserverDesign::new(model, q, r, velocity, settle, 0).map_err(|error| error.to_string())
}

/// Validators that try every identified model on every cylinder that has data for it.
pub fn validators(
    census: &Census,
    cylinders: &[CylinderOutcome],
    shaping: Shaping,
    weights: &ObserverWeights,
) -> Each<Validator> {
    let one = |on: &CylinderOutcome| {
        let own = on.result.as_ref().ok()?;
        let sources = census.sources(usize::from(on.number) - 1);
        let candidates: Vec<Candidate> = cylinders
            .iter()
            .filter_map(|of| {
                let Identified { model, estimate, .. } = of.result.as_ref().ok()?;
                let observer = design(model, sources.velocity, weights).ok();
                let pressure_offset = estimate.pressure_offset;
                Some(Candidate { of: of.number, model: *model, pressure_offset, observer })
            })
            .collect();
        let offset = own.estimate.command_offset.unwrap_or(0.0);
        Some(Validator::new(Shaper::new(shaping, sources), offset, on.number, &candidates))
    };
    Each(cylinders.iter().map(one).collect())
}

impl Identified {
    fn remarks(&self) -> Vec<String> {
        let mut remarks = Vec::new();
        let unstable = self.poles.is_none_or(|poles| poles[0].norm() >= 1.0);
        if unstable {
            remarks.push(
                "the model is not stable by itself: a simulation of it runs away, an observer may \
                 still hold it"
                    .to_owned(),
            );
        }
        if let Some(why) = &self.no_observer {
            remarks.push(format!("it has no observer with the configured weights: {why}"));
        }
        if let Some(offset) = self.estimate.command_offset {
            remarks.push(format!(
                "it rests at a command of {offset:.4} m/s (command_offset), which is taken off"
            ));
        }
        if let Some(offset) = self.estimate.never_commanded {
            remarks.push(format!(
                "it would rest at a command of {offset:.4} m/s, which was never given, so no offset is taken off \
                 (--offset never); without it the model predicts as well"
            ));
        }
        remarks
    }
}
