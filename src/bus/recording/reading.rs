//! The bytes of an input: its format, what is bad in it, and its end.

use super::{
    BadPlace, Barren, Common, Format, HEAD, Input, MAX_LINE, MAX_RECORD, Numbered, Reason,
    Recording, Sorting, Step, formats,
};

impl Recording {
    /// Finds out the current input's format, as soon as it shows.
    pub(super) fn recognise(&mut self) -> Step {
        let unread = self.buffer.unread();
        let whole = self.buffer.ended() || unread.len() >= HEAD;
        match formats::recognise(&unread[..unread.len().min(HEAD)], whole) {
            Some(format) => {
                self.reader = Some((format, (format.reader)(self.time_stamps)));
                if format.is_whole && !self.is_sorting() {
                    // Its beginning could not be looked at without reading all of it.
                    self.sort(Sorting::on());
                }
                Step::On
            }
            None => self.fill(),
        }
    }

    /// Counts the next line or record, of which `shown` bytes may be shown, as bad.
    pub(super) fn bad(&mut self, shown: usize, taken: usize, reason: Reason) -> Step {
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
    pub(super) fn more(&mut self) -> Step {
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
    pub(super) fn long_line(&mut self) -> Step {
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
            let has_frame = match &mut self.sorting {
                Some(sorting) => sorting.end_input(),
                None => self.statistics.frames > self.frames_before,
            };
            if !has_frame {
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
