//! One cylinder in one cycle.

use tertius_core::monitor::Record;
use tertius_core::sample::Quality;
use tertius_core::time::Timestamp;

/// What a recording says of one cylinder in one cycle; `None` where there is nothing, or nothing
/// that is worth anything.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// The opening of the cycle.
    pub timestamp: Timestamp,
    /// The same in seconds since the recording's first frame.
    pub t: f64,
    /// The number of the cycle: the same for all cylinders, one more in the next cycle.
    pub cycle: u64,
    /// From 1.
    pub cylinder: u8,
    /// Positions that passed the plausibility checks, m.
    pub c1: Option<f64>,
    pub c2: Option<f64>,
    /// Their velocities, m/s, where the position passed.
    pub v1: Option<f64>,
    pub v2: Option<f64>,
    /// The command as it was sent, its offset not taken off, m/s.
    pub u: Option<f64>,
    /// bar.
    pub pressure_bottom: Option<f64>,
    /// bar.
    pub pressure_rod: Option<f64>,
    /// The load pressure that the machine itself sends, bar; see [`Self::load_pressure`].
    pub pressure_load: Option<f64>,
    /// P_S, bar.
    pub supply: Option<f64>,
    /// x_m, positive extends, in its own unit.
    pub spool: Option<f64>,
    /// The platform is in a monitored state.
    pub monitored: bool,
    /// The positions as they came, plausible or not, m.
    pub raw: [Option<f64>; 2],
    /// What C1 and C2 are worth.
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

    /// P_L, bar: as the machine sends it, else P_bot − α P_rod (3-4) with the `area_ratio` α of
    /// (3-5).
    pub fn load_pressure(&self, area_ratio: f64) -> Option<f64> {
        let of_chambers = || Some(self.pressure_bottom? - area_ratio * self.pressure_rod?);
        self.pressure_load.or_else(of_chambers)
    }
}

/// Nothing of the cylinder came in that cycle.
pub(super) fn is_empty(record: &Record) -> bool {
    let Record { c1, c2, command, pressures, .. } = record;
    [c1, c2, command].into_iter().chain(pressures).all(Option::is_none)
}
