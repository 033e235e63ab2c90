//! Valid ranges of a machine's numbers. Outside them the integration would fail, or no such machine
//! exists.

use super::disturbance::Disturbance;
use super::tables::{TableError, Tables};
use super::top::TopTable;
use crate::plant::ValveTable;
use crate::sea::Response;
use crate::transducer::{CYLINDERS, Errors, Ripple};
use std::f64::consts::TAU;

/// A number above any that is meant, and below any that overflows.
const MUCH: f64 = 1e9;

/// Checks that every number of `tables` is within its range.
///
/// # Errors
/// The first number that is not.
pub fn ranges(tables: &Tables) -> Result<(), TableError> {
    hexapod(tables)?;
    sea(tables)?;
    plant(tables)?;
    disturbance(&tables.disturbance)?;
    controller(tables)?;
    transducers(tables)
}

fn within(key: &str, value: f64, [low, high]: [f64; 2]) -> Result<(), TableError> {
    if (low..=high).contains(&value) {
        return Ok(());
    }
    Err(TableError::Range { key: key.to_owned(), value, low, high })
}

fn all_within(rows: &[(&str, f64, [f64; 2])]) -> Result<(), TableError> {
    rows.iter().try_for_each(|(key, value, range)| within(key, *value, *range))
}

fn each_within(key: &str, values: &[f64], range: [f64; 2]) -> Result<(), TableError> {
    values.iter().try_for_each(|value| within(key, *value, range))
}

fn ordered(key: &'static str, value: [f64; 2]) -> Result<(), TableError> {
    ordered_within(key, value, [-100.0, 100.0])
}

fn ordered_within(key: &'static str, value: [f64; 2], range: [f64; 2]) -> Result<(), TableError> {
    each_within(key, &value, range)?;
    if value[0] < value[1] { Ok(()) } else { Err(TableError::Order { key, value }) }
}

fn hexapod(tables: &Tables) -> Result<(), TableError> {
    let it = &tables.hexapod;
    let (size, angle) = ([0.01, 100.0], [0.0, 1.0]);
    ordered("hexapod.reach", it.reach)?;
    all_within(&[
        ("hexapod.base_radius", it.base_radius, size),
        ("hexapod.base_half_angle", it.base_half_angle, angle),
        ("hexapod.top_radius", it.top_radius, size),
        ("hexapod.top_half_angle", it.top_half_angle, angle),
        ("hexapod.neutral_height", it.neutral_height, size),
    ])
}

fn sea(tables: &Tables) -> Result<(), TableError> {
    let (sea, vessel) = (&tables.sea, &tables.vessel);
    all_within(&[
        ("sea.height", sea.height, [0.0, 20.0]),
        ("sea.period", sea.period, [2.0, 30.0]),
        ("sea.peakedness", sea.peakedness, [1.0, 10.0]),
        ("gangway.load", tables.gangway.load, [0.0, 0.5]),
        ("gangway.period", tables.gangway.period, [1.0, MUCH]),
        ("gangway.length", tables.gangway.length, [0.0, 1000.0]),
    ])?;
    response("vessel.surge", &vessel.surge)?;
    response("vessel.sway", &vessel.sway)?;
    response("vessel.heave", &vessel.heave)?;
    response("vessel.roll", &vessel.roll)?;
    response("vessel.pitch", &vessel.pitch)?;
    response("vessel.yaw", &vessel.yaw)
}

fn response(key: &str, it: &Response) -> Result<(), TableError> {
    within(&format!("{key}.gain"), it.gain, [-100.0, 100.0])?;
    within(&format!("{key}.natural_period"), it.natural_period, [0.1, 1000.0])?;
    within(&format!("{key}.damping"), it.damping, [0.01, 10.0])?;
    within(&format!("{key}.phase"), it.phase, [-10.0, 10.0])
}

