//! The configuration file as types. Field names are the file's keys; lengths are metres, times
//! seconds, speeds metres per second. Keys that are absent in the file have their defaults here.

mod canopen;
mod estimate;
mod levels;
mod sequential;

pub use canopen::{Canopen, Device, DeviceKind, Role, object_name, object_of};
pub use estimate::Estimate;
pub use levels::LevelsTable;
#[cfg(test)]
pub use levels::ReadLevels;
pub use sequential::{CylinderSequential, Sequential};
use serde::Deserialize;
use std::net::SocketAddr;
use tertius_core::alarm::Levels;

/// Placeholder of the cylinder's number in the signal names of `[signals.cylinder]`.
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
    /// What is configured of CANopen.
    pub canopen: Option<Canopen>,
    #[serde(default)]
    pub http: Http,
    #[serde(default)]
    pub realtime: Realtime,
    /// Overrides for single cylinders; at most one table for each number.
    #[serde(default)]
    pub cylinder: Vec<Cylinder>,
}

#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Machine {
    pub name: String,
    /// Number of cylinders, 1 to 6: Fd_Status has room for six.
    pub cylinders: u8,
    /// Sample time Ts, s.
    pub sample_time: f64,
    /// Reach of a cylinder `[retracted, extended]`, m.
    pub stroke: [f64; 2],
    /// a_p / A_p of (3-5), the rod side's area over the bottom's, from which P_L follows.
    #[serde(default = "default_area_ratio")]
    pub area_ratio: f64,
    /// Platform states in which FDE1 and FDE2 judge; absent: always. Names are those in the DBC's
    /// VAL_ table of the state signal (or the thesis's four), ignoring letter case; or numbers as
    /// text.
    pub monitored_states: Option<Vec<String>>,
    /// Deadline of readings after the opening of their cycle, s; absent: 0.8 Ts.
    pub cycle_deadline: Option<f64>,
    /// Longest gap over which an observer predicts before it restarts, s.
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
    /// SocketCAN interface, or "virtual" for the embedded bus.
    pub interface: String,
    /// Path of the DBC, relative to the configuration file.
    pub dbc: String,
    /// Bit rate, bit/s, from which the gateway's share of the bus is computed.
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
    /// Name of a message (not a signal) that opens a cycle.
    pub sync: Option<String>,
    pub state: Option<String>,
    /// P_S of (3-18), bar; read by commands that learn from a recording.
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
    /// Load pressure, where the machine sends it; the chambers' pressures are then not needed.
    pub load_pressure: Option<String>,
    /// x_m of (3-17), in whatever unit it is sent; read by commands that learn from a recording.
    pub spool: Option<String>,
}

/// Limits beyond which a reading is rejected before any model is asked.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Plausibility {
    /// Time without a new reading after which a signal is stale, s.
    pub stale: f64,
    /// Raw codes that mean a broken wire; absent: see [`Settings::broken_wire_codes`].
    pub broken_wire_codes: Option<Vec<i64>>,
    /// Status bits that mean a broken wire, where a status signal is configured.
    pub status_mask: u64,
    /// Valid raw counts `[lowest, highest]`; absent: the DBC's [min|max], and always the stroke.
    pub valid_raw: Option<[i64; 2]>,
    /// Time for which a reading may be exactly constant while the command moves, s; longer is
    /// frozen.
    pub frozen: f64,
    /// Command speed above which the command counts as moving, m/s.
    pub frozen_speed: f64,
    /// Time without a new platform state after which the state is unknown, s.
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

/// The discrete model (4-1); the defaults are Table 4-1.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Model {
    pub theta: [f64; 5],
    pub gamma: [f64; 2],
    /// Command at which a cylinder rests, m/s; the input of (4-1) is u less this.
    pub command_offset: f64,
    /// Sample time that the model was identified at, s; absent: see [`Settings::model_time_of`].
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
    /// Time for which an observer follows its readings before it judges, s.
    pub settle: f64,
    /// Sample time at which the weights were tuned, s; absent: not known.
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
    /// Lower threshold, below which |R3| counts towards clearing, m; absent: three quarters of
    /// `bound`.
    pub low: Option<f64>,
    /// The machine's own "difference too big", of C1 − C2 as measured, m.
    pub critical: f64,
}

impl Default for Comparator {
    fn default() -> Self {
        Self { bound: 1.5e-3, low: None, critical: 0.05 }
    }
}

/// How warnings are raised and cleared.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Alarm {
    /// Time for which the residual must stay below the lower threshold before a warning clears, s.
    pub clear: f64,
    /// Time within which FDEs that raise saw the same event, s.
    pub coincidence: f64,
    #[serde(with = "LevelsTable")]
    pub levels: Levels,
}

impl Default for Alarm {
    fn default() -> Self {
        Self { clear: 1.0, coincidence: 0.2, levels: Levels::default() }
    }
}

/// The gateway's own node on the bus.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Gateway {
    /// CANopen node number: Fd_Status is 0x180 + node, Fd_Warning 0x280 + node, Fd_Estimate 0x380 +
    /// node.
    pub node: u8,
    /// Largest share of the bus that the gateway takes, 0 to 0.5.
    pub bus_share: f64,
    /// Age at which a frame that could not be sent is dropped, s.
    pub max_age: f64,
    /// Delay of deadlines behind the clock, for frames still on their way, s.
    pub guard: f64,
}

impl Default for Gateway {
    fn default() -> Self {
        Self { node: 81, bus_share: 0.05, max_age: 0.2, guard: 0.01 }
    }
}

/// HTTP server of the gateway's own state.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Http {
    /// `ADDRESS:PORT` to listen on, or [`HTTP_OFF`].
    pub listen: String,
}

/// Value of `listen` for no HTTP at all.
pub const HTTP_OFF: &str = "off";

impl Default for Http {
    fn default() -> Self {
        Self { listen: "127.0.0.1:9481".to_owned() }
    }
}

impl Http {
    /// Address to listen on; `None` if HTTP is off.
    pub fn address(&self) -> Option<SocketAddr> {
        self.listen.parse().ok()
    }
}

/// Scheduling and memory that the gateway requests from the kernel at its start. A reload changes
/// neither.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Realtime {
    /// SCHED_FIFO priority of the data path, 1 to 99; 0 for none.
    pub priority: u8,
    /// Whether all memory, present and future, is locked.
    pub lock_memory: bool,
}

/// Overrides for one cylinder.
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
    /// Sample time of the cylinder's own theta and gamma, s; absent: not known.
    pub sample_time: Option<f64>,
    /// Tables that `calibrate` has fitted; absent: no sequential detector.
    pub sequential: Option<CylinderSequential>,
}

fn unit_gain() -> f64 {
    1.0
}
