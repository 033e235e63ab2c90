//! The object dictionary: which objects there are, and where their values come from. The data sheet
//! is written from it, and the SDO server serves it.

use super::stack::Abort;
use super::value::NodeType;
use std::borrow::Cow;
use tertius_core::alarm::OwnMessage;

/// The object dictionary of a node, in the order of indices.
#[derive(Clone, Debug)]
pub(super) struct Dictionary {
    objects: Vec<NodeObject>,
}

/// An object, with its entries in the order of sub-indices.
#[derive(Clone, Debug)]
pub(super) struct NodeObject {
    pub(super) index: u16,
    pub(super) name: Cow<'static, str>,
    pub(super) shape: Shape,
    pub(super) entries: Vec<NodeEntry>,
}

/// Object code. The numbers are those of CiA 301.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Shape {
    Variable = 7,
    Array = 8,
    Record = 9,
}

/// An entry of an object.
#[derive(Clone, Debug)]
pub(super) struct NodeEntry {
    pub(super) sub: u8,
    pub(super) name: Cow<'static, str>,
    pub(super) kind: NodeType,
    pub(super) access: Access,
    /// Whether it is mapped into a PDO.
    pub(super) mapped: bool,
    pub(super) source: Source,
}

/// Rights of an SDO client.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Access {
    Constant,
    Read,
    ReadWrite,
}

/// Where the value of an entry comes from.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Source {
    Number(u32),
    /// The sum of this and the node number.
    OfNode(u32),
    Real(f32),
    Text(Cow<'static, str>),
    Live(Live),
}

/// A value that changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Live {
    ErrorRegister,
    ErrorCount,
    /// An entry of the history, 0 for the newest.
    Error(u8),
    /// Heartbeat time, ms.
    Heartbeat,
    /// Bytes of the newest PDO.
    Pdo {
        message: OwnMessage,
        from: u8,
        length: u8,
    },
    Level,
    Mode,
    ActiveWarnings,
    /// A count of the monitor.
    Count(u8),
    /// State of a transducer.
    Health {
        cylinder: u8,
        transducer: u8,
    },
    /// A residual of a cylinder.
    Residual {
        cylinder: u8,
        number: u8,
    },
}

impl Dictionary {
    /// # Panics
    /// In tests, if the objects or the entries of one are not in order.
    pub(super) fn new(objects: Vec<NodeObject>) -> Self {
        debug_assert!(objects.is_sorted_by(|one, next| one.index < next.index));
        for object in &objects {
            debug_assert!(object.entries.is_sorted_by(|one, next| one.sub < next.sub));
        }
        Self { objects }
    }

    pub(super) fn objects(&self) -> &[NodeObject] {
        &self.objects
    }

    /// The entry at an address; or whether the object or only its sub-index is missing.
    pub(super) fn find(&self, index: u16, sub: u8) -> Result<&NodeEntry, Abort> {
        let at = self.objects.binary_search_by_key(&index, |object| object.index);
        let object = at.map(|at| &self.objects[at]).map_err(|_| Abort::NoObject)?;
        object.entries.iter().find(|entry| entry.sub == sub).ok_or(Abort::NoSubIndex)
    }
}

impl NodeObject {
    /// An object with one value.
    pub(super) fn variable(index: u16, entry: NodeEntry) -> Self {
        let name = entry.name.clone();
        Self { index, name, shape: Shape::Variable, entries: vec![entry] }
    }

    /// An object with a count of entries at sub-index 0 and the entries from 1 on.
    pub(super) fn record(
        index: u16,
        name: impl Into<Cow<'static, str>>,
        entries: impl IntoIterator<Item = NodeEntry>,
    ) -> Self {
        let mut numbered: Vec<NodeEntry> = vec![];
        for (sub, entry) in (1..=u8::MAX).zip(entries) {
            numbered.push(NodeEntry { sub: if entry.sub == 0 { sub } else { entry.sub }, ..entry });
        }
        let highest = numbered.last().map_or(0, |entry| entry.sub);
        let name_of_count = "Highest sub-index supported";
        let count = NodeEntry::number(name_of_count, NodeType::Unsigned8, highest.into());
        numbered.insert(0, count);
        Self { index, name: name.into(), shape: Shape::Record, entries: numbered }
    }
}

impl NodeEntry {
    fn new(name: impl Into<Cow<'static, str>>, kind: NodeType, source: Source) -> Self {
        Self { sub: 0, name: name.into(), kind, access: Access::Constant, mapped: false, source }
    }

    /// A constant number.
    pub(super) fn number(name: impl Into<Cow<'static, str>>, kind: NodeType, value: u32) -> Self {
        Self::new(name, kind, Source::Number(value))
    }

    /// A constant number to which the node number is added.
    pub(super) fn of_node(name: &'static str, value: u32) -> Self {
        Self::new(name, NodeType::Unsigned32, Source::OfNode(value))
    }

    /// A constant text. CANopen's texts are ASCII.
    pub(super) fn text(name: &'static str, text: &str) -> Self {
        let ascii = |c: char| if c.is_ascii_graphic() || c == ' ' { c } else { '?' };
        let text: String = text.chars().map(ascii).collect();
        Self::new(name, NodeType::Text, Source::Text(text.into()))
    }

    /// A constant length or time.
    pub(super) fn real(name: &'static str, value: f64) -> Self {
        Self::new(name, NodeType::Real32, Source::Real(value as f32))
    }

    /// A value that changes and can only be read.
    pub(super) fn live(name: impl Into<Cow<'static, str>>, kind: NodeType, live: Live) -> Self {
        Self { access: Access::Read, ..Self::new(name, kind, Source::Live(live)) }
    }

    pub(super) fn writable(self) -> Self {
        Self { access: Access::ReadWrite, ..self }
    }

    pub(super) fn mapped(self) -> Self {
        Self { mapped: true, ..self }
    }

    pub(super) fn at(self, sub: u8) -> Self {
        Self { sub, ..self }
    }
}
