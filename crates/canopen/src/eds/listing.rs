//! An object dictionary as text, a line for each variable.

use std::fmt;

use super::dictionary::ObjectDictionary;
use super::object::{Object, ObjectType, Variable};
use super::value::Value;

impl fmt::Display for ObjectDictionary {
    /// A line for each variable: its address, the type of its object, its own data type and access, whether it
    /// may be mapped into a PDO, its default, its value (of a DCF), its limits, and its name, with tabs between them and
    /// `-` for what is not there.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.objects().try_for_each(|object| {
            let mut variables = object.variables.iter();
            variables.try_for_each(|(sub_index, variable)| line(f, object, *sub_index, variable))
        })
    }
}

fn line(
    f: &mut fmt::Formatter<'_>,
    object: &Object,
    sub_index: u8,
    variable: &Variable,
) -> fmt::Result {
    let object_type = match object.object_type {
        ObjectType::Var => "VAR",
        ObjectType::Domain => "DOMAIN",
        ObjectType::Array => "ARRAY",
        ObjectType::Record => "RECORD",
    };
    let text = |value: &Option<Value>| value.as_ref().map_or("-".to_owned(), Value::to_string);
    write!(f, "0x{:04X}:{sub_index:02X}\t{object_type}\t{}", object.index, variable.data_type)?;
    write!(f, "\t{}\t{}", variable.access.word(), if variable.pdo_mapping { "PDO" } else { "-" })?;
    for value in [&variable.default, &variable.value, &variable.low_limit, &variable.high_limit] {
        write!(f, "\t{}", text(value))?;
    }
    writeln!(f, "\t{}", variable.name)
}
