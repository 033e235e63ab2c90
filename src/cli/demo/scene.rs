//! The scene at a moment.

use super::listener::{CYLINDERS, Status};
use super::programme::{ACTS, window};
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
#[derive(Debug, Default)]
pub struct Scene {
    /// Time since the start, s.
    pub now: f64,
    pub rows: [Row; CYLINDERS],
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
        let next = (0..ACTS.len()).find(|&index| self.now < window(index)[1])?;
        Some((next, self.now >= window(next)[0]))
    }
}

fn push(lines: &mut VecDeque<String>, line: String, most: usize) {
    if lines.len() == most {
        lines.pop_front();
    }
    lines.push_back(line);
}
