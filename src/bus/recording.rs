//! A recording: candump lines from several inputs in turn, as a source of frames.

use std::collections::VecDeque;
use std::io::Read;
use std::path::Path;

use crate::frame::{Frame, Kind};

use super::buffer::{Buffer, Next};
use super::candump::{Clock, Common, Known, Line, MAX_LINE, Reason, TimeStamps, blank_frame};
use super::input::{Input, Place};
use super::source::{Source, SourceError};
use super::statistics::Statistics;

/// How a recording is read.
#[derive(Clone, Debug, Default)]
pub struct Options {
    pub time_stamps: TimeStamps,
    /// Only this interface's frames are given out; the others are counted.
    pub interface: Option<String>,
}

/// How far a recording was read, in bytes of its files as they are: compressed where they are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    /// Taken from the files so far; up to some hundred kilobytes ahead of the frames.
    pub consumed: u64,
    /// Of all files; `None` if one of them is a pipe.
    pub total: Option<u64>,
}

/// The frames of candump recordings, one file after the other.
///
/// What is read and counted depends on the bytes alone, not on how they come in. Memory is bounded
/// whatever the input: a buffer of 256 KiB, the decompressor's window and the statistics.
pub struct Recording {
    places: VecDeque<Place>,
    input: Option<Input>,
    /// The current input's end is missing: its last line may be half a line.
    damaged: bool,
    buffer: Buffer,
    common: Common,
    clock: Clock,
    frame: Frame,
    interface: Option<String>,
    statistics: Statistics,
    /// Lines of the inputs before the current one.
    lines_before: u64,
    /// Bytes of the inputs before the current one.
    consumed_before: u64,
    total: Option<u64>,
}

/// What came of looking at what is next.
enum Step {
    /// A frame to give out.
    Frame,
    /// Something else: go on.
    On,
    /// There is nothing more.
    End,
}

impl Recording {
    /// A recording over files; `-` is standard input. `.gz` and `.zst` are recognised by their
    /// content.
    ///
    /// # Errors
    /// A file does not exist, may not be read or is a directory.
    pub fn open<P: AsRef<Path>>(paths: &[P], options: Options) -> Result<Self, SourceError> {
        Self::new(paths.iter().map(|path| Place::of(path.as_ref())).collect(), options)
    }

    /// A recording over any reader; `name` stands for it in reports.
    pub fn from_reader(name: &str, reader: Box<dyn Read + Send>, options: Options) -> Self {
        let place = Place::Reader { name: name.to_owned(), reader };
        Self::over(VecDeque::from([place]), None, options)
    }

    fn new(places: VecDeque<Place>, options: Options) -> Result<Self, SourceError> {
        let mut total = Some(0);
        for place in &places {
            let size = place.check()?;
            total = total.zip(size).map(|(total, size)| total + size);
        }
        Ok(Self::over(places, total, options))
    }

    fn over(places: VecDeque<Place>, total: Option<u64>, options: Options) -> Self {
        Self {
            places,
            input: None,
            damaged: false,
            buffer: Buffer::new(),
            common: Common::new(),
            clock: Clock::new(options.time_stamps),
            frame: blank_frame(),
            interface: options.interface,
            statistics: Statistics::default(),
            lines_before: 0,
            consumed_before: 0,
            total,
        }
    }

    /// What was read so far.
    pub fn statistics(&self) -> &Statistics {
        &self.statistics
    }

    /// How far it was read.
    pub fn progress(&self) -> Progress {
        let current = self.input.as_ref().map_or(0, Input::consumed);
        Progress { consumed: self.consumed_before + current, total: self.total }
    }

    /// Puts the next frame into `self.frame`; false at the end.
    #[inline]
    fn advance(&mut self) -> Result<bool, SourceError> {
        loop {
            let (statistics, wanted) = (&self.statistics, &self.interface);
            let find = |name: &[u8]| known(statistics, wanted.as_deref(), name);
            let read = self.common.read(self.buffer.unread(), &mut self.frame, find);
            let Some(taken) = read else {
                match self.step()? {
                    Step::Frame => return Ok(true),
                    Step::On => continue,
                    Step::End => return Ok(false),
                }
            };
            self.buffer.consume(taken);
            let interface = self.common.interface();
            self.statistics.lines += 1;
            self.statistics.frames += 1;
            self.statistics.interfaces[interface.place].frames += 1;
            if interface.wanted {
                return Ok(true);
            }
            self.statistics.other_interface_frames += 1;
        }
    }

