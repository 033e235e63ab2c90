//! Faults in a table: `cylinder,sensor,kind,t0,magnitude,parameter,t1`, one line each.

use super::MAX_FAULTS;
use super::fault::{Fault, KeyValues, SpecError, find_kind};

/// The longest table, bytes.
pub const MAX_TEXT: usize = 1 << 20;

/// Columns of a table, which its first line names in this order.
pub const HEADER: [&str; 7] = ["cylinder", "sensor", "kind", "t0", "magnitude", "parameter", "t1"];

/// Why a table is refused, and where.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("line {line}: {reason}")]
pub struct FaultTableError {
    /// Line number, counted from 1.
    pub line: usize,
    pub reason: Reason,
}

impl FaultTableError {
    /// The same where only readings can have faults: offers no kinds of the machine itself.
    #[must_use]
    pub fn of_readings(self) -> Self {
        match self.reason {
            Reason::Spec { error } => {
                Self { reason: Reason::Spec { error: error.of_readings() }, ..self }
            }
            reason => Self { reason, ..self },
        }
    }
}

/// Why a table is refused.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Reason {
    #[error("found {found:?}, expected the header {}", HEADER.join(","))]
    Header { found: String },
    #[error("{found} columns, expected {}: {}", HEADER.len(), HEADER.join(","))]
    Columns { found: usize },
    #[error("{column} is {given:?}, but {kind} has no such number; leave it empty, or 0")]
    NotUsed { kind: &'static str, column: &'static str, given: String },
    #[error("{}{error}", column(.error))]
    Spec { error: SpecError },
    #[error("more than {MAX_FAULTS} faults")]
    TooMany,
    #[error("longer than {MAX_TEXT} bytes; a table has a line for each fault")]
    TooLong,
}

/// The column of the key that is wrong.
fn column(error: &SpecError) -> &'static str {
    let key = match error {
        SpecError::Missing { key, .. } | SpecError::Value { key, .. } => *key,
        SpecError::Until { .. } => "until",
        _ => return "",
    };
    match key {
        "at" => "column t0: ",
        "until" => "column t1: ",
        "b" => "column parameter: ",
        "cylinder" => "",
        _ => "column magnitude or parameter: ",
    }
}

/// Reads a table: faults with their lines, counted from 1. `magnitude` and `parameter` are the kind's own keys in their order (size and b of
/// an incipient fault); an empty one has its default. An empty `t1` means to the end. Empty lines
/// and lines that begin with # are left out.
///
/// # Errors
/// The first thing wrong with it.
pub fn parse(text: &str) -> Result<Vec<(usize, Fault)>, FaultTableError> {
    if text.len() > MAX_TEXT {
        return Err(FaultTableError { line: 1, reason: Reason::TooLong });
    }
    let text = text.strip_prefix('\u{FEFF}').unwrap_or(text);
    let mut lines = (1..).zip(text.lines().map(str::trim));
    let mut lines = lines.by_ref().filter(|(_, line)| !(line.is_empty() || line.starts_with('#')));
    let (line, header) = lines.next().unwrap_or((1, ""));
    if !header.split(',').map(str::trim).eq(HEADER) {
        return Err(FaultTableError { line, reason: Reason::Header { found: excerpt(header) } });
    }
    let mut faults = Vec::new();
    for (line, row) in lines {
        if faults.len() == MAX_FAULTS {
            return Err(FaultTableError { line, reason: Reason::TooMany });
        }
        let fault = fault(row).map_err(|reason| FaultTableError { line, reason })?;
        faults.push((line, fault));
    }
    Ok(faults)
}

fn fault(row: &str) -> Result<Fault, Reason> {
    let columns: Vec<&str> = row.split(',').map(str::trim).collect();
    let [cylinder, sensor, kind, t0, magnitude, parameter, t1] = columns[..] else {
        return Err(Reason::Columns { found: columns.len() });
    };
    let spec = |error| Reason::Spec { error };
    let kind = find_kind(kind).map_err(spec)?;
    let mut values = KeyValues::new(kind);
    let given = [("cylinder", cylinder), ("sensor", sensor), ("at", t0), ("until", t1)];
    for (key, value) in given.into_iter().filter(|(_, value)| !value.is_empty()) {
        values.add(key, value).map_err(spec)?;
    }
    // Their keys are codes of which 0 is one, and no magnitudes.
    let is_code = matches!(kind.name, "out_of_range" | "broken_wire");
    for (place, (column, value)) in
        [("magnitude", magnitude), ("parameter", parameter)].into_iter().enumerate()
    {
        match kind.keys.get(place).filter(|_| !is_code) {
            _ if value.is_empty() => {}
            Some(key) => values.add(key.name, value).map_err(spec)?,
            None if value.parse() == Ok(0.0) => {}
            None => {
                let given = excerpt(value);
                return Err(Reason::NotUsed { kind: kind.name, column, given });
            }
        }
    }
    values.fault().map_err(spec)
}

fn excerpt(text: &str) -> String {
    text.chars().take(80).collect()
}
