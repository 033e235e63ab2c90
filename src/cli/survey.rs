//! Recordings for the commands that learn from them: read more than once, as rows instead of
//! frames, within a window of time.

use super::Failure;
use super::machine::Machine;
use super::overriding::SetOptions;
use super::progress::Bar;
use super::recording_options::{StampOption, recordings};
use crate::bus::{Options, Recording, Source, Statistics, TimeStamps, in_order};
use crate::frame::{Frame, Kind};
use crate::monitor::{Counts, MonitorDesign};
use crate::report;
use crate::report::RecordedPace;
use crate::report::judgement::RecordedFacts;
use crate::survey::{self, Frames, Origin, Rows, Surveyor, Timeline, Window};
use crate::time::Span;
use clap::Args;
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// Recordings of a machine, and the part that is used.
#[derive(Args, Debug)]
pub struct Field {
    #[arg(required = true, value_name = "LOG", help = recordings(" or .zst"))]
    pub logs: Vec<PathBuf>,
    /// The machine's configuration
    #[arg(long, value_name = "FILE")]
    pub config: PathBuf,
    #[command(flatten)]
    pub set: SetOptions,
    /// Leaves out everything before: seconds since the first frame, or a part, like 25%. A pause of
    /// more than a minute counts as a minute
    #[arg(long, value_name = "TIME")]
    pub from: Option<Place>,
    /// Leaves out everything after: seconds since the first frame, or a part, like 75%
    #[arg(long, value_name = "TIME")]
    pub to: Option<Place>,
    /// Takes only the frames of this interface, by its name or, where a format has none, its number
    /// [default: the configuration's if the recording has it, else the only one]. For a machine with several
    /// buses that of each: first=can0,second=can1
    #[arg(long, value_name = "NAME", visible_alias = "channel")]
    pub interface: Option<String>,
    /// The meaning of the time stamps of a console recording
    #[arg(long, value_enum, default_value_t = StampOption::Auto)]
    pub time_stamps: StampOption,
}

/// A place in a recording, from the command line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Place {
    /// Time since the first frame, s.
    Seconds(f64),
    /// Part of the recording: 0 is the first frame, 1 the last.
    Part(f64),
}

/// A recording with its machine, its beginning and its end, ready to be read as often as needed.
pub struct Surveyed {
    pub machine: Machine,
    pub design: MonitorDesign,
    /// Times of the recording's frames.
    pub timeline: Timeline,
    /// Requested window.
    pub window: Window,
    pub statistics: Statistics,
    /// Remarks on frames from before the first one, if there are any, and on a Sync that did not come.
    doubts: Vec<String>,
    /// Whether the recordings were named in another order than that of time.
    reordered: bool,
    logs: Vec<PathBuf>,
    options: Options,
}

/// Number of frames between two updates of the progress bar.
const STRIDE: u64 = 1 << 16;

/// Results of the first reading of a recording.
#[derive(Debug, Default)]
struct Extent {
    timeline: Timeline,
    frames: u64,
    /// Number of frames with an identifier of the configuration.
    used: u64,
    /// Number of frames with a time stamp before the first one: time went backwards.
    before: u64,
    /// Number of frames with times that had been recorded already.
    again: u64,
}

/// Time by which a frame may be earlier than the latest one, as where several senders are stamped apart.
const OUT_OF_ORDER: Span = Span::from_nanos(1_000_000_000);

/// Largest part of frames from before the first one with which a recording is accepted, since
/// learning would leave them out.
const LARGEST_LOSS: f64 = 0.01;

impl Extent {
    fn of(
        recording: &mut Recording,
        design: &MonitorDesign,
        pace: &mut RecordedPace,
    ) -> Result<Self, Failure> {
        let bar = Bar::new(recording.progress());
        let mut extent = Self::default();
        while let Some(frame) = recording.next_frame()? {
            if extent.take(frame, design) {
                pace.take(frame);
            }
            if extent.frames.is_multiple_of(STRIDE) {
                bar.show(recording.progress());
            }
        }
        bar.finish();
        Ok(extent)
    }

    /// Takes a frame; returns whether the configuration uses it.
    fn take(&mut self, frame: &Frame, design: &MonitorDesign) -> bool {
        let at = frame.timestamp;
        let latest = self.timeline.ends().map(|(_, latest)| latest);
        self.again += u64::from(latest.is_some_and(|latest| latest.since(at) > OUT_OF_ORDER));
        self.timeline.take(at);
        self.frames += 1;
        self.before += u64::from(at < self.timeline.first());
        let used = reads(design, frame);
        if used {
            self.timeline.read(frame);
            self.used += 1;
        }
        used
    }

