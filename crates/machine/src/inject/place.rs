//! Finds where on the bus a fault is: the configured signal and its DBC.

use super::fault::{Fault, Wanted};
use super::kind::nearest;
use super::placed::{PlaceError, Placed};
use super::service;
use super::shape::{Code, Shape};
use tertius_config::settings::{CylinderSignals, Settings, bus_of};
use tertius_core::decode::{Raw, SignalPlan};
use tertius_core::frame::BusNumber;
use tertius_dbc::{Database, Signal};

/// Overflow code of an S7 analogue input, used where none is configured.
const BROKEN_WIRE: i64 = 32767;

/// Finds the signal of `fault`.
///
/// # Errors
/// The machine does not have the signal, or it cannot be out of range as requested.
pub fn place(
    fault: &Fault,
    settings: &Settings,
    database: &Database,
) -> Result<Placed, PlaceError> {
    let cylinders = settings.machine.cylinders;
    if !(1..=cylinders).contains(&fault.cylinder) {
        return Err(PlaceError::Cylinder { given: fault.cylinder, cylinders });
    }
    if let Wanted::Machine(_) = fault.wanted {
        return Err(PlaceError::Machine);
    }
    let sensor = fault.sensor;
    if let Some(placed) = service::place(fault, settings, database) {
        return placed;
    }
    let signals = &settings.signals.cylinder;
    let Some((_, pattern)) = signals.named().find(|(key, _)| *key == sensor) else {
        let named = signals.named().map(|(key, _)| key);
        return Err(PlaceError::Sensor { sensor, nearest: nearest(sensor, named) });
    };
    if settings.signals_of(fault.cylinder).all(|(key, _)| key != sensor) {
        return Err(PlaceError::NotFitted { sensor, cylinder: fault.cylinder });
    }
    let name = CylinderSignals::of_cylinder(pattern, fault.cylinder);
    let (bus, name) = bus_of(&name).unwrap_or((BusNumber::First, &name));
    let (message, signal) =
        database.signal(name).map_err(|error| PlaceError::Lookup { sensor, error })?;
    if bus == BusNumber::First && settings.own_identifiers().contains(&message.id) {
        return Err(PlaceError::OwnFrame { signal: name.to_owned(), id: message.id });
    }
    let is_position = matches!(sensor, "c1" | "c2");
    let shape = match fault.wanted {
        Wanted::Shape(shape) => shape,
        Wanted::Machine(_) => return Err(PlaceError::Machine),
        Wanted::BrokenWire(code) => {
            let configured = settings.broken_wire_codes(signal).first().copied();
            Shape::Constant(Code::Raw(code.or(configured).unwrap_or(BROKEN_WIRE)))
        }
        Wanted::OutOfRange(code) => {
            let valid = Valid::new(settings, signal, is_position);
            Shape::Constant(valid.beyond(name, &signal.plan, code)?)
        }
    };
    Ok(Placed { bus, id: message.id, plan: signal.plan.clone(), shape, window: fault.window })
}

/// The range that the monitor takes for valid.
struct Valid {
    /// Range of raw codes, both ends inclusive.
    codes: Option<[i64; 2]>,
    /// Range of values in the signal's unit, both ends inclusive.
    values: Option<[f64; 2]>,
}

impl Valid {
    fn new(settings: &Settings, signal: &Signal, is_position: bool) -> Self {
        if !is_position {
            return Self { codes: None, values: signal.range };
        }
        let codes = settings.plausibility.valid_raw;
        Self { codes, values: Some(settings.valid_lengths(signal)) }
    }

    /// The requested value, or one just above the range; refused if it is within the range.
    fn beyond(
        &self,
        name: &str,
        plan: &SignalPlan,
        asked: Option<Code>,
    ) -> Result<Code, PlaceError> {
        let code = match (asked, self.codes, self.values) {
            (Some(code), ..) => code,
            (None, Some([_, highest]), _) => Code::Raw(highest.saturating_add(1)),
            // A tenth of the range: far from what rounding to a count could undo.
            (None, None, Some([low, high])) => Code::Physical(high + 0.1 * (high - low)),
            (None, None, None) => return Err(PlaceError::NoRange { signal: name.to_owned() }),
        };
        let (raw, reading) = as_read(plan, code);
        let code_valid = self
            .codes
            .zip(raw)
            .is_none_or(|([low, high], raw)| (i128::from(low)..=i128::from(high)).contains(&raw));
        // A limit in decimals lies beside its count by rounding.
        let slack = if plan.is_float() { 0.0 } else { 0.5 * plan.factor().abs() };
        let value_valid =
            self.values.is_none_or(|[low, high]| (low - slack..=high + slack).contains(&reading));
        let anything_valid = self.codes.is_none() && self.values.is_none();
        if code_valid && value_valid && !anything_valid {
            let valid = match (self.codes, self.values) {
                (Some([low, high]), _) => format!("raw {low} to {high}"),
                (None, Some([low, high])) => format!("{low} to {high}"),
                (None, None) => String::new(),
            };
            let reading = raw.map_or(format!("{reading}"), |raw| format!("{reading} (raw {raw})"));
            return Err(PlaceError::WithinRange { signal: name.to_owned(), reading, valid });
        }
        Ok(code)
    }
}

/// The reading of a frame with `code`: the raw number of an integer signal, and the value.
fn as_read(plan: &SignalPlan, code: Code) -> (Option<i128>, f64) {
    let wanted = match code {
        Code::Raw(raw) => raw as f64,
        Code::Physical(value) => plan.unscaled(value),
    };
    let Some((low, high)) = plan.raw_limits() else {
        return (None, plan.physical(Raw::Float(wanted)));
    };
    let raw = match code {
        Code::Raw(raw) => i128::from(raw),
        Code::Physical(_) => wanted.round_ties_even() as i128,
    };
    let raw = raw.clamp(low, high);
    (Some(raw), plan.physical(Raw::Float(raw as f64)))
}
