//! From the name of a signal to the subscription that reads it.

use super::flaw::Flaw;
use crate::settings::{CylinderSignals, Settings};
use crate::text::bus_of;
use tertius_core::frame::BusNumber;
use tertius_core::monitor::subscriptions::{SubscribedSignal, Subscription, Subscriptions, Target};
use tertius_core::sample::Field;
use tertius_dbc::{Database, LookupError, Message, Signal};

pub(super) struct Connector<'a> {
    pub(super) settings: &'a Settings,
    pub(super) database: &'a Database,
    pub(super) subscriptions: Subscriptions,
    pub(super) surveys: bool,
    pub(super) flaws: Vec<Flaw>,
}

/// What is known of a signal once it is connected.
pub(super) struct Connected<'a> {
    pub(super) bus: BusNumber,
    pub(super) message: &'a Message,
    pub(super) signal: &'a Signal,
}

impl<'a> Connector<'a> {
    pub(super) fn new(settings: &'a Settings, database: &'a Database, surveys: bool) -> Self {
        Self { settings, database, subscriptions: Subscriptions::new(), surveys, flaws: Vec::new() }
    }

    pub(super) fn connect(
        &mut self,
        n: u8,
        key: &str,
        name: Option<&str>,
        field: Field,
    ) -> Option<Connected<'a>> {
        let name = CylinderSignals::of_cylinder(name?, n);
        let key = format!("signals.cylinder.{key}");
        let found = self.find(&key, &name)?;
        self.refuse_unit(&key, &name, found.signal, field);
        self.refuse_twice(&key, &name, &found, Target::Cylinder(n - 1, field));
        let subscription = self.subscriptions.subscribe(found.bus, found.message.id);
        subscription.reading |= field.is_reading();
        subscription.cyclic = true;
        let target = Target::Cylinder(n - 1, field);
        subscription.signals.push(SubscribedSignal { plan: found.signal.plan.clone(), target });
        Some(found)
    }

    pub(super) fn find(&mut self, key: &str, name: &str) -> Option<Connected<'a>> {
        let (bus, name) = bus_of(name).unwrap_or((BusNumber::First, name));
        match self.database.signal(name) {
            Ok((message, signal)) => Some(Connected { bus, message, signal }),
            Err(error) => {
                let help = match error {
                    LookupError::Refused { .. } => "correct the message in the DBC",
                    LookupError::Object { .. } => {
                        "name an object that is mapped, or map it and give the device's DCF"
                    }
                    _ => "name it MESSAGE.SIGNAL as the DBC does",
                };
                self.flaws.push(Flaw::new(key, error, help));
                None
            }
        }
    }

    /// Refuses a length that is not in metres, which would be wrong by the factor of its unit. What [`crate::units`] knows
    /// was converted before.
    pub(super) fn refuse_unit(&mut self, key: &str, name: &str, signal: &Signal, field: Field) {
        let expected = match field {
            Field::Position(_) => "m",
            Field::Velocity(_) => "m/s",
            Field::Pressure(_) => "bar",
            // A spool's unit is its own: percent, millimetres, volts.
            Field::Status(_) | Field::Counter(_) | Field::Command | Field::Spool => return,
        };
        if !(signal.unit.is_empty() || signal.unit == expected) {
            self.flaws.push(Flaw::new(
                key,
                format!("{name} is in {:?}, expected {expected:?}", signal.unit),
                format!(
                    "the unit is not known; scale factor, offset and range of the DBC to {expected}"
                ),
            ));
        }
    }

    fn refuse_twice(&mut self, key: &str, name: &str, found: &Connected<'_>, target: Target) {
        let subscription = self.subscriptions.find(found.bus, found.message.id);
        let subscription = subscription.map(|place| &self.subscriptions.all()[place]);
        let used =
            |one: &SubscribedSignal| one.plan == found.signal.plan && !one.shares_with(target);
        let alone = |subscription: &&Subscription| !subscription.has_position_of(target);
        let taken = subscription.is_some_and(|subscription| {
            subscription.signals.iter().any(used)
                || alone(&subscription)
                    && subscription.signals.iter().any(|one| one.plan == found.signal.plan)
        });
        if taken {
            self.flaws.push(Flaw::new(
                key,
                format!("{name} is used already for something else"),
                "every signal of every cylinder needs a place of its own; is {n} missing?",
            ));
        }
    }
}
