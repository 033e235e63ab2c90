//! `tertius replay`: a recording through the monitor.

use super::Failure;
use super::history::History;
use super::machine::Machine;
use super::output::Output;
use super::page::PageFile;
use super::progress::Bar;
use crate::bus::{Options, Recording, Source, TimeStamps};
use crate::monitor::{Estimates, Monitor};
use crate::report::human::{self, Heading};
use crate::report::page::{self, Recorder};
use crate::report::{Stops, Summary, jsonl};
use clap::{Args, ValueEnum};
use std::fs;
use std::io::{IsTerminal, Write};
use std::path::{Path, PathBuf};

/// Runs candump recordings through the same monitor as the live gateway.
#[derive(Args, Debug)]
#[command(after_help = "Example:\n  tertius replay field.log.zst --config config/e-type.toml")]
pub struct Replay {
    /// candump recordings (-l, -L, or the console form with time stamps), read in turn; .gz and
    /// .zst as they are, - for standard input
    #[arg(required = true, value_name = "LOG")]
    logs: Vec<PathBuf>,
    /// The machine's configuration
    #[arg(long, value_name = "FILE")]
    config: PathBuf,
    /// A page for people, or lines of JSON for scripts
    #[arg(long, value_enum, default_value_t = Format::Human)]
    format: Format,
    /// Writes readings, estimates and residuals of every cylinder and cycle
    #[arg(long, value_name = "FILE.csv")]
    residuals: Option<PathBuf>,
    /// Writes the estimated length of every cylinder and cycle, with its standard deviation
    #[arg(long, value_name = "FILE.csv")]
    estimates: Option<PathBuf>,
    /// Writes the frames that the gateway would have sent, as candump -l lines
    #[arg(long, value_name = "FILE.log")]
    warnings: Option<PathBuf>,
    /// Writes a page with figures, in one file
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
    /// Goes on with what earlier recordings read on the stops, if the file is there, and writes it
    /// with this one's at the end; recordings in the order of time. `run` goes on with the same file
    #[arg(long, value_name = "FILE")]
    history: Option<PathBuf>,
    /// Takes only the frames of this interface [default: of all]
    #[arg(long, value_name = "NAME")]
    interface: Option<String>,
    /// What the time stamps of a console recording are
    #[arg(long, value_enum, default_value_t = Stamps::Auto)]
    time_stamps: Stamps,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Format {
    Human,
    Jsonl,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Stamps {
    /// As they look
    Auto,
    /// Time of day (candump -ta, -tA)
    Absolute,
    /// Since the frame before (candump -td)
    Delta,
    /// Since the first frame (candump -tz)
    Zero,
}

impl From<Stamps> for TimeStamps {
    fn from(stamps: Stamps) -> Self {
        match stamps {
            Stamps::Auto => Self::Auto,
            Stamps::Absolute => Self::Absolute,
            Stamps::Delta => Self::Delta,
            Stamps::Zero => Self::Zero,
        }
    }
}

/// Frames between two looks at progress and output.
const STRIDE: u64 = 1 << 16;

impl Replay {
    /// Replays.
    ///
    /// # Errors
    /// What is wrong with the call, its files or the output.
    pub fn run(self) -> Result<(), Failure> {
        let machine = Machine::load(&self.config)?;
        let options =
            Options { time_stamps: self.time_stamps.into(), interface: self.interface.clone() };
        let mut recording = Recording::open(&self.logs, options)?;
        self.refuse_overwriting(&machine)?;
        let mut output = Output::create(
            self.format == Format::Jsonl,
            self.residuals.as_deref(),
            self.estimates.as_deref(),
            self.warnings.as_deref(),
            &machine.loaded.settings.bus.interface,
        )?;
        let report = self.report.as_deref().map(PageFile::prepare).transpose()?;
        output.recorder = report.as_ref().map(|_| Recorder::new(&machine.design));
        let mut design = machine.design.clone();
        if self.estimates.is_some() && design.estimates == Estimates::None {
            design.estimates = Estimates::Told;
        }
        let mut monitor = Monitor::new(design);
        let history =
            self.history.as_deref().map(|path| History::read(path, &machine)).transpose()?;
        if let Some(history) = &history {
            monitor.inherit(history.archive());
        }
        let duration = feed(&mut recording, &mut monitor, &mut output)?;
        let whole = !output.failed();
        self.conclude(&machine, &recording, &monitor, duration, report, output)?;
        if let Some(history) = history.filter(|_| whole) {
            history.write(&monitor)?;
        }
        damage(&recording)
    }

    /// A file that is read here would be emptied before it is read.
    fn refuse_overwriting(&self, machine: &Machine) -> Result<(), Failure> {
        let outputs =
            [&self.residuals, &self.estimates, &self.warnings, &self.report, &self.history];
        let outputs = outputs.map(Option::as_deref);
        let inputs = self.logs.iter().chain([&self.config, &machine.loaded.dbc_path]);
        for (index, output) in outputs.iter().enumerate() {
            let Some(output) = output else { continue };
            if let Some(input) = inputs.clone().find(|input| is_same_file(input, output)) {
                let (output, input) = (output.display(), input.display());
                return Err(Failure::Wrong(format!(
                    "{output} would be written over the input {input}; name another file"
                )));
            }
            if outputs[..index].iter().flatten().any(|other| is_same_file(other, output)) {
                return Err(Failure::Wrong(format!(
                    "{} is to hold two outputs; name a file for each",
                    output.display()
                )));
            }
        }
        Ok(())
    }

    /// Tells what came of it on standard output, and on the page.
    fn conclude(
        &self,
        machine: &Machine,
        recording: &Recording,
        monitor: &Monitor,
        duration: f64,
        report: Option<PageFile>,
        mut output: Output,
    ) -> Result<(), Failure> {
        let tallies = monitor.tallies().copied().collect::<Vec<_>>();
        let counter_jumps = monitor.counter_jumps().collect::<Vec<_>>();
        let episodes = std::mem::take(&mut output.episodes);
        let stops = Stops {
            histories: monitor.sequential().map(|(n, it)| (n, it.dwells())).collect(),
            limits: machine.loaded.settings.drift_limits(),
        };
        let summary = Summary {
            stops: &stops,
            duration,
            statistics: recording.statistics(),
            counts: monitor.counts(),
            tallies: &tallies,
            counter_jumps: &counter_jumps,
            episodes: &episodes,
        };
        let inputs = self.logs.iter().map(|log| log.display().to_string()).collect::<Vec<_>>();
        let heading = Heading {
            inputs: &inputs.join(", "),
            machine: &machine.loaded.settings.machine.name,
            config: &self.config.display().to_string(),
            first: output.first,
            colour: std::io::stdout().is_terminal(),
        };
        let html = output.recorder.take().map(|recorder| {
            page::replay::page(&heading, &summary, &output.notices, &recorder.finish())
        });
        let to_stdout = |error| Failure::writing("standard output", &error);
        let printed = match output.lines() {
            Some(lines) => jsonl::summary(lines, &summary).map_err(to_stdout),
            None => {
                let text = human::page(&heading, &summary, &output.notices);
                std::io::stdout().write_all(text.as_bytes()).map_err(to_stdout)
            }
        };
        // A replay that was broken off, since nobody reads its lines, has no page.
        let whole = report.zip(html).filter(|_| !output.failed());
        let written = whole.map_or(Ok(()), |(report, html)| report.write(&html));
        printed.and(output.close()).and(written)
    }
}

/// Whether both are the same regular file, or would be. Devices and pipes may be named twice.
fn is_same_file(one: &Path, other: &Path) -> bool {
    match (fs::canonicalize(one), fs::canonicalize(other)) {
        (Ok(one), Ok(other)) => one == other && one.is_file(),
        _ => one == other,
    }
}

/// Feeds the whole recording to the monitor; the duration from its first to its last frame, s.
fn feed(
    recording: &mut Recording,
    monitor: &mut Monitor,
    output: &mut Output,
) -> Result<f64, Failure> {
    let bar = Bar::new(recording.progress());
    let mut first = None;
    let mut last = output.first;
    let mut frames = 0_u64;
    while let Some(frame) = recording.next_frame()? {
        last = frame.timestamp;
        output.first = *first.get_or_insert(last);
        monitor.take(frame, output);
        frames += 1;
        if frames.is_multiple_of(STRIDE) {
            if output.failed() {
                break;
            }
            bar.show(recording.progress());
        }
    }
    monitor.finish(output);
    bar.finish();
    Ok(last.since(output.first).as_seconds())
}

/// An input of which a part could not be read is a failure, though the rest was replayed.
fn damage(recording: &Recording) -> Result<(), Failure> {
    match recording.statistics().damage.first() {
        Some(damage) => Err(Failure::Failed(damage.to_string())),
        None => Ok(()),
    }
}
