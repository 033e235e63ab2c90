//! What is published of the state, as JSON.

use crate::appliance::telemetry::Telemetry;
use crate::appliance::telemetry::health::HealthReport;
use crate::appliance::telemetry::lamp::Lamp;
use crate::appliance::telemetry::snapshot::{CylinderSnapshot, Snapshot};
use serde::Serialize;
use std::time::Duration;
use tertius_config::MachineNames;
use tertius_core::alarm::status::Health;
use tertius_core::sample::Transducer;
use tertius_core::time::Timestamp;

/// What the broker says in the gateway's place once the connection is lost.
pub(super) const WILL: &str =
    r#"{"online":false,"status":"unknown","reason":"the gateway is not connected to the broker"}"#;

/// The state of gateway and machine, as in `/health`, and of each cylinder.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct StateMessage {
    online: bool,
    /// Time of the message by the system's clock, s since 1970.
    at_s: f64,
    machine: String,
    #[serde(flatten)]
    health: HealthReport,
    /// Number of the highest level in Fd_Status.
    level_number: u8,
    /// Number of the platform's state.
    platform_state: Option<i64>,
    uptime_s: u64,
    cycles: u64,
    cylinders: Vec<CylinderMessage>,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
struct CylinderMessage {
    cylinder: usize,
    /// What people call it, if the configuration says so.
    #[serde(skip_serializing_if = "Option::is_none")]
    name: Option<String>,
    c1: TransducerMessage,
    c2: TransducerMessage,
    /// |R1|, |R2| and |R3| of the newest cycle, m.
    r1_m: Option<f64>,
    r2_m: Option<f64>,
    r3_m: Option<f64>,
    /// Estimated length and its standard deviation, m.
    estimate_m: Option<f64>,
    sigma_m: Option<f64>,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
struct TransducerMessage {
    /// Its tag, if the configuration has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    name: Option<String>,
    state: &'static str,
    lamp: Lamp,
}

impl StateMessage {
    /// The state at the uptime `now`, at which it is `at` by the system's clock.
    pub fn new(telemetry: &Telemetry, now: Duration, at: Timestamp) -> Self {
        let Snapshot { level, platform, cycles, uptime, cylinders, .. } = telemetry.snapshot(now);
        let facts = telemetry.facts();
        let of = |numbered| CylinderMessage::new(numbered, &facts.names);
        Self {
            online: true,
            at_s: at.as_seconds(),
            machine: facts.name.clone(),
            health: telemetry.health(now),
            level_number: level,
            platform_state: platform,
            uptime_s: uptime.as_secs(),
            cycles,
            cylinders: (1..).zip(&cylinders).map(of).collect(),
        }
    }

    /// Whether it says nothing else than `other` but of numbers that change with each cycle.
    pub fn is_like(&self, other: &Self) -> bool {
        let plain = |it: &Self| {
            let mut it = it.clone();
            (it.at_s, it.uptime_s, it.cycles) = (0.0, 0, 0);
            it.health.reason.clear();
            it.health.incidents.iter_mut().for_each(|incident| incident.now_m = None);
            (it.health.seconds_since_turn, it.health.seconds_since_frame) = (None, None);
            for of in &mut it.cylinders {
                let CylinderMessage { r1_m, r2_m, r3_m, estimate_m, sigma_m, .. } = of;
                [r1_m, r2_m, r3_m, estimate_m, sigma_m].into_iter().for_each(|it| *it = None);
            }
            it
        };
        plain(self) == plain(other)
    }

    pub fn to_json(&self) -> String {
        serde_json::to_string(self).unwrap_or_default()
    }
}

impl CylinderMessage {
    fn new((number, of): (usize, &CylinderSnapshot), names: &MachineNames) -> Self {
        let transducer = |which: usize| TransducerMessage {
            name: names.of_transducer(number, Transducer::ALL[which]).map(str::to_owned),
            state: Health::NAMES[of.transducers[which] as usize],
            lamp: of.lamps[which],
        };
        let [r1_m, r2_m, r3_m] = of.residuals;
        Self {
            cylinder: number,
            name: names.of_cylinder(number).map(str::to_owned),
            c1: transducer(0),
            c2: transducer(1),
            r1_m,
            r2_m,
            r3_m,
            estimate_m: of.estimate,
            sigma_m: of.sigma,
        }
    }
}