fn plant(tables: &Tables) -> Result<(), TableError> {
    let (cylinder, friction) = (&tables.cylinder, &tables.friction);
    let (supply, spread) = (&tables.supply, &tables.spread);
    ordered("cylinder.ends", cylinder.ends)?;
    all_within(&[
        ("cylinder.piston_area", cylinder.piston_area, [1e-4, 1.0]),
        ("cylinder.area_ratio", cylinder.area_ratio, [0.05, 1.0]),
        ("cylinder.stiffness", cylinder.stiffness, [0.0, 1e6]),
        ("cylinder.load_mass", cylinder.load_mass, [1.0, 1e6]),
        ("cylinder.pressure_rise", cylinder.pressure_rise, [1.0, 1e5]),
        ("cylinder.leakage", cylinder.leakage, [0.0, 100.0]),
        ("friction.viscous", friction.viscous, [0.0, 1e7]),
        ("friction.coulomb", friction.coulomb, [0.0, 1e6]),
        ("friction.stiction", friction.stiction, [0.0, 1e6]),
        ("friction.stribeck_speed", friction.stribeck_speed, [1e-3, 10.0]),
        ("supply.pressure", supply.pressure, [10.0, 1000.0]),
        ("supply.pump_gain", supply.pump_gain, [0.0, 1.0]),
        ("supply.pump_flow", supply.pump_flow, [0.0, 10.0]),
        ("supply.gas_volume", supply.gas_volume, [0.01, 1000.0]),
        ("supply.exponent", supply.exponent, [1.0, 1.7]),
        ("supply.pump_lag", supply.pump_lag, [0.0, 10.0]),
    ])?;
    valve("valve", &tables.valve)?;
    if let Some(chambers) = &tables.chambers {
        within("chambers.leakage", chambers.leakage, [-1.0, 1.0])?;
        within("chambers.mismatch", chambers.mismatch, [-100.0, 100.0])?;
        within("chambers.time", chambers.time, [1e-3, 10.0])?;
    }
    if let Some(thermal) = &tables.thermal {
        within("thermal.viscosity", thermal.viscosity, [0.0, 0.9])?;
        within("thermal.leakage", thermal.leakage, [0.0, 0.9])?;
        within("thermal.flow", thermal.flow, [0.0, 0.5])?;
        within("thermal.overlap", thermal.overlap, [0.0, 0.9])?;
        within("thermal.period", thermal.period, [60.0, MUCH])?;
    }
    each_within("spread.extend", &spread.extend, [0.1, 10.0])?;
    each_within("spread.retract", &spread.retract, [0.1, 10.0])?;
    each_within("spread.load", &spread.load, [0.1, 10.0])
}

fn valve(key: &str, it: &ValveTable) -> Result<(), TableError> {
    within(&format!("{key}.lag"), it.lag, [1e-3, 10.0])?;
    within(&format!("{key}.overlap"), it.overlap, [1e-6, 0.5])?;
    within(&format!("{key}.progression"), it.progression, [0.0, 1.0])?;
    within(&format!("{key}.leakage"), it.leakage, [0.0, 0.5])?;
    within(&format!("{key}.extend_speed"), it.extend_speed, [0.01, 100.0])?;
    within(&format!("{key}.retract_speed"), it.retract_speed, [0.01, 100.0])
}

fn disturbance(it: &Disturbance) -> Result<(), TableError> {
    let time = [0.0, MUCH];
    if let Some(load) = &it.load {
        ordered_within("disturbance.load.time", load.time, time)?;
        within("disturbance.load.part", load.part, [0.1, 10.0])?;
    }
    if let Some(steps) = &it.load_steps {
        ordered_within("disturbance.load_steps.time", steps.time, time)?;
        within("disturbance.load_steps.part", steps.part, [0.0, 0.9])?;
        within("disturbance.load_steps.every", steps.every, [0.1, MUCH])?;
        within("disturbance.load_steps.within", steps.within, [0.0, 1000.0])?;
    }
    if let Some(pump) = &it.pump {
        ordered_within("disturbance.pump.time", pump.time, time)?;
        within("disturbance.pump.part", pump.part, [0.0, 1.0])?;
    }
    if let Some(sticking) = &it.sticking {
        ordered_within("disturbance.sticking.time", sticking.time, time)?;
        within("disturbance.sticking.band", sticking.band, [0.0, 0.5])?;
    }
    if let Some(spikes) = &it.spikes {
        ordered_within("disturbance.spikes.time", spikes.time, time)?;
        each_within("disturbance.spikes.share", &spikes.share, [0.0, 1.0])?;
        within("disturbance.spikes.counts", spikes.counts, [0.0, MUCH])?;
    }
    if let Some(sampling) = &it.sampling {
        ordered_within("disturbance.sampling.time", sampling.time, time)?;
        within("disturbance.sampling.skew", sampling.skew, [-0.1, 0.1])?;
        within("disturbance.sampling.jitter", sampling.jitter, [0.0, 0.1])?;
        within("disturbance.sampling.shared_jitter", sampling.shared_jitter, [0.0, 0.1])?;
    }
    it.valve.as_ref().map_or(Ok(()), |table| valve("disturbance.valve", table))
}

