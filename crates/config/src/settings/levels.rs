//! `[alarm.levels]`: the keys and words for the levels of findings.

use serde::Deserialize;
use tertius_core::alarm::{Level, Levels};

/// The fields of [`Levels`] as the keys of their table.
#[derive(Deserialize)]
#[serde(remote = "Levels", deny_unknown_fields, default = "Levels::default")]
pub struct LevelsTable {
    #[serde(with = "LevelName")]
    located: Level,
    #[serde(with = "LevelName")]
    undecided: Level,
    #[serde(with = "LevelName")]
    process: Level,
    #[serde(with = "LevelName")]
    implausible: Level,
    #[serde(with = "LevelName")]
    both: Level,
    #[serde(with = "LevelName")]
    critical: Level,
}

/// The words for [`Level`].
#[derive(Deserialize)]
#[serde(remote = "Level", rename_all = "lowercase")]
enum LevelName {
    None,
    Yellow,
    Orange,
    Red,
    Black,
}

/// Type that the table is read into where a test asks for its keys.
#[cfg(test)]
#[derive(Deserialize)]
#[serde(transparent)]
pub struct ReadLevels {
    #[serde(with = "LevelsTable")]
    _read: Levels,
}
