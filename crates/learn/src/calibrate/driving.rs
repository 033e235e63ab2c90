//! Velocity of the rod as a function of the command.

use crate::identify::qr::Triangle;
use tertius_core::sequential::drive::{Commands, Drive, FEATURES};
use tertius_core::sequential::parameters::DriveParameters;

/// Length of a displacement that the drive is fitted to, cycles.
const SPAN: usize = 10;

/// Interval between the beginnings of displacements, which overlap, cycles.
const EVERY: u64 = 5;

/// Pseudo-row for each regressor, as a part of it, since commands of neighbouring cycles are nearly
/// equal.
const DRIVE_RIDGE: f64 = 1e-3;

/// Fewest displacements for a drive: half a minute at 50 Hz.
const LEAST_DISPLACEMENTS: u64 = 300;

/// Regression of displacements of [`SPAN`] cycles on the commands that caused them.
#[derive(Clone, Debug)]
pub(super) struct Drives {
    sample_time: f64,
    commands: Commands,
    /// Ring of the lengths and features of the newest cycles.
    ring: [(f64, [f64; FEATURES]); SPAN],
    held: usize,
    cycle: u64,
    /// Means of the features over a displacement, and its velocity.
    triangle: Triangle<{ FEATURES + 1 }>,
}

impl Drives {
    pub(super) fn new(sample_time: f64) -> Self {
        Self {
            sample_time,
            commands: Commands::new(&DriveParameters::DEFAULT, sample_time),
            ring: [(0.0, [0.0; FEATURES]); SPAN],
            held: 0,
            cycle: 0,
            triangle: Triangle::new(),
        }
    }

    pub(super) fn clear(&mut self) {
        self.commands.clear();
        // Displacements are counted from here on, whatever came before.
        (self.held, self.cycle) = (0, 0);
    }

    pub(super) fn step(&mut self, length: Option<f64>, command: Option<f64>) {
        let Some(command) = command else { return self.clear() };
        self.commands.push(command);
        let Some((length, features)) = length.zip(self.commands.features()) else {
            self.held = 0;
            return;
        };
        let place = (self.cycle % SPAN as u64) as usize;
        if self.held == SPAN && self.cycle.is_multiple_of(EVERY) {
            self.add(length - self.ring[place].0);
        }
        self.ring[place] = (length, features);
        self.held = (self.held + 1).min(SPAN);
        self.cycle += 1;
    }

    fn add(&mut self, displacement: f64) {
        let mut row = [0.0; FEATURES + 1];
        for (_, features) in &self.ring {
            for (mean, feature) in row.iter_mut().zip(features) {
                *mean += feature / SPAN as f64;
            }
        }
        row[FEATURES] = displacement / (SPAN as f64 * self.sample_time);
        self.triangle.add(&row);
    }

    pub(super) fn result(&self) -> Option<Drive> {
        if self.triangle.rows() < LEAST_DISPLACEMENTS {
            return None;
        }
        let mut triangle = self.triangle.clone();
        let rows = (triangle.rows() as f64).sqrt();
        for feature in 0..FEATURES {
            let mut row = [0.0; FEATURES + 1];
            // A regressor that never was anything else than zero has the coefficient zero.
            row[feature] =
                (DRIVE_RIDGE * rows * self.triangle.rms(feature)).max(f64::MIN_POSITIVE.sqrt());
            triangle.add(&row);
        }
        let regressors: Vec<usize> = (0..FEATURES).collect();
        let solved = triangle.solve(&regressors, FEATURES).ok()?;
        Some(Drive(solved.coefficients.try_into().ok()?))
    }
}
