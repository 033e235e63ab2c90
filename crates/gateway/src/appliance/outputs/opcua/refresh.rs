//! ConditionRefresh (OPC 10000-9, 5.5.7): what stands, for a client that has subscribed later.

use super::source::{NAMESPACE, Source};
use super::space;
use async_trait::async_trait;
use opcua::nodes::{BaseEventType, DefaultTypeTree, Event};
use opcua::server::diagnostics::NamespaceMetadata;
use opcua::server::node_manager::{MethodCall, NodeManager, RequestContext, ServerContext};
use opcua::sync::Mutex;
use opcua::types::{
    ByteString, DateTime, MethodId, NodeClass, NodeId, ObjectId, ObjectTypeId, StatusCode,
};
use std::time::Instant;

/// Answers the two methods of the standard, and knows no other node.
///
/// The library tells an event to all who have subscribed to its source, so that everybody is told once more of what
/// stands when one client asks. That is why it may be asked for once a second only.
pub(super) struct Refresher {
    source: Source,
    newest: Mutex<Option<Instant>>,
}

/// Shortest time between two refreshes, s.
const EVERY: u64 = 1;

impl Refresher {
    pub fn new(source: Source) -> Self {
        Self { source, newest: Mutex::new(None) }
    }

    fn refresh(&self, context: &RequestContext) -> StatusCode {
        {
            let mut newest = self.newest.lock();
            if newest.is_some_and(|newest| newest.elapsed().as_secs() < EVERY) {
                return StatusCode::BadRefreshInProgress;
            }
            *newest = Some(Instant::now());
        }
        let standing = self.source.alarms.lock().standing();
        let marker = |of: ObjectTypeId| {
            let now = DateTime::now();
            let id = ByteString::from(now.ticks().to_be_bytes().to_vec());
            BaseEventType::new(of, id, "refresh", now)
                .set_source_node(NodeId::from(ObjectId::Server))
                .set_source_name("Server".into())
        };
        let begin = marker(ObjectTypeId::RefreshStartEventType);
        let end = marker(ObjectTypeId::RefreshEndEventType);
        let namespace = context.type_tree.read().namespaces().get_index(NAMESPACE);
        let machine = space::machine(namespace.unwrap_or_default());
        let all = std::iter::once(&begin as &dyn Event)
            .chain(standing.iter().map(|event| event as &dyn Event))
            .chain(std::iter::once(&end as &dyn Event));
        context.subscriptions.notify_events(all.map(|event| (event, &machine)));
        StatusCode::Good
    }
}

#[async_trait]
impl NodeManager for Refresher {
    fn owns_node(&self, id: &NodeId) -> bool {
        let methods =
            [MethodId::ConditionType_ConditionRefresh, MethodId::ConditionType_ConditionRefresh2];
        id.as_method_id().is_ok_and(|id| methods.contains(&id))
    }

    fn name(&self) -> &str {
        "refresh"
    }

    fn namespaces_for_user(&self, _: &RequestContext) -> Vec<NamespaceMetadata> {
        Vec::new()
    }

    /// Lets clients ask for the ConditionId, which is the NodeId at no path of ConditionType (OPC 10000-9, 5.5.2). The
    /// library takes it for a field that does not exist, and leaves it out of what it answers.
    async fn init(&self, types: &mut DefaultTypeTree, _: ServerContext) {
        let condition = NodeId::from(ObjectTypeId::ConditionType);
        types.add_type_property(&NodeId::new(0, "ConditionId"), &condition, &[], NodeClass::Object);
    }

    async fn call(
        &self,
        context: &RequestContext,
        methods: &mut [&mut MethodCall],
    ) -> Result<(), StatusCode> {
        for method in methods {
            method.set_status(self.refresh(context));
        }
        Ok(())
    }
}
