//! What becomes of the machine's incidents, as changes of alarms.

use super::condition::AlarmEvent;
use super::instant::date_time;
use super::space;
use crate::appliance::telemetry::OpenSlot;
use crate::appliance::telemetry::snapshot::Snapshot;
use opcua::types::{ByteString, NodeId, ObjectTypeId, StatusCode};
use std::collections::BTreeMap;
use tertius_config::MachineNames;
use tertius_core::alarm::Level;
use tertius_core::time::Timestamp;

/// An alarm by its cylinder, 0 for the machine, and the number of its incident.
type Key = (usize, u32);

const MACHINE: usize = 0;

/// The alarms that are active.
#[derive(Debug, Default)]
pub(super) struct Alarms {
    active: BTreeMap<Key, Active>,
    /// Number of changes so far, which makes each an identity of its own.
    changes: u64,
}

#[derive(Clone, Debug)]
struct Active {
    incident: OpenSlot,
    newest: AlarmEvent,
}

impl Alarms {
    /// What has changed until `now`, at which it is `at` by the system's clock.
    pub fn changes(
        &mut self,
        now: &Snapshot,
        at: Timestamp,
        (namespace, names): (u16, &MachineNames),
    ) -> Vec<AlarmEvent> {
        let mut events = Vec::new();
        let open = (1..).zip(&now.cylinders).flat_map(|(cylinder, it)| {
            it.open.iter().map(move |incident| ((cylinder, incident.number), *incident))
        });
        let shared = now.shared.iter().map(|incident| ((MACHINE, incident.number), *incident));
        let open: BTreeMap<Key, OpenSlot> = open.chain(shared).collect();
        let is_over = |key: &Key, known: &Active| {
            // A monitor that begins anew counts anew.
            open.get(key).is_none_or(|incident| incident.begin != known.incident.begin)
        };
        let over: Vec<Key> =
            self.active.iter().filter(|(key, it)| is_over(key, it)).map(|(key, _)| *key).collect();
        for key in over {
            let Some(Active { incident, newest }) = self.active.remove(&key) else { continue };
            let (quality, word) = match now.has_evidence {
                true => (StatusCode::Good, "over"),
                false => (StatusCode::BadNoCommunication, "no longer followed"),
            };
            let message = format!("{word}: {}", incident.summary(key.0, names));
            let (severity, last_severity) = (newest.severity, newest.severity);
            let id = self.identity(at);
            let (time, is_active) = (date_time(at), false);
            let change = AlarmEvent { id, time, received: time, message, severity, ..newest };
            events.push(AlarmEvent { last_severity, is_active, quality, ..change });
        }
        for (key, incident) in open {
            let known = self.active.get(&key);
            if known.is_some_and(|known| known.incident == incident) {
                continue;
            }
            let severity = severity(incident.level);
            let event = AlarmEvent {
                id: ByteString::null(),
                event_type: NodeId::from(ObjectTypeId::AlarmConditionType),
                condition: condition(namespace, key),
                condition_name: format!("incident {}", incident.number),
                source: space::node(namespace, &source(key)),
                source_name: source(key),
                input: space::node(namespace, &input(key)),
                // It begins when it was warned of, and changes now.
                time: date_time(if known.is_none() { incident.begin } else { at }),
                received: date_time(at),
                message: incident.summary(key.0, names),
                severity,
                last_severity: known.map_or(severity, |known| known.newest.severity),
                is_active: true,
                quality: StatusCode::Good,
            };
            let event = AlarmEvent { id: self.identity(at), ..event };
            self.active.insert(key, Active { incident, newest: event.clone() });
            events.push(event);
        }
        events
    }

    /// The newest change of each active alarm.
    pub fn standing(&self) -> Vec<AlarmEvent> {
        self.active.values().map(|it| it.newest.clone()).collect()
    }

    /// Another identity for each change, also of another run of the gateway.
    fn identity(&mut self, at: Timestamp) -> ByteString {
        self.changes += 1;
        let bytes = [at.as_nanos().to_be_bytes(), self.changes.to_be_bytes()].concat();
        ByteString::from(bytes)
    }
}

fn condition(namespace: u16, key: Key) -> NodeId {
    space::node(namespace, &format!("{}_incident_{}", source(key), key.1))
}

