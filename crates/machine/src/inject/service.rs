//! Faults of what CANopen devices say of themselves.

use super::fault::{Fault, SERVICES, Wanted};
use super::placed::{PlaceError, Placed};
use super::shape::{Code, Shape};
use tertius_config::settings::{Device, Role, Settings};
use tertius_core::decode::{BitField, NumberForm, SignalPlan};
use tertius_core::frame::BusNumber;
use tertius_dbc::Database;

/// EMCY *device hardware*, as of a transducer without its magnet.
const HARDWARE: i64 = 0x5000;

/// NMT state *pre-operational*.
const PRE_OPERATIONAL: i64 = 127;

/// Finds the service of `fault`; `None` if it is of a signal. A broken wire is an error that the device knows
/// of, and out of range is a state in which it does not work.
pub(super) fn place(
    fault: &Fault,
    settings: &Settings,
    database: &Database,
) -> Option<Result<Placed, PlaceError>> {
    let sensor = SERVICES.into_iter().find(|service| *service == fault.sensor)?;
    let (role, service) = sensor.split_once('_')?;
    let missing = PlaceError::Service { sensor, cylinder: fault.cylinder };
    let is_it = |device: &&Device| {
        device.cylinder == fault.cylinder && device.role.map_or("valve", Role::name) == role
    };
    let device = settings.devices().iter().find(is_it);
    let services = device.and_then(|device| database.device_services(&device.name()));
    let (id, bits) = match service {
        "heartbeat" => (services.and_then(|services| services.heartbeat), 8),
        _ => (services.and_then(|services| services.emergency), 16),
    };
    let Some(id) = id else { return Some(Err(missing)) };
    let Ok(field) = BitField::new(0, bits, false, false) else { return Some(Err(missing)) };
    let shape = match fault.wanted {
        Wanted::Shape(shape) => shape,
        Wanted::Machine(_) => return None,
        Wanted::OutOfRange(code) => Shape::Constant(code.unwrap_or(Code::Raw(PRE_OPERATIONAL))),
        Wanted::BrokenWire(code) => Shape::Constant(Code::Raw(code.unwrap_or(HARDWARE))),
    };
    let plan = SignalPlan::new(field, NumberForm::Integer, 1.0, 0.0, Box::new([]));
    Some(Ok(Placed { bus: BusNumber::First, id, plan, shape, window: fault.window }))
}
