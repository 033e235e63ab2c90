//! The kinds of faults that can be requested, with their keys.

/// A key of a fault.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Key {
    pub name: &'static str,
    /// Meaning of the key, with its unit.
    pub what: &'static str,
    pub rule: Rule,
    /// Default; `None`: the key must be given, or its kind says what its absence means.
    pub default: Option<f64>,
}

/// Rule for valid numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Rule {
    Finite,
    Positive,
    /// Above 0 and at most 1.
    Probability,
    Whole,
    /// 1 to [`MOST_LATE`].
    Cycles,
    /// Within ±1.
    Part,
}

impl Rule {
    /// What a valid number is, for people.
    pub const fn expected(self) -> &'static str {
        match self {
            Self::Finite => "a number without unit, such as 0.00175 or -2e-3",
            Self::Positive => "a number above 0",
            Self::Probability => "a number above 0 and at most 1",
            Self::Whole => "a whole number",
            Self::Cycles => "a number of cycles, 1 to 15",
            Self::Part => "a part of the whole, -1 to 1",
        }
    }
}

/// A kind of fault.
#[derive(Debug, PartialEq)]
pub(super) struct Kind {
    pub name: &'static str,
    /// Another name for the kind, in use elsewhere.
    pub alias: Option<&'static str>,
    pub what: &'static str,
    pub keys: &'static [Key],
}

const fn key(name: &'static str, what: &'static str, rule: Rule, default: Option<f64>) -> Key {
    Key { name, what, rule, default }
}

const PROBABILITY: &str = "of each frame, above 0 to 1";

pub(super) const KINDS: [Kind; 11] = [
    Kind {
        name: "step",
        alias: Some("abrupt"),
        what: "Type I: adds size",
        keys: &[key("size", "m", Rule::Finite, None)],
    },
    Kind {
        name: "noise",
        alias: None,
        what: "Type II: adds size × −1, 0 or 1, drawn for each frame",
        keys: &[key("size", "m", Rule::Finite, None)],
    },
    Kind {
        name: "incipient",
        alias: None,
        what: "Type III: adds size × (1 − (1 + b)^−(t − at)), t in s",
        keys: &[
            key("size", "m", Rule::Finite, None),
            key("b", "evolution rate", Rule::Positive, Some(1.0)),
        ],
    },
    Kind {
        name: "drift",
        alias: None,
        what: "adds rate × (t − at)",
        keys: &[key("rate", "m/s", Rule::Finite, None)],
    },
    Kind {
        name: "scale",
        alias: None,
        what: "adds gain × the reading",
        keys: &[key("gain", "1", Rule::Finite, None)],
    },
    Kind { name: "freeze", alias: Some("stuck"), what: "holds the last reading", keys: &[] },
    Kind {
        name: "spike",
        alias: None,
        what: "adds size to single frames",
        keys: &[
            key("size", "m", Rule::Finite, None),
            key("probability", PROBABILITY, Rule::Probability, None),
        ],
    },
    Kind {
        name: "out_of_range",
        alias: None,
        what: "always value or raw, by default just above the valid range",
        keys: &[
            key("value", "m", Rule::Finite, None),
            key("raw", "as in the frame", Rule::Whole, None),
        ],
    },
    Kind {
        name: "broken_wire",
        alias: None,
        what: "always the code of a broken wire",
        keys: &[key("code", "raw; default: as configured", Rule::Whole, None)],
    },
    Kind {
        name: "stale",
        alias: None,
        what: "repeats the whole last frame, its counter included",
        keys: &[],
    },
    Kind {
        name: "loss",
        alias: None,
        what: "drops the signal's frames",
        keys: &[key("probability", PROBABILITY, Rule::Probability, Some(1.0))],
    },
];

/// Keys that every kind has.
pub(super) const COMMON: [&str; 4] = ["cylinder", "sensor", "at", "until"];

const fn of_the_machine(name: &'static str, what: &'static str, keys: &'static [Key]) -> Kind {
    Kind { name, alias: None, what, keys }
}

