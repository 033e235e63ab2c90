//! From groups of sections to objects.

use std::collections::BTreeMap;

use super::MAX_SUB_OBJECTS;
use super::data_type::DataType;
use super::finding::{Address, Concern, Finding, Findings};
use super::group::{FIRST_OBJECT, Group, Groups};
use super::ini::{Entry, Section};
use super::number;
use super::object::{AccessType, Object, ObjectType, Variable};
use super::parse_error::ParseError;
use super::value::Value;
use super::variable::Reader;

/// Objects that can be used, and why others cannot.
#[derive(Clone, Debug, Default)]
pub(super) struct Collected {
    pub objects: BTreeMap<u16, Object>,
    pub refused: BTreeMap<Address, Finding>,
}

/// Reads all objects.
///
/// # Errors
/// More sub-objects than [`MAX_SUB_OBJECTS`].
pub(super) fn collect(groups: &Groups, findings: &mut Findings) -> Result<Collected, ParseError> {
    let mut collector = Collector { groups, findings, collected: Collected::default() };
    let mut sub_objects = 0;
    for (&index, group) in groups.objects.range(FIRST_OBJECT..) {
        let Some(head) = group.head.or(group.subs.values().next().copied()) else { continue };
        if let Some(object) = collector.object(index, group, head) {
            sub_objects += object.variables.len();
            let (line, limit) = (head.line, MAX_SUB_OBJECTS);
            if sub_objects > limit {
                return Err(ParseError::TooMany { line, what: "sub-objects", limit });
            }
            collector.collected.objects.insert(index, object);
        }
    }
    for twin in &groups.twins {
        collector.refuse_twin(twin);
    }
    Ok(collector.collected)
}

struct Collector<'a, 'b> {
    groups: &'b Groups<'a>,
    findings: &'b mut Findings,
    collected: Collected,
}