fn controller(tables: &Tables) -> Result<(), TableError> {
    let it = &tables.controller;
    all_within(&[
        ("controller.position", it.position, [0.0, 100.0]),
        ("controller.velocity", it.velocity, [0.0, 10.0]),
        ("controller.pressure", it.pressure, [0.0, 1.0]),
        ("controller.pressure_time", it.pressure_time, [1e-3, MUCH]),
        ("controller.speed_limit", it.speed_limit, [0.01, 100.0]),
        ("controller.stroke_limit", it.stroke_limit, [0.01, 100.0]),
        ("controller.latency", it.latency, [0.0, 1.0]),
        ("controller.safe_spool", it.safe_spool, [-1.0, 1.0]),
        ("controller.settled_speed", it.settled_speed, [-10.0, 10.0]),
        ("controller.transition", it.transition, [0.1, 1000.0]),
        ("controller.dwell", it.dwell, [0.0, 1000.0]),
    ])
}

fn transducers(tables: &Tables) -> Result<(), TableError> {
    let it = &tables.transducer;
    ordered("transducer.range", it.range)?;
    all_within(&[
        ("transducer.noise", it.noise, [0.0, 1.0]),
        ("transducer.fluctuation", it.fluctuation, [0.0, 1.0]),
        ("transducer.fluctuation_probability", it.fluctuation_probability, [0.0, 1.0]),
        ("transducer.fluctuation_time", it.fluctuation_time, [0.0, MUCH]),
        ("transducer.fluctuation_spread", it.fluctuation_spread, [0.0, 1.0]),
        ("transducer.fluctuation_time_spread", it.fluctuation_time_spread, [0.0, 1.0]),
        ("transducer.speed_noise", it.speed_noise, [0.0, 10.0]),
        ("transducer.speed_lag", it.speed_lag, [0.0, 10.0]),
        ("transducer.counts", it.counts, [2.0, MUCH]),
        ("sensors.pressure", tables.sensors.pressure, [0.0, 100.0]),
        ("sensors.supply", tables.sensors.supply, [0.0, 100.0]),
        ("sensors.spool", tables.sensors.spool, [0.0, 0.1]),
        ("sensors.spool_full", tables.sensors.spool_full, [1e-3, MUCH]),
    ])?;
    each_within("sensors.valve_age", &tables.sensors.valve_age, [0.0, 0.02])?;
    top(&tables.sensors.top)?;
    errors("c1", &tables.c1)?;
    errors("c2", &tables.c2)
}

fn top(it: &TopTable) -> Result<(), TableError> {
    each_within("sensors.top.offset", &it.offset, [-0.5, 0.5])?;
    all_within(&[
        ("sensors.top.noise", it.noise, [0.0, 0.1]),
        ("sensors.top.wander", it.wander, [0.0, 0.1]),
        ("sensors.top.period", it.period, [0.0, 10.0]),
        ("sensors.top.latency", it.latency, [0.0, 10.0]),
    ])?;
    let least = if it.wander > 0.0 { 0.1 } else { 0.0 };
    within("sensors.top.wander_time", it.wander_time, [least, MUCH])
}

fn errors(key: &str, it: &Errors) -> Result<(), TableError> {
    each_within(&format!("{key}.offset"), &it.offset, [-1.0, 1.0])?;
    each_within(&format!("{key}.gain"), &it.gain, [-0.5, 0.5])?;
    each_within(&format!("{key}.bow"), &it.bow, [-0.5, 0.5])?;
    each_within(&format!("{key}.skew"), &it.skew, [0.0, 0.1])?;
    let Ripple { amplitudes, lengths, phases } = &it.ripple;
    each_within(&format!("{key}.ripple.amplitudes"), amplitudes.as_flattened(), [0.0, 0.01])?;
    each_within(&format!("{key}.ripple.phases"), phases, [-TAU, TAU])?;
    if *amplitudes != [[0.0; 2]; CYLINDERS] {
        each_within(&format!("{key}.ripple.lengths"), lengths, [0.01, 10.0])?;
    }
    each_within(&format!("{key}.warming.amplitudes"), &it.warming.amplitudes, [-0.01, 0.01])?;
    if it.warming.amplitudes != [0.0; CYLINDERS] {
        within(&format!("{key}.warming.period"), it.warming.period, [60.0, 1e6])?;
    }
    Ok(())
}
