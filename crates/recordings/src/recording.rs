//! A recording: several inputs in turn, each in its own format, as a source of frames.

mod merge;

use merge::Merge;
use std::collections::VecDeque;
use std::io::Read;
use std::path::Path;

use tertius_core::frame::Frame;

use super::bad_line::BadPlace;
use super::barren::Barren;
use super::buffer::Buffer;
use super::format::{End, Format, Item, Numbered, Reader, TimeStamps, Unread, blank_frame};
use super::formats;
use super::formats::candump::{self, Common, Known};
use super::input::{HEAD, Input, InputPlace};
use super::limits::{MAX_LINE, MAX_RECORD};
use super::options::Options;
use super::order;
use super::progress::Progress;
use super::reason::Reason;
use super::selection::{Interfaces, Selected, Selection};
use super::source::{Source, SourceError};
use super::statistics::Statistics;

/// The frames of recordings, one file after the other; those of several buses ([`Interfaces::Several`]) merged by their
/// time stamps, from one file or each from its own.
///
/// Frames and counts depend on the bytes alone, not on the sizes of the reads. Memory is bounded
/// for any input: a buffer of 256 KiB, the decompressor's window, the statistics, and some hundred
/// kilobytes of frames that wait until it is known whether their interface is meant. Of a format whose
/// frames are found only in the whole input (MDF), also that input, up to 1 GiB.
pub struct Recording {
    places: VecDeque<InputPlace>,
    input: Option<Input>,
    /// Whether the current input's end or other parts are missing. Its last line may be incomplete.
    damaged: bool,
    buffer: Buffer,
    time_stamps: TimeStamps,
    /// Format and reader of the current input, once it is recognised.
    reader: Option<(&'static Format, Box<dyn Reader>)>,
    /// The shortcut for most lines of candump's format, which nothing of another format passes.
    common: Common,
    frame: Frame,
    selection: Selection,
    interfaces: Interfaces,
    /// Frames that came before the interface was decided.
    held: VecDeque<Frame>,
    statistics: Statistics,
    /// Frames of the interface of `common` that the statistics do not have yet.
    uncounted: u64,
    /// Lines of the inputs before the current one.
    lines_before: u64,
    /// Frames of the inputs before the current one.
    frames_before: u64,
    /// Bytes of the inputs before the current one.
    consumed_before: u64,
    total: Option<u64>,
    /// The recordings of several buses, by which everything is read then.
    merge: Option<Box<Merge>>,
}

/// Result of a step.
enum Step {
    /// A frame to return.
    Frame,
    /// No frame, but there may be more.
    On,
    /// The end.
    End,
}

impl Recording {
    /// A recording over files; `-` is standard input. `.gz` and `.zst` are recognised by their
    /// content.
    ///
    /// # Errors
    /// A file does not exist, may not be read or is a directory; files are not in the order of time.
    pub fn open<P: AsRef<Path>>(paths: &[P], options: Options) -> Result<Self, SourceError> {
        if let Interfaces::Several(several) = &options.interfaces {
            let merge = Box::new(Merge::open(paths, &options, several)?);
            return Ok(Self { merge: Some(merge), ..Self::over(VecDeque::new(), None, options) });
        }
        Self::lane(paths, options)
    }

    /// A recording of files that follow each other, whatever buses it has.
    pub(super) fn lane<P: AsRef<Path>>(paths: &[P], options: Options) -> Result<Self, SourceError> {
        Self::new(paths.iter().map(|path| InputPlace::of(path.as_ref())).collect(), options)
    }

    /// A recording from any reader; `name` is its name in reports.
    pub fn from_reader(name: &str, reader: Box<dyn Read + Send>, options: Options) -> Self {
        let place = InputPlace::Reader { name: name.to_owned(), reader };
        Self::over(VecDeque::from([place]), None, options)
    }

    fn new(places: VecDeque<InputPlace>, options: Options) -> Result<Self, SourceError> {
        let mut total = Some(0);
        for place in &places {
            let size = place.check()?;
            total = total.zip(size).map(|(total, size)| total + size);
        }
        if matches!(options.time_stamps, TimeStamps::Auto | TimeStamps::Absolute) {
            order::check(&places.iter().collect::<Vec<_>>(), &options.interfaces)?;
        }
        Ok(Self::over(places, total, options))
    }

    fn over(places: VecDeque<InputPlace>, total: Option<u64>, options: Options) -> Self {
        Self {
            places,
            input: None,
            damaged: false,
            buffer: Buffer::new(),
            time_stamps: options.time_stamps,
            reader: None,
            common: Common::new(),
            frame: blank_frame(),
            selection: Selection::new(options.interfaces.clone()),
            interfaces: options.interfaces,
            held: VecDeque::new(),
            statistics: Statistics::default(),
            uncounted: 0,
            lines_before: 0,
            frames_before: 0,
            consumed_before: 0,
            total,
            merge: None,
        }
    }