impl<'a> Collector<'a, '_> {
    /// The object in `group`, whose first section is `head`; nothing if it cannot be used.
    fn object(&mut self, index: u16, group: &Group<'a>, head: &'a Section<'a>) -> Option<Object> {
        let mut reader = self.reader(Address { index, sub_index: None }, head);
        let (name, told) = match group.head {
            Some(_) => (reader.name(), reader.object_type()),
            None => {
                let remedy = "it has sub-objects, so it counts as a RECORD";
                let what = format!("there is no section [{index:04X}]");
                reader.warn(Concern::Section, head.line, what, remedy);
                (String::new(), Ok(Some(ObjectType::Record)))
            }
        };
        let object_type = match told {
            Ok(told) => self.object_type(index, group, head, told),
            Err(finding) => {
                self.refuse(finding);
                return None;
            }
        };
        let variables = match object_type {
            ObjectType::Var | ObjectType::Domain => {
                let address = Address { index, sub_index: Some(0) };
                BTreeMap::from([(0, self.variable(address, head, name.clone())?)])
            }
            ObjectType::Array | ObjectType::Record => self.sub_objects(index, group, head, &name),
        };
        Some(Object { index, name, line: head.line, object_type, variables })
    }

    /// What the object is: what it says, or else a VAR, as the format has it.
    fn object_type(
        &mut self,
        index: u16,
        group: &Group<'a>,
        head: &'a Section<'a>,
        told: Option<ObjectType>,
    ) -> ObjectType {
        let single = matches!(told, None | Some(ObjectType::Var | ObjectType::Domain));
        if !single || group.subs.is_empty() {
            return told.unwrap_or(ObjectType::Var);
        }
        let is_variable = head.filled("DataType").is_some();
        let (object_type, remedy) = if is_variable {
            (told.unwrap_or(ObjectType::Var), "its sub-objects were left out")
        } else {
            (ObjectType::Record, "it counts as a RECORD")
        };
        let what = "it is a single variable by its ObjectType, and has sub-objects".to_owned();
        let mut reader = self.reader(Address { index, sub_index: None }, head);
        reader.warn(Concern::Type, head.line, what, remedy);
        object_type
    }

    fn sub_objects(
        &mut self,
        index: u16,
        group: &Group<'a>,
        head: &'a Section<'a>,
        name: &str,
    ) -> BTreeMap<u8, Variable> {
        let address = Address { index, sub_index: None };
        let compact = self.reader(address, head).count("CompactSubObj").filter(|it| *it > 0);
        let template = compact.and_then(|_| self.variable(address, head, name.to_owned()));
        let mut variables = match compact.zip(template) {
            Some((count, template)) => self.compact(index, group, count, &template),
            None => BTreeMap::new(),
        };
        for (&sub_index, section) in &group.subs {
            let address = Address { index, sub_index: Some(sub_index) };
            let name = self.reader(address, section).name();
            match self.variable(address, section, name) {
                Some(variable) => variables.insert(sub_index, variable),
                None => variables.remove(&sub_index),
            };
        }
        if compact.is_none()
            && let Some(told) = self.reader(address, head).count("SubNumber")
            && usize::from(told) != group.subs.len()
        {
            let what = format!("SubNumber is {told}, and {} sub-objects follow", group.subs.len());
            let remedy = "the sections that are there count";
            let mut reader = self.reader(address, head);
            reader.warn(Concern::Count, head.line, what, remedy);
        }
        variables
    }

    /// The sub-objects of `CompactSubObj`: `count` like `template`, behind their number.
    fn compact(
        &mut self,
        index: u16,
        group: &Group<'a>,
        count: u8,
        template: &Variable,
    ) -> BTreeMap<u8, Variable> {
        let number_of_entries = Variable {
            name: "Number of entries".to_owned(),
            line: template.line,
            data_type: DataType::Unsigned(8),
            access: AccessType::ReadOnly,
            pdo_mapping: false,
            default: Some(Value::Whole { number: i128::from(count), plus_node_id: false }),
            value: None,
            low_limit: None,
            high_limit: None,
            denotation: None,
        };
        let mut variables = BTreeMap::from([(0, number_of_entries)]);
        for sub_index in 1..=count {
            let name = format!("{}{sub_index}", template.name);
            variables.insert(sub_index, Variable { name, ..template.clone() });
        }
        let address = |sub_index| Address { index, sub_index: Some(sub_index) };
        for (section, what) in [
            (group.names, Listed::Name),
            (group.values, Listed::Value),
            (group.denotations, Listed::Denotation),
        ] {
            let Some(section) = section else { continue };
            for entry in &section.entries {
                let Some(sub_index) = number::within(entry.key) else { continue };
                let Some(variable) = variables.get_mut(&sub_index) else { continue };
                what.put(*entry, variable, &mut self.reader(address(sub_index), section));
            }
        }
        variables
    }

    fn variable(
        &mut self,
        address: Address,
        section: &'a Section<'a>,
        name: String,
    ) -> Option<Variable> {
        self.reader(address, section).variable(name).map_err(|finding| self.refuse(finding)).ok()
    }

    fn reader(&mut self, address: Address, section: &'a Section<'a>) -> Reader<'a, '_> {
        Reader { groups: self.groups, section, address, findings: self.findings }
    }

    fn refuse(&mut self, finding: Finding) {
        if let Some(address) = finding.object {
            self.collected.refused.entry(address).or_insert_with(|| finding.clone());
        }
        self.findings.push(finding);
    }

    /// Refuses what has two sections, since it cannot be told which is meant.
    fn refuse_twin(&mut self, twin: &Finding) {
        let Some(Address { index, sub_index }) = twin.object else { return };
        match sub_index {
            None => _ = self.collected.objects.remove(&index),
            Some(sub_index) => {
                if let Some(object) = self.collected.objects.get_mut(&index) {
                    object.variables.remove(&sub_index);
                }
            }
        }
        self.refuse(twin.clone());
    }
}

/// What a section beside an object of `CompactSubObj` lists by sub-index.
#[derive(Clone, Copy)]
enum Listed {
    Name,
    Value,
    Denotation,
}

impl Listed {
    fn put(self, entry: Entry, variable: &mut Variable, reader: &mut Reader) {
        match self {
            Self::Name => variable.name = reader.kept(entry),
            Self::Value => variable.value = reader.value_of(entry, variable.data_type),
            Self::Denotation => variable.denotation = Some(reader.kept(entry)),
        }
    }
}
