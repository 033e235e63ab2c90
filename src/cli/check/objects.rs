//! Which objects of CANopen devices are read, where they are in their PDOs, and what they stand for.

use super::super::machine::Machine;
use crate::canopen::pdo::BITS;
use crate::config::devices;
use crate::config::settings::{CylinderSignals, Device, Role};
use crate::dbc::Signal;
use crate::frame::Id;

/// The number of messages that devices describe themselves; empty without devices.
pub(super) fn messages(machine: &Machine) -> String {
    match machine.database.device_messages() {
        0 => String::new(),
        count => format!(" and {count} of CANopen devices"),
    }
}

/// A line for each signal of cylinder `n` that is an object.
pub(super) fn of_cylinder(machine: &Machine, n: u8) -> String {
    let line = |(key, pattern): (&str, &str)| {
        let name = CylinderSignals::of_cylinder(pattern, n);
        let (message, signal) = machine.database.signal(&name).ok()?;
        let is_object = machine.database.is_of_device(message);
        is_object.then(|| {
            format!(
                "  object    {key} = {} ({}): {}, 0x{}, {}\n",
                signal.name,
                signal.comment.as_deref().unwrap_or_default(),
                message.name,
                message.id,
                scale(signal),
            )
        })
    };
    machine.loaded.settings.signals_of(n).filter_map(line).collect()
}

/// A line for each device of cylinder `n`: by which frames it tells of itself, and when it is lost.
pub(super) fn devices(machine: &Machine, n: u8) -> String {
    let devices = machine.loaded.settings.devices().iter().filter(|device| device.cylinder == n);
    let watched = machine.design.cylinders[usize::from(n) - 1].devices;
    let line = |device: &Device| {
        let services = machine.database.device_services(&device.name())?;
        let watch = watched.into_iter().flatten().find(|watch| watch.node == device.node)?;
        let id = |id: Option<Id>| id.map_or("none".to_owned(), |id| format!("0x{id}"));
        let lost = match watch.heartbeat {
            Some(cycles) => {
                let seconds = f64::from(cycles) * machine.loaded.settings.machine.sample_time;
                format!("lost after {seconds:.2} s without one")
            }
            None => "which may stop".to_owned(),
        };
        let timer = device.event_timer.or(services.event_timer).map_or(String::new(), |time| {
            format!(
                "; it sends every {time} s by its own timer: the newest reading before Sync counts"
            )
        });
        let (emergency, heartbeat) = (id(services.emergency), id(services.heartbeat));
        let (name, node) = (device.role.map_or("valve", Role::name), device.node);
        Some(format!(
            "  device    {name} = node {node}: emergencies {emergency}, heartbeats {heartbeat}, {lost}{timer}\n"
        ))
    };
    devices.filter_map(line).collect()
}

fn scale(signal: &Signal) -> String {
    match signal.unit.as_str() {
        BITS => "as it is".to_owned(),
        unit => format!("{} {unit} each", signal.plan.factor()),
    }
}

/// What was found in the EDS and DCF files.
pub(super) fn findings(machine: &Machine) -> String {
    let mut text = String::new();
    for (sheet, findings) in devices::findings(&machine.loaded.sheets) {
        if findings.is_empty() {
            continue;
        }
        text += &format!("\n{}: worth a look\n", sheet.path.display());
        text.extend(findings.iter().map(|finding| format!("  {finding}\n")));
    }
    text
}
