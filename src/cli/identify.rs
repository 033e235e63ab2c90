//! `tertius identify`: a model from a healthy recording.

use super::Failure;
use super::files::{Claimed, Overwriting};
use super::survey::{Field, Surveyed};
use super::tables::{self, InPlace};
use crate::config::Settings;
use crate::identify::assess::{self, Weights};
use crate::identify::flow::{FlowFit, FlowSources, Scout};
use crate::identify::friction::Stretches;
use crate::identify::nonlinear::Nonlinear;
use crate::identify::outcome::{ASKED, Stray};
use crate::identify::shaper::WIDEST;
use crate::identify::{Census, Expectations, OffsetRule, Outcome, Shaping};
use crate::monitor::MonitorDesign;
use crate::report::{identification, model_tables, page};
use crate::survey::Window;
use clap::{Args, ValueEnum};
use std::io::Write;
use std::path::PathBuf;

/// Identifies the model (4-1) of every cylinder on a healthy recording, and tries it on a part
/// that was held back.
#[derive(Args, Debug)]
#[command(
    after_help = "Example:\n  tertius identify field.log.zst --config config/e-type.toml --output \
                  model.toml"
)]
pub struct Identify {
    #[command(flatten)]
    field: Field,
    /// Writes the tables [model] and [[cylinder]] for the configuration
    #[arg(long, value_name = "FILE.toml")]
    output: Option<PathBuf>,
    /// Writes a page with figures, in one file
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
    #[command(flatten)]
    place: InPlace,
    #[command(flatten)]
    overwriting: Overwriting,
    /// Cycles of the centred moving average of velocity and load pressure; odd, 1 is none
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = window)]
    window: usize,
    /// The part of the time at the end that is held back for validation, %; 0 validates on the
    /// data of the fit
    #[arg(long, value_name = "PERCENT", default_value_t = 50, value_parser = clap::value_parser!(u8).range(0..=90))]
    held_back: u8,
    /// Takes the model of this cylinder [default: the one whose worst VAF is the best]
    #[arg(long, value_name = "N")]
    model_of: Option<u8>,
    /// Writes each cylinder its own model
    #[arg(long)]
    per_cylinder: bool,
    /// Whether the command at which a cylinder rests is estimated, too
    #[arg(long, value_enum, default_value_t = Offset::Auto)]
    offset: Offset,
    /// Tells flow and friction curves, too: section 3-3-1
    #[arg(long)]
    nonlinear: bool,
    /// Supply pressure for --nonlinear, bar [default: as signals.supply has it]
    #[arg(long, value_name = "BAR", requires = "nonlinear", value_parser = supply)]
    supply: Option<f64>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Offset {
    /// Where it comes out beyond a tenth of the command's deviation
    Auto,
    Always,
    /// As in the thesis
    Never,
}

/// Keys of a cylinder that belong to its model.
const OF_A_MODEL: [&str; 4] = ["theta", "gamma", "sample_time", "command_offset"];

const RUNS_AWAY: &str = "simulated open loop the taken model runs away (VAF below 0 %): a position is \
                         the sum of all speeds, so what a dead band or a changing offset of the \
                         command leaves over adds up; the monitor uses the prediction, which is \
                         led by the readings";

fn window(text: &str) -> Result<usize, String> {
    let expected = || format!("expected an odd number from 1 to {WIDEST}");
    let number: usize = text.parse().map_err(|_| expected())?;
    let sound = number % 2 == 1 && number <= WIDEST;
    if sound { Ok(number) } else { Err(expected()) }
}

fn supply(text: &str) -> Result<f64, String> {
    let expected = || "expected a pressure above 0, at most 2000 bar".to_owned();
    let bar: f64 = text.parse().map_err(|_| expected())?;
    if bar > 0.0 && bar <= 2000.0 { Ok(bar) } else { Err(expected()) }
}

