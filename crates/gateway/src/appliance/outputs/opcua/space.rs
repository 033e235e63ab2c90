//! The nodes of the machine: one for each value, below an object for the machine and one for each cylinder.

use crate::appliance::telemetry::points::{Point, PointKind, PointUnit, Points};
use crate::appliance::telemetry::snapshot::Snapshot;
use opcua::server::address_space::{
    AddressSpace, EventNotifier, ObjectBuilder, ReferenceDirection, VariableBuilder,
};
use opcua::types::{
    DataTypeId, EUInformation, ExtensionObject, LocalizedText, NodeId, ObjectId, ObjectTypeId,
    QualifiedName, ReferenceTypeId, UAString, VariableTypeId, Variant,
};
use tertius_core::alarm::status::MAX_CYLINDERS;

/// Where the identifiers of units come from (OPC 10000-8, 5.6.4.3).
const UNITS: &str = "http://www.opcfoundation.org/UA/units/un/cefact";

/// Node with the name `name` in the machine's namespace.
pub(super) fn node(namespace: u16, name: &str) -> NodeId {
    NodeId::new(namespace, name)
}

/// The object of the machine, which tells of alarms.
pub(super) fn machine(namespace: u16) -> NodeId {
    node(namespace, "machine")
}

/// The object of the cylinder `number`, from 1.
pub(super) fn cylinder(namespace: u16, number: usize) -> NodeId {
    node(namespace, &format!("cylinder_{number}"))
}

/// Puts all nodes into `space`.
pub(super) fn fill(space: &mut AddressSpace, namespace: u16) {
    let points = Points::new(&Snapshot::unknown(MAX_CYLINDERS));
    let machine = machine(namespace);
    object(&machine, "machine", namespace)
        .event_notifier(EventNotifier::SUBSCRIBE_TO_EVENTS)
        .organized_by(ObjectId::ObjectsFolder)
        .reference(ObjectId::Server, ReferenceTypeId::HasNotifier, ReferenceDirection::Inverse)
        .insert(space);
    points.machine.iter().for_each(|point| variable(space, namespace, &machine, point, ""));
    for (number, points) in (1..).zip(&points.cylinders) {
        let (name, id) = (format!("cylinder_{number}"), cylinder(namespace, number));
        object(&id, &name, namespace)
            .component_of(machine.clone())
            .reference(
                machine.clone(),
                ReferenceTypeId::HasEventSource,
                ReferenceDirection::Inverse,
            )
            .insert(space);
        let prefix = format!("{name}_");
        points.iter().for_each(|point| variable(space, namespace, &id, point, &prefix));
    }
}

fn object(id: &NodeId, name: &str, namespace: u16) -> ObjectBuilder {
    ObjectBuilder::new(id, QualifiedName::new(namespace, name), LocalizedText::new("", name))
        .has_type_definition(ObjectTypeId::BaseObjectType)
}

/// The node of `point`, whose browse name is its name without `prefix`.
fn variable(space: &mut AddressSpace, namespace: u16, owner: &NodeId, point: &Point, prefix: &str) {
    let id = node(namespace, &point.name);
    let name = point.name.strip_prefix(prefix).unwrap_or(&point.name);
    let (data_type, definition) = match (point.kind, point.unit) {
        (PointKind::Choice(_), _) => (DataTypeId::UInt32, VariableTypeId::MultiStateDiscreteType),
        (PointKind::Time, _) => (DataTypeId::UtcTime, VariableTypeId::BaseDataVariableType),
        (PointKind::Real, _) => (DataTypeId::Double, VariableTypeId::AnalogUnitType),
        (PointKind::Whole, PointUnit::None) => {
            (DataTypeId::Int64, VariableTypeId::BaseDataVariableType)
        }
        (PointKind::Whole, _) => (DataTypeId::Int64, VariableTypeId::AnalogUnitType),
    };
    let (browse, shown) = (QualifiedName::new(namespace, name), LocalizedText::new("", name));
    VariableBuilder::new(&id, browse, shown)
        .description(LocalizedText::new("en", &point.meaning))
        .data_type(data_type)
        .has_type_definition(definition)
        .component_of(owner.clone())
        .insert(space);
    let property = |space: &mut AddressSpace, what: &str, data_type, rank, value: Variant| {
        let own = node(namespace, &format!("{}.{what}", point.name));
        VariableBuilder::new(&own, QualifiedName::new(0, what), LocalizedText::new("", what))
            .data_type(data_type)
            .value_rank(rank)
            .has_type_definition(VariableTypeId::PropertyType)
            .property_of(id.clone())
            .value(value)
            .insert(space);
    };
    if let PointKind::Choice(names) = point.kind {
        let names: Vec<LocalizedText> =
            names.iter().map(|name| LocalizedText::new("", name)).collect();
        property(space, "EnumStrings", DataTypeId::LocalizedText, 1, names.into());
    }
    if let Some(unit) = unit(point.unit) {
        let value = Variant::from(ExtensionObject::from_message(unit));
        property(space, "EngineeringUnits", DataTypeId::EUInformation, -1, value);
    }
}

/// A unit as the standard describes it, by the code of UNECE recommendation 20.
fn unit(unit: PointUnit) -> Option<EUInformation> {
    let (code, name) = match unit {
        PointUnit::None => return None,
        PointUnit::Metre => ("MTR", "metre"),
        PointUnit::Second => ("SEC", "second"),
        PointUnit::Millisecond => ("C26", "millisecond"),
    };
    Some(EUInformation {
        namespace_uri: UAString::from(UNITS),
        unit_id: code.bytes().fold(0, |number, letter| number << 8 | i32::from(letter)),
        display_name: LocalizedText::new("", unit.symbol()),
        description: LocalizedText::new("en", name),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers of the units in the list of the OPC Foundation, UNECE_to_OPCUA.csv.
    #[test]
    fn units_have_the_numbers_of_the_standard() {
        let number = |of: PointUnit| unit(of).map(|it| it.unit_id);
        assert_eq!(number(PointUnit::Metre), Some(5_067_858));
        assert_eq!(number(PointUnit::Second), Some(5_457_219));
        assert_eq!(number(PointUnit::Millisecond), Some(4_403_766));
        assert_eq!(number(PointUnit::None), None);
    }
}
