//! `tertius demo`: a machine, its bus and the gateway in one process, to be watched.

mod audience;
mod listener;
mod programme;
mod scene;
mod score;
mod screen;
mod view;
mod wording;

use super::Failure;
use super::files::{Inputs, Mark, Overwriting};
use super::gateway;
use super::machine::Machine;
use super::overriding::SetOptions;
use super::plant::PlantOptions;
use super::player::Pace;
use super::simulation::Simulation;
use super::stage::Stage;
use crate::bus::Identifiers;
use crate::controller::State;
use crate::frame::BusNumber;
use crate::inject::{Placed, place};
use crate::live::supervisor;
use crate::simulator::{Options, Simulator, Tables};
use crate::time::Span;
use audience::Audience;
use clap::Args;
use listener::Listener;
use programme::Programme;
use scene::Scene;
use score::Score;
use screen::Screen;
use signal_hook::consts::{SIGINT, SIGTERM};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Speed of the start-up of the platform, during which there is little to see.
const PRELUDE: f64 = 6.0;

/// Shows the gateway at work on a simulated machine: faults arrive, it warns.
///
/// Simulator, embedded bus and gateway run in this process. Except for readings and residuals,
/// everything shown is read from the frames on the bus.
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  tertius demo
  tertius demo --speed max --record demo.log --force
  tertius replay demo.log --config config/e-type-simulated.toml
  tertius demo --config config/a-type-simulated.toml --plant config/a-type-plant.toml

On a terminal it takes 40 seconds and draws in place; elsewhere it writes lines, as fast as possible.
Exit code 1: a fault was not found as announced.")]
pub struct Demo {
    /// Speed as a multiple of real time; max: as fast as possible [default: 1 on a terminal, else
    /// max]
    #[arg(long, value_name = "N")]
    speed: Option<Pace>,
    /// Seed of everything random: the sea, the noise
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Shows the machine of this configuration [default: built in, as config/e-type-simulated.toml]
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    #[command(flatten)]
    set: SetOptions,
    #[command(flatten)]
    plant: PlantOptions,
    /// Shows a machine whose transducers and valves are CANopen devices
    #[arg(long, conflicts_with = "config")]
    canopen: bool,
    /// Writes all frames of the bus in the format of candump -l
    #[arg(long, value_name = "FILE.log")]
    record: Option<PathBuf>,
    #[command(flatten)]
    overwriting: Overwriting,
}

impl Demo {
    /// Runs the command.
    ///
    /// # Errors
    /// A fault was not found as announced, or an output cannot be written.
    pub fn run(self) -> Result<(), Failure> {
        let machine = self.machine()?;
        let tables = self.plant.tables()?;
        let settings = &machine.loaded.settings;
        PlantOptions::compare(&tables, settings);
        let programme = Programme::new(settings, &tables);
        let introduction = introduction(settings.machine.cylinders, programme.acts.len());
        let stage = self.stage(&machine, &tables, &programme)?;
        let mut audience = self.audience(&machine, &stage, programme)?;
        let opener =
            stage.opener(Identifiers::Only(gateway::identifiers(&machine, BusNumber::First)));
        let introduced = audience.screen.say(&introduction);
        introduced.map_err(|error| Failure::writing("standard output", &error))?;
        supervisor::run(gateway::gateway(machine), opener, &mut audience);
        // Its stopping status.
        audience.attend();
        end(audience)
    }

    /// The machine that is shown.
    fn machine(&self) -> Result<Machine, Failure> {
        let Some(config) = &self.config else {
            if self.set.are_given() {
                return Err(Failure::Wrong(
                    "--set changes a configuration, and none is given; add --config FILE"
                        .to_owned(),
                ));
            }
            return if self.canopen { Machine::simulated_canopen() } else { Machine::simulated() };
        };
        let machine = Machine::load(config, &self.set.overrides()?)?;
        let instead = "give a configuration with one bus";
        machine.refuse_several("the demonstration", instead)?;
        Ok(machine)
    }

    /// The bus with the machine connected to it.
    fn stage(
        &self,
        machine: &Machine,
        tables: &Tables,
        programme: &Programme,
    ) -> Result<Stage<Simulation>, Failure> {
        let settings = &machine.loaded.settings;
        // Only a given machine may have no place for a fault.
        let wrong = |error: &dyn std::fmt::Display| {
            Failure::Wrong(format!("{} cannot be shown: {error}", machine.loaded.document.name()))
        };
        let faults = (0..programme.acts.len())
            .map(|index| {
                let fault = programme.fault(index).map_err(|error| wrong(&error))?;
                place(&fault, settings, &machine.database).map_err(|error| wrong(&error))
            })
            .collect::<Result<Vec<Placed>, Failure>>()?;
        let options = Options { seed: self.seed, start: State::Safe, faults, ..Options::default() };
        let mut simulator = Simulator::new(tables, settings, &machine.database, &options)
            .map_err(|error| wrong(&error))?;
        simulator.request(State::Engaged);
        let cycles = (programme.end() / settings.machine.sample_time).round() as u64;
        // The last open cycle ends, and what follows from it gets past the guard.
        let rest = Span::from_seconds(settings.gateway.guard + settings.machine.sample_time);
        Stage::new(Simulation::new(simulator, cycles), Pace::Max, rest, None)
    }

