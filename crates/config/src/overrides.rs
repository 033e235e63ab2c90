//! Values of single keys that come from outside the file: of one call, `--set fde.high=0.002`, and of its
//! surroundings, `TERTIUS_FDE__HIGH=0.002`.

use std::fmt;

/// Begin of the names of environment variables that override a key.
const PREFIX: &str = "TERTIUS_";
/// What stands between the names of table and key in such a variable; a single `_` is part of a name.
const SEPARATOR: &str = "__";

/// Where an override comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OverrideOrigin {
    /// `--set KEY=VALUE`
    CommandLine,
    /// `TERTIUS_TABLE__KEY=VALUE`
    Environment,
}

/// A value for one key, instead of the one in the file.
///
/// Its `Display` is as a person writes it, `--set fde.high=0.002` or `TERTIUS_FDE__HIGH=0.002`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Override {
    key: String,
    value: String,
    origin: OverrideOrigin,
}

impl Override {
    /// An override from the argument of `--set`.
    ///
    /// # Errors
    /// What was expected, if `text` is not `KEY=VALUE`.
    pub fn of_argument(text: &str) -> Result<Self, String> {
        match text.split_once('=') {
            Some((key, value)) if !key.trim().is_empty() => Ok(Self {
                key: key.trim().to_owned(),
                value: value.trim().to_owned(),
                origin: OverrideOrigin::CommandLine,
            }),
            _ => Err("expected KEY=VALUE with the key's full name, such as fde.high=0.002".into()),
        }
    }

    /// An override from an environment variable; `None` if `name` is not that of one. `TERTIUS_TOKEN` and others
    /// without a double underscore mean something else.
    pub fn of_variable(name: &str, value: &str) -> Option<Self> {
        let key = name.strip_prefix(PREFIX).filter(|rest| rest.contains(SEPARATOR))?;
        Some(Self {
            key: key.to_lowercase().replace(SEPARATOR, "."),
            value: value.trim().to_owned(),
            origin: OverrideOrigin::Environment,
        })
    }

    /// Full name of the key, for example `fde.high`.
    pub fn key(&self) -> &str {
        &self.key
    }

    /// The value as it was given.
    pub fn value(&self) -> &str {
        &self.value
    }

    /// `key` as it is written where this override comes from.
    pub(super) fn name_of(&self, key: &str) -> String {
        match self.origin {
            OverrideOrigin::CommandLine => key.to_owned(),
            OverrideOrigin::Environment => {
                format!("{PREFIX}{}", key.replace('.', SEPARATOR).to_uppercase())
            }
        }
    }
}

impl fmt::Display for Override {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let start = match self.origin {
            OverrideOrigin::CommandLine => "--set ",
            OverrideOrigin::Environment => "",
        };
        write!(f, "{start}{}={}", self.name_of(&self.key), self.value)
    }
}

/// The overrides in force, each key once.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Overrides(Vec<Override>);

impl Overrides {
    /// All of `given`, of which a later one takes precedence over an earlier one of the same key.
    pub fn new(given: impl IntoIterator<Item = Override>) -> Self {
        let mut list: Vec<Override> = Vec::new();
        for one in given {
            list.retain(|earlier| earlier.key != one.key);
            list.push(one);
        }
        Self(list)
    }

    /// The overrides in the order in which they were given.
    pub fn all(&self) -> &[Override] {
        &self.0
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The override of `key`, or of the list that the value `key` is in, such as `fde.q` for `fde.q[1]`.
    pub(super) fn of(&self, key: &str) -> Option<&Override> {
        let is = |own: &str| {
            key.strip_prefix(own).is_some_and(|rest| rest.is_empty() || rest.starts_with('['))
        };
        self.0.iter().find(|one| is(&one.key))
    }
}
