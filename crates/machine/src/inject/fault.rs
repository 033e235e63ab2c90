//! A fault as a person writes it: `step,cylinder=3,sensor=c1,at=60,size=0.00175,until=65`.

use super::kind::{AILMENTS, KINDS, Key, Kind, Rule, nearest};
use super::shape::{Code, Shape, Window};
use crate::plant::{Ailment, MOST_LATE};
use tertius_core::time::Span;

/// The signals of a cylinder that can have a fault: the keys of `[signals.cylinder]`.
pub const SENSORS: [&str; 11] = [
    "c1",
    "c1_velocity",
    "c1_status",
    "c1_counter",
    "c2",
    "c2_velocity",
    "c2_status",
    "c2_counter",
    "control_speed",
    "pressure_bottom",
    "pressure_rod",
];

/// What the CANopen devices of a cylinder say of themselves, which can have a fault, too: the state in a
/// heartbeat, and the error code of an emergency message.
pub const SERVICES: [&str; 6] = [
    "c1_heartbeat",
    "c1_emergency",
    "c2_heartbeat",
    "c2_emergency",
    "valve_heartbeat",
    "valve_emergency",
];

/// The sensor of a fault of the machine itself, which has none.
pub const MACHINE: &str = "machine";

/// All sensors that can have a fault.
fn sensors() -> impl Iterator<Item = &'static str> {
    SENSORS.into_iter().chain(SERVICES)
}

/// A fault of one signal of one cylinder, not yet placed on the bus.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fault {
    /// Cylinder number, counted from 1.
    pub cylinder: u8,
    /// Sensor with the fault, one of [`SENSORS`] or [`SERVICES`], or [`MACHINE`].
    pub sensor: &'static str,
    pub wanted: Wanted,
    pub window: Window,
}

/// The requested fault, some of which depends on the signal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Wanted {
    Shape(Shape),
    /// A value out of range; `None`: just above the valid range.
    OutOfRange(Option<Code>),
    /// A broken wire's raw code; `None`: the one that is configured.
    BrokenWire(Option<i64>),
    /// A fault of the machine itself.
    Machine(Ailment),
}

