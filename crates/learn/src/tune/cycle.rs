//! One cycle of a cylinder, as its observers take it.

use crate::survey::Row;
use tertius_core::observe::observer::{Innovation, Measurement, Observer};

/// Inputs of one cylinder's observers in one cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cycle {
    /// Control speed l̇_ctrl less the command's offset, m/s.
    pub command: Option<f64>,
    /// Measurements of C1 and C2.
    pub measurements: [Option<(f64, Option<f64>)>; 2],
    /// Whether the platform is in a monitored state.
    pub monitored: bool,
}

impl Cycle {
    /// A missing cycle.
    pub const NONE: Self = Self { command: None, measurements: [None; 2], monitored: false };

    pub fn new(row: &Row, command_offset: f64) -> Self {
        Self {
            command: row.u.map(|u| u - command_offset),
            measurements: [row.c1.map(|c1| (c1, row.v1)), row.c2.map(|c2| (c2, row.v2))],
            monitored: row.monitored,
        }
    }

    /// Steps the observer of C1 (0) or C2 (1); returns its residual where it is judged, m.
    pub fn step(&self, observer: &mut Observer, transducer: usize) -> Option<f64> {
        let measurement = self.measurements[transducer]
            .map(|(position, velocity)| Measurement { position, velocity });
        let (innovation, _) = observer.step(measurement, self.command);
        let judges = |it: &Innovation| it.settled && it.whole && self.monitored;
        let judged = innovation.filter(judges)?;
        // Without a command the model predicts nothing.
        self.command.map(|_| judged.residual)
    }
}
