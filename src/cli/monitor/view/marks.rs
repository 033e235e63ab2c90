//! Signs and colours. No state is told by its colour alone, and colours are the sixteen of every terminal, with the
//! terminal's own for text: what is readable on a dark one is so on a light one.

use crate::appliance::telemetry::lamp::Lamp;
use ratatui::style::{Color, Modifier, Style};

/// What the terminal can show.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Marks {
    /// Whether it shows more than ASCII.
    pub unicode: bool,
    /// Whether colours are wanted.
    pub colours: bool,
}

/// Eighths of a cell, from the left and from below.
const ACROSS: [&str; 9] = [" ", "▏", "▎", "▍", "▌", "▋", "▊", "▉", "█"];
const UPWARDS: [&str; 9] = [" ", "▁", "▂", "▃", "▄", "▅", "▆", "▇", "█"];

impl Marks {
    /// The shape of a lamp, and its colours, after NAMUR NE 107.
    pub const fn lamp(self, lamp: Lamp) -> (&'static str, Style) {
        let (shape, ascii, style) = match lamp {
            Lamp::Failure => ("⊗", "X", badge(Color::White, Color::Red)),
            Lamp::CheckFunction => ("▼", "V", badge(Color::Black, Color::Yellow)),
            Lamp::OutOfSpecification => ("▲", "A", badge(Color::Black, Color::Yellow)),
            Lamp::MaintenanceRequired => ("◆", "M", badge(Color::White, Color::Blue)),
            Lamp::Good => ("●", "o", Style::new().fg(Color::Green)),
            Lamp::NotFitted => ("–", "-", quiet()),
            Lamp::Unknown => ("○", "?", Style::new()),
        };
        (self.pick(shape, ascii), style)
    }

    /// Colours of a level of alarm.
    pub fn level(level: &str) -> Style {
        match level {
            "yellow" => badge(Color::Black, Color::Yellow),
            "orange" => badge(Color::Black, Color::Yellow).add_modifier(Modifier::BOLD),
            "red" => badge(Color::White, Color::Red).add_modifier(Modifier::BOLD),
            "black" => Style::new().add_modifier(Modifier::REVERSED.union(Modifier::BOLD)),
            _ => Style::new(),
        }
    }

    /// A bar of `width` cells that is filled by `share`, at most wholly.
    pub fn bar(self, share: f64, width: usize) -> String {
        let eighths = (share.clamp(0.0, 1.0) * 8.0 * width as f64).round() as usize;
        (0..width).map(|cell| self.part(ACROSS, eighths.saturating_sub(8 * cell))).collect()
    }

    /// A cell that is filled from below by so many eighths.
    pub fn column(self, eighths: usize) -> &'static str {
        self.part(UPWARDS, eighths)
    }

    fn part(self, parts: [&'static str; 9], eighths: usize) -> &'static str {
        let ascii = if eighths >= 4 { "#" } else { " " };
        self.pick(parts[eighths.min(8)], ascii)
    }

    /// `sign` where the terminal shows it, otherwise `ascii`.
    pub const fn pick(self, sign: &'static str, ascii: &'static str) -> &'static str {
        if self.unicode { sign } else { ascii }
    }
}

const fn badge(text: Color, ground: Color) -> Style {
    Style::new().fg(text).bg(ground)
}

/// What is beside the point.
pub const fn quiet() -> Style {
    Style::new().add_modifier(Modifier::DIM)
}

pub const fn strong() -> Style {
    Style::new().add_modifier(Modifier::BOLD)
}

/// What is beyond its limit.
pub const fn beyond() -> Style {
    Style::new().fg(Color::Red).add_modifier(Modifier::BOLD)
}