impl Identify {
    /// Identifies.
    ///
    /// # Errors
    /// What is wrong with the call or its files; cylinders that were refused.
    pub fn run(self) -> Result<(), Failure> {
        let surveyed = self.field.open()?;
        let cylinders = surveyed.machine.loaded.settings.machine.cylinders;
        if let Some(n) = self.model_of
            && !(1..=cylinders).contains(&n)
        {
            return Err(Failure::Wrong(format!(
                "--model-of {n}: the machine has cylinders 1 to {cylinders}"
            )));
        }
        let outputs = [&self.output, &self.report];
        let [output, report] = tables::claim(
            "identify",
            outputs,
            self.overwriting,
            &self.field,
            &surveyed,
            &self.place,
        )?;
        let outcome = self.outcome(&surveyed)?;
        let text = identification::page(&outcome);
        std::io::stdout()
            .write_all(text.as_bytes())
            .map_err(|error| Failure::writing("standard output", &error))?;
        self.write(&outcome, output)?;
        if let Some(report) = report {
            report.write(&page::identification::page(&outcome))?;
        }
        surveyed.damage()?;
        self.conclude(&outcome)
    }

    /// Reads the recording three times: what is in it, the fit, the validation.
    fn outcome(&self, surveyed: &Surveyed) -> Result<Outcome, Failure> {
        let settings = &surveyed.machine.loaded.settings;
        let [fitted, validated] = match self.held_back {
            0 => [surveyed.window; 2],
            part => surveyed.window.split(1.0 - f64::from(part) / 100.0),
        };
        let shaping = Shaping {
            sample_time: settings.machine.sample_time,
            window: self.window,
            area_ratio: settings.machine.area_ratio,
        };
        let observer = &settings.observer;
        let settle = (observer.settle / settings.machine.sample_time).round() as u32;
        let weights = Weights { q: observer.q, r: observer.r, settle };
        let census = survey(surveyed, settings, fitted)?;
        let (mut estimators, judged) = assess::estimators(&census.0, shaping);
        surveyed.read(fitted, &mut estimators)?;
        let rule = self.offset.into();
        let mut cylinders =
            assess::cylinders(&census.0, judged, &estimators, rule, shaping, &weights);
        let mut validators = assess::validators(&census.0, &cylinders, shaping, &weights);
        surveyed.read(validated, &mut validators)?;
        for (cylinder, validator) in cylinders.iter_mut().zip(validators.0) {
            cylinder.trials = validator.map(|validator| validator.finish());
        }
        let mut remarks = surveyed.remarks();
        remarks.extend(census.1);
        let mut outcome = Outcome {
            machine: settings.machine.name.clone(),
            inputs: surveyed.inputs(),
            first: surveyed.first,
            last: surveyed.last,
            shaping,
            fitted,
            validated,
            cylinders,
            choice: None,
            remarks,
            nonlinear: self.nonlinear.then(|| self.nonlinear(surveyed, fitted)).transpose()?,
        };
        outcome.choice = outcome.choose(self.model_of);
        if let Some(choice) = outcome.choice
            && outcome.cylinders.iter().any(|cylinder| cylinder.runs_away(choice.of))
        {
            outcome.remarks.push(RUNS_AWAY.to_owned());
        }
        if let Some(choice) = outcome.choice.filter(|choice| choice.worst < ASKED) {
            outcome.remarks.push(format!(
                "a position VAF of {:.2} % is below the {ASKED} % that a model should reach, \
                 simulated open loop: expect larger residuals, and let `tertius tune` choose the \
                 thresholds",
                choice.worst
            ));
        }
        Ok(outcome)
    }

