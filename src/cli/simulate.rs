//! `tertius simulate`: a recording of a simulated machine, or its bus, live.

use super::Failure;
use super::broadcast::Broadcast;
use super::faults::{self, FaultOptions, Faulty, Named};
use super::files::{Claimed, Inputs, Mark, Overwriting};
use super::machine::Machine;
use super::overriding::SetOptions;
use super::plant::{self, PlantOptions};
use super::player::Pace;
use super::simulation::Simulation;
use crate::bus::{Source, append_log_line};
use crate::controller::State;
use crate::inject::{Fault, Wanted, grammar, machine_grammar};
use crate::simulator::{Options, Simulator, truth};
use crate::time::Span;
use clap::{Args, ValueEnum};
use std::path::{Path, PathBuf};

const EXAMPLE: &str = "Examples:
  tertius simulate --config config/e-type.toml --duration 60 --seed 1 --output e-type.log \\
      --fault step,cylinder=3,sensor=c1,at=30,size=0.0025 --truth e-type.truth.csv
  tertius simulate --config config/e-type.toml --duration 600 --interface vcan0

The machine begins engaged, its cylinders following a sea; with --start safe it goes through all
platform states first, and with --states 0:engaged,60:safe,70:engaged it is released after a minute and
engages again. The same call gives the same bytes, in a file and on an interface. A fault is
KIND,key=value,… as in `tertius inject`, sensor c1 by default:
";

const MACHINE: &str = "
A fault of the machine itself is written in the same way, without a sensor, and moves the cylinder:
";

const LOOP: &str = "
A table begins with the line cylinder,sensor,kind,t0,magnitude,parameter,t1, as --truth writes it.

A fault is added to the reading on the bus; with --in-loop the machine's controller reads it, too,
and moves the cylinder.

A [[canopen.device]] sends heartbeats where its EDS has a time for them (object 0x1017). For it,
  broken_wire,sensor=c1_emergency     says that it has an error (EMCY 0x5000; code=…), and at the end that it is over
  out_of_range,sensor=c1_heartbeat    says in its heartbeat that it is pre-operational (raw=…)
  loss,sensor=c1_heartbeat            stops its heartbeat
and so for c2 and valve.";

/// Longest simulation, s: a year.
const LONGEST: f64 = 366.0 * 86_400.0;

/// Simulates a machine and writes its frames in the format of candump -l, or sends them on an
/// interface.
#[derive(Args, Debug)]
#[command(after_help = format!("{EXAMPLE}{}{MACHINE}{}{LOOP}", grammar(), machine_grammar()))]
pub struct Simulate {
    /// The machine's configuration: its signals, and the DBC that places them
    #[arg(long, value_name = "FILE")]
    config: PathBuf,
    #[command(flatten)]
    set: SetOptions,
    #[command(flatten)]
    plant: PlantOptions,
    /// Duration in the machine's time, s
    #[arg(long, value_name = "S", default_value_t = 60.0)]
    duration: f64,
    /// Seed of everything random: the same seed gives the same bytes
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    /// Significant wave height, m, and peak period, s [default: the plant's]
    #[arg(long, value_name = "HS,TP")]
    sea: Option<String>,
    /// State of the platform at the beginning; it then goes to engaged
    #[arg(long, value_enum, default_value_t = Start::Engaged)]
    start: Start,
    /// States that the platform is asked for, and when, s; those in between it passes through, but safe is
    /// reached at once [default: 0:engaged]
    #[arg(long, value_name = "S:STATE,…", value_delimiter = ',', value_parser = Request::parse)]
    states: Vec<Request>,
    #[command(flatten)]
    faults: FaultOptions,
    /// The controller reads C1 with its faults
    #[arg(long)]
    in_loop: bool,
    /// Output for the recording; - for standard output [default: -, but none with --interface]
    #[arg(long, value_name = "FILE.log")]
    output: Option<PathBuf>,
    /// Sends the frames on this interface (vcan or vxcan), each at its time, until --duration or
    /// SIGINT
    #[arg(long, value_name = "NAME")]
    interface: Option<String>,
    /// On the interface: speed as a multiple of real time; max: as fast as possible
    #[arg(long, value_name = "N", default_value = "1", requires = "interface")]
    speed: Pace,
    /// Allows also a real bus: for test benches, never where a machine listens
    #[arg(long, requires = "interface")]
    real_bus: bool,
    /// Output for a table of the faults, which `inject` can also read
    #[arg(long, value_name = "FILE.csv")]
    truth: Option<PathBuf>,
    #[command(flatten)]
    overwriting: Overwriting,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Start {
    Safe,
    Settled,
    Neutral,
    Engaged,
}

/// A state that the platform is asked for at a time.
#[derive(Clone, Copy, Debug)]
struct Request {
    /// s since the first cycle.
    at: f64,
    state: State,
}

impl Request {
    fn parse(text: &str) -> Result<Self, String> {
        let expected = || {
            format!(
                "{text:?}, expected seconds and a state, safe, settled, neutral or engaged, such as 60:safe"
            )
        };
        let (at, state) = text.split_once(':').ok_or_else(expected)?;
        let at = at.trim().parse().ok().filter(|at| (0.0..=LONGEST).contains(at));
        let state = Start::from_str(state.trim(), true).ok();
        at.zip(state).map(|(at, state)| Self { at, state: state.into() }).ok_or_else(expected)
    }
}

impl From<Start> for State {
    fn from(start: Start) -> Self {
        match start {
            Start::Safe => Self::Safe,
            Start::Settled => Self::Settled,
            Start::Neutral => Self::Neutral,
            Start::Engaged => Self::Engaged,
        }
    }
}

impl Simulate {
    /// Runs the command.
    ///
    /// # Errors
    /// A wrong call or file, or output that cannot be written.
    pub fn run(self) -> Result<(), Failure> {
        self.duration()?;
        let sea = self.sea.as_deref().map(plant::sea).transpose()?;
        let faults = self.faults.read(Faulty::Machine)?;
        let tables = self.plant.tables()?;
        let machine = Machine::load_unjudging(&self.config, &self.set.overrides()?)?;
        let settings = &machine.loaded.settings;
        PlantOptions::compare(&tables, settings);
        let of_the_machine = |named: &Named| matches!(named.fault.wanted, Wanted::Machine(_));
        let (ailments, readings): (Vec<Named>, Vec<Named>) =
            faults.iter().cloned().partition(of_the_machine);
        let placed = faults::place_all(&readings, &machine)?;
        faults::on_the_machine(&ailments, settings.machine.cylinders)?;
        let cycles = self.cycles(&machine)?;
        let end = Span::from_seconds(cycles as f64 * settings.machine.sample_time);
        faults::before_the_end(&faults, end)?;
        let options = Options {
            seed: self.seed,
            sea,
            start: self.start.into(),
            in_loop: self.in_loop,
            faults: placed,
            ailments: ailments.iter().map(|named| named.fault).collect(),
            ..Options::default()
        };
        let mut simulator = Simulator::new(&tables, settings, &machine.database, &options)
            .map_err(|error| Failure::Wrong(error.to_string()))?;
        let requests = self.requests(settings.machine.sample_time);
        if requests.is_empty() {
            simulator.request(State::Engaged);
        }
        let table = truth::table(&faults.iter().map(|named| named.fault).collect::<Vec<Fault>>());
        let [output, truth] = self.outputs(&machine, &table)?;
        let simulation = Simulation::new(simulator, cycles).asked_for(requests);
        let names: Vec<&str> = settings.bus.interfaces().map(|(_, name)| name).collect();
        let simulation = self.go(simulation, &names, output)?;
        if let Some(truth) = truth {
            truth.write(&table)?;
        }
        faults::report(&readings, simulation.tallies());
        Ok(())
    }

