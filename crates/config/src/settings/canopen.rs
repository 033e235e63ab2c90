//! `[canopen]`: the gateway as a CANopen node.

use super::Settings;
use serde::Deserialize;

/// The gateway as a CANopen node.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Canopen {
    /// Whether the gateway is a node; its number is that of the gateway.
    pub node: bool,
    /// Time between heartbeats, s; 0 for none.
    pub heartbeat: f64,
    /// Whether the node becomes operational without an NMT master.
    pub autostart: bool,
}

impl Default for Canopen {
    fn default() -> Self {
        Self { node: false, heartbeat: 1.0, autostart: true }
    }
}

impl Canopen {
    /// Shortest time between heartbeats, s.
    pub const SHORTEST_HEARTBEAT: f64 = 0.05;

    /// Rate of the heartbeats, 1/s, which no configuration that is accepted exceeds.
    pub fn heartbeats(&self) -> f64 {
        let period = self.heartbeat.max(Self::SHORTEST_HEARTBEAT);
        if self.heartbeat > 0.0 { period.recip() } else { 0.0 }
    }
}

impl Settings {
    /// The gateway as a CANopen node; `None` if it is none.
    pub fn canopen_node(&self) -> Option<&Canopen> {
        self.canopen.as_ref().filter(|canopen| canopen.node)
    }

    /// Number of frames that the gateway sends each second whatever happens: Fd_Status every 100 ms,
    /// heartbeats, and Fd_Estimate for each cylinder in each cycle where it is sent.
    pub fn periodic_frames(&self) -> f64 {
        let machine = &self.machine;
        let estimates = f64::from(machine.cylinders) / machine.sample_time;
        let estimates = if self.estimate.send { estimates } else { 0.0 };
        STATUSES + self.canopen_node().map_or(0.0, Canopen::heartbeats) + estimates
    }
}

/// Rate of Fd_Status, 1/s.
pub const STATUSES: f64 = 10.0;
