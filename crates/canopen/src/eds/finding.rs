//! Errors and oddities of an EDS.

use std::fmt;

/// Severity of a finding.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// Noted; the object can be used.
    Warning,
    /// The object or sub-object cannot be used.
    Error,
}

/// What a finding is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Concern {
    /// A line that is neither a section, nor an entry, nor a comment.
    Line,
    /// Two sections, or two entries of a section, have the same name.
    Duplicate,
    /// A section that the format requires is missing, or belongs to nothing.
    Section,
    /// An entry that the format requires is missing.
    Missing,
    /// `ObjectType` or `DataType` is unknown or unsuitable.
    Type,
    /// `AccessType` is unknown.
    Access,
    /// A number cannot be read, or a value does not fit its type.
    Number,
    /// A name or value is too long.
    Length,
    /// A list or count disagrees with the sections.
    Count,
}

/// Place in an object dictionary: an object, or one of its sub-objects.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Address {
    pub index: u16,
    /// `None` where the whole object is meant.
    pub sub_index: Option<u8>,
}

impl fmt::Display for Address {
    /// `0x1018` or `0x1018:01`, both hexadecimal.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "0x{:04X}", self.index)?;
        self.sub_index.map_or(Ok(()), |sub_index| write!(f, ":{sub_index:02X}"))
    }
}

/// One thing that a person should know about an EDS.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Finding {
    pub severity: Severity,
    pub concern: Concern,
    /// Line in the EDS, counted from 1.
    pub line: usize,
    pub object: Option<Address>,
    /// What was found.
    pub what: String,
    /// What was expected, or what to do about it.
    pub remedy: &'static str,
}

impl fmt::Display for Finding {
    /// `line 12: object 0x1018:01: what; remedy`
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "line {}: ", self.line)?;
        if let Some(object) = self.object {
            write!(f, "object {object}: ")?;
        }
        write!(f, "{}; {}", self.what, self.remedy)
    }
}

/// The first findings, and the number of those beyond.
#[derive(Clone, Debug, Default)]
pub(super) struct Findings {
    list: Vec<Finding>,
    left_out: usize,
}

impl Findings {
    pub fn push(&mut self, finding: Finding) {
        if self.list.len() < super::MAX_FINDINGS {
            self.list.push(finding);
        } else {
            self.left_out += 1;
        }
    }

    /// A warning about the file, not about an object.
    pub fn warn(&mut self, concern: Concern, line: usize, what: String, remedy: &'static str) {
        let severity = Severity::Warning;
        self.push(Finding { severity, concern, line, object: None, what, remedy });
    }

    pub fn list(&self) -> &[Finding] {
        &self.list
    }

    pub fn left_out(&self) -> usize {
        self.left_out
    }

    /// Sorts the findings by their lines in the file.
    pub fn sort(&mut self) {
        self.list.sort_by_key(|finding| finding.line);
    }
}
