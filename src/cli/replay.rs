//! `tertius replay`: plays a recording through the monitor.

mod feeding;
mod witness;

use super::Failure;
use super::columns::ColumnFolder;
use super::files::{Claimed, Inputs, Mark, Overwriting};
use super::history::History;
use super::machine::Machine;
use super::output::{Explaining, Output};
use super::overriding::SetOptions;
use super::recorded::RecordedInputs;
use super::recording_options::{StampOption, recordings};
use super::state::{self, StateFile};
use crate::bus::{Options, Recording, Statistics};
use crate::config::visible;
use crate::monitor::{Estimates, Monitor};
use crate::report::alignment;
use crate::report::doubtful;
use crate::report::explanation;
use crate::report::human::{self, Heading};
use crate::report::page::{self, PageRecorder};
use crate::report::stamps::Stamped;
use crate::report::{Blanks, Judgement, Stops, Summary, Zone, estimates, jsonl, residuals};
use crate::time::Span;
use clap::{Args, ValueEnum};
use feeding::{damage, feed};
use jiff::tz::TimeZone;
use std::fs;
use std::io::{IsTerminal, Write};
use std::num::NonZero;
use std::path::{Path, PathBuf};
use std::thread;
use witness::Witness;

/// Runs recordings through the same monitor as the live gateway.
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  tertius replay field.log.zst --config config/e-type.toml
  tertius replay /var/lib/tertius/recordings/20260314T120000Z-cylinder-2-incident-1")]
pub struct Replay {
    #[arg(required = true, value_name = "LOG", help = recordings(" or .zst, - for standard input"))]
    logs: Vec<PathBuf>,
    /// The machine's configuration; the folder of a recorded incident has its own
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    #[command(flatten)]
    set: SetOptions,
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
    /// Writes warnings, incidents, notices, dwells, statistics of each minute and the summary as tables in Parquet
    /// files, below this folder by machine and day
    #[arg(long, value_name = "FOLDER")]
    parquet: Option<PathBuf>,
    /// The machine's name in the tables of --parquet [default: machine.name of the configuration]
    #[arg(long, value_name = "NAME", requires = "parquet")]
    machine: Option<String>,
    /// Continues the readings on the stops of earlier recordings, if the file exists, and adds
    /// those of this recording; recordings must be in the order of time. `run` can continue with
    /// the same file
    #[arg(long, value_name = "FILE")]
    history: Option<PathBuf>,
    /// Goes on from the monitor's state in the file, if it exists, and leaves the state there at the
    /// end of the recording, which is not taken for the end of the machine: recordings that are
    /// replayed one by one, in the order of time and with the same configuration, then give what
    /// they give together
    #[arg(long, value_name = "FILE")]
    state: Option<PathBuf>,
    /// Takes only the frames of this interface, by its name or, where a format has none, its number
    /// [default: the configuration's if the recording has it, else the only one]. For a machine with several
    /// buses that of each: first=can0,second=can1
    #[arg(long, value_name = "NAME", visible_alias = "channel")]
    interface: Option<String>,
    /// Explains the findings at this time, in seconds after the first frame, instead of replaying the rest: each rule that
    /// was asked whose fault a finding is, and what it answered
    #[arg(long, value_name = "SECONDS", value_parser = seconds_after_begin, conflicts_with_all =
        ["format", "residuals", "estimates", "warnings", "report", "parquet", "history", "state"])]
    explain: Option<Span>,
    /// Time zone of the text and the page, by its name in the IANA database
    #[arg(long, value_name = "NAME", default_value = "UTC", value_parser = zone)]
    time_zone: TimeZone,
    #[command(flatten)]
    overwriting: Overwriting,
    /// 1: reads, judges and writes in turn. 2: reads ahead, unless the recording comes by a pipe, and writes the tables
    /// of --residuals and --estimates behind, on threads of their own. The result is the same [default: as many as there
    /// are processors]
    #[arg(long, value_name = "N", value_parser = threads)]
    threads: Option<usize>,
    /// The meaning of the time stamps of a console recording
    #[arg(long, value_enum, default_value_t = StampOption::Auto)]
    time_stamps: StampOption,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Format {
    Human,
    Jsonl,
}

