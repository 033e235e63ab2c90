//! A message as a DBC has it, before it is judged.

use can_dbc::SignalExtendedValueType;

use super::finding::{Concern, Finding, Findings, Severity};

/// A message as the file has it.
pub(super) struct Draft {
    pub line: usize,
    /// The number in the file; a number beyond u64 is u64::MAX.
    pub id: u64,
    /// The long one, where it has one.
    pub name: String,
    /// The one that the format has room for, where `name` is longer.
    pub short: Option<String>,
    pub length: u64,
    pub comment: Option<String>,
    pub signals: Vec<DraftSignal>,
    /// Why it cannot be used.
    pub refused: Option<Finding>,
}

/// A signal as the file has it.
pub(super) struct DraftSignal {
    pub line: usize,
    /// Its name is the one that other statements know it by.
    pub parsed: can_dbc::Signal,
    /// A name that the format has no room for.
    pub long: Option<String>,
    /// `m` without a number, which the parser takes for a plain signal.
    pub bare_indicator: bool,
    pub value_type: Option<SignalExtendedValueType>,
    pub multiplex: Option<Multiplex>,
    pub values: Vec<(i64, String)>,
    pub comment: Option<String>,
}

/// An `SG_MUL_VAL_`.
pub(super) struct Multiplex {
    pub line: usize,
    pub multiplexor: String,
    pub ranges: Vec<(u64, u64)>,
}

impl DraftSignal {
    /// The long name, where it has one.
    pub fn name(&self) -> &str {
        self.long.as_deref().unwrap_or(&self.parsed.name)
    }
}

impl Draft {
    pub fn finding(
        &self,
        severity: Severity,
        concern: Concern,
        signal: Option<&DraftSignal>,
        what: String,
        remedy: &'static str,
    ) -> Finding {
        Finding {
            severity,
            concern,
            line: signal.map_or(self.line, |signal| signal.line),
            message: Some(self.name.clone()),
            signal: signal.map(|signal| signal.name().to_owned()),
            what,
            remedy,
        }
    }

    /// Notes a finding; an error makes the message unusable.
    pub fn judge(&mut self, finding: Finding, findings: &mut Findings) {
        if finding.severity == Severity::Error && self.refused.is_none() {
            self.refused = Some(finding.clone());
        }
        findings.push(finding);
    }
}