/// Name of the node of the cylinder or the machine.
fn source((cylinder, _): Key) -> String {
    if cylinder == MACHINE { "machine".to_owned() } else { format!("cylinder_{cylinder}") }
}

/// Name of the variable that tells of it: its number, or of the machine how many are open.
fn input(key: Key) -> String {
    if key.0 == MACHINE { "incidents_open".to_owned() } else { format!("{}_incident", source(key)) }
}

/// Severity of a level, in the middle of each fifth of the standard's range (OPC 10000-5, 6.4.2).
const fn severity(level: Level) -> u16 {
    match level {
        Level::None => 100,
        Level::Yellow => 300,
        Level::Orange => 500,
        Level::Red => 700,
        Level::Black => 900,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tertius_core::incident::Cylinders;
    use tertius_core::verdict::{Fault, Suspect};

    fn incident(number: u32, level: Level) -> OpenSlot {
        let begin = Timestamp::from_nanos(1_700_000_000_000_000_000 + i64::from(number));
        OpenSlot {
            number,
            cylinders: Cylinders::NONE,
            level,
            suspect: Suspect::C1,
            fault: Fault::Abrupt,
            is_alone: false,
            begin,
            named: None,
            worst: None,
        }
    }

    fn state(open: &[OpenSlot]) -> Snapshot {
        let mut now = Snapshot { has_evidence: true, ..Snapshot::unknown(2) };
        now.cylinders[1].open = open.to_vec();
        now
    }

    #[test]
    fn an_alarm_is_told_once_for_each_change() {
        let at = Timestamp::from_nanos(1_700_000_001_000_000_000);
        let mut alarms = Alarms::default();
        let told = |events: Vec<AlarmEvent>| -> Vec<(String, bool, u16, u16)> {
            let short = |it: AlarmEvent| {
                (it.condition.to_string(), it.is_active, it.severity, it.last_severity)
            };
            events.into_iter().map(short).collect()
        };
        let mut look = |open: &[OpenSlot]| {
            told(alarms.changes(&state(open), at, (3, &MachineNames::default())))
        };
        let named = |number: u32| format!("ns=3;s=cylinder_2_incident_{number}");
        assert_eq!(look(&[]), []);
        let yellow = [incident(4, Level::Yellow)];
        assert_eq!(look(&yellow), [(named(4), true, 300, 300)]);
        assert_eq!(look(&yellow), []);
        let two = [incident(4, Level::Red), incident(5, Level::Black)];
        assert_eq!(look(&two), [(named(4), true, 700, 300), (named(5), true, 900, 900)]);
        assert_eq!(look(&two[1..]), [(named(4), false, 700, 700)]);
        assert_eq!(look(&[]), [(named(5), false, 900, 900)]);
    }

    /// The same number of another monitor is another incident.
    #[test]
    fn an_incident_of_a_new_monitor_is_another_one() {
        let at = Timestamp::from_nanos(1_700_000_001_000_000_000);
        let mut alarms = Alarms::default();
        let first = incident(1, Level::Red);
        let second = OpenSlot { begin: at, ..first };
        let opened = alarms.changes(&state(&[first]), at, (3, &MachineNames::default()));
        let changed = alarms.changes(&state(&[second]), at, (3, &MachineNames::default()));
        let active: Vec<bool> = changed.iter().map(|it| it.is_active).collect();
        assert_eq!(active, [false, true]);
        let ids = [&opened[0].id, &changed[0].id, &changed[1].id];
        assert!(ids[0] != ids[1] && ids[1] != ids[2] && ids[0] != ids[2]);
        assert_eq!(alarms.standing().len(), 1);
    }

    /// What was forgotten is not over.
    #[test]
    fn an_incident_that_is_not_followed_is_not_called_over() {
        let at = Timestamp::from_nanos(1_700_000_001_000_000_000);
        let mut alarms = Alarms::default();
        alarms.changes(&state(&[incident(1, Level::Red)]), at, (3, &MachineNames::default()));
        let forgotten = alarms.changes(&Snapshot::unknown(2), at, (3, &MachineNames::default()));
        assert_eq!(forgotten[0].quality, StatusCode::BadNoCommunication);
        assert!(forgotten[0].message.starts_with("no longer followed: "), "{forgotten:?}");
    }
}
