//! `[[canopen.device]]`: devices whose objects are read.

use crate::kinds::{MOST_CYLINDERS, number, text, whole};
use crate::schema::{Kind, Limits, Scalar, table};
use crate::text::TextRule;
use serde::Deserialize;

table! {
    /// A device on the bus, described by its EDS or DCF.
    pub struct Device = DEVICE {
        node: u8 => whole(1, 127, "CANopen has the node-IDs 1 to 127"),
            "1", "the device's node-ID";
        kind: DeviceKind => Kind::One(Scalar::Choice(&["transducer", "valve"])),
            "\"transducer\"", "a position transducer (CiA 406) or a proportional valve (CiA 408)";
        cylinder: u8 => whole(1, MOST_CYLINDERS as i128, "cylinders are numbered from 1"),
            "1", "the cylinder that it is on";
        role: Option<Role> = None => Kind::One(Scalar::Choice(&["c1", "c2"])),
            "\"c1\"", "which transducer of the cylinder it is; a valve has none";
        eds: String => text(TextRule::Path),
            "\"../dbc/transducer.eds\"", "the device's EDS or DCF, relative to this file";
        event_timer: Option<f64> = None =>
            number(Limits::above(0.0, "a time in seconds").most(65.535)),
            "0.005", "time from one reading to the next of a transducer that sends by its own timer (object 0x1800:05) \
                instead of SYNC, s; without the key as a DCF says, and by an EDS alone it answers the SYNC";
        heartbeat: Option<f64> = None =>
            number(Limits::least(0.0, "a time in seconds, or 0").most(100.0)),
            "1.5", "time without a heartbeat after which the device is lost, s; without the key 1.5 times object \
                0x1017 of the EDS; 0: its heartbeats may stop";
        full_speed: Option<f64> = None =>
            number(Limits::above(0.0, "a speed in metres per second").most(100.0)),
            "1.0", "the commanded speed at 100 % of a valve's set point, m/s, where the set point has no unit";
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum DeviceKind {
    /// A position transducer (CiA 406).
    Transducer,
    /// A proportional valve (CiA 408).
    Valve,
}

impl DeviceKind {
    /// Number of its profile at CiA.
    pub fn profile(self) -> u16 {
        match self {
            Self::Transducer => 406,
            Self::Valve => 408,
        }
    }

    /// Its word in the configuration.
    pub fn word(self) -> &'static str {
        match self {
            Self::Transducer => "transducer",
            Self::Valve => "valve",
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Role {
    C1,
    C2,
}

impl Role {
    /// Its word in the configuration.
    pub fn name(self) -> &'static str {
        match self {
            Self::C1 => "c1",
            Self::C2 => "c2",
        }
    }
}

impl Device {
    /// Name by which the signals of the device are found, such as `c1 of cylinder 3`.
    pub fn name(&self) -> String {
        device_name(self.role, &self.cylinder.to_string())
    }
}

pub(super) fn device_name(role: Option<Role>, cylinder: &str) -> String {
    format!("{} of cylinder {cylinder}", role.map_or("valve", Role::name))
}

/// Name of an object as a signal of its device.
pub fn object_name(index: u16, sub_index: u8) -> String {
    format!("0x{index:04X}:{sub_index:02X}")
}
