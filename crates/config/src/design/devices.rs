//! Devices that tell of themselves: the services by which they do, and the watches on them.

use super::connector::Connector;
use super::flaw::Flaw;
use crate::settings::{Device, DeviceKind, Role};
use tertius_core::frame::{BusNumber, Id};
use tertius_core::monitor::subscriptions::{
    DeviceService, SubscribedService, SubscribedSignal, Target,
};
use tertius_core::sample::device::DeviceDesign;
use tertius_core::sample::{DeviceRole, Transducer};

/// Factor on the time between heartbeats after which the next one is given up, where the configuration has
/// no time: one may be late by half of it.
const HEARTBEAT_MARGIN: f64 = 1.5;

impl Connector<'_> {
    /// Subscribes to the emergency messages and heartbeats of the devices of the configuration. Everything
    /// else must be connected already.
    pub(super) fn connect_devices(&mut self) {
        let settings = self.settings;
        for (index, device) in settings.devices().iter().enumerate() {
            let role = role_of(device);
            let services = self.database.device_services(&device.name());
            let (Some(services), true) = (services, self.is_used(device, role)) else { continue };
            let place = (device.cylinder - 1, role);
            if let Some(time) = device.event_timer.or(services.event_timer) {
                self.connect_timer(index, time, place);
            }
            for (id, service) in [
                (services.emergency, DeviceService::Emergency),
                (services.heartbeat, DeviceService::Heartbeat),
            ] {
                if let Some(id) = id {
                    self.connect_service(index, id, service, place);
                }
            }
        }
    }

    /// Whether the monitor has what the device is of: a second transducer may not be configured.
    fn is_used(&self, device: &Device, role: DeviceRole) -> bool {
        let has = role != DeviceRole::C2 || self.settings.has_c2(device.cylinder);
        has && device.cylinder <= self.settings.machine.cylinders
    }

    /// Takes the readings of a transducer that sends by its own timer as such.
    fn connect_timer(&mut self, index: usize, time: f64, (cylinder, role): (u8, DeviceRole)) {
        let key = format!("canopen.device[{index}].event_timer");
        let settings = self.settings;
        let transducer = match role {
            DeviceRole::C1 => Transducer::C1,
            DeviceRole::C2 => Transducer::C2,
            DeviceRole::Valve => {
                let message = "a valve sends no readings that a timer would matter for";
                self.flaws.push(Flaw::new(&key, message, "leave the key out"));
                return;
            }
        };
        let half = 0.5 * settings.machine.sample_time;
        if time > half || settings.signals.sync.is_none() {
            let message = format!("a transducer sends every {time} s by its own timer");
            let help = format!(
                "that takes a Sync, before which the newest reading counts, and at most half a sample time, {half} s"
            );
            self.flaws.push(Flaw::new(&key, message, help));
            return;
        }
        let own = |one: &SubscribedSignal| match one.target {
            Target::Cylinder(index, field) => {
                index == cylinder && field.transducer() == Some(transducer)
            }
            Target::State | Target::Inclination(_) => false,
        };
        if !self.subscriptions.send_by_timer(own) {
            let message = "a message of this transducer also has other signals than readings";
            let help = "let it answer the SYNC (object 0x1800:02 is 1), or map its readings alone";
            self.flaws.push(Flaw::new(&key, message, help));
        }
    }

    fn connect_service(
        &mut self,
        index: usize,
        id: Id,
        service: DeviceService,
        place: (u8, DeviceRole),
    ) {
        let devices = self.settings.devices();
        let subscription = self.subscriptions.subscribe(BusNumber::First, id);
        let is_input = subscription.sync || !subscription.signals.is_empty();
        let node = devices[index].node;
        match &mut subscription.service {
            None if !is_input => {
                let devices = vec![place];
                subscription.service = Some(SubscribedService { service, devices });
            }
            // One node with several sensors tells of all of them.
            Some(known) if known.service == service && is_of(known, node, devices) => {
                known.devices.push(place);
            }
            _ => {
                let what = match service {
                    DeviceService::Emergency => "emergency messages",
                    DeviceService::Heartbeat => "heartbeats",
                };
                self.flaws.push(Flaw::new(
                    &format!("canopen.device[{index}].node"),
                    format!("0x{id} is the identifier of node {node}'s {what} and of another input"),
                    "nodes have node-IDs and COB-IDs of their own; does the signal come from that node?",
                ));
            }
        }
    }

    /// Watches on the devices of cylinder `n`, by [`DeviceRole`].
    pub(super) fn watched(&self, n: u8) -> [Option<DeviceDesign>; 3] {
        DeviceRole::ALL.map(|role| {
            let is_it = |device: &&Device| device.cylinder == n && role_of(device) == role;
            let device = self.settings.devices().iter().find(is_it)?;
            let device = Some(device).filter(|it| self.is_used(it, role))?;
            let services = self.database.device_services(&device.name())?;
            let period = services.period.map(|period| HEARTBEAT_MARGIN * period);
            let time = device.heartbeat.or(period).filter(|time| *time > 0.0);
            let cycles = |time: f64| (time / self.settings.machine.sample_time).ceil() as u32;
            let heartbeat = time.map(cycles);
            Some(DeviceDesign { node: device.node, heartbeat })
        })
    }
}

fn role_of(device: &Device) -> DeviceRole {
    match (device.kind, device.role) {
        (DeviceKind::Valve, _) => DeviceRole::Valve,
        (DeviceKind::Transducer, Some(Role::C2)) => DeviceRole::C2,
        (DeviceKind::Transducer, _) => DeviceRole::C1,
    }
}

/// Whether everything that a service is of is one node.
fn is_of(service: &SubscribedService, node: u8, devices: &[Device]) -> bool {
    let is_of_node = |(index, role): &(u8, DeviceRole)| {
        let same = |it: &Device| it.cylinder == index + 1 && role_of(it) == *role;
        devices.iter().any(|it| same(it) && it.node == node)
    };
    service.devices.iter().all(is_of_node)
}
