//! Tells subscribers what has changed.

use super::source::{NAMESPACE, Source};
use super::{space, values};
use opcua::nodes::Event;
use opcua::server::ServerHandle;
use opcua::types::AttributeId;
use std::time::Duration;

/// Interval at which the telemetry is looked at.
const LOOK: Duration = Duration::from_millis(500);

/// Looks at the telemetry again and again, until the task is dropped.
pub(super) async fn watch(source: Source, handle: &ServerHandle) {
    let Some(namespace) = handle.get_namespace_index(NAMESPACE) else { return };
    let machine = space::machine(namespace);
    let mut interval = tokio::time::interval(LOOK);
    loop {
        interval.tick().await;
        let now = source.telemetry.snapshot(source.clock.uptime());
        let (facts, at) = (source.telemetry.facts(), source.clock.system());
        let events = source.alarms.lock().changes(&now, at, (namespace, &facts.names));
        let events = events.iter().map(|event| (event as &dyn Event, &machine));
        handle.subscriptions().notify_events(events);
        let values = values::now(&source, namespace);
        let values = values.iter().map(|(id, value)| (value.clone(), id, AttributeId::Value));
        handle.subscriptions().notify_data_change(values);
    }
}
