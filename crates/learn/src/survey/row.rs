//! One cylinder in one cycle.

use tertius_core::monitor::Record;
use tertius_core::sample::Quality;
use tertius_core::time::Timestamp;

/// Usable data of one cylinder in one cycle; `None` where there are none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// Opening of the cycle.
    pub timestamp: Timestamp,
    /// Opening of the cycle, seconds since the recording's first frame.
    pub t: f64,
    /// Number of the cycle: the same for all cylinders, and one more in the next cycle.
    pub cycle: u64,
    /// Cylinder number, counted from 1.
    pub cylinder: u8,
    /// Position of C1, m, if it passed the plausibility checks.
    pub c1: Option<f64>,
    /// Position of C2, m, if it passed the plausibility checks.
    pub c2: Option<f64>,
    /// Velocity by C1, m/s, where its position passed.
    pub v1: Option<f64>,
    /// Velocity by C2, m/s, where its position passed.
    pub v2: Option<f64>,
    /// Command as sent, with its offset, m/s.
    pub u: Option<f64>,
    /// Pressure of the bottom chamber, bar.
    pub pressure_bottom: Option<f64>,
    /// Pressure of the rod chamber, bar.
    pub pressure_rod: Option<f64>,
    /// Load pressure that the machine itself sends, bar; see [`Self::load_pressure`].
    pub pressure_load: Option<f64>,
    /// Supply pressure P_S, bar.
    pub supply: Option<f64>,
    /// Spool position x_m, positive extends, in its own unit.
    pub spool: Option<f64>,
    /// Whether the platform is in a monitored state.
    pub monitored: bool,
    /// Positions as received, plausible or not, m.
    pub raw: [Option<f64>; 2],
    /// Qualities of C1 and C2.
    pub qualities: [Quality; 2],
}

impl Row {
    pub(super) fn new(record: &Record, t: f64) -> Self {
        let good = record.qualities.map(Quality::is_good);
        let [c1, c2] = [record.c1.filter(|_| good[0]), record.c2.filter(|_| good[1])];
        let [v1, v2] = record.velocities;
        let [pressure_bottom, pressure_rod, pressure_load] = record.pressures;
        Self {
            timestamp: record.timestamp,
            t,
            cycle: record.cycle,
            cylinder: record.cylinder,
            c1,
            c2,
            v1: v1.filter(|_| good[0]),
            v2: v2.filter(|_| good[1]),
            u: record.command,
            pressure_bottom,
            pressure_rod,
            pressure_load,
            supply: record.supply,
            spool: record.spool,
            monitored: record.monitored,
            raw: [record.c1, record.c2],
            qualities: record.qualities,
        }
    }

    /// Load pressure P_L, bar: as the machine sends it, or else P_bot − α P_rod (3-4) with the
    /// `area_ratio` α of (3-5).
    pub fn load_pressure(&self, area_ratio: f64) -> Option<f64> {
        let of_chambers = || Some(self.pressure_bottom? - area_ratio * self.pressure_rod?);
        self.pressure_load.or_else(of_chambers)
    }
}

/// Whether nothing of the cylinder came in that cycle.
pub(super) fn is_empty(record: &Record) -> bool {
    let Record { c1, c2, command, pressures, .. } = record;
    [c1, c2, command].into_iter().chain(pressures).all(Option::is_none)
}