    /// Remark on frames from before the first one, if there are any.
    fn backwards(&self) -> Result<Option<String>, Failure> {
        let Self { frames, before, .. } = *self;
        if before == 0 {
            return Ok(None);
        }
        let first = self.timeline.first();
        let told = format!(
            "{before} of {frames} frames are earlier than the first one, at \
            {first}"
        );
        if before as f64 <= LARGEST_LOSS * frames as f64 {
            return Ok(Some(format!("{told}, and are left out")));
        }
        Err(Failure::Wrong(format!(
            "{told}, and would be left out: the clock was set back, or recordings are not in the order \
             of time; learn from one part at a time"
        )))
    }

    /// Refuses what has the same times twice, of which nobody knows what was when.
    fn all_once(&self) -> Result<(), Failure> {
        let Self { frames, again, .. } = *self;
        if again as f64 <= LARGEST_LOSS * frames as f64 {
            return Ok(());
        }
        Err(Failure::Wrong(format!(
            "{again} of {frames} frames have times that had been recorded before: recordings overlap, one is \
             named twice, or the clock was set back; name each recording once, and learn from one part at a time"
        )))
    }
}

impl Field {
    /// Loads the machine and reads the recording once for its length.
    ///
    /// # Errors
    /// A wrong call or file, or a recording without a frame.
    pub fn open(&self) -> Result<Surveyed, Failure> {
        if self.logs.iter().any(|log| log.as_os_str() == "-") {
            return Err(Failure::Wrong(
                "-: the recording is read more than once, which is impossible with standard input; \
                 name a file"
                    .to_owned(),
            ));
        }
        let machine = Machine::load_surveying(&self.config, &self.set.overrides()?)?;
        let design = machine.design.clone();
        let interfaces = machine.interfaces(self.interface.as_deref())?;
        let options = Options { time_stamps: self.time_stamps.into(), interfaces };
        let logs = self.in_order(&options);
        let mut recording = Recording::open(&logs, options.clone())?;
        let mut pace = machine.pace();
        let extent = Extent::of(&mut recording, &design, &mut pace)?;
        let statistics = recording.statistics().clone();
        let (interfaces, used) = (&options.interfaces, extent.used);
        let recorded = RecordedFacts {
            statistics: &statistics,
            interfaces,
            design: &design,
            used,
            goes_on: false,
        };
        let nothing = recorded.nothing();
        if extent.timeline.ends().is_none() || !nothing.is_empty() {
            let reasons = nothing.join("; ");
            return Err(Failure::Failed(format!("nothing was judged: {reasons}")));
        }
        let backwards = extent.backwards()?;
        extent.all_once()?;
        let doubt = pace.of_a_lesson().map_err(Failure::Wrong)?;
        let doubts = backwards.into_iter().chain(doubt).collect();
        let timeline = extent.timeline;
        let window = self.window(timeline.length())?;
        let reordered = logs != self.logs;
        Ok(Surveyed {
            machine,
            design,
            timeline,
            window,
            statistics,
            doubts,
            reordered,
            logs,
            options,
        })
    }

    /// The recordings in the order of time, so that learning does not depend on the order of their
    /// names.
    fn in_order(&self, options: &Options) -> Vec<PathBuf> {
        match options.time_stamps {
            TimeStamps::Auto | TimeStamps::Absolute => in_order(&self.logs, &options.interfaces),
            _ => self.logs.clone(),
        }
    }

    /// The requested window of a recording of `length` seconds.
    fn window(&self, length: f64) -> Result<Window, Failure> {
        let at = |place: Place| match place {
            Place::Seconds(seconds) => seconds,
            Place::Part(part) => part * length,
        };
        let from = self.from.map_or(0.0, at);
        // The last cycle opens before the last frame; without an end given it is within.
        let to = self.to.map_or(length + 1e-9, at);
        if from < to && from < length {
            return Ok(Window { from, to: to.min(length + 1e-9) });
        }
        Err(Failure::Wrong(format!(
            "from {from:.3} s to {to:.3} s there is nothing in a recording of {length:.3} s"
        )))
    }
}

impl Surveyed {
    /// Origin of the rows.
    pub fn origin(&self) -> Origin {
        Origin {
            inputs: self.inputs(),
            timeline: self.timeline.clone(),
            window: self.window,
            remarks: self.timeline.remarks().into_iter().chain(self.remarks()).collect(),
        }
    }

    /// The recordings, in the order of time.
    pub fn logs(&self) -> impl Iterator<Item = &Path> {
        self.logs.iter().map(PathBuf::as_path)
    }

