//! The gateway of a machine, and what it listens to.

use super::machine::Machine;
use super::node;
use crate::canopen::node::Node;
use crate::frame::{BusNumber, Id};
use crate::live::gateway::Gateway;
use crate::live::outbox::{Outbox, OutboxLimits};
use crate::monitor::Monitor;
use crate::time::Span;

/// The gateway of a machine.
pub fn gateway(machine: Machine) -> Gateway {
    let settings = &machine.loaded.settings;
    let limits = OutboxLimits {
        waiting: OutboxLimits::WAITING,
        estimates: usize::from(settings.machine.cylinders),
        age: Span::from_seconds(settings.gateway.max_age),
        bitrate: f64::from(settings.bus.bitrate),
        share: settings.gateway.bus_share,
        burst: OutboxLimits::BURST,
    };
    let outbox = Outbox::new(limits);
    let guard = Span::from_seconds(settings.gateway.guard);
    let node = node::design(&machine).and_then(|design| Node::new(&design));
    let own = settings.own_identifiers();
    let gateway =
        Gateway::new(Monitor::new(machine.design), outbox, guard).with_own_identifiers(own);
    match node {
        Some(node) => gateway.with_node(node),
        None => gateway,
    }
}

/// Identifiers that the gateway of a machine receives on `bus`, its own included: a socket receives those of other devices
/// only.
pub fn identifiers(machine: &Machine, bus: BusNumber) -> Vec<Id> {
    let settings = &machine.loaded.settings;
    let node = settings.canopen_node().map(|_| Node::inputs(settings.gateway.node));
    let node = node.filter(|_| bus == BusNumber::First);
    let inputs = machine.design.subscriptions.all().iter().filter(|line| line.bus == bus);
    let own = settings.own_identifiers().into_iter().filter(|_| bus == BusNumber::First);
    inputs.map(|line| line.id).chain(node.into_iter().flatten()).chain(own).collect()
}
