//! Valves and friction that were identified on a machine, in the place of the plant's own.

use super::PASCAL;
use super::friction::Friction;
use serde::Deserialize;
use tertius_config::settings::{CylinderNonlinear, FlowTable, Stribeck, ValveCurve, ValveFlow};

/// Largest leakage, 1/s.
const MOST_LEAKAGE: f64 = 100.0;

/// Least part of the spool's stroke that a curve has to cover.
const LEAST_STROKE: f64 = 0.01;

/// One cylinder as it was identified.
#[derive(Clone, Debug, PartialEq)]
pub struct Identified {
    /// Cylinder number, counted from 1.
    pub number: u8,
    /// `None`: the valve, the leakage and the stiffening of the plant's tables.
    pub flow: Option<IdentifiedFlow>,
    /// Friction over the piston's area; `None`: that of the plant's tables.
    pub friction: Option<Stribeck>,
}

/// Flow of one cylinder by the position of its spool and its pressures: the third row of (3-15).
#[derive(Clone, Debug, PartialEq)]
pub struct IdentifiedFlow {
    /// f, by the part of the spool's stroke.
    pub valve: ValveFlow,
    /// α of (3-8), bar/m.
    pub stiffening: f64,
    /// β of (3-8), 1/s.
    pub leakage: f64,
}

/// The part of a file that says what was identified; other keys are somebody else's.
#[derive(Deserialize)]
struct File {
    #[serde(default)]
    cylinder: Vec<Table>,
}

#[derive(Deserialize)]
struct Table {
    n: u8,
    nonlinear: Option<CylinderNonlinear>,
    process: Option<Relations>,
}

#[derive(Deserialize)]
struct Relations {
    flow: Option<FlowTable>,
}

/// Whether `text` has `[[cylinder]]` tables, as a configuration and what is learnt for it have. A plant has one table of
/// that name.
pub fn is_identified(text: &str) -> bool {
    let table = text.parse::<toml::Table>();
    table.is_ok_and(|table| table.get("cylinder").is_some_and(toml::Value::is_array))
}

/// The identified cylinders in the text of a file that `identify --nonlinear` wrote, or of a configuration that has such
/// tables. A cylinder without a flow curve takes that of its process detector. `full` is the spool's signal at full stroke.
///
/// # Errors
/// What is wrong with the text, or that there are none.
pub fn identified(text: &str, full: f64) -> Result<Vec<Identified>, String> {
    let file: File = toml::from_str(text).map_err(|error| error.to_string())?;
    let mut found = Vec::new();
    for Table { n, nonlinear, process } in file.cylinder {
        let (curve, friction) =
            nonlinear.map_or((None, None), |table| (table.flow, table.friction));
        let relation = || Some(ValveCurve::from(&process?.flow?));
        let flow = curve.or_else(relation).map(|curve| flow(&curve, full)).transpose();
        let flow = flow.map_err(|why| format!("cylinder {n}: {why}"))?;
        if flow.is_some() || friction.is_some() {
            found.push(Identified { number: n, flow, friction });
        }
    }
    if found.is_empty() {
        return Err("has no [cylinder.nonlinear]; `tertius identify --nonlinear --output` writes \
                    it"
        .to_owned());
    }
    Ok(found)
}

fn flow(curve: &ValveCurve, full: f64) -> Result<IdentifiedFlow, String> {
    let (limit, least) = (curve.limit, LEAST_STROKE * full);
    if !(least..=full).contains(&limit) {
        return Err(format!(
            "the spool goes to {limit}, expected {least} to {full}, which is the simulated spool's full stroke \
             (sensors.spool_full of the plant)"
        ));
    }
    if curve.samples.len() + 1 != curve.curve.len() {
        let [samples, values] = [curve.samples.len(), curve.curve.len()];
        return Err(format!("{samples} counts of samples for {values} knots, expected one fewer"));
    }
    let valve = curve.flow().ok_or("its flow curve was not taught on both sides of rest")?;
    let [inward, outward] = valve.reach();
    if !(valve.at(inward) < 0.0 && valve.at(outward) > 0.0) {
        return Err("its flow curve does not rise".to_owned());
    }
    let stiffening = -1.0 / curve.compression;
    if !(1.0..=1e5).contains(&stiffening) {
        return Err(format!(
            "compression is {}, expected -1 to -1e-5 m per bar",
            curve.compression
        ));
    }
    // Oil that flows from the lower pressure to the higher one is an error of what was measured.
    let leakage = (-curve.leakage * stiffening).max(0.0);
    if leakage > MOST_LEAKAGE {
        return Err(format!("leakage is {}, expected -0.1 to 0.1 m/s per bar", curve.leakage));
    }
    Ok(IdentifiedFlow { valve: valve.scaled(1.0 / full), stiffening, leakage })
}

/// The friction of a piston of `area`, m².
pub(super) fn friction(identified: &Stribeck, area: f64) -> Friction {
    let newtons = area * PASCAL;
    Friction {
        viscous: identified.viscous * newtons,
        coulomb: identified.coulomb * newtons,
        stiction: identified.stiction * newtons,
        stribeck_speed: identified.stribeck_speed,
    }
}
