//! Flow and friction curves (section 3-3-1) as text.

use super::sheet::{Section, Sheet};
use std::fmt::Write as _;
use tertius_core::text::Millimetres;
use tertius_learn::identify::flow::{FEWEST, FlowCurve, MEMBERSHIPS, NoFlow};
use tertius_learn::identify::friction::{FrictionCurve, NoFriction};
use tertius_learn::identify::nonlinear::Nonlinear;
use tertius_learn::identify::valve::IdentifiedValve;
use tertius_learn::tables::cylinders::by_cylinders;

/// The section of the page.
pub fn section(nonlinear: &Nonlinear) -> String {
    let mut text = flow(nonlinear);
    let valves = valves(nonlinear).text();
    if !valves.is_empty() {
        text += &format!("\n{valves}");
    }
    text += &no_valve(nonlinear);
    text += &friction(nonlinear);
    text
}

/// The valves' curves for a plant, and how each does on the part that was held back.
pub fn valves(nonlinear: &Nonlinear) -> Section {
    let header =
        ["cylinder", "known from", "to", "α bar/m", "β 1/s", "VAF l", "RMS l", "VAF l̇", "RMS l̇"];
    let mut table = Sheet::new(&header);
    for (number, valve) in (1..).zip(&nonlinear.valves) {
        let Ok(IdentifiedValve { curve, reach, score }) = valve else { continue };
        let stiffening = -1.0 / curve.compression;
        let (l, v) = (&score.position, &score.velocity);
        table.add_row([
            format!("{number}"),
            format!("{:.2}", reach[0]),
            format!("{:.2}", reach[1]),
            format!("{stiffening:.0}"),
            format!("{:.2}", -curve.leakage * stiffening),
            format!("{:.3} %", l.vaf()),
            format!("{:.1}", Millimetres(l.rms())),
            format!("{:.3} %", v.vaf()),
            format!("{:.2} mm/s", v.rms() * 1e3),
        ]);
    }
    table.about(
        "valves for a plant (3-15), with leakage and compression beside the curve: spool positions for \
         which they are known; α and β of (3-8); and the rod as they move it by the recorded spool and \
         pressures, open loop (velocity over 0.2 s)",
    )
}

/// Cylinders without a valve for a plant, one line each; one for all of the same reason.
pub fn no_valve(nonlinear: &Nonlinear) -> String {
    let without = (1..).zip(&nonlinear.valves).filter_map(|(number, valve)| {
        let why = valve.as_ref().err()?;
        Some((number, format!("no valve for a plant: {why}")))
    });
    let without: Vec<(u8, String)> = without.collect();
    let told = by_cylinders(without.iter().map(|(number, why)| (*number, &**why)));
    told.into_iter().map(|line| line + "\n").collect()
}

/// Definition of the flow curves, and their data.
pub fn sources(nonlinear: &Nonlinear) -> String {
    let sources = &nonlinear.sources;
    let opening = if sources.spool {
        "x is the recorded spool position, in its unit of the DBC".to_owned()
    } else {
        "no spool position is configured (signals.cylinder.spool): x is the command u (m/s), so \
         that the curve also includes the machine's own look-up table and the valve's lag"
            .to_owned()
    };
    let supply = sources.supply.map_or("P_S as recorded".to_owned(), |bar| {
        format!("P_S taken as constant at {bar} bar, which it is not")
    });
    format!(
        "flow curves f_NL (3-17), (3-18), over the piston area A_p, in mm/s/√bar: {MEMBERSHIPS} \
         triangular membership functions each way\n{opening}; {supply}; without leakage and \
         compression, as (3-17)\n"
    )
}

fn heading(nonlinear: &Nonlinear) -> String {
    format!(
        "\n{}? is not known: fewer than {FEWEST:.0} cycles determine it; ± is a lower bound, since \
         the residuals are not white\n",
        sources(nonlinear)
    )
}

const WAYS: [&str; 2] = ["extending", "retracting"];

