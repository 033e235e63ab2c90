//! Devices that describe their messages themselves, beside the DBC.

use super::message::Message;
use tertius_core::frame::Id;

/// A device's messages, for [`Database::add_device`](super::Database::add_device).
#[derive(Clone, Debug, Default)]
pub struct DeviceMessages {
    /// Names by which the device is known, each in place of a message's: `NAME.SIGNAL`.
    pub names: Vec<String>,
    /// Messages, each with an identifier that nothing else has.
    pub messages: Vec<Message>,
    /// Services by which it tells of itself.
    pub services: DeviceServices,
    /// What a person should know who misses a signal; may be empty.
    pub note: String,
}

/// Services by which a CANopen device tells of itself.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DeviceServices {
    /// Identifier of its emergency messages; `None` where it sends none.
    pub emergency: Option<Id>,
    /// Identifier of its boot-up message and heartbeats.
    pub heartbeat: Option<Id>,
    /// From one heartbeat to the next, s; `None` where it sends none.
    pub period: Option<f64>,
    /// From one PDO to the next, s, where it is set to send them by a timer; `None` where it answers Sync.
    pub event_timer: Option<f64>,
}

/// A message whose identifier another message has.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{message} has the identifier 0x{id}, as has {other}")]
pub struct IdTaken {
    pub message: String,
    pub other: String,
    pub id: Id,
}

/// A device in a database.
#[derive(Clone, Debug)]
pub(super) struct Device {
    /// Places of its messages.
    pub messages: std::ops::Range<usize>,
    pub services: DeviceServices,
    pub note: String,
}
