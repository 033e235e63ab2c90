//! `[canopen]`: the gateway as a CANopen node, and devices on the bus.

use super::device::{DEVICE, Device};
use crate::kinds::number;
use crate::schema::{Kind, Limits, Scalar, table};

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
