//! The values of the nodes, read from the telemetry for each request.

use super::instant::date_time;
use super::source::{NAMESPACE, Source};
use super::space;
use crate::appliance::telemetry::points::{Point, PointValue, Points};
use crate::appliance::telemetry::snapshot::Snapshot;
use async_trait::async_trait;
use opcua::server::address_space::{AddressSpace, read_node_value};
use opcua::server::diagnostics::NamespaceMetadata;
use opcua::server::node_manager::memory::InMemoryNodeManagerImpl;
use opcua::server::node_manager::{ParsedReadValueId, RequestContext, ServerContext};
use opcua::sync::RwLock;
use opcua::types::{DataValue, DateTime, NodeId, StatusCode, TimestampsToReturn, Variant};
use std::collections::HashMap;
use std::time::Duration;
use tertius_core::alarm::status::MAX_CYLINDERS;
use tertius_core::time::Timestamp;

/// Answers reads of the machine's nodes. Nothing can be written or called.
pub(super) struct Values {
    source: Source,
    namespace: u16,
}

impl Values {
    pub fn new(source: Source, context: &ServerContext, space: &mut AddressSpace) -> Self {
        let namespace = context.type_tree.write().namespaces_mut().add_namespace(NAMESPACE);
        space.add_namespace(NAMESPACE, namespace);
        space::fill(space, namespace);
        Self { source, namespace }
    }
}

#[async_trait]
impl InMemoryNodeManagerImpl for Values {
    async fn init(&self, _: &mut AddressSpace, _: ServerContext) {}

    fn name(&self) -> &str {
        "machine"
    }

    fn namespaces(&self) -> Vec<NamespaceMetadata> {
        vec![NamespaceMetadata {
            namespace_uri: NAMESPACE.to_owned(),
            namespace_index: self.namespace,
            ..NamespaceMetadata::default()
        }]
    }

    /// The values of one request are of one moment.
    async fn read_values(
        &self,
        context: &RequestContext,
        space: &RwLock<AddressSpace>,
        nodes: &[&ParsedReadValueId],
        max_age: f64,
        stamps: TimestampsToReturn,
    ) -> Vec<DataValue> {
        let known = now(&self.source, self.namespace);
        let space = space.read();
        let read = |it: &&ParsedReadValueId| match space.validate_node_read(context, it) {
            Err(status) => DataValue { status: Some(status), ..DataValue::default() },
            Ok(node) => match known.get(&it.node_id) {
                None => read_node_value(node, context, it, max_age, stamps),
                Some(_) if it.index_range.has_range() => DataValue {
                    status: Some(StatusCode::BadIndexRangeNoData),
                    ..DataValue::default()
                },
                Some(value) => stamped(value.clone(), stamps),
            },
        };
        nodes.iter().map(read).collect()
    }
}

/// With the time stamps that the client has asked for.
fn stamped(mut value: DataValue, stamps: TimestampsToReturn) -> DataValue {
    let of = |stamp: Option<DateTime>| stamp.unwrap_or_default();
    let (source, server) = (of(value.source_timestamp), of(value.server_timestamp));
    value.set_timestamps(stamps, source, server);
    value
}

/// All values as they are now, by their nodes.
///
/// The source time stamp is the time of the machine's newest frame, and now where the machine is not heard. A value that
/// is not known is Bad, and says why.
pub(super) fn now(source: &Source, namespace: u16) -> HashMap<NodeId, DataValue> {
    let now = source.telemetry.snapshot(source.clock.uptime());
    let at = source.clock.system();
    let heard = earlier(at, now.since_frame.filter(|_| now.has_evidence).unwrap_or_default());
    let missing = match now.has_evidence {
        true => StatusCode::BadNoData,
        false => StatusCode::BadNoCommunication,
    };
    let mut points = Points::new(&now);
    let absent = Points::new(&Snapshot::unknown(MAX_CYLINDERS)).cylinders;
    let absent = absent.into_iter().skip(points.cylinders.len());
    points.cylinders.extend(absent.map(|of| {
        of.into_iter().map(|point| Point { value: None, ..point }).collect::<Vec<Point>>()
    }));
    let listed = points.all().map(|point| {
        let value = DataValue {
            value: point.value.map(variant),
            status: Some(if point.value.is_some() { StatusCode::Good } else { missing }),
            source_timestamp: Some(date_time(heard)),
            source_picoseconds: Some(0),
            server_timestamp: Some(date_time(at)),
            server_picoseconds: Some(0),
        };
        (space::node(namespace, &point.name), value)
    });
    listed.collect()
}

fn variant(value: PointValue) -> Variant {
    match value {
        PointValue::Whole(value) => Variant::Int64(value),
        PointValue::Real(value) => Variant::Double(value),
        PointValue::Time(value) => Variant::from(date_time(value)),
        PointValue::Choice(place) => Variant::UInt32(place.into()),
    }
}

fn earlier(at: Timestamp, by: Duration) -> Timestamp {
    let by = i64::try_from(by.as_nanos()).unwrap_or(i64::MAX);
    Timestamp::from_nanos(at.as_nanos().saturating_sub(by))
}
