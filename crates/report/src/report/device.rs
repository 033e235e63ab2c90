//! What CANopen devices say of themselves, as JSON.

use serde::Serialize;
use tertius_core::sample::emergency::Emergency;
use tertius_core::sample::{DeviceReason, DeviceReport};

/// Fields of a warning that a device has given a reason for.
#[derive(Serialize)]
pub(super) struct DeviceFields {
    pub(super) node: u8,
    pub(super) reason: &'static str,
    #[serde(skip_serializing_if = "Option::is_none", flatten)]
    pub(super) emergency: Option<EmergencyFields>,
}

/// Fields of an emergency message.
#[derive(Debug, Serialize)]
pub(super) struct EmergencyFields {
    pub(super) code: String,
    pub(super) words: &'static str,
    pub(super) register: String,
    pub(super) field: String,
}

impl From<DeviceReport> for DeviceFields {
    fn from(report: DeviceReport) -> Self {
        let (reason, emergency) = match report.reason {
            DeviceReason::Emergency(emergency) => ("emergency", Some(emergency.into())),
            DeviceReason::HeartbeatLost => ("heartbeat_lost", None),
        };
        Self { node: report.node, reason, emergency }
    }
}

impl From<Emergency> for EmergencyFields {
    fn from(emergency: Emergency) -> Self {
        Self {
            code: format!("0x{:04X}", emergency.code),
            words: emergency.words(),
            register: format!("0x{:02X}", emergency.register),
            field: emergency.detail.iter().map(|byte| format!("{byte:02X}")).collect(),
        }
    }
}
