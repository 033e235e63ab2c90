//! `[canopen]`: the gateway as a CANopen node, and devices on the bus.

use super::Settings;
use super::device::{DEVICE, Device};
use crate::kinds::number;
use crate::schema::{Kind, Limits, Scalar, table};
use tertius_core::alarm::OwnMessage;
use tertius_core::alarm::frames::{identifiers, service_identifiers};
use tertius_core::alarm::own::Sending;
use tertius_core::frame::Id;

table! {
    /// The gateway as a CANopen node, and devices that describe themselves in EDS or DCF files.
    pub struct Canopen = CANOPEN {
        /// Its number is that of the gateway.
        node: bool = false => Kind::One(Scalar::Switch),
            "true", "whether the gateway is a CANopen node, with heartbeat, EMCY, SDO and NMT; its number is \
                gateway.node";
        heartbeat: f64 = 1.0 =>
            number(Limits::least(0.0, "a time in seconds that object 0x1017 can hold").most(65.535)),
            "1.0", "from one heartbeat to the next, s, 0.05 at least; 0: no heartbeat; a master may set another \
                time by object 0x1017";
        autostart: bool = true => Kind::One(Scalar::Switch),
            "true", "whether the node becomes operational by itself; otherwise no Fd_ frame is sent until an NMT \
                master starts it";
        device: Vec<Device> = Vec::new() => Kind::Tables(&DEVICE),
            "", "a device whose objects are read as its EDS or DCF says";
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
        Some(&self.canopen).filter(|canopen| canopen.node)
    }

    /// The identifiers that the gateway sends: those of its messages in the order of
    /// [`OwnMessage::ALL`], and those of a node's services.
    pub fn own_identifiers(&self) -> Vec<Id> {
        let node = self.gateway.node;
        let services = self.canopen_node().and_then(|_| service_identifiers(node));
        identifiers(node).into_iter().flatten().chain(services.into_iter().flatten()).collect()
    }

    /// Number of frames with a period that the gateway sends each second: Fd_Status, and heartbeats.
    pub fn reports(&self) -> f64 {
        let messages = OwnMessage::ALL.into_iter().map(OwnMessage::sending);
        let statuses: f64 = messages.filter_map(Sending::frequency).sum();
        statuses + self.canopen_node().map_or(0.0, Canopen::heartbeats)
    }

    /// Number of frames that the gateway sends each second whatever happens: [`Self::reports`], and
    /// Fd_Estimate for each cylinder in each cycle where it is sent.
    pub fn periodic_frames(&self) -> f64 {
        let cyclic = OwnMessage::ALL.iter().filter(|message| message.sending() == Sending::Cycles);
        let a_cycle = f64::from(self.machine.cylinders) * cyclic.count() as f64;
        let estimates = if self.estimate.send { a_cycle / self.machine.sample_time } else { 0.0 };
        self.reports() + estimates
    }
}