/// What is wrong with the text of a fault: what was found, and what was expected.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SpecError {
    #[error(
        "no fault is called {given:?}{}; there are {}",
        hint(*.nearest),
        names(.known.iter())
    )]
    Kind { given: String, nearest: Option<&'static str>, known: Vec<&'static str> },
    #[error("{given:?} is not of the form key=value, such as size=0.00175")]
    Form { given: String },
    #[error("{kind} has no key {given:?}{}; it has {}", hint(*.nearest), names(.known.iter()))]
    Key {
        kind: &'static str,
        given: String,
        nearest: Option<&'static str>,
        known: Vec<&'static str>,
    },
    #[error("{key} is given twice")]
    Twice { key: &'static str },
    #[error("{kind} needs {key} ({what})")]
    Missing { kind: &'static str, key: &'static str, what: &'static str },
    #[error("{key} is {given:?}, expected {expected}")]
    Value { key: &'static str, given: String, expected: &'static str },
    #[error("there is no sensor {given:?}{}; there are {}", hint(*.nearest), names(sensors()))]
    Sensor { given: String, nearest: Option<&'static str> },
    #[error("until ({until} s) is not after at ({at} s)")]
    Until { at: String, until: String },
    #[error("value and raw are both given, expected one of them")]
    TwoValues,
}

fn hint(nearest: Option<&'static str>) -> String {
    nearest.map_or(String::new(), |near| format!(" (nearest: {near})"))
}

fn names(names: impl Iterator<Item = impl AsRef<str>>) -> String {
    names.map(|name| name.as_ref().to_owned()).collect::<Vec<_>>().join(", ")
}

impl Fault {
    /// Reads `KIND,key=value,…`: the kind first, then its keys in any order, blanks around them
    /// ignored. Every kind has `cylinder`, `sensor` (default c1), `at` (s since the first frame,
    /// default 0) and `until` (s, exclusive; default: to the end); [`super::grammar`] lists the
    /// others.
    ///
    /// # Errors
    /// The first thing wrong with it.
    pub fn parse(text: &str) -> Result<Self, SpecError> {
        let mut parts = text.split(',').map(str::trim);
        // `split` gives at least one part.
        let kind = find_kind(parts.next().unwrap_or_default())?;
        let mut values = KeyValues::new(kind);
        for part in parts {
            let form = || SpecError::Form { given: part.to_owned() };
            let (key, value) = part.split_once('=').ok_or_else(form)?;
            values.add(key.trim(), value.trim())?;
        }
        values.fault()
    }
}

impl SpecError {
    /// The same where only readings can have faults: offers no kinds of the machine itself.
    #[must_use]
    pub fn of_readings(self) -> Self {
        match self {
            Self::Kind { given, .. } => Self::kind(&given, &KINDS.each_ref().map(|kind| kind.name)),
            other => other,
        }
    }

    fn kind(given: &str, known: &[&'static str]) -> Self {
        let nearest = nearest(given, known.iter().copied());
        Self::Kind { given: given.to_owned(), nearest, known: known.to_vec() }
    }
}

/// The kind of that name.
pub(super) fn find_kind(given: &str) -> Result<&'static Kind, SpecError> {
    let all = || super::kind::names().collect::<Vec<_>>();
    Kind::find(given).ok_or_else(|| SpecError::kind(given, &all()))
}

/// The keys and values that were given for a kind.
pub(super) struct KeyValues<'a> {
    kind: &'static Kind,
    given: Vec<(&'static str, &'a str)>,
}

impl<'a> KeyValues<'a> {
    pub fn new(kind: &'static Kind) -> Self {
        Self { kind, given: Vec::new() }
    }

    pub fn add(&mut self, key: &str, value: &'a str) -> Result<(), SpecError> {
        let Some(key) = self.kind.keys().find(|known| *known == key) else {
            return Err(SpecError::Key {
                kind: self.kind.name,
                given: key.to_owned(),
                nearest: nearest(key, self.kind.keys()),
                known: self.kind.keys().collect(),
            });
        };
        if self.text(key).is_some() {
            return Err(SpecError::Twice { key });
        }
        self.given.push((key, value));
        Ok(())
    }

    pub fn fault(&self) -> Result<Fault, SpecError> {
        Ok(Fault {
            cylinder: self.cylinder()?,
            sensor: self.sensor()?,
            wanted: self.wanted()?,
            window: self.window()?,
        })
    }

    fn text(&self, key: &str) -> Option<&'a str> {
        self.given.iter().find(|(known, _)| *known == key).map(|(_, value)| *value)
    }

    fn missing(&self, key: &'static str, what: &'static str) -> SpecError {
        SpecError::Missing { kind: self.kind.name, key, what }
    }

    fn cylinder(&self) -> Result<u8, SpecError> {
        let given = self.text("cylinder").ok_or_else(|| self.missing("cylinder", "from 1"))?;
        given.parse().ok().filter(|cylinder| *cylinder > 0).ok_or_else(|| SpecError::Value {
            key: "cylinder",
            given: given.to_owned(),
            expected: "the number of a cylinder, from 1",
        })
    }

    fn sensor(&self) -> Result<&'static str, SpecError> {
        if AILMENTS.contains(self.kind) {
            return self.machine();
        }
        let given = self.text("sensor").unwrap_or("c1");
        let known = sensors().find(|sensor| sensor.eq_ignore_ascii_case(given));
        known.ok_or_else(|| SpecError::Sensor {
            given: given.to_owned(),
            nearest: nearest(given, sensors()),
        })
    }

    /// The machine, for a fault that is no sensor's.
    fn machine(&self) -> Result<&'static str, SpecError> {
        match self.text("sensor") {
            Some(given) if !given.eq_ignore_ascii_case(MACHINE) => Err(SpecError::Value {
                key: "sensor",
                given: given.to_owned(),
                expected: "none: it is a fault of the machine, and no sensor's",
            }),
            _ => Ok(MACHINE),
        }
    }

    fn window(&self) -> Result<Window, SpecError> {
        let at = self.seconds("at")?.unwrap_or(Span::ZERO);
        let until = self.seconds("until")?;
        if until.is_some_and(|until| until <= at) {
            let text = |key| self.text(key).unwrap_or("0").to_owned();
            return Err(SpecError::Until { at: text("at"), until: text("until") });
        }
        Ok(Window { from: at, until })
    }

    /// A time since the first frame; a century is enough for any recording.
    fn seconds(&self, key: &'static str) -> Result<Option<Span>, SpecError> {
        let Some(given) = self.text(key) else { return Ok(None) };
        let seconds = given.parse().ok().filter(|seconds| (0.0..=3.2e9).contains(seconds));
        seconds.map(|seconds| Some(Span::from_seconds(seconds))).ok_or_else(|| SpecError::Value {
            key,
            given: given.to_owned(),
            expected: "seconds since the first frame, such as 60 or 259.98",
        })
    }

    fn wanted(&self) -> Result<Wanted, SpecError> {
        Ok(Wanted::Shape(match self.kind.name {
            "step" => Shape::Step { size: self.number("size")? },
            "noise" => Shape::Noise { size: self.number("size")? },
            "incipient" => Shape::Incipient { size: self.number("size")?, b: self.number("b")? },
            "drift" => Shape::Drift { rate: self.number("rate")? },
            "scale" => Shape::Scale { gain: self.number("gain")? },
            "freeze" => Shape::Freeze,
            "spike" => Shape::Spike {
                size: self.number("size")?,
                probability: self.number("probability")?,
            },
            "stale" => Shape::Stale,
            "loss" => Shape::Loss { probability: self.number("probability")? },
            "broken_wire" => return Ok(Wanted::BrokenWire(self.whole("code")?)),
            "out_of_range" => return self.out_of_range(),
            // The kinds are those of the table, and a test asks for each.
            _ => return Ok(Wanted::Machine(self.ailment()?)),
        }))
    }

    fn ailment(&self) -> Result<Ailment, SpecError> {
        // Each has one key.
        let size = self.number(self.kind.keys[0].name)?;
        Ok(match self.kind.name {
            "leakage" => Ailment::Leakage { rate: size },
            "valve_leakage" => Ailment::ValveLeakage { speed: size },
            "sticking" => Ailment::Sticking { band: size },
            "dead_band" => Ailment::DeadBand { size },
            "spool_offset" => Ailment::SpoolOffset { size },
            "null_shift" => Ailment::NullShift { size },
            "supply_loss" => Ailment::SupplyLoss { part: size },
            "friction" => Ailment::Friction { factor: size },
            "late_command" => Ailment::LateCommand { cycles: size as usize },
            // "wrong_command".
            _ => Ailment::WrongCommand { gain: size },
        })
    }

    fn out_of_range(&self) -> Result<Wanted, SpecError> {
        let value = self.optional("value")?.map(Code::Physical);
        let raw = self.whole("raw")?.map(Code::Raw);
        if value.is_some() && raw.is_some() {
            return Err(SpecError::TwoValues);
        }
        Ok(Wanted::OutOfRange(value.or(raw)))
    }

    fn number(&self, name: &'static str) -> Result<f64, SpecError> {
        let key = self.key(name);
        self.optional(name)?.or(key.default).ok_or_else(|| self.missing(name, key.what))
    }

    fn optional(&self, name: &'static str) -> Result<Option<f64>, SpecError> {
        let Some(given) = self.text(name) else { return Ok(None) };
        let rule = self.key(name).rule;
        let sound = |number: &f64| match rule {
            Rule::Finite | Rule::Whole => number.is_finite(),
            Rule::Positive => number.is_finite() && *number > 0.0,
            Rule::Probability => *number > 0.0 && *number <= 1.0,
            Rule::Part => number.abs() <= 1.0,
            Rule::Cycles => number.fract() == 0.0 && (1.0..=MOST_LATE as f64).contains(number),
        };
        given.parse().ok().filter(sound).map(Some).ok_or_else(|| self.refused(name, given))
    }

    fn whole(&self, name: &'static str) -> Result<Option<i64>, SpecError> {
        let Some(given) = self.text(name) else { return Ok(None) };
        given.parse().map(Some).map_err(|_| self.refused(name, given))
    }

    fn refused(&self, name: &'static str, given: &str) -> SpecError {
        let expected = self.key(name).rule.expected();
        SpecError::Value { key: name, given: given.to_owned(), expected }
    }

    fn key(&self, name: &str) -> &'static Key {
        self.kind.key(name).expect("only keys of the kind are asked for; a test asks for each")
    }
}