    /// Reads the recording twice more: how far the spools go, then what they do.
    fn nonlinear(&self, surveyed: &Surveyed, fitted: Window) -> Result<Nonlinear, Failure> {
        let loaded = &surveyed.machine.loaded.settings;
        let (signals, machine) = (&loaded.signals.cylinder, &loaded.machine);
        let (spool, area_ratio) = (signals.spool.is_some(), machine.area_ratio);
        let sources = FlowSources { spool, supply: self.supply, area_ratio };
        let mut scout = Scout::new(machine.cylinders, sources);
        surveyed.read(fitted, &mut scout)?;
        let mut fit = FlowFit::new(&scout);
        let mut stretches = Stretches::new(machine.cylinders, area_ratio);
        surveyed.read(fitted, (&mut fit, &mut stretches))?;
        let (flow, points, friction) = (fit.curves(), fit.samples(), stretches.curves());
        Ok(Nonlinear { sources, flow, points, friction })
    }

    fn write(&self, outcome: &Outcome, output: Option<Claimed>) -> Result<(), Failure> {
        if self.stray(outcome).is_some() {
            return Ok(());
        }
        let version = env!("CARGO_PKG_VERSION");
        let Some(tables) = model_tables::tables(outcome, version, self.per_cylinder) else {
            return Ok(());
        };
        output.map_or(Ok(()), |output| output.write(&tables))?;
        self.place.put(&tables, &OF_A_MODEL, MonitorDesign::unjudging)
    }

    /// Why the taken models, or each cylinder's own, are not written.
    fn stray(&self, outcome: &Outcome) -> Option<String> {
        let taken = outcome.choice?.of;
        let of = |n: u8| if self.per_cylinder { n } else { taken };
        let cylinders = outcome.cylinders.iter().map(|cylinder| cylinder.number);
        let strays: Vec<String> = cylinders
            .flat_map(|on| outcome.strays(of(on)).into_iter().filter(move |it| it.on == on))
            .map(|Stray { on, position, velocity }| {
                format!("cylinder {on}: position {position:.2} %, velocity {velocity:.2} %")
            })
            .collect();
        (!strays.is_empty()).then(|| {
            format!(
                "the model does not follow its command, and nothing is written: VAF on the data \
                 that was tried, {}; below 0 % a velocity is better told by its mean, below -100 % \
                 a position by chance. Is the command that of this cylinder and in m/s, was the \
                 machine healthy, is the part that was fitted like the one that was tried (--from, \
                 --to)?",
                strays.join("; ")
            )
        })
    }

    /// A cylinder without a model is a failure, though the others have theirs.
    fn conclude(&self, outcome: &Outcome) -> Result<(), Failure> {
        if let Some(stray) = self.stray(outcome) {
            return Err(Failure::Failed(stray));
        }
        let refused: Vec<String> = outcome
            .cylinders
            .iter()
            .filter_map(|cylinder| {
                let refusal = cylinder.result.as_ref().err()?;
                Some(format!("cylinder {}: {refusal}", cylinder.number))
            })
            .collect();
        match (refused.is_empty(), outcome.choice, self.model_of) {
            (true, Some(_), _) => Ok(()),
            (true, None, Some(n)) => {
                Err(Failure::Failed(format!("the model of cylinder {n} could not be tried")))
            }
            (true, None, None) => Err(Failure::Failed("there is no model".to_owned())),
            (false, ..) => Err(Failure::Failed(refused.join("\ntertius: "))),
        }
    }
}

/// The census of `window`, and what is to be said of values that could not be used.
fn survey(
    surveyed: &Surveyed,
    settings: &Settings,
    window: Window,
) -> Result<(Census, Option<String>), Failure> {
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
        calibrations: (1..=settings.machine.cylinders).map(calibration).collect(),
    };
    let mut census = Census::new(settings.machine.cylinders.into(), expected);
    let counts = surveyed.read(window, &mut census)?;
    let bad = (counts.bad_signals > 0).then(|| {
        let bad = counts.bad_signals;
        format!("{bad} values that their frame was too short for, or not a number (NaN)")
    });
    Ok((census, bad))
}

impl From<Offset> for OffsetRule {
    fn from(offset: Offset) -> Self {
        match offset {
            Offset::Auto => Self::WhereItMatters,
            Offset::Always => Self::Always,
            Offset::Never => Self::Never,
        }
    }
}