pub(super) fn zone(name: &str) -> Result<TimeZone, String> {
    Zone::named(name).ok_or_else(|| {
        format!("there is no time zone {name:?}; expected a name such as UTC or Europe/Amsterdam")
    })
}

fn seconds_after_begin(text: &str) -> Result<Span, String> {
    let seconds = text.parse().ok().filter(|it| (0.0..1e9).contains(it));
    let expected = || "expected seconds after the first frame, such as 300.5".to_owned();
    seconds.map(Span::from_seconds).ok_or_else(expected)
}

fn threads(text: &str) -> Result<usize, String> {
    let wanted = text.parse().ok().filter(|wanted| *wanted > 0);
    wanted.ok_or_else(|| {
        "expected a number of threads, 1 or more; more than 2 are not used".to_owned()
    })
}

/// Number of processors that may be used.
pub(super) fn processors() -> usize {
    thread::available_parallelism().map_or(1, NonZero::get)
}

impl Replay {
    /// Runs the command.
    ///
    /// # Errors
    /// A wrong call or file, or output that cannot be written.
    pub fn run(self) -> Result<(), Failure> {
        let mut inputs = RecordedInputs::of(&self.logs, self.config.as_deref())?;
        let machine = Machine::load(&inputs.config, &self.set.overrides()?)?;
        if machine.loaded.differs_from_file() {
            // What the monitor knew by another configuration.
            inputs.state = None;
        }
        let interfaces = machine.interfaces(self.interface.as_deref())?;
        let time_stamps = self.time_stamps.into();
        let options = Options { time_stamps, interfaces: interfaces.clone() };
        let mut recording = Recording::open(&inputs.logs, options.clone())?;
        let Claims { residuals, estimates, frames, report, state, columns } =
            self.claim(&machine, &inputs)?;
        let threads = self.threads.unwrap_or_else(processors);
        let mut output = Output::create(
            self.format == Format::Jsonl,
            [residuals, estimates, frames],
            &machine.loaded.settings,
            threads,
        )?;
        output.columns = columns;
        output.explaining = self.explain.map(|at| Explaining { at, explained: None });
        output.recorder = report.as_ref().map(|_| PageRecorder::new(&machine.design));
        let history =
            self.history.as_deref().map(|path| History::read(path, &machine)).transpose()?;
        let (mut monitor, mut kept) = self.monitor(&machine, state, &inputs, history.as_ref())?;
        let read = (&inputs, &options);
        let goes_on = monitor.newest().is_some();
        let mut witness = Witness::new(&machine);
        let watched = (&mut monitor, &mut witness);
        let duration = feed(&mut recording, threads, watched, &mut output, kept.as_mut(), read)?;
        if output.failed() {
            return broken_off(output);
        }
        if let Some(explaining) = &output.explaining {
            return explain(explaining, &machine, duration);
        }
        let statistics = recording.statistics();
        let stamped = Stamped { first: output.first, length: duration };
        let read = (&interfaces, statistics);
        let judgement = witness.judgement(&machine, read, &monitor, goes_on, stamped);
        let replayed = Replayed {
            machine: &machine,
            inputs: &inputs,
            statistics,
            monitor: &monitor,
            judgement: &judgement,
            remarks: &witness.remarks(),
            duration,
        };
        self.conclude(&replayed, report, output)?;
        if let Some(history) = history {
            history.write(&monitor)?;
        }
        if let Some(kept) = kept {
            kept.write(&monitor)?;
        }
        damage(statistics)?;
        match judgement.is_judged() {
            true => Ok(()),
            false => Err(Failure::Failed(format!(
                "nothing was judged: {}",
                judgement.reasons().join("; ")
            ))),
        }
    }

