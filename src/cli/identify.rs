//! `tertius identify`: a model from a healthy recording.

use super::Failure;
use super::files::{Claimed, Overwriting};
use super::survey::Field;
use super::tables::{self, InPlace};
use crate::config::design;
use crate::failure::print;
use crate::identify::course::{IdentificationCourse, Options};
use crate::identify::shaper::WIDEST;
use crate::identify::{OffsetRule, Outcome};
use crate::report::ReadWith;
use crate::report::{identification, nonlinear, page};
use crate::tables::model;
use clap::{Args, ValueEnum};
use std::path::PathBuf;

/// Identifies the model (4-1) of every cylinder on a healthy recording, and validates it on a part
/// that was held back.
#[derive(Args, Debug)]
#[command(
    after_help = "Example:\n  tertius identify field.log.zst --config config/e-type.toml --output \
                  model.toml"
)]
pub struct Identify {
    #[command(flatten)]
    field: Field,
    /// Writes the tables [model] and [[cylinder]] for the configuration, with --nonlinear also [cylinder.nonlinear], which
    /// `simulate --plant` takes, too
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
    /// Part of the time at the end that is held back for validation, %; 0 validates on the data of
    /// the fit
    #[arg(long, value_name = "PERCENT", default_value_t = 50, value_parser = clap::value_parser!(u8).range(0..=90))]
    held_back: u8,
    /// Uses the model of this cylinder [default: the one whose worst VAF is the best]
    #[arg(long, value_name = "N")]
    model_of: Option<u8>,
    /// Writes a model for each cylinder
    #[arg(long)]
    per_cylinder: bool,
    /// Whether to estimate also the command at which a cylinder rests
    #[arg(long, value_enum, default_value_t = Offset::Auto)]
    offset: Offset,
    /// Also identifies flow and friction curves: section 3-3-1
    #[arg(long)]
    nonlinear: bool,
    /// Supply pressure for --nonlinear, bar [default: the signal of signals.supply]
    #[arg(long, value_name = "BAR", requires = "nonlinear", value_parser = supply)]
    supply: Option<f64>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Offset {
    /// If it exceeds a tenth of the command's standard deviation
    Auto,
    Always,
    /// As in the thesis
    Never,
}

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
    /// Runs the command.
    ///
    /// # Errors
    /// A wrong call or file, or cylinders that were refused.
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
        let (settings, origin) = (&surveyed.machine.loaded.settings, &surveyed.origin());
        let outcome =
            IdentificationCourse { settings, origin, options: self.options() }.run(&surveyed)?;
        let with = ReadWith::from(&surveyed.machine.loaded);
        let text = identification::page(&outcome, &with);
        print(&text)?;
        self.write(&outcome, output)?;
        if let Some(report) = report {
            report.write(&page::identification::page(&outcome, &with))?;
        }
        surveyed.damage()?;
        self.conclude(&outcome)?;
        self.complete(&outcome)
    }

    const fn options(&self) -> Options {
        Options {
            window: self.window,
            held_back: self.held_back,
            model_of: self.model_of,
            offset: self.offset.rule(),
            nonlinear: if self.nonlinear { Some(self.supply) } else { None },
        }
    }

    fn write(&self, outcome: &Outcome, output: Option<Claimed>) -> Result<(), Failure> {
        if outcome.follows(self.per_cylinder).is_err() {
            return Ok(());
        }
        let version = env!("CARGO_PKG_VERSION");
        let Some(tables) = model::of(outcome, version, self.per_cylinder) else {
            return Ok(());
        };
        output.map_or(Ok(()), |output| output.write(&tables))?;
        self.place.put(&tables, &model::anew(outcome), design::unjudging)
    }

    /// Fails if a cylinder has no model, although the others have theirs.
    fn conclude(&self, outcome: &Outcome) -> Result<(), Failure> {
        let follows = outcome.follows(self.per_cylinder);
        follows.map_err(|why| Failure::Failed(format!("nothing is written: {why}")))?;
        let refused = outcome.refusals();
        match (refused.is_empty(), outcome.choice, self.model_of) {
            (true, Some(_), _) => Ok(()),
            (true, None, Some(n)) => {
                Err(Failure::Failed(format!("the model of cylinder {n} could not be tried")))
            }
            (true, None, None) => Err(Failure::Failed("there is no model".to_owned())),
            (false, ..) => Err(Failure::refused(&refused)),
        }
    }
}

impl Identify {
    /// Fails if flow curves were to be written and a cylinder has none.
    fn complete(&self, outcome: &Outcome) -> Result<(), Failure> {
        let wanted = self.output.is_some() || self.place.is_wanted();
        let missing = outcome.nonlinear.as_ref().map_or(String::new(), nonlinear::no_valve);
        if !wanted || missing.is_empty() {
            return Ok(());
        }
        Err(Failure::Failed(format!(
            "{missing}their [cylinder.nonlinear.flow] is not written; everything else is"
        )))
    }
}

impl Offset {
    const fn rule(self) -> OffsetRule {
        match self {
            Self::Auto => OffsetRule::WhereItMatters,
            Self::Always => OffsetRule::Always,
            Self::Never => OffsetRule::Never,
        }
    }
}
