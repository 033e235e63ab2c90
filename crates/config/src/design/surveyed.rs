//! Signals that only the process detectors monitor, and commands that learn from a recording read.

use super::connector::Connector;
use crate::settings::CylinderSignals;
use tertius_core::monitor::subscriptions::{SubscribedSignal, Target};
use tertius_core::sample::{Field, Pressure};

impl Connector<'_> {
    /// Pressures and spool of cylinder `n`.
    pub(super) fn connect_surveyed(&mut self, n: u8, signals: &CylinderSignals) {
        self.connect_pressures(n, signals);
        self.connect_supply(n);
        self.connect_spool(n, signals);
    }

    /// Whether anybody reads pressures and spool of cylinder `n`.
    fn reads_all_of(&self, n: u8) -> bool {
        self.surveys || self.settings.process_of(n).is_some()
    }

    fn connect_pressures(&mut self, n: u8, signals: &CylinderSignals) {
        for (key, name, pressure) in [
            ("pressure_bottom", &signals.pressure_bottom, Pressure::Bottom),
            ("pressure_rod", &signals.pressure_rod, Pressure::Rod),
            ("load_pressure", &signals.load_pressure, Pressure::Load),
        ] {
            let Some(name) = name else { continue };
            if self.reads_all_of(n) {
                self.connect(n, key, Some(name), Field::Pressure(pressure));
            } else {
                // Not read; yet a name that leads nowhere is a mistake to tell at once.
                let name = CylinderSignals::of_cylinder(name, n);
                self.find(&format!("signals.cylinder.{key}"), &name);
            }
        }
    }

    /// Connects the supply pressure, one signal for all cylinders, as an input of each.
    fn connect_supply(&mut self, n: u8) {
        let Some(name) = self.settings.signals.supply.as_deref() else { return };
        let Some(found) = self.find("signals.supply", name) else { return };
        self.refuse_unit("signals.supply", name, found.signal, Field::Pressure(Pressure::Supply));
        if self.reads_all_of(n) || self.settings.process.supply.is_some() {
            let subscription = self.subscriptions.subscribe(found.bus, found.message.id);
            subscription.cyclic = true;
            let target = Target::Cylinder(n - 1, Field::Pressure(Pressure::Supply));
            subscription.signals.push(SubscribedSignal { plan: found.signal.plan.clone(), target });
        }
    }

    fn connect_spool(&mut self, n: u8, signals: &CylinderSignals) {
        let Some(name) = &signals.spool else { return };
        if self.reads_all_of(n) {
            self.connect(n, "spool", Some(name), Field::Spool);
        } else {
            self.find("signals.cylinder.spool", &CylinderSignals::of_cylinder(name, n));
        }
    }
}
