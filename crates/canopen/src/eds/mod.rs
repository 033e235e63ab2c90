//! Electronic data sheets (CiA 306): EDS files of devices, and DCF files of configured ones.
//!
//! [`ObjectDictionary::parse`] reads the text of either and returns the objects that are known to be sound,
//! and [`Finding`]s about the rest: an object with an error is refused where it is used, and the others
//! can be used. Nothing here reads files.

mod collect;
mod data_type;
mod device;
mod dictionary;
mod finding;
mod group;
mod ini;
mod listing;
mod number;
mod object;
mod parse_error;
mod value;
mod variable;

pub use data_type::DataType;
pub use device::{Commissioning, DeviceInformation};
pub use dictionary::{LookupError, ObjectDictionary};
pub use finding::{Address, Concern, Finding, Severity};
pub use object::{AccessType, Object, ObjectType, Variable};
pub use parse_error::ParseError;
pub use value::Value;

/// The longest EDS text that is read, in bytes.
pub const MAX_TEXT: usize = 4 << 20;
/// The longest line, in bytes.
pub const MAX_LINE: usize = 16 << 10;
/// The most sections of an EDS.
pub const MAX_SECTIONS: usize = 65_536;
/// The most entries (`KEY=VALUE`) of all sections together.
pub const MAX_ENTRIES: usize = 524_288;
/// The most sub-objects of all objects together, those of `CompactSubObj` included.
pub const MAX_SUB_OBJECTS: usize = 65_536;
/// The longest name of an object, in bytes; the format's own limit is 241 characters.
pub const MAX_NAME: usize = 256;
/// The longest default value that is kept, in bytes of the file.
pub const MAX_VALUE: usize = 1024;
/// The most findings that are kept; further ones are counted.
pub const MAX_FINDINGS: usize = 1000;
