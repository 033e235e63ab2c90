//! `tertius convert`: recordings in another format.

use super::Failure;
use super::files::{Claimed, Inputs, Mark, Overwriting};
use super::packed::{PackedWriter, Packing};
use super::passing::{Newest, report};
use super::progress::Bar;
use super::recording_options::{StampOption, recordings};
use crate::bus::{
    self, FrameEncoder, Interfaces, Options, Recording, Selected, Selection, Source, Statistics,
    Unsayable, Written,
};
use crate::frame::{Frame, Kind};
use crate::report::times;
use crate::text::counted;
use crate::time::Timestamp;
use clap::Args;
use clap::builder::PossibleValuesParser;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

const EXAMPLE: &str = "Examples:
  tertius convert monday.blf monday.log.zst
  tertius convert monday.log.zst tuesday.log.zst for-wireshark.pcapng
  tertius convert both-machines.asc second.log --channel 2
  candump -L can0 | tertius convert - - --format asc

The ending of OUT tells the format: .log (of candump), .asc and .blf (of Vector), .pcapng (of
Wireshark); .gz or .zst behind it compresses. Standard error says how many frames were written, and
what was left out. ASC and BLF have numbers for interfaces instead of names, and say that there was
an error frame, but not which error. docs/COMMANDS.md lists what each format keeps.";

/// Writes recordings in another format: candump, ASC, BLF or pcapng.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLE)]
pub struct Convert {
    #[arg(required = true, value_name = "IN")]
    #[arg(help = recordings(" or .zst, - for standard input"))]
    logs: Vec<PathBuf>,
    /// The recording to write; - for standard output
    #[arg(value_name = "OUT")]
    output: PathBuf,
    /// Format of OUT [default: by the ending of its name]
    #[arg(long, value_name = "FORMAT", value_parser = PossibleValuesParser::new(words()))]
    format: Option<String>,
    /// Takes only the frames of this interface, by its name or, where a format has none, its number
    /// [default: all interfaces]
    #[arg(long, value_name = "NAME", visible_alias = "channel")]
    interface: Option<String>,
    /// The meaning of the time stamps of a console recording
    #[arg(long, value_enum, default_value_t = StampOption::Auto)]
    time_stamps: StampOption,
    #[command(flatten)]
    overwriting: Overwriting,
}

/// Number of frames between two updates of the progress bar.
const STRIDE: u64 = 1 << 16;
/// Bytes that are collected before they are written.
const PIECE: usize = 1 << 16;

/// Words for the formats that are written.
fn words() -> Vec<&'static str> {
    bus::written().map(|format| format.word).collect()
}

impl Convert {
    /// Runs the command.
    ///
    /// # Errors
    /// A wrong call or file, a recording without a frame, or an output that cannot be written.
    pub fn run(self) -> Result<(), Failure> {
        let (format, packing) = self.wanted()?;
        let options = Options { time_stamps: self.time_stamps.into(), ..Options::default() };
        let mut recording = Recording::open(&self.logs, options)?;
        let inputs = Inputs::new(self.logs.iter().map(PathBuf::as_path));
        let wanted = (Some(self.output.as_path()), Mark::None);
        let [claimed] = inputs.claim([wanted], self.overwriting)?;
        let name = if self.output.as_os_str() == "-" {
            "standard output".to_owned()
        } else {
            self.output.display().to_string()
        };
        let mut out = Out { claimed, packing, name, open: None };
        let interfaces = self.interface.clone().map_or(Interfaces::All, Interfaces::Only);
        let mut conversion = Conversion::new(format);
        let read = conversion.pass(&mut recording, &interfaces, &mut out)?;
        let statistics = recording.statistics();
        if conversion.written == 0 {
            return Err(nothing(statistics, &interfaces, &conversion));
        }
        let head = conversion.encoder.finish(&mut conversion.bytes);
        out.put(&mut conversion.bytes)?;
        out.close(head)?;
        report(read, conversion.written, statistics);
        conversion.report(statistics, read);
        match statistics.damage.first() {
            Some(damage) => Err(Failure::Failed(damage.to_string())),
            None => Ok(()),
        }
    }

    /// The format to write, and how it is compressed.
    fn wanted(&self) -> Result<(&'static Written, Packing), Failure> {
        let name = self.output.file_name().unwrap_or_default().to_string_lossy();
        let (stem, packing) = Packing::of(&name);
        let ending = Path::new(stem).extension().map(|ending| ending.to_ascii_lowercase());
        let ending = ending.as_ref().and_then(|ending| ending.to_str());
        let word = self.format.as_deref().or(ending);
        let Some(format) = bus::written().find(|format| Some(format.word) == word) else {
            return Err(Failure::Wrong(format!(
                "{}: the name does not tell the format to write; expected one that ends in .{}, or --format",
                self.output.display(),
                words().join(", .")
            )));
        };
        if format.is_packed && packing != Packing::None {
            return Err(Failure::Wrong(format!(
                "{}: {} is compressed by itself; expected a name without .gz or .zst",
                self.output.display(),
                format.word
            )));
        }
        Ok((format, packing))
    }
}

/// The output, which is opened when there is something to write.
struct Out {
    claimed: Option<Claimed>,
    packing: Packing,
    name: String,
    open: Option<PackedWriter>,
}

