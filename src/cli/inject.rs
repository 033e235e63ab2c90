//! `tertius inject`: puts faults into a recording or a bus.

use super::Failure;
use super::faults::{self, FaultOptions, Faulty};
use super::files::{Inputs, Mark, Overwriting, Writer};
use super::machine::Machine;
use super::overriding::SetOptions;
use super::passing::{Newest, report};
use super::progress::Bar;
use super::proxy::{self, Ends};
use super::recording_options::recordings;
use crate::bus::{
    Interfaces, Options, Recording, Selected, Selection, Source, Statistics, append_log_line,
};
use crate::frame::Frame;
use crate::inject::{Injector, grammar};
use crate::text::counted;
use crate::time::Timestamp;
use clap::Args;
use std::collections::VecDeque;
use std::path::PathBuf;
use std::time::Duration;

const EXAMPLE: &str = "Examples:
  tertius inject healthy.log --config config/e-type.toml --output faulty.log \\
      --fault step,cylinder=3,sensor=c1,at=60,size=0.00175,until=65
  tertius inject --from can0 --to can1 --config config/e-type.toml \\
      --fault step,cylinder=3,sensor=c1,at=60,size=0.00175,until=65

With --from and --to it stands between two interfaces: the machine, or one who plays it, on the one,
and whatever is to be tested on the other. It is for test benches. Never put it between a machine
and its controller in operation: it sends whatever it hears, with faults, and late where it has to.

A fault is KIND,key=value,… with these keys, whatever the kind:
  cylinder      number of the cylinder, from 1
  sensor        a key of [signals.cylinder]: c1, c2, c1_velocity, … (default c1), or c1_heartbeat,
                c1_emergency, … (c2, valve) of a [[canopen.device]]
  at            when it begins, s since the first frame (default 0)
  until         when it has ended, s (default: to the end)
and these of its own (m where the sensor reads m, else the sensor's unit):
";

const TABLE: &str = "
A table begins with the line cylinder,sensor,kind,t0,magnitude,parameter,t1.

Only the bits of the named signals change, clamped to what they can hold, which is reported. The
machine's controller did not see the fault: the motion in the recording does not answer to it.

Between interfaces the first frame is the first that was forwarded. Error frames are not forwarded;
an interface that goes away is waited for; what comes meanwhile is dropped.
At the end, by SIGTERM, SIGINT or --for, it tells what became of the frames and the faults.";

/// Puts faults into recordings and writes the result in the format of candump -l, or
/// forwards frames between two interfaces of a test bench and puts faults into them.
#[derive(Args, Debug)]
#[command(after_help = format!("{EXAMPLE}{}{TABLE}", grammar()))]
pub struct Inject {
    #[arg(required_unless_present = "from", value_name = "LOG")]
    #[arg(help = recordings(" or .zst, - for standard input"))]
    logs: Vec<PathBuf>,
    /// Instead of recordings: interface whose frames get faults on their way to that of --to
    #[arg(long, value_name = "NAME", requires = "to")]
    #[arg(conflicts_with_all = ["logs", "output", "interface"])]
    from: Option<String>,
    /// The other interface, whose frames go to that of --from unchanged
    #[arg(long, value_name = "NAME", requires = "from", conflicts_with = "logs")]
    to: Option<String>,
    /// Ends the forwarding after this time [default: upon SIGTERM or SIGINT]
    #[arg(long = "for", value_name = "SECONDS", requires = "from", conflicts_with = "logs")]
    #[arg(value_parser = Ends::parse_seconds)]
    lasts: Option<Duration>,
    /// Between interfaces: drops a frame that could not be forwarded within this time
    #[arg(long, value_name = "SECONDS", requires = "from", conflicts_with = "logs")]
    #[arg(value_parser = Ends::parse_seconds, default_value = "0.1")]
    max_age: Duration,
    /// The machine's configuration
    #[arg(long, value_name = "FILE")]
    config: PathBuf,
    #[command(flatten)]
    set: SetOptions,
    /// Output for the recording with the faults; - for standard output
    #[arg(long, value_name = "FILE.log", default_value = "-")]
    output: PathBuf,
    #[command(flatten)]
    overwriting: Overwriting,
    #[command(flatten)]
    faults: FaultOptions,
    /// Seed of everything random: the same seed gives the same bytes
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    /// Puts faults only into frames of this interface, by its name or number [default: the
    /// configuration's if the recording has it, else the only one]; the others are passed on. For a machine
    /// with several buses those of each: first=can0,second=can1
    #[arg(long, value_name = "NAME", visible_alias = "channel")]
    interface: Option<String>,
}

/// Number of frames between two updates of the progress bar.
const STRIDE: u64 = 1 << 16;

impl Inject {
    /// Runs the command.
    ///
    /// # Errors
    /// A wrong call or file, a recording without a frame for a fault, or output that cannot be written.
    pub fn run(self) -> Result<(), Failure> {
        let faults = self.faults.read(Faulty::Readings)?;
        if faults.is_empty() {
            let message = "no fault to inject; give --fault SPEC or --faults FILE.csv";
            return Err(Failure::Wrong(message.to_owned()));
        }
        let machine = Machine::load_unjudging(&self.config, &self.set.overrides()?)?;
        let mut injector = Injector::new(&faults::place_all(&faults, &machine)?, self.seed);
        if let (Some(from), Some(to)) = (&self.from, &self.to) {
            machine.refuse_several("`inject` between interfaces", "inject into a recording")?;
            let (from, to) = (from.clone(), to.clone());
            let ends = Ends { from, to, lasts: self.lasts, max_age: self.max_age };
            let injector = proxy::run(&ends, injector)?;
            faults::report(&faults, injector.tallies());
            return Ok(());
        }
        let mut recording = Recording::open(&self.logs, Options::default())?;
        let [output] = self
            .inputs(&machine)
            .claim([(Some(self.output.as_path()), Mark::None)], self.overwriting)?;
        let out = output.expect("it was asked for").open()?;
        let line = Vec::new();
        let mut passage = Passage { injector: &mut injector, out, line, written: 0, times: None };
        let interfaces = machine.interfaces(self.interface.as_deref())?;
        let fallback = &machine.loaded.settings.bus.interface;
        let read = pump(&mut recording, &mut passage, &interfaces, fallback)?;
        let Passage { out, written, times, .. } = passage;
        if injector.tallies().iter().all(|tally| tally.frames == 0) {
            // What is dropped leaves the previous file.
            drop(out);
            faults::report(&faults, injector.tallies());
            return Err(self.nothing(read, times, recording.statistics()));
        }
        out.close()?;
        report(read, written, recording.statistics());
        faults::report(&faults, injector.tallies());
        match recording.statistics().damage.first() {
            Some(damage) => Err(Failure::Failed(damage.to_string())),
            None => Ok(()),
        }
    }

    fn inputs(&self, machine: &Machine) -> Inputs {
        let logs = self.logs.iter().map(PathBuf::as_path);
        Inputs::new(logs.chain(machine.files(&self.config)).chain(self.faults.table()))
    }

    /// Why no fault had an effect on the recording, of which so many frames were `read` between two `times`.
    fn nothing(
        &self,
        read: u64,
        times: Option<(Timestamp, Timestamp)>,
        statistics: &Statistics,
    ) -> Failure {
        let logs: Vec<String> = self.logs.iter().map(|log| log.display().to_string()).collect();
        let length = times.map_or(0.0, |(first, last)| last.since(first).as_seconds());
        let mut reasons = vec![format!(
            "no fault had an effect on {} ({} in {length:.2} s)",
            logs.join(", "),
            counted(read, "frame")
        )];
        reasons.extend(statistics.damage.iter().map(ToString::to_string));
        reasons.extend(statistics.barren.iter().map(ToString::to_string));
        let done = if self.output.as_os_str() == "-" {
            "what is on standard output is the recording as it was"
        } else {
            "nothing was written"
        };
        Failure::Failed(format!(
            "{}; {done}. Expected frames of {} while a fault lasts: is it a recording of this machine, and does a \
             fault begin before its end?",
            reasons.join("; "),
            self.config.display()
        ))
    }
}

/// The way of frames through the injector to the output.
struct Passage<'a> {
    injector: &'a mut Injector,
    out: Writer,
    line: Vec<u8>,
    written: u64,
    /// Times of the first and of the newest frame that was read.
    times: Option<(Timestamp, Timestamp)>,
}

