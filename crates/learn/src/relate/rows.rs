//! What is kept of a recording.

use crate::survey::{Row, Surveyor};
use tertius_config::settings::Settings;
use tertius_core::alarm::status::MAX_CYLINDERS;
use tertius_core::process::ProcessParameters;
use tertius_core::time;

/// Rows of one cylinder that are kept: four hours at 50 Hz, 29 MB. More teach nothing new.
const MOST: usize = 720_000;

/// One cylinder in one cycle, after the platform has been in a monitored state for a while. Seven digits are more than
/// any of its signals has.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProcessRow {
    /// Seconds since the recording's first frame.
    pub t: f64,
    /// Command as sent, m/s.
    pub command: f32,
    /// Position of the spool, in its unit.
    pub spool: Option<f32>,
    /// P_bot, P_rod and P_S, bar.
    pub pressures: Option<[f32; 3]>,
    /// Whether the row before is that of the cycle before.
    pub follows: bool,
}

/// The rows of all cylinders.
#[derive(Clone, Debug)]
pub struct ProcessRows {
    rows: [Vec<ProcessRow>; MAX_CYLINDERS],
    /// Cycles of the present stay in a monitored state.
    open: [u32; MAX_CYLINDERS],
    opening: u32,
    /// Whether there were more rows than are kept.
    is_full: [bool; MAX_CYLINDERS],
}

impl ProcessRows {
    /// Rows of the machine of `settings`.
    pub fn new(settings: &Settings) -> Self {
        let opening = ProcessParameters::DEFAULT.opening;
        Self {
            rows: Default::default(),
            open: [0; MAX_CYLINDERS],
            opening: time::cycles(opening, settings.machine.sample_time),
            is_full: [false; MAX_CYLINDERS],
        }
    }

    /// Whether cylinder `n` had more rows than are kept.
    pub const fn is_full(&self, n: u8) -> bool {
        self.is_full[n as usize - 1]
    }

    /// Those of cylinder `n`.
    pub fn of(&self, n: u8) -> &[ProcessRow] {
        &self.rows[usize::from(n) - 1]
    }
}

impl Surveyor for ProcessRows {
    fn row(&mut self, row: &Row) {
        let index = usize::from(row.cylinder) - 1;
        let open = &mut self.open[index];
        let Some(command) = row.u.filter(|_| row.monitored) else {
            *open = 0;
            return;
        };
        *open = open.saturating_add(1);
        if *open < self.opening {
            return;
        }
        if self.rows[index].len() == MOST {
            self.is_full[index] = true;
            return;
        }
        let chambers = row.pressure_bottom.zip(row.pressure_rod).zip(row.supply);
        self.rows[index].push(ProcessRow {
            t: row.t,
            command: command as f32,
            spool: row.spool.map(|spool| spool as f32),
            pressures: chambers
                .map(|((bottom, rod), supply)| [bottom, rod, supply].map(|it| it as f32)),
            follows: *open > self.opening,
        });
    }

    fn gap(&mut self, cylinder: u8) {
        let index = usize::from(cylinder) - 1;
        // The first row after it has none before, and the spool has moved on by less than a cycle or two.
        self.open[index] = self.open[index].min(self.opening - 1);
    }
}