impl Out {
    /// Writes `bytes` and empties them.
    fn put(&mut self, bytes: &mut Vec<u8>) -> Result<(), Failure> {
        if let Some(claimed) = self.claimed.take() {
            self.open = Some(PackedWriter::open(claimed, self.name.clone(), self.packing)?);
        }
        if let Some(open) = &mut self.open {
            open.put(bytes)?;
        }
        bytes.clear();
        Ok(())
    }

    fn close(self, head: Option<Vec<u8>>) -> Result<(), Failure> {
        self.open.map_or(Ok(()), |open| open.close(head))
    }
}

/// The way of frames into another format.
struct Conversion {
    format: &'static Written,
    encoder: Box<dyn FrameEncoder>,
    bytes: Vec<u8>,
    written: u64,
    /// Error frames among those written.
    errors: u64,
    /// Frames of other interfaces than the one that was asked for.
    others: u64,
    /// Frames that the format cannot have.
    unsayable: BTreeMap<Unsayable, u64>,
    /// Time stamp of the newest frame, and how often one was earlier than that of the frame before.
    newest: Option<Timestamp>,
    backwards: u64,
}

impl Conversion {
    fn new(format: &'static Written) -> Self {
        let (encoder, unsayable) = ((format.encoder)(), BTreeMap::new());
        Self {
            format,
            encoder,
            bytes: Vec::new(),
            written: 0,
            errors: 0,
            others: 0,
            unsayable,
            newest: None,
            backwards: 0,
        }
    }

    /// Passes on the whole recording; returns the number of frames read.
    fn pass(
        &mut self,
        recording: &mut Recording,
        interfaces: &Interfaces,
        out: &mut Out,
    ) -> Result<u64, Failure> {
        let bar = Bar::new(recording.progress());
        let (mut newest, mut selection) = (Newest::default(), Selection::new(interfaces.clone()));
        let mut read = 0_u64;
        while let Some(frame) = recording.next_frame()? {
            // The recording is asked about the frame's interface once it no longer lends the frame.
            let frame = frame.clone();
            let Some(name) = newest.interface(recording.statistics()) else {
                return Err(too_many(recording.statistics()));
            };
            // Whether all interfaces are wanted or one, no frame has to be held back.
            match selection.judge(name.as_bytes()) {
                Ok(Selected::Wanted) => self.add(name, &frame),
                _ => self.others += 1,
            }
            if self.bytes.len() >= PIECE {
                out.put(&mut self.bytes)?;
            }
            read += 1;
            if read.is_multiple_of(STRIDE) {
                bar.show(recording.progress());
            }
        }
        bar.finish();
        Ok(read)
    }

    fn add(&mut self, interface: &str, frame: &Frame) {
        let newest = self.newest.replace(frame.timestamp);
        self.backwards += u64::from(newest.is_some_and(|newest| frame.timestamp < newest));
        match self.encoder.add(interface, frame, &mut self.bytes) {
            Ok(()) => {
                self.written += 1;
                self.errors += u64::from(frame.kind == Kind::Error);
            }
            Err(why) => *self.unsayable.entry(why).or_default() += 1,
        }
    }

    /// Reports what is missing in what was written, or has another name there.
    fn report(&self, statistics: &Statistics, read: u64) {
        if self.others > 0 {
            let (others, read) = (self.others, counted(read, "frame"));
            tell!("{others} of {read} are of other interfaces and are left out");
        }
        for (why, frames) in &self.unsayable {
            tell!("{} left out: {why}", counted(*frames, "frame"));
        }
        if self.backwards > 0 {
            tell!(
                "the time stamps go back {}, and the frames are written as they come: a candump recording is put in order \
                 with sort -s -k 1,1 all.log > sorted.log",
                times(self.backwards)
            );
        }
        if self.errors > 0 && !self.format.explains_errors {
            let errors = counted(self.errors, "error frame");
            tell!("{errors} written without the kind of error, for which the format has no place");
        }
        let renamed: Vec<String> = self
            .encoder
            .channels()
            .iter()
            .filter(|(name, number)| *name != format!("channel{number}"))
            .map(|(name, number)| format!("{name} is channel {number}"))
            .collect();
        if !renamed.is_empty() {
            tell!("{}", renamed.join(", "));
        }
        statistics.barren.iter().for_each(|barren| tell!("{barren}"));
    }
}

/// Why nothing was written.
fn nothing(statistics: &Statistics, interfaces: &Interfaces, conversion: &Conversion) -> Failure {
    let mut reasons = Vec::new();
    if conversion.others > 0 {
        let found = statistics.interfaces_found();
        reasons.push(format!("no frame is from {interfaces}; the recording has {found}"));
    }
    let unsayable = conversion.unsayable.iter();
    reasons.extend(unsayable.map(|(why, frames)| format!("{} {why}", counted(*frames, "frame"))));
    reasons.extend(statistics.damage.iter().map(ToString::to_string));
    reasons.extend(statistics.barren.iter().map(ToString::to_string));
    Failure::Failed(format!("nothing was written: {}", reasons.join("; ")))
}

fn too_many(statistics: &Statistics) -> Failure {
    Failure::Wrong(format!(
        "the recording has more interfaces than the {} that are told apart: {}, and others; expected the recording of \
         one computer",
        statistics.interfaces.len(),
        statistics.interfaces_found()
    ))
}
