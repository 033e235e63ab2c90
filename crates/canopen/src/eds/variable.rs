//! From a section to a variable.

use super::data_type::DataType;
use super::finding::{Address, Concern, Finding, Findings, Severity};
use super::group::Groups;
use super::ini::{Entry, Section};
use super::number;
use super::object::{AccessType, ObjectType, Variable};
use super::parse_error::excerpt;
use super::value::Value;
use super::{MAX_NAME, MAX_VALUE};

/// Reads the section of one object or sub-object, and notes what is odd.
pub(super) struct Reader<'a, 'b> {
    pub groups: &'b Groups<'a>,
    pub section: &'a Section<'a>,
    pub address: Address,
    pub findings: &'b mut Findings,
}

impl Reader<'_, '_> {
    /// The variable of that name that the section describes.
    ///
    /// # Errors
    /// Without a known data type a variable cannot be used.
    pub fn variable(&mut self, name: String) -> Result<Variable, Finding> {
        let data_type = self.data_type()?;
        Ok(Variable {
            name,
            line: self.section.line,
            data_type,
            access: self.access(data_type),
            pdo_mapping: self.flag("PDOMapping"),
            default: self.value("DefaultValue", data_type),
            value: self.value("ParameterValue", data_type),
            low_limit: self.limit("LowLimit", data_type),
            high_limit: self.limit("HighLimit", data_type),
            denotation: self.section.filled("Denotation").map(|entry| self.kept(entry)),
        })
    }

    /// `ParameterName`.
    pub fn name(&mut self) -> String {
        if let Some(entry) = self.section.filled("ParameterName") {
            return self.kept(entry);
        }
        let remedy = "ParameterName is its name and should not be empty";
        self.warn(Concern::Missing, self.section.line, "it has no ParameterName".into(), remedy);
        String::new()
    }

    /// What the section says the object is; `None` if it does not say so.
    ///
    /// # Errors
    /// The code is unknown, or that of a definition.
    pub fn object_type(&self) -> Result<Option<ObjectType>, Finding> {
        let Some(entry) = self.section.filled("ObjectType") else { return Ok(None) };
        let known = number::whole(entry.value).and_then(ObjectType::from_code);
        known.map(Some).ok_or_else(|| {
            let what = format!("ObjectType is {:?}", excerpt(entry.value));
            let remedy = "expected 0x2 (DOMAIN), 0x7 (VAR), 0x8 (ARRAY) or 0x9 (RECORD)";
            self.error(Concern::Type, entry.line, what, remedy)
        })
    }

    /// A count of sub-objects, at most 254; nothing where it is missing or wrong.
    pub fn count(&mut self, key: &str) -> Option<u8> {
        let entry = self.section.filled(key)?;
        let number = number::within(entry.value).filter(|number| *number < u8::MAX);
        if number.is_none() {
            let what = format!("{key} is {:?}", excerpt(entry.value));
            self.warn(Concern::Count, entry.line, what, "expected a number from 0 to 254");
        }
        number
    }

    fn data_type(&self) -> Result<DataType, Finding> {
        const REMEDY: &str = "expected the number of a data type, such as 0x0007 for UNSIGNED32";
        let Some(entry) = self.section.filled("DataType") else {
            // The format lets domains leave it out.
            if matches!(self.object_type(), Ok(Some(ObjectType::Domain))) {
                return Ok(DataType::Domain);
            }
            let (line, what) = (self.section.line, "it has no DataType".to_owned());
            return Err(self.error(Concern::Missing, line, what, REMEDY));
        };
        let number = number::within(entry.value).filter(|number| *number > 0).ok_or_else(|| {
            let what = format!("DataType is {:?}", excerpt(entry.value));
            self.error(Concern::Type, entry.line, what, REMEDY)
        })?;
        let number = self.groups.defined_type(number).unwrap_or(number);
        Ok(DataType::from_number(number))
    }

    fn access(&mut self, data_type: DataType) -> AccessType {
        const REMEDY: &str = "expected ro, wo, rw, rwr, rww or const, so it counts as ro";
        let Some(entry) = self.section.filled("AccessType") else {
            if data_type == DataType::Domain {
                return AccessType::ReadWrite;
            }
            let line = self.section.line;
            self.warn(Concern::Missing, line, "it has no AccessType".to_owned(), REMEDY);
            return AccessType::ReadOnly;
        };
        AccessType::from_word(number::without_comment(entry.value)).unwrap_or_else(|| {
            let what = format!("AccessType is {:?}", excerpt(entry.value));
            self.warn(Concern::Access, entry.line, what, REMEDY);
            AccessType::ReadOnly
        })
    }

    fn flag(&mut self, key: &str) -> bool {
        let Some(entry) = self.section.filled(key) else { return false };
        number::whole(entry.value).map_or_else(
            || {
                let what = format!("{key} is {:?}", excerpt(entry.value));
                self.warn(Concern::Number, entry.line, what, "expected 0 or 1, so it counts as 0");
                false
            },
            |number| number != 0,
        )
    }

    fn limit(&mut self, key: &str, data_type: DataType) -> Option<Value> {
        // Texts and the like have none.
        data_type.bits()?;
        self.value(key, data_type)
    }

    fn value(&mut self, key: &str, data_type: DataType) -> Option<Value> {
        self.value_of(self.section.filled(key)?, data_type)
    }

    /// The value of an entry; nothing if it cannot be one of that type.
    pub fn value_of(&mut self, entry: Entry, data_type: DataType) -> Option<Value> {
        if matches!(data_type, DataType::Other(_)) {
            return None;
        }
        let read = if entry.value.len() > MAX_VALUE {
            Err("the value is longer than 1024 bytes")
        } else {
            Value::read(entry.value, data_type)
        };
        read.map_err(|reason| {
            let what = format!("{} of {data_type} is {:?}", entry.key, excerpt(entry.value));
            self.warn(Concern::Number, entry.line, what, reason);
        })
        .ok()
    }

    /// The entry's text, shortened to what a name may have.
    pub fn kept(&mut self, entry: Entry) -> String {
        let mut end = entry.value.len().min(MAX_NAME);
        while !entry.value.is_char_boundary(end) {
            end -= 1;
        }
        if end < entry.value.len() {
            let what = format!("{} has {} bytes", entry.key, entry.value.len());
            self.warn(Concern::Length, entry.line, what, "the first 256 are kept");
        }
        entry.value[..end].to_owned()
    }

    /// Notes something that does not keep the object from being used.
    pub fn warn(&mut self, concern: Concern, line: usize, what: String, remedy: &'static str) {
        let object = Some(self.address);
        let severity = Severity::Warning;
        self.findings.push(Finding { severity, concern, line, object, what, remedy });
    }

    /// A finding that keeps the object from being used.
    pub fn error(
        &self,
        concern: Concern,
        line: usize,
        what: String,
        remedy: &'static str,
    ) -> Finding {
        let object = Some(self.address);
        Finding { severity: Severity::Error, concern, line, object, what, remedy }
    }
}