fn flow(nonlinear: &Nonlinear) -> String {
    let mut text = heading(nonlinear);
    for (number, curves) in (1..).zip(&nonlinear.flow) {
        if let Some(why) = no_flow_at_all(number, curves) {
            _ = write!(text, "\n{why}\n");
            continue;
        }
        for (way, curve) in WAYS.into_iter().zip(curves) {
            text += &match curve {
                Ok(curve) => one(number, way, curve),
                Err(why) => format!("\ncylinder {number}, {way}: no flow curve: {why}\n"),
            };
        }
    }
    text
}

/// Why there is no curve in either direction, if the reason is the same.
fn no_flow_at_all(number: usize, curves: &[Result<FlowCurve, NoFlow>; 2]) -> Option<String> {
    let [Err(out), Err(back)] = curves else { return None };
    (out == back).then(|| format!("cylinder {number}: no flow curve: {out}"))
}

/// Cylinders and directions without a flow curve, one line each.
pub fn no_flow(nonlinear: &Nonlinear) -> String {
    let mut text = String::new();
    for (number, curves) in (1..).zip(&nonlinear.flow) {
        if let Some(why) = no_flow_at_all(number, curves) {
            _ = writeln!(text, "{why}");
            continue;
        }
        for (way, curve) in WAYS.into_iter().zip(curves) {
            if let Err(why) = curve {
                _ = writeln!(text, "cylinder {number}, {way}: no flow curve: {why}");
            }
        }
    }
    text
}

/// Cylinders without a friction curve, one line each.
pub fn no_friction(nonlinear: &Nonlinear) -> String {
    let without =
        (1..).zip(&nonlinear.friction).filter_map(|(n, it)| Some((n, it.as_ref().err()?)));
    without.map(|(number, why)| none(number, why)).collect()
}

fn one(number: usize, way: &str, curve: &FlowCurve) -> String {
    let mut table = Sheet::new(&["x", "f_NL", "±", "cycles"]);
    for singleton in &curve.singletons {
        let number = |value: Option<f64>, places: usize| {
            value.map_or("?".to_owned(), |value| format!("{:.places$}", 1e3 * value))
        };
        table.add_row([
            format!("{:.4}", singleton.centre),
            number(singleton.value.map(|(value, _)| value), 3),
            number(singleton.value.map(|(_, error)| error), 3),
            format!("{:.0}", singleton.coverage),
        ]);
    }
    format!(
        "\ncylinder {number}, {way}: {} of {MEMBERSHIPS} known, from {} cycles; RMS about the curve \
         {:.3} mm/s/√bar\n{table}\n",
        curve.known(),
        curve.rows,
        1e3 * curve.rms
    )
}

fn friction(nonlinear: &Nonlinear) -> String {
    let mut text = "\nfriction (3-13), (3-19) from stretches of constant velocity in monitored \
                    states, over the piston area A_p, in bar\n"
        .to_owned();
    for (number, curve) in (1..).zip(&nonlinear.friction) {
        match curve {
            Ok(curve) => text += &stribeck(number, curve),
            Err(why) => text += &none(number, why),
        }
    }
    text
}

fn none(number: usize, why: &NoFriction) -> String {
    format!("cylinder {number}: no friction curve: {why}\n")
}

fn stribeck(number: usize, curve: &FrictionCurve) -> String {
    let mut table = Sheet::new(&["speed mm/s", "friction bar", "deviation", "stretches"]);
    for point in &curve.points {
        table.add_row([
            format!("{:.2}", 1e3 * point.velocity),
            format!("{:.3}", point.force),
            format!("{:.3}", point.deviation),
            point.stretches.to_string(),
        ]);
    }
    format!("\ncylinder {number}: {}\n{table}\n", stribeck_line(curve))
}

/// The parameters of (3-13).
pub fn stribeck_line(curve: &FrictionCurve) -> String {
    let stiction = curve
        .stribeck
        .map_or("no static friction shows at these speeds".to_owned(), |(force, speed)| {
            format!("F_s0 {force:.3} bar, c_s {:.2} mm/s", 1e3 * speed)
        });
    format!(
        "μ_v {:.3} bar s/m, F_c0 {:.3} bar, {stiction}; {} stretches, RMS {:.3} bar",
        curve.viscous, curve.coulomb, curve.stretches, curve.rms
    )
}
