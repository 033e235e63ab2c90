//! What is kept of a recording.

use super::kept::{Consecutive, Pieces};
use crate::survey::{Lull, Ranking, Row, Surveyor};
use tertius_config::settings::Settings;
use tertius_core::alarm::status::MAX_CYLINDERS;
use tertius_core::process::ProcessParameters;
use tertius_core::time;

/// Rows of one cylinder that are kept: three hours at 50 Hz, 35 MB. Of a longer recording every other
/// piece is kept, or every fourth, and so on: more teach nothing new.
const MOST: usize = 540_000;

/// Rows of a piece: a minute at 50 Hz.
const PIECE: usize = 3000;

impl Consecutive for ProcessRow {
    fn part(&mut self) {
        self.follows = false;
    }
}

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
    /// What flow and friction are learnt from.
    pub flow: Option<FlowRow>,
    /// Whether the row before is that of the cycle before.
    pub follows: bool,
}

/// What moves the rod, and the rod.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlowRow {
    /// C1 and C2, m.
    pub lengths: [f32; 2],
    /// P_L and P_S, bar.
    pub load: f32,
    pub supply: Option<f32>,
}

/// The rows of all cylinders.
#[derive(Clone, Debug)]
pub struct ProcessRows {
    cylinders: [Pieces<ProcessRow>; MAX_CYLINDERS],
    /// Cycles of the present stay in a monitored state.
    open: [u32; MAX_CYLINDERS],
    opening: u32,
    lulls: [Lull; MAX_CYLINDERS],
    /// α of (3-5).
    area_ratio: f64,
    /// Whether C1 stands for C2, too, of each cylinder.
    is_alone: [bool; MAX_CYLINDERS],
    /// P_S, bar, where it is given instead of recorded.
    supply: Option<f64>,
}

impl ProcessRows {
    /// Rows of the machine of `settings`.
    pub fn new(settings: &Settings) -> Self {
        let opening = ProcessParameters::DEFAULT.opening;
        Self {
            cylinders: std::array::from_fn(|_| Pieces::new(MOST, PIECE)),
            open: [0; MAX_CYLINDERS],
            opening: time::cycles(opening, settings.machine.sample_time),
            lulls: Default::default(),
            area_ratio: settings.machine.area_ratio,
            is_alone: std::array::from_fn(|index| !settings.has_c2(index as u8 + 1)),
            supply: None,
        }
    }

    /// Rows of C1 alone, which stands for C2, too; with this supply pressure, bar, unless it is `None`.
    pub fn of_c1(settings: &Settings, supply: Option<f64>) -> Self {
        Self { is_alone: [true; MAX_CYLINDERS], supply, ..Self::new(settings) }
    }

    /// Puts the stretches of the recording into the order of this `ranking`.
    pub(super) fn rank(&mut self, ranking: &Ranking) {
        for cylinder in &mut self.cylinders {
            cylinder.rank(ranking, |row| row.t);
        }
    }

    fn flow_row(&self, row: &Row) -> Option<FlowRow> {
        let c1 = row.c1?;
        let c2 = if self.is_alone[usize::from(row.cylinder) - 1] { c1 } else { row.c2? };
        Some(FlowRow {
            lengths: [c1 as f32, c2 as f32],
            load: row.load_pressure(self.area_ratio)? as f32,
            supply: self.supply.or(row.supply).map(|supply| supply as f32),
        })
    }

    /// Those of cylinder `n`.
    pub fn of(&self, n: u8) -> &[ProcessRow] {
        self.cylinders[usize::from(n) - 1].rows()
    }
}

impl Surveyor for ProcessRows {
    fn row(&mut self, row: &Row) {
        let index = usize::from(row.cylinder) - 1;
        let flow = self.flow_row(row);
        let open = &mut self.open[index];
        if self.lulls[index].ends(row.t) {
            *open = 0;
            self.cylinders[index].pause();
        }
        let Some(command) = row.u.filter(|_| row.monitored) else {
            *open = 0;
            return;
        };
        *open = open.saturating_add(1);
        if *open < self.opening {
            return;
        }
        let chambers = row.pressure_bottom.zip(row.pressure_rod).zip(row.supply);
        self.cylinders[index].push(ProcessRow {
            t: row.t,
            command: command as f32,
            spool: row.spool.map(|spool| spool as f32),
            pressures: chambers
                .map(|((bottom, rod), supply)| [bottom, rod, supply].map(|it| it as f32)),
            flow,
            follows: *open > self.opening,
        });
    }

    fn gap(&mut self, cylinder: u8) {
        let index = usize::from(cylinder) - 1;
        // The first row after it has none before, and the spool has moved on by less than a cycle or two.
        self.open[index] = self.open[index].min(self.opening - 1);
    }
}