impl Passage<'_> {
    /// Passes on a frame of the interface `name`, with its faults if it is `concerned`.
    fn pass(&mut self, name: &str, frame: &Frame, concerned: bool) -> Result<(), Failure> {
        let passed = if concerned { self.injector.take(frame) } else { Some(frame) };
        if let Some(frame) = passed {
            self.line.clear();
            append_log_line(&mut self.line, name, frame);
            self.out.put(&self.line)?;
            self.written += 1;
        }
        Ok(())
    }

    fn pass_all(
        &mut self,
        held: &mut VecDeque<(String, Frame)>,
        concerned: bool,
    ) -> Result<(), Failure> {
        held.drain(..).try_for_each(|(name, frame)| self.pass(&name, &frame, concerned))
    }
}

/// Passes on the whole recording; returns the number of frames. Frames of an unknown interface
/// count as those of `fallback`.
fn pump(
    recording: &mut Recording,
    passage: &mut Passage<'_>,
    interfaces: &Interfaces,
    fallback: &str,
) -> Result<u64, Failure> {
    let bar = Bar::new(recording.progress());
    let mut newest = Newest::default();
    let mut selection = Selection::new(interfaces.clone());
    let mut held = VecDeque::new();
    let mut read = 0_u64;
    while let Some(frame) = recording.next_frame()? {
        // The recording is asked about the frame's interface once it no longer lends the frame.
        let mut frame = frame.clone();
        let first = passage.times.map_or(frame.timestamp, |(first, _)| first);
        passage.times = Some((first, frame.timestamp));
        let name = newest.interface(recording.statistics()).unwrap_or(fallback);
        frame.bus = interfaces.bus(name.as_bytes()).unwrap_or_default();
        let Ok(selected) = selection.judge(name.as_bytes()) else {
            return Err(recording.ambiguous(interfaces).into());
        };
        match selected {
            Selected::Undecided => held.push_back((name.to_owned(), frame)),
            selected => {
                passage.pass_all(&mut held, false)?;
                passage.pass(name, &frame, selected == Selected::Wanted)?;
            }
        }
        if selection.is_decided() {
            passage.pass_all(&mut held, true)?;
        }
        read += 1;
        if read.is_multiple_of(STRIDE) {
            bar.show(recording.progress());
        }
    }
    selection.decide().map_err(|_| recording.ambiguous(interfaces))?;
    passage.pass_all(&mut held, true)?;
    bar.finish();
    Ok(read)
}
