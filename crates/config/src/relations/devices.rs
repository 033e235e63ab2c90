//! Devices have to fit the machine, the signals that are read of them, and each other.

use super::requirement::Relations;
use crate::settings::{Cylinder, Device, DeviceKind, Role, Settings};

impl Relations<'_> {
    pub(super) fn devices(&mut self, settings: &Settings) {
        let devices = settings.devices();
        for (index, device) in devices.iter().enumerate() {
            self.device(settings, index, device);
            self.unlike(&devices[..index], index, device);
        }
        for (key, role) in settings.signals.cylinder.objects() {
            self.has_devices(settings, key, role);
        }
    }

    fn device(&mut self, settings: &Settings, index: usize, device: &Device) {
        let key = |name: &str| format!("canopen.device[{index}].{name}");
        let (count, n) = (settings.machine.cylinders, device.cylinder);
        self.require(
            n <= count,
            &[&key("cylinder"), "machine.cylinders"],
            format!("`{}` is {n}, but the machine has {count} cylinders", key("cylinder")),
            "they are numbered from 1; see machine.cylinders",
        );
        self.require(
            device.node != settings.gateway.node,
            &[&key("node"), "gateway.node"],
            format!("`{}` is {}, which is the gateway's own", key("node"), device.node),
            "each node has a node-ID of its own; see gateway.node",
        );
        let is_missing = |it: &Cylinder| it.n == n && !it.c2;
        self.require(
            device.role != Some(Role::C2) || !settings.cylinder.iter().any(is_missing),
            &[&key("role")],
            format!("`{}` is \"c2\", but cylinder {n} has no C2 (`c2 = false`)", key("role")),
            "leave out the device, or `c2 = false` in the [[cylinder]] table",
        );
        let is_transducer = device.kind == DeviceKind::Transducer;
        self.require(
            is_transducer == device.role.is_some(),
            &[&key("role"), &key("kind")],
            format!(
                "[[canopen.device]] number {} is a {}",
                index + 1,
                if is_transducer { "transducer without `role`" } else { "valve with `role`" }
            ),
            "a transducer is role = \"c1\" or \"c2\" of its cylinder, and a valve is neither",
        );
        self.require(
            !is_transducer || device.full_speed.is_none(),
            &[&key("full_speed")],
            format!("[[canopen.device]] number {} is a transducer with `full_speed`", index + 1),
            "that is the speed at a valve's full set point; a transducer's unit is in its EDS",
        );
    }

    /// Two devices are not the same one of a cylinder, and one node has one file.
    fn unlike(&mut self, earlier: &[Device], index: usize, device: &Device) {
        let key = |name: &str| format!("canopen.device[{index}].{name}");
        let name = device.name();
        let twin = earlier.iter().position(|other| other.name() == name).map_or(0, |at| at + 1);
        self.require(
            twin == 0,
            &[&key("cylinder")],
            format!("[[canopen.device]] number {} is {name}, as is number {twin}", index + 1),
            "each cylinder has one c1, one c2 and one valve at most",
        );
        let other = earlier.iter().find(|other| other.node == device.node);
        let fits = |other: &Device| {
            other.eds == device.eds && other.kind == device.kind && other.role.is_some()
        };
        self.require(
            other.is_none_or(fits),
            &[&key("node")],
            format!("`{}` is {}, as is another device's", key("node"), device.node),
            "one node is several transducers only if it has several sensors, with one `eds`",
        );
    }

    fn has_devices(&mut self, settings: &Settings, key: &str, role: Option<Role>) {
        let has = |n: &u8| settings.devices().iter().any(|it| it.cylinder == *n && it.role == role);
        let wants = |n: &u8| role != Some(Role::C2) || settings.has_c2(*n);
        let lacking = (1..=settings.machine.cylinders).find(|n| wants(n) && !has(n));
        let wanted = match role {
            Some(Role::C1) => "role = \"c1\"",
            Some(Role::C2) => "role = \"c2\"",
            None => "kind = \"valve\"",
        };
        self.require(
            lacking.is_none(),
            &[&format!("signals.cylinder.{key}")],
            format!(
                "`signals.cylinder.{key}` is an object, but no [[canopen.device]] is {wanted} of cylinder {}",
                lacking.unwrap_or_default()
            ),
            "write one with node, kind, cylinder, role and eds for each cylinder, or name a signal of the DBC",
        );
    }
}