    fn audience(
        &self,
        machine: &Machine,
        stage: &Stage<Simulation>,
        programme: Programme,
    ) -> Result<Audience, Failure> {
        let [over, interrupted] = [(); 2].map(|()| Arc::new(AtomicBool::new(false)));
        for signal in [SIGINT, SIGTERM] {
            signal_hook::flag::register(signal, Arc::clone(&interrupted))
                .map_err(|error| Failure::Failed(format!("signals cannot be caught: {error}")))?;
        }
        stage.stop_at_end(Arc::clone(&over));
        let wanted = [(self.record.as_deref(), Mark::None)];
        let config = self.config.iter().flat_map(|config| machine.files(config));
        let inputs = Inputs::new(config.chain(self.plant.files()));
        let [record] = inputs.claim(wanted, self.overwriting)?;
        let record = record.map(audience::record).transpose()?;
        let settings = &machine.loaded.settings;
        let (fde, comparator) = (settings.fde.high, settings.comparator.bound);
        let screen = Screen::new();
        let usual = if screen.is_terminal() { Pace::Times(1.0) } else { Pace::Max };
        let pace = self.speed.unwrap_or(usual);
        stage.set_pace(match pace {
            Pace::Times(times) => Pace::Times(PRELUDE * times),
            Pace::Max => Pace::Max,
        });
        Ok(Audience {
            stage: stage.clone(),
            ear: stage.listener()?,
            listener: Listener::new(
                settings,
                &machine.database,
                gateway::identifiers(machine, BusNumber::First),
            )?,
            screen,
            record,
            pace,
            limits: [fde, fde, comparator],
            over,
            interrupted,
            scene: Scene::new(programme.clone(), settings.machine.cylinders),
            score: Score::new(programme),
            strangers: 0,
            begun: [0; 2],
            failure: None,
        })
    }
}

/// What is shown, with so many `faults` to come.
fn introduction(cylinders: u8, faults: usize) -> [String; 4] {
    const WORDS: [&str; 7] = ["no", "one", "two", "three", "four", "five", "six"];
    let word = |number: usize| WORDS.get(number).map_or(number.to_string(), |it| (*it).to_owned());
    let whose = match cylinders {
        1 => "Its cylinder".to_owned(),
        many => format!("Each of {} cylinders", word(many.into())),
    };
    let mut faults = word(faults);
    faults.get_mut(..1).into_iter().for_each(str::make_ascii_uppercase);
    [
        "This is a simulated gangway, its CAN bus, and the gateway that listens to it.".to_owned(),
        format!("{whose} has two position transducers, C1 and C2. R1 and R2 are"),
        "their readings minus an observer's prediction, R3 is C1 minus C2: the largest of"
            .to_owned(),
        format!("a second. {faults} faults will come, one after the other. Ctrl-C ends it."),
    ]
}

/// Prints the result.
fn end(mut audience: Audience) -> Result<(), Failure> {
    if let Some(record) = audience.record.take() {
        record.into_inner().finish().map_err(|error| Failure::writing("the record", &error))?;
    }
    if let Some(failure) = audience.failure {
        return Err(failure);
    }
    let Audience { mut screen, score, scene, strangers, interrupted, .. } = audience;
    let at = scene.now;
    let [right, over] = score.tally(at);
    let [statuses, warnings] = scene.sent;
    let mut lines = vec![String::new()];
    lines.extend(score.table(at));
    lines.extend([
        String::new(),
        format!("{right} of {over} as announced, {} warnings without a fault.", score.unfounded()),
        format!("The gateway sent {statuses} Fd_Status and {warnings} Fd_Warning, and no other."),
    ]);
    screen.say(&lines).map_err(|error| Failure::writing("standard output", &error))?;
    // The cursor comes back before anything is said on standard error.
    drop(screen);
    let stopped = interrupted.load(Ordering::Relaxed);
    if strangers > 0 {
        return Err(Failure::Failed(format!("{strangers} frames on the bus are unknown")));
    }
    if right < over || !(stopped || over == scene.programme.acts.len()) {
        return Err(Failure::Failed(
            "not everything was found as announced; see the \
            table"
                .to_owned(),
        ));
    }
    Ok(())
}
