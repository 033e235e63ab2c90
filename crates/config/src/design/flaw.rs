//! What does not fit in settings and a DBC.

/// A setting that does not fit the DBC or cannot be computed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Flaw {
    /// Key at fault, for example `signals.cylinder.c1`.
    pub key: String,
    pub message: String,
    /// Advice on what to do.
    pub help: String,
}

impl Flaw {
    pub(crate) fn new(key: &str, message: impl ToString, help: impl ToString) -> Self {
        Self { key: key.to_owned(), message: message.to_string(), help: help.to_string() }
    }
}

/// The first flaw of each key: a misspelt signal is one mistake, and not one for each cylinder.
pub(super) fn once_per_key(flaws: Vec<Flaw>) -> Vec<Flaw> {
    let mut kept: Vec<Flaw> = Vec::new();
    for flaw in flaws {
        if kept.iter().all(|known| known.key != flaw.key) {
            kept.push(flaw);
        }
    }
    kept
}
