//! The gateway of a machine as a CANopen node.

use super::machine::Machine;
use crate::alarm::frames::FRAME_BITS;
use crate::canopen::node::{CylinderThresholds, NodeDesign, checksum};
use crate::config::settings::Canopen;
use crate::config::{Fingerprint, Settings};
use crate::monitor::Estimates;

/// The node that the configuration asks for; `None` if the gateway is none.
pub fn design(machine: &Machine) -> Option<NodeDesign> {
    let Machine { loaded, design, .. } = machine;
    let settings = &loaded.settings;
    let canopen = settings.canopen_node()?;
    let cylinders = design.cylinders.iter().map(|cylinder| {
        let (observer, difference) = (&cylinder.bank.observer, &cylinder.bank.difference);
        CylinderThresholds {
            observer: [observer.low, observer.high],
            difference: [difference.low, difference.high],
            critical: cylinder.critical,
        }
    });
    let fingerprints = loaded.fingerprints();
    let calibrated = design.cylinders.iter().filter(|cylinder| cylinder.sequential.is_some());
    Some(NodeDesign {
        node: settings.gateway.node,
        heartbeat: milliseconds(canopen.heartbeat),
        shortest_heartbeat: shortest_heartbeat(settings, canopen),
        autostart: canopen.autostart,
        version: env!("CARGO_PKG_VERSION").to_owned(),
        machine: settings.machine.name.clone(),
        sample_time: settings.machine.sample_time,
        cylinders: cylinders.collect(),
        sends_estimates: design.estimates == Estimates::Sent,
        calibrated: calibrated.fold(0, |bits, cylinder| bits | 1 << (cylinder.number - 1)),
        configuration: fingerprints.configuration.number(),
        calibration: fingerprints.calibration.map_or(0, Fingerprint::number),
        database: checksum(&loaded.layout()),
        bitrate: settings.bus.bitrate,
    })
}

/// Shortest heartbeat time that a master may set, ms: heartbeats take half at most of what the
/// gateway's other periodic frames leave of its share of the bus.
fn shortest_heartbeat(settings: &Settings, canopen: &Canopen) -> u16 {
    let share = f64::from(settings.bus.bitrate) * settings.gateway.bus_share / FRAME_BITS;
    let others = settings.periodic_frames() - canopen.heartbeats();
    let most = (share - others) / 2.0;
    let shortest = if most > 0.0 { most.recip() } else { f64::INFINITY };
    let configured = if canopen.heartbeat > 0.0 { canopen.heartbeat } else { f64::INFINITY };
    milliseconds(shortest.max(Canopen::SHORTEST_HEARTBEAT).min(configured))
}

/// Milliseconds, rounded up; the most that object 0x1017 can hold if there are more.
fn milliseconds(seconds: f64) -> u16 {
    (seconds * 1e3).ceil() as u16
}