/// Faults of the machine itself; each has one key, its size.
pub(super) const AILMENTS: [Kind; 10] = [
    of_the_machine(
        "leakage",
        "the piston leaks: adds rate to β of (3-8)",
        &[key(
            "rate",
            "1/s; 1 is 3.4 mm/s at 24 bar on the built-in machine",
            Rule::Positive,
            None,
        )],
    ),
    of_the_machine(
        "valve_leakage",
        "worn edges: the valve leaks in its middle",
        &[key("speed", "m/s of the piston at 24 bar", Rule::Positive, None)],
    ),
    of_the_machine(
        "sticking",
        "the spool stays until its command is so far away",
        &[key("band", SPOOL, Rule::Probability, None)],
    ),
    of_the_machine(
        "dead_band",
        "the ports open later",
        &[key("size", SPOOL, Rule::Probability, None)],
    ),
    of_the_machine(
        "spool_offset",
        "the spool stands beside its command",
        &[key("size", SPOOL, Rule::Part, None)],
    ),
    of_the_machine(
        "null_shift",
        "the spool's null is elsewhere",
        &[key("size", SPOOL, Rule::Part, None)],
    ),
    of_the_machine(
        "supply_loss",
        "the pump's set point falls, for all cylinders",
        &[key("part", "of the supply pressure; 1 is a pump that stands", Rule::Probability, None)],
    ),
    of_the_machine(
        "friction",
        "all friction is factor times the usual",
        &[key("factor", "1", Rule::Positive, None)],
    ),
    of_the_machine(
        "late_command",
        "the valve gets its command late",
        &[key("cycles", "1 to 15", Rule::Cycles, Some(1.0))],
    ),
    of_the_machine(
        "wrong_command",
        "the valve does 1 + gain times its command",
        &[key("gain", "1", Rule::Part, None)],
    ),
];

const SPOOL: &str = "part of the spool's stroke";

/// All kinds that have a name.
pub(super) fn names() -> impl Iterator<Item = &'static str> {
    KINDS.iter().chain(&AILMENTS).map(|kind| kind.name)
}

impl Kind {
    /// The kind of that name, letter case and hyphens ignored.
    pub fn find(name: &str) -> Option<&'static Self> {
        let name = name.to_ascii_lowercase().replace('-', "_");
        KINDS.iter().chain(&AILMENTS).find(|kind| kind.name == name || kind.alias == Some(&name))
    }

    pub fn key(&self, name: &str) -> Option<&'static Key> {
        self.keys.iter().find(|key| key.name == name)
    }

    /// All keys that this kind may have.
    pub fn keys(&self) -> impl Iterator<Item = &'static str> {
        COMMON.into_iter().chain(self.keys.iter().map(|key| key.name))
    }
}

/// All kinds of faults of readings with their keys and units, one line each, for a person.
pub fn grammar() -> String {
    lines(&KINDS)
}

/// The same for faults of the machine itself.
pub fn machine_grammar() -> String {
    lines(&AILMENTS)
}

fn lines(kinds: &[Kind]) -> String {
    let mut text = String::new();
    for kind in kinds {
        let keys: Vec<String> = kind
            .keys
            .iter()
            .map(|key| match key.default {
                Some(default) => format!("{} ({}; default {default})", key.name, key.what),
                None => format!("{} ({})", key.name, key.what),
            })
            .collect();
        let keys = if keys.is_empty() { String::new() } else { format!("; {}", keys.join(", ")) };
        text += &format!("  {:<13} {}{keys}\n", kind.name, kind.what);
    }
    text
}

/// The candidate most similar to `given`, if any is similar at all.
pub(super) fn nearest(
    given: &str,
    candidates: impl Iterator<Item = &'static str>,
) -> Option<&'static str> {
    const SIMILAR: f64 = 0.4;
    // The comparison takes time with the product of both lengths.
    let given: String = given.chars().take(40).collect::<String>().to_lowercase();
    candidates
        .map(|name| (strsim::normalized_damerau_levenshtein(&given, name), name))
        .filter(|(similarity, _)| *similarity >= SIMILAR)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, name)| name)
}