    /// The monitor of `machine`, and the file of its state, from which it goes on where there is one; otherwise from
    /// the state that was recorded with the `inputs`, or from the `history` of the stops.
    fn monitor(
        &self,
        machine: &Machine,
        state: Option<Claimed>,
        inputs: &RecordedInputs,
        history: Option<&History>,
    ) -> Result<(Monitor, Option<StateFile>), Failure> {
        let mut design = machine.design.clone();
        if self.estimates.is_some() && design.estimates == Estimates::None {
            design.estimates = Estimates::Computed;
        }
        let open = |(path, claimed)| StateFile::open(path, claimed, &design);
        let opened = self.state.as_deref().zip(state).map(open).transpose()?;
        let (kept, resumed) = opened.map_or((None, None), |(kept, it)| (Some(kept), it));
        let recorded = inputs.state.as_deref().filter(|_| self.state.is_none());
        let monitor = match (resumed, recorded) {
            (Some(resumed), _) => resumed,
            (None, Some(path)) => state::recorded(path, design)?,
            (None, None) => {
                let mut monitor = Monitor::new(design);
                if let Some(history) = history {
                    monitor.restore(history.archive());
                }
                monitor
            }
        };
        Ok((monitor, kept))
    }

    /// Claims the files that are written.
    fn claim(&self, machine: &Machine, inputs: &RecordedInputs) -> Result<Claims, Failure> {
        let logs = inputs.logs.iter().chain(&inputs.state).map(PathBuf::as_path);
        // The history that is gone on with may be the gateway's own.
        let real = |path: &Path| fs::canonicalize(path).ok();
        let kept = self.history.as_deref().and_then(real);
        let own = machine.loaded.history_path.as_deref();
        let is_kept = |path: &Path| Some(path) == own && kept.is_some() && real(path) == kept;
        let files = machine.files(&inputs.config).filter(|path| !is_kept(path));
        let header = |columns: &str| format!("{columns}\n");
        let (residuals, estimates) = (header(residuals::HEADER), header(estimates::HEADER));
        let wanted = [
            (self.residuals.as_deref(), Mark::Parts(&[&residuals])),
            (self.estimates.as_deref(), Mark::Parts(&[&estimates])),
            (self.warnings.as_deref(), Mark::None),
            (self.report.as_deref(), Mark::Page("replay")),
            (self.history.as_deref(), Mark::Judged),
            (self.state.as_deref(), Mark::Parts(&[state::MARK])),
        ];
        let inputs = Inputs::new(logs.chain(files));
        let [residuals, estimates, frames, report, _, state] =
            inputs.claim(wanted, self.overwriting)?;
        let columns = self.parquet.as_deref().map(|folder| {
            let name = self.machine.as_deref().unwrap_or(&machine.loaded.settings.machine.name);
            let names = machine.loaded.settings.names();
            ColumnFolder::create(folder, (name, names), inputs, self.overwriting)
        });
        Ok(Claims { residuals, estimates, frames, report, state, columns: columns.transpose()? })
    }