    /// The recording, if requested, and the file for the table of `truth`.
    fn outputs(&self, machine: &Machine, truth: &str) -> Result<[Option<Claimed>; 2], Failure> {
        let others = self.faults.table().into_iter().chain(self.plant.files());
        let inputs = Inputs::new(machine.files(&self.config).chain(others));
        let standard = self.interface.is_none().then_some(Path::new("-"));
        let recording = (self.output.as_deref().or(standard), Mark::None);
        inputs.claim([recording, (self.truth.as_deref(), Mark::Text(truth))], self.overwriting)
    }

    /// Simulates to the end, into the recording and onto the interface. `names` are the interfaces'
    /// names in the recording, by bus: those of the configuration, so that the same call gives the same
    /// bytes wherever it sends them.
    fn go(
        &self,
        mut simulation: Simulation,
        names: &[&str],
        output: Option<Claimed>,
    ) -> Result<Simulation, Failure> {
        let mut broadcast = match &self.interface {
            Some(interface) => Some(Broadcast::open(interface, self.speed, self.real_bus)?),
            None => None,
        };
        let mut recording = output.map(Claimed::open).transpose()?;
        let (mut frames, mut line) = (0_u64, Vec::with_capacity(192));
        while let Some(frame) = simulation.next_frame()? {
            if let Some(broadcast) = &mut broadcast
                && !broadcast.send(frame)?
            {
                break;
            }
            if let Some(recording) = &mut recording {
                line.clear();
                append_log_line(&mut line, names[frame.bus.index()], frame);
                recording.put(&line)?;
            }
            frames += 1;
        }
        if let Some(recording) = recording {
            recording.close()?;
            tell!("{frames} frames");
        }
        if let Some(broadcast) = &broadcast {
            broadcast.report();
        }
        Ok(simulation)
    }

    /// Cycles at which states are asked for, in order.
    fn requests(&self, sample_time: f64) -> Vec<(u64, State)> {
        let cycle = |request: &Request| ((request.at / sample_time).round() as u64, request.state);
        let mut requests: Vec<_> = self.states.iter().map(cycle).collect();
        requests.sort_by_key(|(cycle, _)| *cycle);
        requests
    }

    fn duration(&self) -> Result<(), Failure> {
        if self.duration > 0.0 && self.duration <= LONGEST {
            return Ok(());
        }
        let given = self.duration;
        Err(Failure::Wrong(format!("--duration is {given}, expected seconds, up to {LONGEST}")))
    }

    /// Number of cycles of the `machine` in the duration.
    fn cycles(&self, machine: &Machine) -> Result<u64, Failure> {
        let (given, cycle) = (self.duration, machine.loaded.settings.machine.sample_time);
        if given >= cycle {
            return Ok((given / cycle).round() as u64);
        }
        Err(Failure::Wrong(format!(
            "--duration is {given} s, which is shorter than a cycle of {}; expected at least {cycle} s \
             (machine.sample_time)",
            machine.loaded.title()
        )))
    }
}
