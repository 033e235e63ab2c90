//! The configuration file as types. Field names are the file's keys; lengths are metres, times
//! seconds, speeds metres per second. What is absent in the file has its default here.

mod estimate;
mod levels;
mod sequential;

pub use estimate::Estimate;
pub use levels::LevelsTable;
#[cfg(test)]
pub use levels::ReadLevels;
pub use sequential::{CylinderSequential, Sequential};
use serde::Deserialize;
use std::net::SocketAddr;
use tertius_core::alarm::Levels;

/// Stands for the cylinder's number in the signal names of `[signals.cylinder]`.
pub const PLACEHOLDER: &str = "{n}";

/// The whole file.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    pub machine: Machine,
    pub bus: Bus,
    pub signals: Signals,
    #[serde(default)]
    pub plausibility: Plausibility,
    #[serde(default)]
    pub model: Model,
    #[serde(default)]
    pub observer: Observer,
    #[serde(default)]
    pub fde: Fde,
    #[serde(default)]
    pub comparator: Comparator,
    #[serde(default)]
    pub alarm: Alarm,
    #[serde(default)]
    pub sequential: Sequential,
    #[serde(default)]
    pub estimate: Estimate,
    #[serde(default)]
    pub gateway: Gateway,
    #[serde(default)]
    pub http: Http,
    #[serde(default)]
    pub realtime: Realtime,
    /// Overrides per cylinder; at most one table for each number.
    #[serde(default)]
    pub cylinder: Vec<Cylinder>,
}

#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Machine {
    pub name: String,
    /// 1 to 6: Fd_Status has room for six.
    pub cylinders: u8,
    /// Ts, s.
    pub sample_time: f64,
    /// The cylinder's reach `[retracted, extended]`, m.
    pub stroke: [f64; 2],
    /// a_p / A_p of (3-5), the rod side's area by the bottom's; makes P_L of the pressures.
    #[serde(default = "default_area_ratio")]
    pub area_ratio: f64,
    /// Platform states in which FDE1 and FDE2 judge; absent: always. Names as in the DBC's VAL_
    /// table of the state signal (or the thesis's four), letter case ignored; or numbers as text.
    pub monitored_states: Option<Vec<String>>,
    /// Readings later than this after the opening of their cycle are late, s; absent: 0.8 Ts.
    pub cycle_deadline: Option<f64>,
    /// An observer predicts over at most this long a gap before it starts anew, s.
    #[serde(default = "default_max_gap")]
    pub max_gap: f64,
}

fn default_area_ratio() -> f64 {
    0.5
}

fn default_max_gap() -> f64 {
    0.1
}

#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Bus {
    /// A SocketCAN interface, or "virtual": the embedded bus.
    pub interface: String,
    /// The DBC's path, relative to the configuration file.
    pub dbc: String,
    /// Bit rate, bit/s; the gateway's share of the bus is reckoned from it.
    #[serde(default = "default_bitrate")]
    pub bitrate: u32,
}

fn default_bitrate() -> u32 {
    500_000
}

/// Where the signals are: `MESSAGE.SIGNAL` of the DBC.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Signals {
    /// A message (not a signal) that opens a cycle.
    pub sync: Option<String>,
    pub state: Option<String>,
    /// P_S of (3-18), bar; read by who learns from a recording.
    pub supply: Option<String>,
    pub cylinder: CylinderSignals,
}

/// Signal names of one cylinder; `{n}` stands for its number.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CylinderSignals {
    pub c1: String,
    pub c1_velocity: Option<String>,
    pub c1_status: Option<String>,
    pub c1_counter: Option<String>,
    pub c2: Option<String>,
    pub c2_velocity: Option<String>,
    pub c2_status: Option<String>,
    pub c2_counter: Option<String>,
    pub control_speed: String,
    pub pressure_bottom: Option<String>,
    pub pressure_rod: Option<String>,
    /// The load pressure where the machine sends it; then the chambers' are not asked.
    pub load_pressure: Option<String>,
    /// x_m of (3-17), in whatever unit it is sent; read by who learns from a recording.
    pub spool: Option<String>,
}

/// When a reading is not to be believed before any model is asked.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Plausibility {
    /// Without a new reading for this long a signal is stale, s.
    pub stale: f64,
    /// Raw codes that mean a broken wire; absent: see [`Settings::broken_wire_codes`].
    pub broken_wire_codes: Option<Vec<i64>>,
    /// Status bits that mean a broken wire, where a status signal is configured.
    pub status_mask: u64,
    /// Valid raw counts `[lowest, highest]`; absent: the DBC's [min|max], and always the stroke.
    pub valid_raw: Option<[i64; 2]>,
    /// A reading exactly constant for this long while the command moves is frozen, s.
    pub frozen: f64,
    /// The command moves when it is beyond this, m/s.
    pub frozen_speed: f64,
    /// Without a new platform state for this long the state is not known, s.
    pub state_stale: f64,
}

