//! `tertius simulate`: a recording of a machine that nobody has on the desk.

use super::Failure;
use super::machine::Machine;
use super::plant;
use crate::bus::append_log_line;
use crate::controller::State;
use crate::inject::{Fault, MAX_FAULTS, Placed, Tally, grammar, place};
use crate::simulator::{Options, Simulator, truth};
use clap::{Args, ValueEnum};
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

const EXAMPLE: &str = "Example:
  tertius simulate --config config/e-type.toml --duration 60 --seed 1 --output e-type.log \\
      --fault step,cylinder=3,sensor=c1,at=30,size=0.0025 --truth e-type.truth.csv

The machine begins engaged, its cylinders following a sea; with --start safe it goes through all
platform states first. The same call gives the same bytes. A fault is KIND,key=value,… as in
`tertius inject`, sensor c1 by default:
";

const LOOP: &str = "
A fault is added to the reading on the bus; with --in-loop the machine's controller reads it, too,
and moves the cylinder.";

/// The longest simulation, s: a year.
const LONGEST: f64 = 366.0 * 86_400.0;

/// Simulates a machine and writes its frames as candump -l would.
#[derive(Args, Debug)]
#[command(after_help = format!("{EXAMPLE}{}{LOOP}", grammar()))]
pub struct Simulate {
    /// The machine's configuration: its signals, and the DBC that places them
    #[arg(long, value_name = "FILE")]
    config: PathBuf,
    /// The simulated machine [default: built in, as config/e-type-plant.toml]
    #[arg(long, value_name = "FILE")]
    plant: Option<PathBuf>,
    /// s of the machine's time
    #[arg(long, value_name = "S", default_value_t = 60.0)]
    duration: f64,
    /// Whatever is random comes from this number
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    /// Significant wave height, m, and peak period, s [default: the plant's]
    #[arg(long, value_name = "HS,TP")]
    sea: Option<String>,
    /// The platform's state at the beginning; it goes on to engaged
    #[arg(long, value_enum, default_value_t = Start::Engaged)]
    start: Start,
    /// A fault; several act in this order where they meet
    #[arg(long = "fault", value_name = "SPEC")]
    faults: Vec<String>,
    /// The controller reads C1 with its faults
    #[arg(long)]
    in_loop: bool,
    /// Where the recording goes; - for standard output
    #[arg(long, value_name = "FILE.log", default_value = "-")]
    output: PathBuf,
    /// Where a table of the faults goes, which `inject` reads, too
    #[arg(long, value_name = "FILE.csv")]
    truth: Option<PathBuf>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Start {
    Safe,
    Settled,
    Neutral,
    Engaged,
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
    /// Simulates.
    ///
    /// # Errors
    /// What is wrong with the call, its files or the output.
    pub fn run(self) -> Result<(), Failure> {
        let cycles_for = self.duration()?;
        let sea = self.sea.as_deref().map(plant::sea).transpose()?;
        let faults = self.faults()?;
        let tables = plant::tables(self.plant.as_deref())?;
        let machine = Machine::load(&self.config)?;
        let settings = &machine.loaded.settings;
        let wrong = |text: &str, error: &dyn std::fmt::Display| {
            Failure::Wrong(format!("--fault {text:?}: {error}"))
        };
        let placed = self
            .faults
            .iter()
            .zip(&faults)
            .map(|(text, fault)| {
                place(fault, settings, &machine.database).map_err(|error| wrong(text, &error))
            })
            .collect::<Result<Vec<Placed>, Failure>>()?;
        let options = Options {
            seed: self.seed,
            sea,
            start: self.start.into(),
            in_loop: self.in_loop,
            faults: placed,
            ..Options::default()
        };
        let mut simulator = Simulator::new(&tables, settings, &machine.database, &options)
            .map_err(|error| Failure::Wrong(error.to_string()))?;
        simulator.request(State::Engaged);
        let cycles = (cycles_for / settings.machine.sample_time).round() as u64;
        let interface = &settings.bus.interface;
        let frames = record(&mut simulator, cycles, interface, &self.output)?;
        if let Some(path) = &self.truth {
            std::fs::write(path, truth::table(&faults))
                .map_err(|error| Failure::creating(path, &error))?;
        }
        report(&self.faults, simulator.tallies(), frames);
        Ok(())
    }

    fn duration(&self) -> Result<f64, Failure> {
        if self.duration > 0.0 && self.duration <= LONGEST {
            return Ok(self.duration);
        }
        let given = self.duration;
        Err(Failure::Wrong(format!("--duration is {given}, expected seconds, up to {LONGEST}")))
    }

    fn faults(&self) -> Result<Vec<Fault>, Failure> {
        if self.faults.len() > MAX_FAULTS {
            let given = self.faults.len();
            return Err(Failure::Wrong(format!("{given} faults, expected at most {MAX_FAULTS}")));
        }
        let parse = |text: &String| {
            Fault::parse(text).map_err(|error| Failure::Wrong(format!("--fault {text:?}: {error}")))
        };
        self.faults.iter().map(parse).collect()
    }
}

/// Writes the frames of so many cycles; how many there were.
fn record(
    simulator: &mut Simulator,
    cycles: u64,
    interface: &str,
    output: &Path,
) -> Result<u64, Failure> {
    let (writer, name): (Box<dyn Write>, _) = if output == Path::new("-") {
        (Box::new(io::stdout()), "standard output".to_owned())
    } else {
        let file = File::create(output).map_err(|error| Failure::creating(output, &error))?;
        (Box::new(file), output.display().to_string())
    };
    let mut writer = BufWriter::with_capacity(1 << 16, writer);
    let mut lines = Vec::with_capacity(1 << 13);
    let mut frames = 0;
    for _ in 0..cycles {
        lines.clear();
        simulator.step(&mut |frame| {
            frames += 1;
            append_log_line(&mut lines, interface, frame);
        });
        writer.write_all(&lines).map_err(|error| Failure::writing(&name, &error))?;
    }
    writer.flush().map_err(|error| Failure::writing(&name, &error))?;
    Ok(frames)
}

/// Tells what became of each fault, on standard error: the recording may be on standard output.
fn report(faults: &[String], tallies: &[Tally], frames: u64) {
    eprintln!("{frames} frames");
    for (text, tally) in faults.iter().zip(tallies) {
        eprintln!("--fault {text:?}: {} of {} frames changed or lost", tally.altered, tally.frames);
        if tally.clamped > 0 {
            eprintln!("  {} clamped to what the signal can hold", tally.clamped);
        }
    }
}
