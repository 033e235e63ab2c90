//! A listener that decodes the bus like any other node: frames, by the DBC.

use crate::alarm::e2e;
use crate::cli::Failure;
use crate::config::Settings;
use crate::config::settings::bus_of;
use crate::dbc::{Database, Signal};
use crate::frame::{Frame, Id};

/// Meaning of a frame for the audience.
#[derive(Clone, Debug, PartialEq)]
pub enum Heard {
    /// State of the platform.
    Platform(String),
    Status(Status),
    Warning(Warning),
    /// A frame of the gateway whose CRC is wrong.
    Damaged,
    /// One of the machine's other frames.
    Machine,
    /// A frame that neither the machine nor the gateway should send.
    Stranger,
}

/// Contents of Fd_Status.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Status {
    /// States of C1 and C2 of each cylinder.
    pub states: Vec<[String; 2]>,
    pub level: String,
    pub mode: String,
    pub active: i64,
}

/// Contents of Fd_Warning.
#[derive(Clone, Debug, PartialEq)]
pub struct Warning {
    /// Cylinder number, counted from 1.
    pub cylinder: i64,
    pub detector: String,
    pub fault: String,
    pub suspect: String,
    pub level: String,
    pub raised: bool,
    /// Residual, m; `None` where the detector has none.
    pub residual: Option<f64>,
    /// Threshold; `None` where the detector has none.
    pub threshold: Option<Limit>,
}

/// A threshold as Fd_Warning has it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Limit {
    /// m.
    Of(f64),
    /// Beyond the scale of its byte, which ends at this one, m.
    Above(f64),
}

/// Reads the frames of the bus.
pub struct Listener {
    database: Database,
    status: Own,
    warning: Own,
    /// The platform's state, where the machine sends it.
    platform: Option<(Id, Signal)>,
    /// Number of cylinders that the machine has; Fd_Status has room for more.
    cylinders: usize,
    /// Identifiers that the gateway receives, of which some are in no database: those of devices' services.
    received: Vec<Id>,
}

/// A message of the gateway.
struct Own {
    id: Id,
    signals: Vec<Signal>,
}

impl Listener {
    /// # Errors
    /// A message that the DBC does not have.
    pub fn new(
        settings: &Settings,
        database: &Database,
        received: Vec<Id>,
    ) -> Result<Self, Failure> {
        let own = |name: &str| -> Result<Own, Failure> {
            let message = database.message(name).map_err(|error| {
                Failure::Wrong(format!("{error}; the demonstration reads what the gateway sends"))
            })?;
            Ok(Own { id: message.id, signals: message.signals.clone() })
        };
        let state = settings.signals.state.as_deref();
        let state = state.map(|name| bus_of(name).map_or(name, |(_, name)| name));
        let state = state.and_then(|name| database.signal(name).ok());
        Ok(Self {
            status: own("Fd_Status")?,
            warning: own("Fd_Warning")?,
            platform: state.map(|(message, signal)| (message.id, signal.clone())),
            database: database.clone(),
            cylinders: settings.machine.cylinders.into(),
            received,
        })
    }

    pub fn hear(&self, frame: &Frame) -> Heard {
        for own in [&self.status, &self.warning] {
            // The data ID is the identifier, which has 11 bits.
            if frame.id == own.id && e2e::check(frame.data(), own.id.value() as u16).is_err() {
                return Heard::Damaged;
            }
        }
        if frame.id == self.status.id {
            Heard::Status(self.status(frame))
        } else if frame.id == self.warning.id {
            Heard::Warning(self.warning(frame))
        } else if let Some((_, signal)) = self.platform.as_ref().filter(|(id, _)| *id == frame.id) {
            Heard::Platform(name(signal, frame))
        } else if self.database.message_by_id(frame.id).is_some()
            || self.received.contains(&frame.id)
        {
            Heard::Machine
        } else {
            Heard::Stranger
        }
    }

    fn status(&self, frame: &Frame) -> Status {
        let state = |n: usize, c: usize| self.status.name(&format!("Cyl{n}_C{c}_State"), frame);
        Status {
            states: (1..=self.cylinders).map(|n| [1, 2].map(|c| state(n, c))).collect(),
            level: self.status.name("Level", frame),
            mode: self.status.name("Mode", frame),
            active: self.status.number("ActiveWarnings", frame) as i64,
        }
    }

    fn warning(&self, frame: &Frame) -> Warning {
        let own = &self.warning;
        let detector = own.name("Detector", frame);
        Warning {
            cylinder: own.number("Cylinder", frame) as i64,
            fault: own.name("Fault", frame).replace('_', " "),
            suspect: own.name("Suspect", frame),
            level: own.name("Level", frame),
            raised: own.number("Raised", frame) != 0.0,
            residual: own.signal("Residual").and_then(|signal| residual(signal, frame)),
            threshold: own.signal("Threshold").and_then(|signal| threshold(signal, frame)),
            detector,
        }
    }
}

impl Own {
    fn signal(&self, name: &str) -> Option<&Signal> {
        self.signals.iter().find(|signal| signal.name == name)
    }

    fn number(&self, name: &str, frame: &Frame) -> f64 {
        let value = self.signal(name).and_then(|signal| signal.plan.decode(frame).value());
        value.map_or(f64::NAN, |value| value.physical)
    }

    fn name(&self, name: &str, frame: &Frame) -> String {
        self.signal(name).map_or_else(String::new, |signal| self::name(signal, frame))
    }
}

/// The residual, m; the lowest count stands for none.
fn residual(signal: &Signal, frame: &Frame) -> Option<f64> {
    let value = signal.plan.decode(frame).value()?;
    (value.raw.as_i64() != Some(i16::MIN.into())).then_some(value.physical)
}

/// The threshold: no counts stand for none, and the DBC has a name for those beyond the scale.
fn threshold(signal: &Signal, frame: &Frame) -> Option<Limit> {
    let value = signal.plan.decode(frame).value()?;
    let counts = value.raw.as_i64()?;
    Some(match signal.value_name(counts) {
        Some(_) => Limit::Above(value.physical - signal.plan.factor()),
        None => Limit::Of(value.physical),
    })
    .filter(|_| counts > 0)
}

/// Name of the signal's number in the DBC.
fn name(signal: &Signal, frame: &Frame) -> String {
    let number = signal.plan.decode(frame).value().and_then(|value| value.raw.as_i64());
    let name = number.and_then(|number| signal.value_name(number));
    name.unwrap_or("?").to_owned()
}
