//! Errors and oddities of a DBC.

/// Severity of a finding.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// Noted; the message can be used.
    Warning,
    /// The message cannot be used.
    Error,
}

/// What a finding is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Concern {
    /// Two messages have the same identifier.
    DuplicateId,
    /// Two messages, or two signals of a message, have the same name.
    DuplicateName,
    /// The identifier is not a CAN identifier.
    IdOutOfRange,
    /// The message is longer than any frame, or has a length that no frame has.
    MessageLength,
    /// A signal ends behind its message.
    OutsideMessage,
    /// Two signals that one frame can carry share bits.
    Overlap,
    /// A signal has no bits or too many, or a float signal does not have a float's number of bits.
    SignalLength,
    /// The factor is zero, or factor or offset are not finite.
    Scale,
    /// \[min|max\] is upside down or not finite.
    Limits,
    /// A multiplexor is missing, ambiguous, cyclic or unsuitable, or never selects a signal.
    Multiplexing,
    /// A statement refers to a message or signal that does not exist, or is repeated.
    Reference,
    /// A statement that is not understood and was left out.
    Statement,
}

/// One thing that a person should know about a DBC.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Finding {
    pub severity: Severity,
    pub concern: Concern,
    /// Line in the DBC, counted from 1.
    pub line: usize,
    pub message: Option<String>,
    pub signal: Option<String>,
    /// What was found.
    pub what: String,
    /// What to do about it.
    pub remedy: &'static str,
}

impl std::fmt::Display for Finding {
    /// `line 12: message M, signal S: what; remedy`
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "line {}: ", self.line)?;
        match (&self.message, &self.signal) {
            (Some(message), Some(signal)) => write!(f, "message {message}, signal {signal}: ")?,
            (Some(message), None) => write!(f, "message {message}: ")?,
            (None, Some(signal)) => write!(f, "signal {signal}: ")?,
            (None, None) => {}
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