impl Default for Plausibility {
    fn default() -> Self {
        Self {
            stale: 0.1,
            broken_wire_codes: None,
            status_mask: u64::MAX,
            valid_raw: None,
            frozen: 0.1,
            frozen_speed: 0.02,
            state_stale: 1.0,
        }
    }
}

/// The discrete model (4-1); defaults are Table 4-1.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Model {
    pub theta: [f64; 5],
    pub gamma: [f64; 2],
    /// The command at which a cylinder rests, m/s; (4-1) has u less this as its input.
    pub command_offset: f64,
    /// The sample time that they are of, s; absent: see [`Settings::model_time_of`].
    pub sample_time: Option<f64>,
}

impl Default for Model {
    fn default() -> Self {
        Self {
            theta: [-0.0101, -0.1231, -1.6891e-5, -10.7104, -0.0023],
            gamma: [0.0926, 6.5427],
            command_offset: 0.0,
            sample_time: None,
        }
    }
}

/// Weights of the Riccati equation, the diagonals of Q (position, velocity, load pressure) and R
/// (position, velocity).
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Observer {
    pub q: [f64; 3],
    pub r: [f64; 2],
    /// An observer judges after it has followed its readings for this long, s.
    pub settle: f64,
    /// The sample time at which the weights were tuned, s; absent: not known.
    pub sample_time: Option<f64>,
}

impl Default for Observer {
    fn default() -> Self {
        Self { q: [5e-9, 2e-4, 1e4], r: [1e-8, 5.0], settle: 1.0, sample_time: None }
    }
}

/// Thresholds of R1 and R2 (section 5-4-1), m.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Fde {
    pub low: f64,
    pub high: f64,
}

impl Default for Fde {
    fn default() -> Self {
        Self { low: 7.5e-4, high: 1.0e-3 }
    }
}

/// Thresholds of R3 (section 5-5), m.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Comparator {
    pub bound: f64,
    /// Below this R3 counts towards clearing; absent: three quarters of `bound`.
    pub low: Option<f64>,
    /// The machine's own "difference too big", of C1 − C2 as measured.
    pub critical: f64,
}

impl Default for Comparator {
    fn default() -> Self {
        Self { bound: 1.5e-3, low: None, critical: 0.05 }
    }
}

/// How warnings come and go.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Alarm {
    /// A warning clears after its residual stayed below the lower threshold this long, s.
    pub clear: f64,
    /// FDEs that raise within this time of each other saw the same event, s.
    pub coincidence: f64,
    #[serde(with = "LevelsTable")]
    pub levels: Levels,
}

impl Default for Alarm {
    fn default() -> Self {
        Self { clear: 1.0, coincidence: 0.2, levels: Levels::default() }
    }
}

/// The gateway's own place on the bus.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Gateway {
    /// CANopen node: Fd_Status is 0x180 + node, Fd_Warning 0x280 + node, Fd_Estimate 0x380 + node.
    pub node: u8,
    /// The largest part of the bus that it takes, 0 to 0.5.
    pub bus_share: f64,
    /// A frame that could not be sent for this long is dropped, s.
    pub max_age: f64,
    /// Deadlines are kept this far behind the clock, for frames still on their way, s.
    pub guard: f64,
}

impl Default for Gateway {
    fn default() -> Self {
        Self { node: 81, bus_share: 0.05, max_age: 0.2, guard: 0.01 }
    }
}

/// The gateway's own state over HTTP.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Http {
    /// `ADDRESS:PORT`, or [`HTTP_OFF`].
    pub listen: String,
}

/// No HTTP at all.
pub const HTTP_OFF: &str = "off";

impl Default for Http {
    fn default() -> Self {
        Self { listen: "127.0.0.1:9481".to_owned() }
    }
}

impl Http {
    /// Where to listen; `None` if it is off.
    pub fn address(&self) -> Option<SocketAddr> {
        self.listen.parse().ok()
    }
}

/// What the gateway asks of the kernel as it starts. A reload changes neither.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Realtime {
    /// SCHED_FIFO priority of the data path, 1 to 99; 0 for none.
    pub priority: u8,
    /// Whether all memory, present and future, is locked.
    pub lock_memory: bool,
}

/// What one cylinder has of its own.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Cylinder {
    pub n: u8,
    /// a of (5-20).
    #[serde(default = "unit_gain")]
    pub c2_gain: f64,
    /// b of (5-20), m.
    #[serde(default)]
    pub c2_offset: f64,
    pub theta: Option<[f64; 5]>,
    pub gamma: Option<[f64; 2]>,
    pub command_offset: Option<f64>,
    /// The sample time of its own theta and gamma, s; absent: not known.
    pub sample_time: Option<f64>,
    /// What `calibrate` has fitted; absent: no sequential detector.
    pub sequential: Option<CylinderSequential>,
}

fn unit_gain() -> f64 {
    1.0
}
