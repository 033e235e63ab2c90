//! Units. A monitor reckons in metres, metres per second and bar; what a DBC has in another unit that is known is read
//! as if it had these.

use super::settings::{CylinderSignals, Settings};
use super::text::bus_of;
use tertius_dbc::Database;

/// A unit by its name in a DBC, and by how much its numbers become those of the first one: times and per.
type Unit = (&'static str, [f64; 2]);

const LENGTHS: [Unit; 9] = [
    ("m", [1.0, 1.0]),
    ("dm", [1.0, 10.0]),
    ("cm", [1.0, 100.0]),
    ("mm", [1.0, 1e3]),
    ("um", [1.0, 1e6]),
    ("µm", [1.0, 1e6]),
    ("μm", [1.0, 1e6]),
    ("in", [254.0, 1e4]),
    ("inch", [254.0, 1e4]),
];

const SPEEDS: [Unit; 7] = [
    ("m/s", [1.0, 1.0]),
    ("dm/s", [1.0, 10.0]),
    ("cm/s", [1.0, 100.0]),
    ("mm/s", [1.0, 1e3]),
    ("m/min", [1.0, 60.0]),
    ("mm/min", [1.0, 6e4]),
    ("in/s", [254.0, 1e4]),
];

const PRESSURES: [Unit; 7] = [
    ("bar", [1.0, 1.0]),
    ("mbar", [1.0, 1e3]),
    ("Pa", [1.0, 1e5]),
    ("hPa", [1.0, 1e3]),
    ("kPa", [1.0, 100.0]),
    ("MPa", [10.0, 1.0]),
    ("psi", [6_894.757_293_168_361, 1e5]),
];

/// Signals that are read in another unit than the DBC gives them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Converted {
    /// Names, in the order of the cylinders.
    pub signals: Vec<String>,
    pub from: String,
    pub to: &'static str,
}

/// What makes metres of a length, or metres per second of a speed, or bar of a pressure, in `unit`: times and per.
/// `None` where the unit is not known.
pub fn conversion(unit: &str) -> Option<[f64; 2]> {
    [&LENGTHS[..], &SPEEDS, &PRESSURES].into_iter().find_map(|units| known(units, unit))
}

/// Reads the machine's lengths, speeds and pressures in metres, metres per second and bar, where the DBC has another unit
/// that is known. A spool's unit is its own.
pub fn convert(settings: &Settings, database: &mut Database) -> Vec<Converted> {
    let of_cylinders = (1..=settings.machine.cylinders).flat_map(|n| {
        settings.signals_of(n).filter_map(move |(key, name)| {
            Some((units_of(key)?, CylinderSignals::of_cylinder(name, n)))
        })
    });
    let supply = settings.signals.supply.iter().map(|name| (&PRESSURES[..], name.clone()));
    let mut all: Vec<Converted> = Vec::new();
    for (units, name) in of_cylinders.chain(supply) {
        let bare = bus_of(&name).map_or(name.as_str(), |(_, bare)| bare);
        let Ok((_, signal)) = database.signal(bare) else { continue };
        let (from, to) = (signal.unit.clone(), units[0].0);
        let Some(factor) = known(units, &from).filter(|_| from != to) else { continue };
        database.rescale(bare, to, factor);
        match all.iter_mut().find(|it| (&*it.from, it.to) == (&*from, to)) {
            Some(alike) => alike.signals.push(name),
            None => all.push(Converted { signals: vec![name], from, to }),
        }
    }
    all
}

/// The units of what the key of a cylinder's signal stands for, that of the monitor first.
fn units_of(key: &str) -> Option<&'static [Unit]> {
    match key {
        "c1" | "c2" => Some(&LENGTHS),
        "c1_velocity" | "c2_velocity" | "control_speed" => Some(&SPEEDS),
        "pressure_bottom" | "pressure_rod" | "load_pressure" => Some(&PRESSURES),
        _ => None,
    }
}

fn known(units: &[Unit], unit: &str) -> Option<[f64; 2]> {
    units.iter().find(|(name, _)| *name == unit.trim()).map(|(_, factor)| *factor)
}
