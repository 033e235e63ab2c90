//! The attitude sensor on the deck: where it is read, and what it is compared with.

use super::connector::Connector;
use super::flaw::Flaw;
use tertius_core::hexapod::{Geometry, Inclination, LEGS, TiltDesign, TiltParameters};
use tertius_core::monitor::subscriptions::{SubscribedSignal, Target};

impl Connector<'_> {
    /// The comparison of the deck's attitude with its sensor; `None` where no sensor on it is named.
    pub(super) fn connect_tilt(&mut self) -> Option<TiltDesign> {
        let signals = &self.settings.signals;
        let angles = [
            ("signals.top_roll", &signals.top_roll, Inclination::TopRoll),
            ("signals.top_pitch", &signals.top_pitch, Inclination::TopPitch),
            ("signals.vessel_roll", &signals.vessel_roll, Inclination::VesselRoll),
            ("signals.vessel_pitch", &signals.vessel_pitch, Inclination::VesselPitch),
        ];
        let has_sensor = signals.top_roll.is_some() || signals.top_pitch.is_some();
        for (key, name, which) in angles {
            match name {
                Some(name) => self.connect_angle(key, name, which, has_sensor),
                None if has_sensor => self.flaws.push(Flaw::new(
                    key,
                    "the attitude sensor on the deck is of no use without this angle",
                    "name roll and pitch of both the deck and the vessel, or neither of the deck",
                )),
                None => {}
            }
        }
        has_sensor.then(|| self.tilt_design()).flatten()
    }

    fn connect_angle(&mut self, key: &str, name: &str, which: Inclination, is_read: bool) {
        let Some(found) = self.find(key, name) else { return };
        let unit = &found.signal.unit;
        if !(unit.is_empty() || unit == "rad") {
            self.flaws.push(Flaw::new(
                key,
                format!("{name} is in {unit:?}, expected \"rad\""),
                "scale factor, offset and range of the DBC to rad",
            ));
        }
        let plan = found.signal.plan.clone();
        let target = Target::Inclination(which);
        let subscription = self.subscriptions.find(found.bus, found.message.id);
        let subscription = subscription.map(|place| &self.subscriptions.all()[place]);
        if subscription.is_some_and(|it| it.signals.iter().any(|one| one.plan == plan)) {
            self.flaws.push(Flaw::new(
                key,
                format!("{name} is used already for something else"),
                "each angle has a signal of its own",
            ));
        } else if is_read {
            let subscription = self.subscriptions.subscribe(found.bus, found.message.id);
            subscription.signals.push(SubscribedSignal { plan, target });
        }
    }

    fn tilt_design(&mut self) -> Option<TiltDesign> {
        let machine = &self.settings.machine;
        let Some(table) = &self.settings.hexapod else {
            self.flaws.push(Flaw::new(
                "signals.top_roll",
                "the attitude sensor on the deck is of no use without the platform's geometry",
                "give its dimensions in [hexapod], or leave out the angles of the deck",
            ));
            return None;
        };
        if usize::from(machine.cylinders) != LEGS {
            self.flaws.push(Flaw::new(
                "machine.cylinders",
                format!(
                    "the machine has {} cylinders, and a hexapod has {LEGS}",
                    machine.cylinders
                ),
                "leave out [hexapod] and the angles of the deck",
            ));
            return None;
        }
        let geometry = Geometry {
            base_radius: table.base_radius,
            base_half_angle: table.base_half_angle,
            top_radius: table.top_radius,
            top_half_angle: table.top_half_angle,
            neutral_height: table.neutral_height,
            reach: machine.stroke,
        };
        Some(TiltDesign {
            geometry,
            accuracy: table.top_accuracy,
            sample_time: machine.sample_time,
            parameters: &TiltParameters::DEFAULT,
        })
    }
}