    /// Writes the results on standard output, and on the page.
    fn conclude(
        &self,
        replayed: &Replayed<'_>,
        report: Option<Claimed>,
        mut output: Output,
    ) -> Result<(), Failure> {
        let Replayed { machine, inputs, statistics, monitor, judgement, remarks, duration } =
            *replayed;
        let tallies = monitor.tallies().copied().collect::<Vec<_>>();
        let counter_jumps = monitor.counter_jumps().collect::<Vec<_>>();
        let of_all = (1..).zip(monitor.blanks());
        let blanks = of_all.flat_map(|(n, blanks)| blanks.map(move |blank| (n, blank)));
        let blanks = Blanks { blanks: blanks.collect(), unjudged: monitor.unjudged().collect() };
        let episodes = std::mem::take(&mut output.episodes);
        let incidents = std::mem::take(&mut output.incidents);
        let remarks: Vec<String> = remarks
            .iter()
            .cloned()
            .chain(alignment::remark(&episodes))
            .chain(doubtful::remarks(monitor.counts()))
            .chain(output.wraps.remarks())
            .collect();
        let histories = monitor.dwells().collect();
        let names = machine.loaded.settings.names();
        let stops = Stops::new(histories, machine.loaded.settings.drift_limits(), &names);
        let summary = Summary {
            stops: &stops,
            duration: duration.as_seconds(),
            recorded: duration.as_seconds() - output.jumped,
            sample_time: machine.loaded.settings.machine.sample_time,
            names: &names,
            fingerprints: &machine.loaded.fingerprints(),
            has_model: machine.loaded.has_model(),
            switched_off: machine.loaded.settings.switched_off(),
            observes: machine.loaded.settings.fde.enabled,
            judgement,
            remarks: &remarks,
            statistics,
            counts: monitor.counts(),
            tallies: &tallies,
            blanks: &blanks,
            counter_jumps: &counter_jumps,
            episodes: &episodes,
            incidents: &incidents,
        };
        let logs = inputs.logs.iter().map(|log| log.display().to_string()).collect::<Vec<_>>();
        let zone = Zone::new(self.time_zone.clone(), output.first, duration.as_seconds());
        let (inputs, title) = (logs.join(", "), machine.loaded.title());
        let heading = Heading {
            inputs: &visible(&inputs),
            machine: &visible(&machine.loaded.settings.machine.name),
            config: &visible(&title),
            zone: &zone,
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
        let written = report.zip(html).map_or(Ok(()), |(report, html)| report.write(&html));
        let budget = machine.loaded.settings.sequential.false_alarms_per_year;
        let columns = output.columns.take();
        let finish = |columns: ColumnFolder| columns.finish(&summary, &logs.join(","), budget);
        printed.and(output.close()).and(written).and_then(|()| columns.map_or(Ok(()), finish))
    }
}

/// The files that a replay writes, besides the history.
#[derive(Debug)]
struct Claims {
    residuals: Option<Claimed>,
    estimates: Option<Claimed>,
    frames: Option<Claimed>,
    report: Option<Claimed>,
    state: Option<Claimed>,
    columns: Option<ColumnFolder>,
}

/// Results of a replay after the whole recording was read.
#[derive(Clone, Copy)]
struct Replayed<'a> {
    machine: &'a Machine,
    inputs: &'a RecordedInputs,
    statistics: &'a Statistics,
    monitor: &'a Monitor,
    judgement: &'a Judgement,
    remarks: &'a [String],
    /// Duration from the first frame to the last.
    duration: Span,
}

/// Writes how the suspects at a time were named.
fn explain(explaining: &Explaining, machine: &Machine, duration: Span) -> Result<(), Failure> {
    let (at, length) = (explaining.at.as_seconds(), duration.as_seconds());
    let Some(explained) = &explaining.explained else {
        return Err(Failure::Wrong(format!(
            "--explain {at}: the recording ends {length} s after its first frame; give an earlier time"
        )));
    };
    if explained.findings.is_empty() && explained.unjudged.len() == explained.cylinders {
        return Err(Failure::Failed(format!(
            "--explain {at}: nothing was judged at that time; `tertius replay` without --explain reports why"
        )));
    }
    let text = explanation::text(explained, &machine.loaded.settings.names(), at);
    let written = std::io::stdout().write_all(text.as_bytes());
    written.map_err(|error| Failure::writing("standard output", &error))
}

/// Ends a replay whose output cannot be written: a page of the part that was read would look
/// complete.
fn broken_off(output: Output) -> Result<(), Failure> {
    output.close().map_err(|failure| match failure {
        Failure::Failed(message) => Failure::Failed(format!(
            "{message}; the replay stopped there, and neither page nor summary is written"
        )),
        other => other,
    })
}
