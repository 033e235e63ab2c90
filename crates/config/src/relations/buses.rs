//! Relations between the buses and the signals that are on them.

use super::requirement::Relations;
use crate::settings::{Bus, Settings};
use crate::text::bus_of;
use tertius_core::frame::BusNumber;

/// The name of the embedded bus as an interface.
const EMBEDDED: &str = "virtual";

impl Relations<'_> {
    pub(super) fn buses(&mut self, settings: &Settings) {
        self.interfaces(&settings.bus);
        let used = self.named_buses(settings);
        for (bus, _) in settings.bus.interfaces().filter(|(bus, _)| *bus != BusNumber::First) {
            let key = format!("bus.{bus}");
            self.require(
                used.contains(&bus),
                &[&key],
                format!("[{key}] is configured, but no signal is on it"),
                "name the signals that are on it with the bus before them, for example \
                 second:Cyl{n}_C2.Position, or leave the table out",
            );
        }
    }

    fn interfaces(&mut self, bus: &Bus) {
        let all: Vec<(BusNumber, &str)> = bus.interfaces().collect();
        for (index, (number, name)) in all.iter().enumerate().skip(1) {
            let key = format!("bus.{number}.interface");
            let before = BusNumber::ALL[number.index() - 1];
            self.require(
                number.index() == index,
                &[&key],
                format!("there is a [bus.{number}], but no [bus.{before}]"),
                "buses are numbered without gaps: first, which is [bus] itself, second, third, fourth",
            );
            let twice = all[..index].iter().any(|(_, known)| known == name);
            self.require(
                !twice,
                &[&key],
                format!("`{key}` is \"{name}\", which another bus has already"),
                "each bus has an interface of its own",
            );
            self.require(
                *name != EMBEDDED && bus.interface != EMBEDDED,
                &[&key, "bus.interface"],
                format!("`{key}` is \"{name}\" beside \"{}\"", bus.interface),
                "the embedded bus is a single one; several buses need interfaces of the system",
            );
        }
    }

    /// The buses that signals are named on; one that is not configured is a problem.
    fn named_buses(&mut self, settings: &Settings) -> Vec<BusNumber> {
        let signals = &settings.signals;
        let machine = [
            ("signals.sync", &signals.sync),
            ("signals.state", &signals.state),
            ("signals.supply", &signals.supply),
            ("signals.vessel_roll", &signals.vessel_roll),
            ("signals.vessel_pitch", &signals.vessel_pitch),
            ("signals.top_roll", &signals.top_roll),
            ("signals.top_pitch", &signals.top_pitch),
        ];
        let machine =
            machine.into_iter().filter_map(|(key, name)| Some((key.to_owned(), name.as_deref()?)));
        let cylinder = signals.cylinder.named();
        let cylinder = cylinder.map(|(key, name)| (format!("signals.cylinder.{key}"), name));
        let mut used = Vec::new();
        for (key, name) in machine.chain(cylinder) {
            let Some((bus, _)) = bus_of(name) else { continue };
            self.require(
                settings.bus.interfaces().any(|(known, _)| known == bus),
                &[&key],
                format!("`{key}` is on the {bus} bus, but there is no [bus.{bus}]"),
                "add the table with the bus's interface, for example interface = \"can1\"",
            );
            used.push(bus);
        }
        used
    }
}
