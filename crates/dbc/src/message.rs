//! Messages and signals that are known to be sound.

use tertius_core::decode::SignalPlan;
use tertius_core::frame::Id;

/// A message of a DBC.
#[derive(Clone, Debug, PartialEq)]
pub struct Message {
    pub id: Id,
    /// The long name (`SystemMessageLongSymbol`), where the file has one.
    pub name: String,
    /// Name in the `BO_` statement, where there is a longer one.
    pub short: Option<String>,
    /// The payload's length in bytes, 0 to 64.
    pub length: usize,
    /// Signals in the order of the file.
    pub signals: Vec<Signal>,
    pub comment: Option<String>,
    /// Line in the DBC, counted from 1.
    pub line: usize,
}

impl Message {
    /// The signal of that name, long or short, letter case respected.
    pub fn signal(&self, name: &str) -> Option<&Signal> {
        let is_it = |signal: &&Signal| signal.name == name || signal.short.as_deref() == Some(name);
        self.signals.iter().find(is_it)
    }
}

/// A signal of a message.
#[derive(Clone, Debug, PartialEq)]
pub struct Signal {
    /// The long name (`SystemSignalLongSymbol`), where the file has one.
    pub name: String,
    /// Name in the `SG_` statement, where there is a longer one.
    pub short: Option<String>,
    /// Unit as given in the file; empty where there is none.
    pub unit: String,
    /// \[min|max\] in the signal's unit; `None` where the file has \[0|0\] or an invalid range
    /// (which is a finding).
    pub range: Option<[f64; 2]>,
    /// Names of raw numbers (VAL_), in the order of the file.
    pub values: Vec<(i64, String)>,
    pub comment: Option<String>,
    pub plan: SignalPlan,
    /// Line in the DBC, counted from 1.
    pub line: usize,
}

impl Signal {
    /// Name of a raw number; the first of several.
    pub fn value_name(&self, number: i64) -> Option<&str> {
        self.values.iter().find(|(value, _)| *value == number).map(|(_, name)| name.as_str())
    }

    /// The raw numbers with that name, ignoring ASCII letter case: usually one, none where the name
    /// is unknown, several where the table gives a name ("reserved") more than once.
    pub fn numbers_named<'a>(&'a self, name: &'a str) -> impl Iterator<Item = i64> + 'a {
        self.values
            .iter()
            .filter(move |(_, known)| known.eq_ignore_ascii_case(name))
            .map(|(number, _)| *number)
    }
}
