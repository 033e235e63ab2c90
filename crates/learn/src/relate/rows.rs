//! What is kept of a recording.

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
    cylinders: [Pieces; MAX_CYLINDERS],
    /// Cycles of the present stay in a monitored state.
    open: [u32; MAX_CYLINDERS],
    opening: u32,
    lulls: [Lull; MAX_CYLINDERS],
    /// α of (3-5).
    area_ratio: f64,
    /// Whether C1 stands for C2, too.
    is_alone: bool,
    /// P_S, bar, where it is given instead of recorded.
    supply: Option<f64>,
}

/// Every n-th piece of the rows of one cylinder, counted anew after each pause, so that what is kept
/// of a file does not depend on what was recorded before it.
#[derive(Clone, Debug)]
struct Pieces {
    most: usize,
    rows: Vec<ProcessRow>,
    /// Number of each piece that is kept, and the index of its first row.
    begun: Vec<(u64, usize)>,
    stride: u64,
    /// Number of the newest piece, from 0, and the rows that it has had.
    newest: Option<(u64, usize)>,
}

impl Default for Pieces {
    fn default() -> Self {
        Self { most: MOST, rows: Vec::new(), begun: Vec::new(), stride: 1, newest: None }
    }
}

impl Pieces {
    fn pause(&mut self) {
        self.newest = None;
    }

    fn push(&mut self, mut row: ProcessRow) {
        let (number, had) = match self.newest {
            None => (0, 0),
            Some((number, PIECE)) => (number + 1, 0),
            Some(newest) => newest,
        };
        self.newest = Some((number, had + 1));
        if number.is_multiple_of(self.stride) && self.rows.len() == self.most {
            self.halve();
        }
        // Of more pauses than there is room for, the first.
        if !number.is_multiple_of(self.stride) || self.rows.len() == self.most {
            return;
        }
        if had == 0 {
            self.begun.push((number, self.rows.len()));
            // The piece before it may be missing.
            row.follows &= self.stride == 1;
        }
        self.rows.push(row);
    }

    fn halve(&mut self) {
        self.stride = self.stride.saturating_mul(2);
        let ends = self.begun.iter().skip(1).map(|(_, begin)| *begin).chain([self.rows.len()]);
        let spans: Vec<_> = self.begun.iter().copied().zip(ends).collect();
        let (mut rows, mut begun) = (Vec::with_capacity(self.rows.len()), Vec::new());
        for ((number, begin), end) in spans {
            if number.is_multiple_of(self.stride) {
                begun.push((number, rows.len()));
                rows.extend_from_slice(&self.rows[begin..end]);
            }
        }
        begun.iter().for_each(|(_, begin)| rows[*begin].follows = false);
        (self.rows, self.begun) = (rows, begun);
    }
}

impl ProcessRows {
    /// Rows of the machine of `settings`.
    pub fn new(settings: &Settings) -> Self {
        let opening = ProcessParameters::DEFAULT.opening;
        Self {
            cylinders: Default::default(),
            open: [0; MAX_CYLINDERS],
            opening: time::cycles(opening, settings.machine.sample_time),
            lulls: Default::default(),
            area_ratio: settings.machine.area_ratio,
            is_alone: false,
            supply: None,
        }
    }

    /// Rows of C1 alone, which stands for C2, too; with this supply pressure, bar, unless it is `None`.
    pub fn of_c1(settings: &Settings, supply: Option<f64>) -> Self {
        Self { is_alone: true, supply, ..Self::new(settings) }
    }

    /// Puts the stretches of the recording into the order of this `ranking`.
    pub(super) fn rank(&mut self, ranking: &Ranking) {
        for cylinder in &mut self.cylinders {
            cylinder.rows.sort_by_key(|row| ranking.rank(row.t));
        }
    }

    fn flow_row(&self, row: &Row) -> Option<FlowRow> {
        let c1 = row.c1?;
        let c2 = if self.is_alone { c1 } else { row.c2? };
        Some(FlowRow {
            lengths: [c1 as f32, c2 as f32],
            load: row.load_pressure(self.area_ratio)? as f32,
            supply: self.supply.or(row.supply).map(|supply| supply as f32),
        })
    }

    /// Those of cylinder `n`.
    pub fn of(&self, n: u8) -> &[ProcessRow] {
        &self.cylinders[usize::from(n) - 1].rows
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

#[cfg(test)]
mod tests {
    use super::*;

    /// The rows that are kept of files in this order, each with the numbers of its rows.
    fn kept(most: usize, files: &[std::ops::Range<u32>]) -> Vec<ProcessRow> {
        let mut pieces = Pieces { most, ..Pieces::default() };
        for file in files {
            pieces.pause();
            for number in file.clone() {
                let follows = number != file.start;
                let command = number as f32;
                let (spool, pressures, flow) = (None, None, None);
                pieces.push(ProcessRow { t: 0.0, command, spool, pressures, flow, follows });
            }
        }
        assert!(pieces.rows.len() <= most);
        pieces.rows
    }

    #[test]
    fn files_in_either_order_keep_the_same_pieces() {
        let (one, other) = (0..40_000_u32, 100_000..125_500);
        for most in [100_000, 40_000, 20_000] {
            let mut there = kept(most, &[one.clone(), other.clone()]);
            let mut back = kept(most, &[other.clone(), one.clone()]);
            let by_command = |a: &ProcessRow, b: &ProcessRow| a.command.total_cmp(&b.command);
            there.sort_by(by_command);
            back.sort_by(by_command);
            assert_eq!(there, back);
            assert!(there.len() >= most.min(65_500) / 2, "{} of {most}", there.len());
            // A row follows the one before where that is kept, too.
            for (last, row) in there.iter().zip(&there[1..]) {
                let next = row.command == last.command + 1.0;
                assert!(next || !row.follows, "{row:?}");
            }
        }
    }
}