    /// Statistics of what was read so far.
    pub fn statistics(&mut self) -> &Statistics {
        if let Some(merge) = &mut self.merge {
            self.statistics = merge.statistics();
        }
        self.count();
        &self.statistics
    }

    /// Adds what `advance` has read of one interface to the statistics: three counters a frame there
    /// would cost a fourteenth of reading a line.
    fn count(&mut self) {
        let (frames, interface) = (std::mem::take(&mut self.uncounted), self.common.interface());
        if frames == 0 {
            return;
        }
        self.statistics.lines += frames;
        self.statistics.frames += frames;
        self.statistics.interfaces[interface.place].frames += frames;
        if !interface.wanted {
            self.statistics.other_interface_frames += frames;
        }
    }

    /// Progress so far.
    pub fn progress(&self) -> Progress {
        if let Some(merge) = &self.merge {
            return merge.progress();
        }
        let current = self.input.as_ref().map_or(0, Input::consumed);
        Progress { consumed: self.consumed_before + current, total: self.total }
    }

    /// Reads the next frame into `self.frame`; returns false at the end.
    #[inline(always)]
    fn advance(&mut self) -> Result<bool, SourceError> {
        loop {
            let read = self.common.read(self.buffer.unread(), &mut self.frame);
            let Some(taken) = read.or_else(|| self.read_new()) else {
                match self.step()? {
                    Step::Frame => return Ok(true),
                    Step::On => continue,
                    Step::End => return Ok(false),
                }
            };
            self.buffer.consume(taken);
            self.uncounted += 1;
            if self.common.interface().wanted {
                return Ok(true);
            }
        }
    }

    /// Reads a line that differs a little from the previous one; returns its length.
    #[inline(never)]
    fn read_new(&mut self) -> Option<usize> {
        self.count();
        self.reader.as_ref().filter(|(format, _)| std::ptr::eq(*format, &candump::FORMAT))?;
        let (statistics, selection) = (&self.statistics, &self.selection);
        let (interfaces, is_open) = (&self.interfaces, self.held.is_empty());
        let find = |name: &[u8]| {
            // Not while earlier frames are held back.
            let place = statistics.interface(name).filter(|_| is_open)?;
            let wanted = selection.known(name)?;
            // What is not wanted is on no bus.
            Some(Known { place, wanted, bus: interfaces.bus(name).unwrap_or_default() })
        };
        self.common.read_new(self.buffer.unread(), &mut self.frame, find)
    }

    /// Handles the next line or record, or whatever else comes next.
    #[inline(never)]
    fn step(&mut self) -> Result<Step, SourceError> {
        if self.selection.is_decided()
            && let Some(frame) = self.held.pop_front()
        {
            self.frame = frame;
            return Ok(Step::Frame);
        }
        if self.input.is_none() {
            let Some(place) = self.places.pop_front() else { return self.merged_or_end() };
            self.input = Some(place.open()?);
        }
        let Some((_, reader)) = &mut self.reader else { return Ok(self.recognise()) };
        let end = match (self.buffer.ended(), self.damaged) {
            (false, _) => End::Open,
            (true, false) => End::Whole,
            (true, true) => End::Lost,
        };
        let unread = Unread { bytes: self.buffer.unread(), end };
        match reader.read(unread, &mut self.frame) {
            Item::Frame { taken, interface, .. } => {
                self.statistics.add_frame(self.frame.kind, interface);
                let selected = self.selection.judge(interface);
                self.frame.bus = self.interfaces.bus(interface).unwrap_or_default();
                self.buffer.consume(taken);
                self.give(selected.map_err(|_| self.undecided(&self.interfaces))?)
            }
            Item::Nothing { taken } => {
                self.statistics.lines += 1;
                self.buffer.consume(taken);
                Ok(Step::On)
            }
            Item::Bad { shown, taken, reason } => Ok(self.bad(shown, taken, reason)),
            Item::BadAt { at, shown, reason, loses } => {
                self.statistics.lines += 1;
                let file = self.input.as_ref().map_or("", Input::name);
                self.statistics.add_bad(file, BadPlace::Byte(at), shown, reason);
                // Said once for each input.
                if loses && !std::mem::replace(&mut self.damaged, true) {
                    let told = format!("frames are missing; at byte {at}: {reason}");
                    self.statistics.add_damage(file, told);
                }
                Ok(Step::On)
            }
            Item::LongLine => Ok(self.long_line()),
            Item::More => Ok(self.more()),
        }
    }

    /// Finds out the current input's format, as soon as it shows.
    fn recognise(&mut self) -> Step {
        let unread = self.buffer.unread();
        let whole = self.buffer.ended() || unread.len() >= HEAD;
        match formats::recognise(&unread[..unread.len().min(HEAD)], whole) {
            Some(format) => {
                self.reader = Some((format, (format.reader)(self.time_stamps)));
                Step::On
            }
            None => self.fill(),
        }
    }

