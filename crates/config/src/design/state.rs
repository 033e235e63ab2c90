//! The platform's state: where it is read, and which of its values matter.

use super::connector::Connector;
use super::flaw::Flaw;
use tertius_core::monitor::subscriptions::{SubscribedSignal, Target};
use tertius_dbc::Signal;

/// States of the thesis (section 2-2-1), for a DBC that names none.
const STATES: [(&str, i64); 4] = [("safe", 0), ("settled", 1), ("neutral", 2), ("engaged", 3)];

impl Connector<'_> {
    /// Numbers of the monitored states (`None` where FDE1 and FDE2 always judge), and of the states
    /// in which the rods stand on their stops.
    pub(super) fn connect_state(&mut self) -> (Option<Vec<i64>>, Vec<i64>) {
        let machine = &self.settings.machine;
        let Some(name) = &self.settings.signals.state else {
            let keys = [
                ("machine.monitored_states", &machine.monitored_states),
                ("sequential.stop_states", &self.settings.sequential.stop_states),
            ];
            let told = "there is no signal that tells the platform's state";
            let help = "name it as signals.state, or leave the key out";
            let asked = keys.into_iter().filter(|(_, states)| states.is_some());
            self.flaws.extend(asked.map(|(key, _)| Flaw::new(key, told, help)));
            return (None, vec![]);
        };
        let Some(found) = self.find("signals.state", name) else { return (None, vec![]) };
        let signal = SubscribedSignal { plan: found.signal.plan.clone(), target: Target::State };
        self.subscriptions.subscribe(found.bus, found.message.id).signals.push(signal);
        let settings = self.settings;
        let mut numbers = |key: &str, names: &[String]| -> Vec<i64> {
            names.iter().flat_map(|name| self.state_numbers(key, found.signal, name)).collect()
        };
        let stops = settings.sequential.stop_states.as_deref().unwrap_or_default();
        let stops = numbers("sequential.stop_states", stops);
        let monitored = machine.monitored_states.as_ref();
        (monitored.map(|names| numbers("machine.monitored_states", names)), stops)
    }

    fn state_numbers(&mut self, key: &str, signal: &Signal, name: &str) -> Vec<i64> {
        if let Ok(number) = name.parse() {
            return vec![number];
        }
        let mut numbers: Vec<i64> = signal.numbers_named(name).collect();
        if signal.values.is_empty() {
            let known = STATES.iter().filter(|(known, _)| known.eq_ignore_ascii_case(name));
            numbers.extend(known.map(|(_, number)| number));
        }
        if numbers.is_empty() {
            let known: Vec<&str> = if signal.values.is_empty() {
                STATES.iter().map(|(name, _)| *name).collect()
            } else {
                signal.values.iter().map(|(_, name)| name.as_str()).collect()
            };
            self.flaws.push(Flaw::new(
                key,
                format!("the platform has no state {name:?}"),
                format!("known states: {}; or give the number as text", known.join(", ")),
            ));
        }
        numbers
    }
}
