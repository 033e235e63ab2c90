//! Objects of a device, and the variables in them.

use std::collections::BTreeMap;

use super::data_type::DataType;
use super::value::Value;

/// What an object is (CiA 301, table 42).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ObjectType {
    /// A large amount of data, such as a program.
    Domain,
    /// A single variable.
    Var,
    /// Variables of one type.
    Array,
    /// Variables of several types.
    Record,
}

impl ObjectType {
    /// The type of that object code; `None` for type definitions and unknown codes.
    pub(super) fn from_code(code: i128) -> Option<Self> {
        match code {
            2 => Some(Self::Domain),
            7 => Some(Self::Var),
            8 => Some(Self::Array),
            9 => Some(Self::Record),
            _ => None,
        }
    }
}

/// What the bus may do with a variable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AccessType {
    /// `ro`: read.
    ReadOnly,
    /// `wo`: write.
    WriteOnly,
    /// `rw`: read and write.
    ReadWrite,
    /// `rwr`: read and write, and sent in a PDO.
    ReadWriteOnRead,
    /// `rww`: read and write, and received in a PDO.
    ReadWriteOnWrite,
    /// `const`: read, always the same.
    Const,
}

/// Words of the format, whatever their letter case.
const ACCESS: [(&str, AccessType); 6] = [
    ("ro", AccessType::ReadOnly),
    ("wo", AccessType::WriteOnly),
    ("rw", AccessType::ReadWrite),
    ("rwr", AccessType::ReadWriteOnRead),
    ("rww", AccessType::ReadWriteOnWrite),
    ("const", AccessType::Const),
];

impl AccessType {
    pub(super) fn from_word(word: &str) -> Option<Self> {
        ACCESS.iter().find(|(known, _)| word.eq_ignore_ascii_case(known)).map(|it| it.1)
    }

    /// The format's word, in small letters.
    pub fn word(self) -> &'static str {
        ACCESS.iter().find(|(_, access)| *access == self).map_or("", |it| it.0)
    }
}

/// A variable: an object of its own, or a sub-object.
#[derive(Clone, Debug, PartialEq)]
pub struct Variable {
    /// `ParameterName`; empty where the file has none.
    pub name: String,
    /// Line of its section in the EDS, counted from 1.
    pub line: usize,
    pub data_type: DataType,
    pub access: AccessType,
    /// Whether it may be mapped into a PDO.
    pub pdo_mapping: bool,
    pub default: Option<Value>,
    /// `ParameterValue` of a DCF: what the device is configured to.
    pub value: Option<Value>,
    pub low_limit: Option<Value>,
    pub high_limit: Option<Value>,
    /// `Denotation` of a DCF: what the variable is in this plant.
    pub denotation: Option<String>,
}

impl Variable {
    /// What the device has after its configuration: the DCF's value, or else the default.
    pub fn configured(&self) -> Option<&Value> {
        self.value.as_ref().or(self.default.as_ref())
    }
}

/// An object: all that has one index.
#[derive(Clone, Debug, PartialEq)]
pub struct Object {
    pub index: u16,
    /// `ParameterName`; empty where the file has none.
    pub name: String,
    /// Line of its section in the EDS, counted from 1.
    pub line: usize,
    pub object_type: ObjectType,
    /// Its variables by sub-index; a single one has 0.
    pub variables: BTreeMap<u8, Variable>,
}