    /// Whether the configuration uses this frame.
    pub fn reads(&self, frame: &Frame) -> bool {
        reads(&self.design, frame)
    }

    /// Names of the recordings, for people.
    pub fn inputs(&self) -> String {
        let logs: Vec<String> = self.logs.iter().map(|log| log.display().to_string()).collect();
        logs.join(", ")
    }

    /// Remarks on what could not be read; empty where everything could.
    pub fn remarks(&self) -> Vec<String> {
        let Statistics { lines, bad_lines, first_bad_lines, .. } = &self.statistics;
        let bad = (*bad_lines > 0)
            .then(|| report::bad_lines(*bad_lines, *lines, first_bad_lines.len() as u64));
        let bad = bad.into_iter().chain(first_bad_lines.iter().map(ToString::to_string));
        let reordered = self.reordered.then(|| {
            "the recordings are read in the order of their time stamps, not in the order given"
                .to_owned()
        });
        reordered.into_iter().chain(self.doubts.clone()).chain(bad).collect()
    }

    /// Passes the frames within `window` (seconds by the timeline) to `take`, with their original
    /// time stamps.
    ///
    /// # Errors
    /// The frames can no longer be read.
    pub fn recorded(&self, window: Window, mut take: impl FnMut(&Frame)) -> Result<(), Failure> {
        let mut recording = Recording::open(&self.logs, self.options.clone())?;
        let bar = Bar::new(recording.progress());
        let mut frames = 0_u64;
        while let Some(frame) = recording.next_frame()? {
            if window.holds(self.timeline.seconds(frame.timestamp)) {
                take(frame);
            }
            frames += 1;
            if frames.is_multiple_of(STRIDE) {
                bar.show(recording.progress());
            }
        }
        bar.finish();
        Ok(())
    }

    /// Fails if a part of an input could not be read, although the rest was used.
    ///
    /// # Errors
    /// The first damage.
    pub fn damage(&self) -> Result<(), Failure> {
        match self.statistics.damage.first() {
            Some(damage) => Err(Failure::Failed(damage.to_string())),
            None => Ok(()),
        }
    }

    /// Fails if a part of an input could not be read, before anything is learnt that is kept.
    ///
    /// # Errors
    /// The first damage.
    pub fn whole(&self) -> Result<(), Failure> {
        self.damage().map_err(|damage| {
            Failure::Failed(format!(
                "{damage}; nothing is learnt from a recording that cannot be read completely: record again, or \
                 take what can be read of it by `tertius convert`"
            ))
        })
    }
}

impl Frames for Surveyed {
    type Error = Failure;

    fn frames(&self, window: Window, mut take: impl FnMut(&Frame)) -> Result<(), Failure> {
        self.recorded(window, |frame| placed(frame, &self.timeline, &mut take))
    }
}

impl survey::Recording for Surveyed {
    type Error = Failure;

    fn read(&self, window: Window, surveyor: impl Surveyor) -> Result<(), Failure> {
        self.read_counted(window, surveyor).map(drop)
    }

    fn read_counted(&self, window: Window, surveyor: impl Surveyor) -> Result<Counts, Failure> {
        let (design, first) = (&self.design, self.timeline.first());
        Rows { frames: self, design, first }.read_counted(window, surveyor)
    }
}

/// Whether the configuration of `design` uses this frame.
fn reads(design: &MonitorDesign, frame: &Frame) -> bool {
    let data = matches!(frame.kind, Kind::Data | Kind::Fd { .. });
    data && design.subscriptions.find(frame.bus, frame.id).is_some()
}

/// Passes a frame to `take` with its place on a timeline.
pub fn placed(frame: &Frame, timeline: &Timeline, take: &mut impl FnMut(&Frame)) {
    let timestamp = timeline.place(frame.timestamp);
    if timestamp == frame.timestamp {
        take(frame);
    } else {
        let mut moved = frame.clone();
        moved.timestamp = timestamp;
        take(&moved);
    }
}

impl FromStr for Place {
    type Err = String;

    /// Parses `120`, `120s` or `25%`.
    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let expected =
            || format!("{text:?} is not a time: expected seconds, like 120, or a part, like 25%");
        let (number, part) = match text.strip_suffix('%') {
            Some(number) => (number, true),
            None => (text.strip_suffix('s').unwrap_or(text), false),
        };
        let number: f64 = number.trim().parse().map_err(|_| expected())?;
        match part {
            _ if !number.is_finite() || number < 0.0 => Err(expected()),
            true if number > 100.0 => Err(expected()),
            true => Ok(Self::Part(number / 100.0)),
            false => Ok(Self::Seconds(number)),
        }
    }
}
