//! What all parts of the server share.

use super::alarms::Alarms;
use crate::appliance::telemetry::Telemetry;
use crate::appliance::telemetry::clock::Clock;
use opcua::sync::Mutex;
use std::sync::Arc;

/// Name of the namespace of the machine's nodes.
pub const NAMESPACE: &str = "urn:tertius:machine";

/// What all parts of the server share.
#[derive(Clone)]
pub(super) struct Source {
    pub telemetry: Arc<Telemetry>,
    pub clock: Arc<dyn Clock>,
    pub alarms: Arc<Mutex<Alarms>>,
}
