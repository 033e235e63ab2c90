//! Counts of the peers over the network: the broker over MQTT, and masters over Modbus.

use super::Telemetry;
use super::cell::{Gauge, Total};

/// What a count is called, what it means, and the count.
type Described<'a, T> = (&'static str, &'static str, T);

/// Counts since the start of the process; one thread counts for MQTT, and one for Modbus.
#[derive(Debug, Default)]
pub(super) struct Peers {
    mqtt_connections: Total,
    mqtt_failures: Total,
    mqtt_states: Total,
    mqtt_events: Total,
    mqtt_acknowledged: Total,
    mqtt_refused: Total,
    mqtt_up: Gauge,
    mqtt_waiting: Gauge,
    modbus_connections: Total,
    modbus_turned_away: Total,
    modbus_answers: Total,
    modbus_refused: Total,
}

impl Peers {
    #[rustfmt::skip]
    pub fn totals(&self) -> [Described<'_, &Total>; 10] {
        [
            ("mqtt_connections", "Times that the broker accepted a connection.", &self.mqtt_connections),
            ("mqtt_failures", "Attempts to connect to the broker that failed, and connections that ended.",
                &self.mqtt_failures),
            ("mqtt_states_sent", "States sent to the broker.", &self.mqtt_states),
            ("mqtt_events_sent", "Messages of the event store sent to the broker, those that were sent again included.",
                &self.mqtt_events),
            ("mqtt_acknowledged", "States and messages that the broker acknowledged.", &self.mqtt_acknowledged),
            ("mqtt_refused", "States and messages that the broker refused.", &self.mqtt_refused),
            ("modbus_connections", "Masters that connected over Modbus.", &self.modbus_connections),
            ("modbus_turned_away", "Masters that were turned away, because too many were connected.",
                &self.modbus_turned_away),
            ("modbus_answers", "Requests over Modbus that were answered.", &self.modbus_answers),
            ("modbus_refused", "Requests over Modbus that were refused: to write, or for other registers.",
                &self.modbus_refused),
        ]
    }

    #[rustfmt::skip]
    pub fn gauges(&self) -> [Described<'_, Option<f64>>; 2] {
        [
            ("mqtt_up", "1 while the broker is connected, else 0. Absent without one.", self.mqtt_up.get()),
            ("mqtt_events_waiting", "Messages of the event store that the broker has not acknowledged, at the last \
                attempt to connect or later. Absent without broker or store.", self.mqtt_waiting.get()),
        ]
    }
}

impl Telemetry {
    /// Notes whether the broker is connected; `None` where nothing is published. For the publisher alone, as all that
    /// begins with `mqtt`.
    pub fn mqtt_up(&self, up: Option<bool>) {
        let peers = &self.peers;
        if up == Some(true) {
            peers.mqtt_connections.add(1);
        }
        if up.is_none() {
            peers.mqtt_waiting.set(None);
        }
        peers.mqtt_up.set(up.map(|up| f64::from(u8::from(up))));
    }

    /// Counts an attempt that failed, or a connection that ended.
    pub fn mqtt_failed(&self) {
        self.peers.mqtt_failures.add(1);
        self.mqtt_up(Some(false));
    }

    pub fn mqtt_state_sent(&self) {
        self.peers.mqtt_states.add(1);
    }

    pub fn mqtt_event_sent(&self) {
        self.peers.mqtt_events.add(1);
    }

    /// Counts what the broker took, or refused.
    pub fn mqtt_answered(&self, taken: bool) {
        self.peers.mqtt_acknowledged.add(u64::from(taken));
        self.peers.mqtt_refused.add(u64::from(!taken));
    }

    /// Takes the number of messages that wait in the event store; `None` where it is not known.
    pub fn mqtt_waiting(&self, waiting: Option<u64>) {
        self.peers.mqtt_waiting.set(waiting.map(|waiting| waiting as f64));
    }

    /// Counts a master that connected, with a place or without; for the server over Modbus alone, as the next.
    pub fn modbus_connected(&self, has_place: bool) {
        self.peers.modbus_connections.add(u64::from(has_place));
        self.peers.modbus_turned_away.add(u64::from(!has_place));
    }

    /// Counts a request that was answered, or refused.
    pub fn modbus_answered(&self, answered: bool) {
        self.peers.modbus_answers.add(u64::from(answered));
        self.peers.modbus_refused.add(u64::from(!answered));
    }
}
