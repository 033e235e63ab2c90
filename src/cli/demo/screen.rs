//! Output of the demonstration: a terminal, drawn in place, or successive lines.

use console::{Term, truncate_str};
use std::io::{self, Stdout, Write};
use std::time::{Duration, Instant};

/// Interval at which the terminal is redrawn.
const PERIOD: Duration = Duration::from_millis(50);

/// Escape sequence that clears the rest of the line.
const TO_END_OF_LINE: &str = "\x1b[K";

/// Kind of output.
pub enum Screen {
    Terminal(Terminal),
    /// Lines, on a pipe that cannot be redrawn.
    Lines(Stdout),
}

/// A part of a terminal.
pub struct Terminal {
    term: Term,
    /// Number of lines of the previous drawing.
    drawn: usize,
    due: Instant,
}

impl Screen {
    /// A terminal, or lines where standard output cannot be drawn on.
    pub fn new() -> Self {
        let term = Term::buffered_stdout();
        if !term.features().is_attended() || console::is_dumb() {
            return Self::Lines(io::stdout());
        }
        // Not every terminal can; then it blinks.
        _ = term.hide_cursor();
        Self::Terminal(Terminal { term, drawn: 0, due: Instant::now() })
    }

    pub const fn is_terminal(&self) -> bool {
        matches!(self, Self::Terminal(_))
    }

    /// Writes lines that stay, above the drawing.
    ///
    /// # Errors
    /// Errors of the output.
    pub fn say(&mut self, lines: &[String]) -> io::Result<()> {
        match self {
            Self::Terminal(terminal) => terminal.say(lines),
            Self::Lines(out) => lines.iter().try_for_each(|line| writeln!(out, "{line}")),
        }
    }

    /// Draws, if the output is a terminal and it is time.
    ///
    /// # Errors
    /// Errors of the output.
    pub fn draw(&mut self, lines: impl FnOnce() -> Vec<String>) -> io::Result<()> {
        match self {
            Self::Terminal(terminal) if Instant::now() >= terminal.due => terminal.draw(&lines()),
            _ => Ok(()),
        }
    }
}

impl Terminal {
    fn draw(&mut self, lines: &[String]) -> io::Result<()> {
        self.due = Instant::now() + PERIOD;
        let (height, width) = self.term.size();
        // A line more would scroll what is above away, and a wider one would take two.
        let shown = &lines[..lines.len().min(usize::from(height).saturating_sub(1))];
        self.term.move_cursor_up(std::mem::take(&mut self.drawn))?;
        for line in shown {
            // Written over and not wiped before, so that nothing blinks.
            let line = truncate_str(line, usize::from(width), "");
            self.term.write_line(&format!("{line}{TO_END_OF_LINE}"))?;
        }
        self.drawn = shown.len();
        self.term.clear_to_end_of_screen()?;
        self.term.flush()
    }

    fn say(&mut self, lines: &[String]) -> io::Result<()> {
        self.clear()?;
        lines.iter().try_for_each(|line| self.term.write_line(line))?;
        self.term.flush()
    }

    fn clear(&mut self) -> io::Result<()> {
        self.term.move_cursor_up(std::mem::take(&mut self.drawn))?;
        self.term.clear_to_end_of_screen()
    }
}

impl Drop for Terminal {
    fn drop(&mut self) {
        // There is nobody left to tell that it failed.
        _ = self.term.show_cursor();
        _ = self.term.flush();
    }
}
