//! An identification from beginning to end, on a recording that can be read repeatedly.

use super::assess::{self, ObserverWeights};
use super::flow::{FlowFit, FlowSources, Scout};
use super::friction::Stretches;
use super::nonlinear::Nonlinear;
use super::outcome::ASKED;
use super::valve::{self, ValveTrial};
use super::{Census, Expectations, OffsetRule, Outcome, Shaping};
use crate::relate::ProcessRows;
use crate::survey::{Origin, Recording, Window};
use tertius_config::settings::Settings;

/// Options of an identification.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Width of the centred moving average of velocity and load pressure, cycles; odd.
    pub window: usize,
    /// Part of the time at the end that is held back for validation, %.
    pub held_back: u8,
    /// Cylinder whose model is used for the machine; `None`: the one whose worst fit is the best.
    pub model_of: Option<u8>,
    pub offset: OffsetRule,
    /// Whether flow and friction are identified, too, and with which supply.
    pub nonlinear: Option<Supply>,
}

/// Supply pressure, bar; `None`: as recorded.
pub type Supply = Option<f64>;

impl Default for Options {
    fn default() -> Self {
        Self {
            window: 5,
            held_back: 50,
            model_of: None,
            offset: OffsetRule::WhereItMatters,
            nonlinear: None,
        }
    }
}

/// Inputs of an identification.
#[derive(Clone, Copy, Debug)]
pub struct IdentificationCourse<'a> {
    pub settings: &'a Settings,
    pub origin: &'a Origin,
    pub options: Options,
}

const RUNS_AWAY: &str = "simulated open loop, the chosen model runs away (VAF below 0 %): a \
    position is the sum of all speeds, so errors from a dead band or a changing offset of the \
command add up; the monitor uses the prediction, which follows the readings";

impl IdentificationCourse<'_> {
    /// Reads `recording` three times, for the census, the fit and the validation, and three
    /// times more for the non-linear parts.
    ///
    /// # Errors
    /// The recording's own.
    pub fn run<R: Recording>(&self, recording: &R) -> Result<Outcome, R::Error> {
        let Self { settings, origin, options } = *self;
        let [fitted, validated] = match options.held_back {
            0 => [origin.window; 2],
            part => origin.window.split(1.0 - f64::from(part) / 100.0),
        };
        let shaping = Shaping {
            sample_time: settings.machine.sample_time,
            window: options.window,
            area_ratio: settings.machine.area_ratio,
        };
        let observer = &settings.observer;
        let settle = (observer.settle / settings.machine.sample_time).round() as u32;
        let weights = ObserverWeights { q: observer.q, r: observer.r, settle };
        let (census, bad) = self.census(recording, fitted)?;
        let (mut estimators, judged) = assess::estimators(&census, shaping);
        recording.read(fitted, &mut estimators)?;
        let mut cylinders =
            assess::cylinders(&census, judged, &estimators, options.offset, shaping, &weights);
        let mut validators = assess::validators(&census, &cylinders, shaping, &weights);
        recording.read(validated, &mut validators)?;
        for (cylinder, validator) in cylinders.iter_mut().zip(validators.0) {
            cylinder.trials = validator.map(|validator| validator.finish());
        }
        let nonlinear = options
            .nonlinear
            .map(|supply| self.nonlinear(recording, [fitted, validated], supply))
            .transpose()?;
        let mut outcome = Outcome {
            machine: settings.machine.name.clone(),
            inputs: origin.inputs.clone(),
            timeline: origin.timeline.clone(),
            shaping,
            fitted,
            validated,
            cylinders,
            choice: None,
            remarks: origin.remarks.iter().cloned().chain(bad).collect(),
            nonlinear,
        };
        outcome.choice = outcome.choose(options.model_of);
        let remarks = doubts(&outcome);
        outcome.remarks.extend(remarks);
        Ok(outcome)
    }

    /// The census of `window`, with remarks on values that could not be used.
    fn census<R: Recording>(
        &self,
        recording: &R,
        window: Window,
    ) -> Result<(Census, Option<String>), R::Error> {
        let settings = self.settings;
        let signals = &settings.signals.cylinder;
        let chambers = signals.pressure_bottom.is_some() && signals.pressure_rod.is_some();
        let calibration = |n| {
            let calibration = settings.comparator_of(n);
            (calibration != (1.0, 0.0)).then_some(calibration)
        };
        let expected = Expectations {
            sample_time: settings.machine.sample_time,
            area_ratio: settings.machine.area_ratio,
            velocity: signals.c1_velocity.is_some(),
            pressure: chambers || signals.load_pressure.is_some(),
            seconds: (1..=settings.machine.cylinders).map(|n| settings.has_c2(n)).collect(),
            calibrations: (1..=settings.machine.cylinders).map(calibration).collect(),
        };
        let mut census = Census::new(settings.machine.cylinders.into(), expected);
        let bad = recording.read_counted(window, &mut census)?.bad_signals;
        let told = (bad > 0).then(|| {
            format!(
                "{bad} values for which the frame was too short, or that were not a number \
                (NaN)"
            )
        });
        Ok((census, told))
    }

    /// Finds the reach of the spools, then flow and friction; the valves' curves are tried on the second window.
    fn nonlinear<R: Recording>(
        &self,
        recording: &R,
        [fitted, validated]: [Window; 2],
        supply: Supply,
    ) -> Result<Nonlinear, R::Error> {
        let (signals, machine) = (&self.settings.signals.cylinder, &self.settings.machine);
        let (spool, area_ratio) = (signals.spool.is_some(), machine.area_ratio);
        let sources = FlowSources { spool, supply, area_ratio };
        let mut scout = Scout::new(machine.cylinders, sources);
        recording.read(fitted, &mut scout)?;
        let mut fit = FlowFit::new(&scout);
        let mut stretches = Stretches::new(machine.cylinders, area_ratio);
        let mut rows = ProcessRows::of_c1(self.settings, supply);
        recording.read(fitted, (&mut fit, (&mut stretches, &mut rows)))?;
        let curves = (1..)
            .zip(&scout.cylinders)
            .map(|(n, reach)| valve::curve(&rows, n, reach, spool, machine.sample_time));
        let mut trial = ValveTrial::new(curves, machine.sample_time, area_ratio, supply);
        recording.read(validated, &mut trial)?;
        let valves = trial.finish();
        let (flow, points, friction) = (fit.curves(), fit.samples(), stretches.curves());
        Ok(Nonlinear { sources, flow, points, valves, friction })
    }
}

