//! What there is to see at a moment.

use super::listener::{CYLINDERS, Status};
use super::programme::{ACTS, window};
use crate::monitor::Record;
use std::collections::VecDeque;

/// s for which the largest residual is shown: a step's is over after a few cycles.
const HOLD: f64 = 1.0;

/// Lines that are kept of what was told.
pub const TOLD: usize = 4;
pub const FRAMES: usize = 2;

/// The readings of a cylinder, m.
#[derive(Clone, Copy, Debug, Default)]
pub struct Row {
    pub readings: [Option<f64>; 2],
    /// The largest of R1, R2 and R3, and when they were.
    peaks: [Option<(f64, f64)>; 3],
}

/// Readings, residuals, states, and the newest lines.
#[derive(Debug, Default)]
pub struct Scene {
    /// s since the start.
    pub now: f64,
    pub rows: [Row; CYLINDERS],
    pub platform: String,
    pub status: Status,
    /// Frames of the gateway: Fd_Status and Fd_Warning.
    pub sent: [u64; 2],
    pub warnings: VecDeque<String>,
    pub last_status: String,
    pub frames: VecDeque<String>,
}

impl Row {
    /// The largest residual of the last second, m.
    pub fn residual(&self, which: usize) -> Option<f64> {
        self.peaks[which].map(|(value, _)| value)
    }
}

impl Scene {
    /// Takes what the monitor made of a cycle.
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

    /// The fault that is there now, or the next one; `None` after the last.
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
