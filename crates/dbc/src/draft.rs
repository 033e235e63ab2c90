//! A message as the DBC gives it, before it is judged.

use can_dbc::SignalExtendedValueType;

use super::finding::{Concern, Finding, Findings, Severity};

/// A message as the file gives it.
pub(super) struct Draft {
    pub line: usize,
    /// Identifier number in the file; a number beyond u64 is u64::MAX.
    pub id: u64,
    /// Long name, or the only one.
    pub name: String,
    /// Name in the `BO_` statement, where `name` is a longer one.
    pub short: Option<String>,
    pub length: u64,
    pub comment: Option<String>,
    pub signals: Vec<DraftSignal>,
    /// Error that makes the message unusable.
    pub refused: Option<Finding>,
}

/// A signal as the file gives it.
pub(super) struct DraftSignal {
    pub line: usize,
    /// The signal as parsed; its name is the one that other statements use.
    pub parsed: can_dbc::Signal,
    /// Long name, where there is one.
    pub long: Option<String>,
    /// The signal has an `m` without a number, which the parser takes for a plain signal.
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
    /// The long name, or else the short one.
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