/// Remarks on the chosen model.
fn doubts(outcome: &Outcome) -> Vec<String> {
    let Some(choice) = outcome.choice else { return Vec::new() };
    let mut doubts = Vec::new();
    if outcome.cylinders.iter().any(|cylinder| cylinder.runs_away(choice.of)) {
        doubts.push(RUNS_AWAY.to_owned());
    }
    if choice.worst < ASKED {
        doubts.push(format!(
            "a position VAF of {:.2} % is below the {ASKED} % that a model should reach, simulated open \
             loop: expect larger residuals, and let `tertius tune` choose the thresholds",
            choice.worst
        ));
    }
    doubts
}

impl Outcome {
    /// Checks that the chosen model, or each cylinder's own (`per_cylinder`), follows the data that
    /// it was validated on.
    ///
    /// # Errors
    /// Those that do not, in words; no model may be written then.
    pub fn follows(&self, per_cylinder: bool) -> Result<(), String> {
        let Some(choice) = self.choice else { return Ok(()) };
        let of = |n: u8| if per_cylinder { n } else { choice.of };
        let strays: Vec<String> = self
            .cylinders
            .iter()
            .map(|cylinder| cylinder.number)
            .flat_map(|on| self.strays(of(on)).into_iter().filter(move |stray| stray.on == on))
            .map(|stray| {
                let (on, position, velocity) = (stray.on, stray.position, stray.velocity);
                format!("cylinder {on}: position {position:.2} %, velocity {velocity:.2} %")
            })
            .collect();
        if strays.is_empty() {
            return Ok(());
        }
        Err(format!(
            "the model does not follow its command: VAF on the data of the \
             trial, {}; below 0 % the mean predicts a velocity better, below -100 % chance \
            predicts a position better. Does the command belong to this cylinder, is it in m/s, \
            was the machine healthy, and is the part that was fitted like the one that was tried \
            (--from, --to)?",
            strays.join("; ")
        ))
    }

    /// Whether no cylinder follows its own model. One whose command is wrong spoils the model that is chosen for all: then the
    /// others still follow theirs.
    pub fn follows_nowhere(&self) -> bool {
        let mut identified = self.cylinders.iter().filter(|it| it.result.is_ok()).peekable();
        identified.peek().is_some()
            && identified.all(|it| self.strays(it.number).iter().any(|stray| stray.on == it.number))
    }

    /// Cylinders without a model, and the reasons.
    pub fn refusals(&self) -> Vec<(u8, String)> {
        let refused = self.cylinders.iter().filter_map(|cylinder| {
            let refusal = cylinder.result.as_ref().err()?;
            Some((cylinder.number, refusal.to_string()))
        });
        refused.collect()
    }
}
