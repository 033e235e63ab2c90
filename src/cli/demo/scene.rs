//! The scene at a moment.

use super::listener::Status;
use super::programme::Programme;
use crate::monitor::Record;
use std::collections::VecDeque;

/// Time for which the largest residual is shown, s, since that of a step is over after a few
/// cycles.
const HOLD: f64 = 1.0;

/// Number of printed lines that are kept.
pub const TOLD: usize = 4;
pub const FRAMES: usize = 2;

/// The readings of a cylinder, m.
#[derive(Clone, Copy, Debug, Default)]
pub struct Row {
    pub readings: [Option<f64>; 2],
    /// Largest R1, R2 and R3, and their times.
    peaks: [Option<(f64, f64)>; 3],
}

/// Readings, residuals, states, and the newest lines.
#[derive(Debug)]
pub struct Scene {
    pub programme: Programme,
    /// Time since the start, s.
    pub now: f64,
    /// A row for each cylinder.
    pub rows: Vec<Row>,
    pub platform: String,
    pub status: Status,
    /// Number of frames of the gateway: Fd_Status and Fd_Warning.
    pub sent: [u64; 2],
    pub warnings: VecDeque<String>,
    pub last_status: String,
    pub frames: VecDeque<String>,
}

impl Row {
    /// Largest residual of the last second, m.
    pub fn residual(&self, which: usize) -> Option<f64> {
        self.peaks[which].map(|(value, _)| value)
    }
}

impl Scene {
    /// The scene before the first frame of a machine of so many `cylinders`.
    pub fn new(programme: Programme, cylinders: u8) -> Self {
        Self {
            programme,
            now: 0.0,
            rows: vec![Row::default(); cylinders.into()],
            platform: String::new(),
            status: Status::default(),
            sent: [0; 2],
            warnings: VecDeque::new(),
            last_status: String::new(),
            frames: VecDeque::new(),
        }
    }

    /// Takes the monitor's record of a cycle.
    pub fn record(&mut self, record: &Record) {
        let now = self.now;
        let Some(row) = self.rows.get_mut(usize::from(record.cylinder).wrapping_sub(1)) else {
            return;
        };
        row.readings = [record.c1, record.c2];
        for (peak, residual) in row.peaks.iter_mut().zip(record.residuals) {
            let held = peak.filter(|(value, at)| {
                now - at < HOLD && residual.is_none_or(|it| it.abs() < value.abs())
            });
            *peak = held.or(residual.map(|it| (it, now)));
        }
    }

    pub fn warn(&mut self, line: String) {
        push(&mut self.warnings, line, TOLD);
    }

    pub fn send(&mut self, line: String) {
        push(&mut self.frames, line, FRAMES);
    }

    /// The present fault, or the next one; `None` after the last.
    pub fn act(&self) -> Option<(usize, bool)> {
        let programme = &self.programme;
        let next = (0..programme.acts.len()).find(|it| self.now < programme.window(*it)[1])?;
        Some((next, self.now >= programme.window(next)[0]))
    }
}

fn push(lines: &mut VecDeque<String>, line: String, most: usize) {
    if lines.len() == most {
        lines.pop_front();
    }
    lines.push_back(line);
}
