//! `[alarm.levels]`: the keys and words for the levels of findings.

use crate::schema::{Kind, Scalar, table};
use serde::Deserialize;
use tertius_core::alarm::{Level, Levels};

const fn level() -> Kind {
    Kind::One(Scalar::Choice(&["none", "yellow", "orange", "red", "black"]))
}

table! {
    /// The fields of [`Levels`] as the keys of their table.
    pub struct LevelsTable = LEVELS {
        located: Level as LevelName = Levels::default().located => level(),
            "\"yellow\"", "one transducer is blamed by its FDE";
        undecided: Level as LevelName = Levels::default().undecided => level(),
            "\"yellow\"", "R3 beyond its bound, location not decided";
        process: Level as LevelName = Levels::default().process => level(),
            "\"yellow\"", "both observers disagree with readings that agree with each other";
        implausible: Level as LevelName = Levels::default().implausible => level(),
            "\"orange\"", "a reading is stale, out of range, frozen or has a broken wire";
        both: Level as LevelName = Levels::default().both => level(),
            "\"black\"", "neither transducer can be relied on";
        soon: Level as LevelName = Levels::default().soon => level(),
            "\"orange\"", "the machine trips, or the supply no longer carries the load, within alarm.soon";
        at_once: Level as LevelName = Levels::default().at_once => level(),
            "\"red\"", "the same within alarm.at_once";
        critical: Level as LevelName = Levels::default().critical => level(),
            "\"black\"", "the measured C1 - C2 beyond the critical limit";
    }
}

impl From<LevelsTable> for Levels {
    fn from(table: LevelsTable) -> Self {
        let LevelsTable { located, undecided, process, implausible, both, soon, at_once, critical } =
            table;
        Self { located, undecided, process, implausible, both, soon, at_once, critical }
    }
}

/// The words for [`Level`].
#[derive(Deserialize)]
#[serde(rename_all = "lowercase")]
enum LevelName {
    None,
    Yellow,
    Orange,
    Red,
    Black,
}

impl From<LevelName> for Level {
    fn from(name: LevelName) -> Self {
        match name {
            LevelName::None => Self::None,
            LevelName::Yellow => Self::Yellow,
            LevelName::Orange => Self::Orange,
            LevelName::Red => Self::Red,
            LevelName::Black => Self::Black,
        }
    }
}