    /// Any line, or whatever else comes next.
    #[inline(never)]
    fn step(&mut self) -> Result<Step, SourceError> {
        if self.input.is_none() {
            let Some(place) = self.places.pop_front() else { return Ok(Step::End) };
            self.input = Some(place.open()?);
        }
        match self.buffer.next() {
            Next::Line { length, taken } => Ok(self.line(length, taken)),
            Next::Unterminated { length } if self.damaged => {
                Ok(self.bad_line(length, length, Reason::CutOff))
            }
            Next::Unterminated { length } => Ok(self.line(length, length)),
            Next::TooLong => Ok(self.long_line()),
            Next::More => Ok(self.fill()),
            Next::End => Ok(self.end_input()),
        }
    }

    /// The line of `length` bytes that comes next, `taken` with its newline.
    fn line(&mut self, length: usize, taken: usize) -> Step {
        let text = &self.buffer.unread()[..length];
        let line = match Line::parse(text) {
            Ok(Some(line)) => line,
            Ok(None) => {
                self.statistics.lines += 1;
                self.buffer.consume(taken);
                return Step::On;
            }
            Err(reason) => return self.bad_line(length, taken, reason),
        };
        let read = line.read_frame(&mut self.frame);
        if read.is_ok() && self.clock.must_look_ahead(&line) {
            let whole = self.buffer.ended();
            if !self.clock.look_ahead(self.buffer.unread(), whole) {
                return self.fill();
            }
        }
        // A bad frame's time counts too: those after it may be relative to it.
        match self.clock.instant(&line).and_then(|instant| read.map(|()| instant)) {
            Ok(instant) => self.frame.timestamp = instant,
            Err(reason) => return self.bad_line(length, taken, reason),
        }
        let statistics = &mut self.statistics;
        statistics.lines += 1;
        statistics.frames += 1;
        statistics.error_frames += u64::from(self.frame.kind == Kind::Error);
        statistics.remote_frames += u64::from(matches!(self.frame.kind, Kind::Remote { .. }));
        statistics.add_interface_frame(line.interface);
        let wanted = is_wanted(self.interface.as_deref(), line.interface);
        statistics.other_interface_frames += u64::from(!wanted);
        self.buffer.consume(taken);
        if wanted { Step::Frame } else { Step::On }
    }

    /// Counts the line that comes next, of which `length` bytes may be shown, as bad.
    fn bad_line(&mut self, length: usize, taken: usize, reason: Reason) -> Step {
        self.statistics.lines += 1;
        let number = self.statistics.lines - self.lines_before;
        let file = self.input.as_ref().map_or("", Input::name);
        let text = &self.buffer.unread()[..length];
        self.statistics.add_bad_line(file, number, text, reason);
        self.buffer.consume(taken);
        Step::On
    }

    /// Counts a line that is too long and drops it, however long it is.
    fn long_line(&mut self) -> Step {
        self.bad_line(MAX_LINE, 0, Reason::LineTooLong);
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
        if let Some(input) = self.input.take() {
            self.consumed_before += input.consumed();
        }
        self.damaged = false;
        self.lines_before = self.statistics.lines;
        self.buffer.restart();
        self.clock.restart();
        Step::On
    }
}

fn is_wanted(wanted: Option<&str>, name: &[u8]) -> bool {
    wanted.is_none_or(|wanted| wanted.as_bytes() == name)
}

fn known(statistics: &Statistics, wanted: Option<&str>, name: &[u8]) -> Option<Known> {
    let place = statistics.interface(name)?;
    Some(Known { place, wanted: is_wanted(wanted, name) })
}

impl Source for Recording {
    #[inline]
    fn next_frame(&mut self) -> Result<Option<&Frame>, SourceError> {
        Ok(if self.advance()? { Some(&self.frame) } else { None })
    }
}
