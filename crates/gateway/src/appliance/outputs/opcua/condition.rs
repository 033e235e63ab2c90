//! An alarm as an event: the fields of AlarmConditionType (OPC 10000-9, 5.8.2).

use opcua::nodes::{Event, EventField};
use opcua::types::{
    AttributeId, ByteString, DateTime, LocalizedText, NodeId, NumericRange, ObjectTypeId,
    QualifiedName, StatusCode, UAString, Variant,
};

/// Types whose fields the event has: its own and those that it is derived from.
const TYPES: [ObjectTypeId; 4] = [
    ObjectTypeId::BaseEventType,
    ObjectTypeId::ConditionType,
    ObjectTypeId::AcknowledgeableConditionType,
    ObjectTypeId::AlarmConditionType,
];

/// A change of an alarm.
#[derive(Clone, Debug)]
pub(super) struct AlarmEvent {
    /// Another one for each change.
    pub id: ByteString,
    pub event_type: NodeId,
    /// The alarm: the same from its begin to its end.
    pub condition: NodeId,
    pub condition_name: String,
    /// The cylinder, and its name.
    pub source: NodeId,
    pub source_name: String,
    /// The variable that has the alarm's number while it is the worst of the cylinder.
    pub input: NodeId,
    /// Time of the change, and time at which the server heard of it.
    pub time: DateTime,
    pub received: DateTime,
    pub message: String,
    /// 1 to 1000, and that of the change before.
    pub severity: u16,
    pub last_severity: u16,
    pub is_active: bool,
    /// Bad if it is not known whether the alarm is still active.
    pub quality: StatusCode,
}

impl AlarmEvent {
    /// The value of the field at `path`; empty where there is none.
    fn field(&self, path: &[&str]) -> Variant {
        let text = |text: &str| Variant::from(LocalizedText::new("en", text));
        match path {
            ["EventId"] => self.id.clone().into(),
            ["EventType"] => self.event_type.clone().into(),
            ["SourceNode"] => self.source.clone().into(),
            ["SourceName"] => UAString::from(self.source_name.as_str()).into(),
            ["Time"] => self.time.into(),
            ["ReceiveTime"] => self.received.into(),
            ["Message"] => text(&self.message),
            ["Severity"] => self.severity.into(),
            ["ConditionClassId"] => NodeId::from(ObjectTypeId::ProcessConditionClassType).into(),
            ["ConditionClassName"] => text("ProcessConditionClassType"),
            ["ConditionName"] => UAString::from(self.condition_name.as_str()).into(),
            ["BranchId"] => NodeId::null().into(),
            ["Retain"] | ["ActiveState", "Id"] => self.is_active.into(),
            ["EnabledState"] => text("Enabled"),
            ["ActiveState"] => text(if self.is_active { "Active" } else { "Inactive" }),
            // Nothing is acknowledged here, so that nothing is asked for either.
            ["AckedState"] => text("Acknowledged"),
            ["EnabledState" | "AckedState", "Id"] => true.into(),
            ["Quality"] => self.quality.into(),
            ["LastSeverity"] => self.last_severity.into(),
            ["Comment"] => Variant::from(LocalizedText::null()),
            ["ClientUserId"] => Variant::from(UAString::null()),
            ["InputNode"] => self.input.clone().into(),
            ["SuppressedOrShelved"] => false.into(),
            _ => Variant::Empty,
        }
    }
}

impl EventField for AlarmEvent {
    fn get_value(
        &self,
        attribute: AttributeId,
        range: &NumericRange,
        path: &[QualifiedName],
    ) -> Variant {
        // The alarm itself (ConditionId) is the NodeId of what has no path.
        if attribute == AttributeId::NodeId && path.is_empty() {
            return self.condition.clone().into();
        }
        let is_plain = path.iter().all(|name| name.namespace_index == 0);
        if attribute != AttributeId::Value || !is_plain || range.has_range() {
            return Variant::Empty;
        }
        let names: Vec<&str> = path.iter().map(|name| name.name.as_ref()).collect();
        self.field(&names)
    }
}

impl Event for AlarmEvent {
    fn get_field(
        &self,
        of_type: &NodeId,
        attribute: AttributeId,
        range: &NumericRange,
        path: &[QualifiedName],
    ) -> Variant {
        match TYPES.iter().any(|known| of_type == known) {
            true => self.get_value(attribute, range, path),
            false => Variant::Empty,
        }
    }

    fn time(&self) -> &DateTime {
        &self.time
    }

    fn event_type_id(&self) -> &NodeId {
        &self.event_type
    }
}
