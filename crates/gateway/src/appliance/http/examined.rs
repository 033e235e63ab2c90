//! The last examination of this computer.

use crate::appliance::doctor::Finding;
use serde::Serialize;
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::Mutex;

/// The last examination, and its uptime. It is locked while one is made, also for someone who no longer waits, so that
/// one that takes long occupies one thread and not all.
pub(super) type Examined = Arc<Mutex<Option<(Duration, Report)>>>;

/// What was found.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Report {
    /// When, s since 1970.
    pub at_s: f64,
    pub findings: Vec<Finding>,
}