    /// Returns, holds back or leaves out the frame that was read.
    fn give(&mut self, selected: Selected) -> Result<Step, SourceError> {
        match selected {
            Selected::Wanted => {
                // None of what was held back is of the interface that was waited for.
                self.statistics.other_interface_frames += self.held.len() as u64;
                self.held.clear();
                Ok(Step::Frame)
            }
            Selected::Other => {
                self.statistics.other_interface_frames += 1;
                Ok(Step::On)
            }
            Selected::Undecided => {
                self.held.push_back(std::mem::replace(&mut self.frame, blank_frame()));
                Ok(Step::On)
            }
        }
    }

    /// Takes the next frame of several buses, of which this recording has no bytes of its own, or ends.
    fn merged_or_end(&mut self) -> Result<Step, SourceError> {
        let Some(merge) = &mut self.merge else { return self.end() };
        let Some(frame) = merge.next_frame()? else { return Ok(Step::End) };
        self.frame = frame;
        Ok(Step::Frame)
    }

    /// Handles the end of the last input.
    fn end(&mut self) -> Result<Step, SourceError> {
        self.selection.decide().map_err(|_| self.undecided(&self.interfaces))?;
        Ok(if self.held.is_empty() { Step::End } else { Step::On })
    }

    /// The error that the frames up to here do not tell which interface is meant, for callers that
    /// read [`Interfaces::All`] with their own [`Selection`]; `interfaces` is the criterion.
    pub fn ambiguous(&mut self, interfaces: &Interfaces) -> SourceError {
        self.count();
        self.undecided(interfaces)
    }

    fn undecided(&self, interfaces: &Interfaces) -> SourceError {
        let line = self.statistics.lines - self.lines_before;
        let place = match &self.input {
            Some(input) => format!("{}:{line}", input.name()),
            None => "at its end".to_owned(),
        };
        let found = self.statistics.interfaces_found();
        SourceError::Interfaces { place, found, configured: interfaces.to_string() }
    }

    /// Counts the next line or record, of which `shown` bytes may be shown, as bad.
    fn bad(&mut self, shown: usize, taken: usize, reason: Reason) -> Step {
        self.statistics.lines += 1;
        let place = match self.reader {
            Some((Format { numbered: Numbered::Bytes, .. }, _)) => {
                BadPlace::Byte(self.buffer.consumed())
            }
            _ => BadPlace::Line(self.statistics.lines - self.lines_before),
        };
        let file = self.input.as_ref().map_or("", Input::name);
        self.statistics.add_bad(file, place, &self.buffer.unread()[..shown], reason);
        self.buffer.consume(taken);
        Step::On
    }

    /// Reads more, unless the input has ended, or what is there should be enough.
    fn more(&mut self) -> Step {
        let left = self.buffer.unread().len();
        if self.buffer.ended() {
            let reason = if self.damaged { Reason::CutOff } else { Reason::Incomplete };
            return if left == 0 { self.end_input() } else { self.bad(left, left, reason) };
        }
        if left > MAX_RECORD {
            return self.bad(left, left, Reason::RecordTooLong);
        }
        self.fill()
    }

    /// Counts a line that is too long and drops it, however long it is.
    fn long_line(&mut self) -> Step {
        self.bad(MAX_LINE, 0, Reason::LineTooLong);
        // To its very end: what follows within it may look like a line of its own.
        while !self.buffer.drop_line() && !self.buffer.ended() {
            self.fill();
        }
        Step::On
    }

    /// Reads more of the current input.
    fn fill(&mut self) -> Step {
        if let Some(input) = &mut self.input
            && let Err(error) = self.buffer.fill(input)
        {
            self.damaged = true;
            self.statistics.add_damage(input.name(), input.explain(&error));
        }
        Step::On
    }

    fn end_input(&mut self) -> Step {
        if let Some((input, (format, _))) = self.input.take().zip(self.reader.take()) {
            self.consumed_before += input.consumed();
            if self.statistics.frames == self.frames_before {
                let lines = self.statistics.lines - self.lines_before;
                let flaws = self.statistics.first_bad_lines.iter();
                // Damage is told by itself.
                let flaw = flaws.filter(|_| !self.damaged).find(|bad| bad.file == input.name());
                let barren = Barren::of(&input, format, lines, flaw);
                self.statistics.add_barren(barren);
            }
        }
        self.damaged = false;
        self.lines_before = self.statistics.lines;
        self.frames_before = self.statistics.frames;
        self.buffer.restart();
        self.common = Common::new();
        Step::On
    }
}

impl Source for Recording {
    // Inlined: a call by itself costs a sixth of reading a line.
    #[inline(always)]
    fn next_frame(&mut self) -> Result<Option<&Frame>, SourceError> {
        Ok(if self.advance()? { Some(&self.frame) } else { None })
    }
}

#[cfg(test)]
mod tests;
