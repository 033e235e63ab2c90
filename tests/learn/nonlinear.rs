//! Flow and friction curves against a plant whose curves are known, and against NumPy.

use crate::identify_support::{TS, row};
use serde_json::{Value, json};
use tertius::identify::flow::{Direction, FlowCurve, FlowFit, FlowSources, NoFlow, Scout};
use tertius::identify::friction::{FrictionCurve, NoFriction, Stretches};
use tertius::plant::{Inputs, Parameters, Plant};
use tertius::sea::GRAVITY;
use tertius::simulator::Tables;
use tertius::survey::{Row, Surveyor};
use tertius_testing::oracle;

const SUB_STEPS: u32 = 20;
pub const SOURCES: FlowSources = FlowSources { spool: true, supply: None, area_ratio: 0.5 };

fn parameters() -> Parameters {
    Tables::default().plant()
}

/// A plant that carries its load without moving, and what acts on it then.
fn balanced() -> (Plant, Inputs) {
    let parameters = parameters();
    let mut plant = Plant::new(&parameters, TS / f64::from(SUB_STEPS), 0.0);
    let loads = parameters.spread.load;
    for (leg, load) in loads.into_iter().enumerate() {
        plant.states_mut()[leg].pressure = plant.cylinders()[leg].balance(0.0, load, GRAVITY);
    }
    (plant, Inputs { loads, accelerations: [GRAVITY; 6], ..Inputs::default() })
}

/// Cylinder `leg` + 1 of `plant`, as faultless transducers have it.
fn seen(plant: &Plant, leg: usize, k: u32) -> Row {
    let state = plant.states()[leg];
    let [bottom, rod] = plant.chamber_pressures(leg);
    Row {
        pressure_bottom: Some(bottom),
        pressure_rod: Some(rod),
        supply: Some(plant.supply_pressure()),
        spool: Some(state.spool),
        ..row(leg as u8 + 1, k, state.length, state.speed, 0.0, 0.0)
    }
}

/// Minutes of a sea with spools within ±0.55, held in the stroke by the position.
pub fn swung(cycles: u32) -> Vec<Row> {
    let (mut plant, mut inputs) = balanced();
    let mut rows = Vec::new();
    for k in 0..cycles {
        let t = f64::from(k) * TS;
        let lengths = plant.states().map(|state| state.length);
        inputs.spools = std::array::from_fn(|leg| {
            let phase = leg as f64;
            let swing = 0.40 * (0.9 * t + phase).sin() + 0.16 * (2.3 * t - phase).sin();
            swing - 0.1 * lengths[leg]
        });
        plant.run(&inputs, SUB_STEPS);
        rows.extend((0..6).map(|leg| seen(&plant, leg, k)));
    }
    rows
}

fn flow(rows: &[Row], sources: FlowSources) -> Vec<[Result<FlowCurve, NoFlow>; 2]> {
    let mut scout = Scout::new(6, sources);
    rows.iter().for_each(|row| scout.row(row));
    let mut fit = FlowFit::new(&scout);
    rows.iter().for_each(|row| fit.row(row));
    fit.curves()
}

/// f_NL over A_p of the plant's own valve: its flow at 1 bar of drop; inwards that of the rod side.
fn truth(plant: &Plant, leg: usize, x: f64) -> f64 {
    plant.cylinders()[leg].valve().flow(x, 0.0, 1.0)
        * if x > 0.0 { 1.0 } else { SOURCES.area_ratio }
}

/// Within 2.5 % of the largest flow that was covered: leakage and compression, which (3-17) leaves
/// out, take some of it.
#[test]
fn the_flow_curve_is_that_of_the_plants_valve() {
    let rows = swung(9000);
    let (plant, _) = balanced();
    for (leg, curves) in flow(&rows, SOURCES).iter().enumerate() {
        for curve in curves {
            let curve = curve.as_ref().expect("both ways are covered");
            assert!(curve.known() >= 15, "cylinder {}: {curve:?}", leg + 1);
            let known = || curve.singletons.iter().filter_map(|it| Some((it.centre, it.value?.0)));
            let largest = known().map(|(x, _)| truth(&plant, leg, x).abs()).fold(0.0, f64::max);
            let worst = known()
                .map(|(x, value)| (value - truth(&plant, leg, x)).abs() / largest)
                .fold(0.0, f64::max);
            println!("cylinder {}: {:.2} % of {largest:.4}", leg + 1, 100.0 * worst);
            assert!(worst < 0.025, "cylinder {}: {worst} of {largest}: {curve:?}", leg + 1);
        }
    }
}

/// The spread of the valves (Figure 3-8) shows: cylinder 6 passes more outwards than cylinder 2.
#[test]
fn every_cylinder_has_its_own_curve() {
    let curves = flow(&swung(6000), SOURCES);
    let at = |leg: usize, way: Direction, x: f64| {
        curves[leg][way as usize].as_ref().expect("covered").at(x).expect("known")
    };
    let ratio = at(5, Direction::Extend, 0.3) / at(1, Direction::Extend, 0.3);
    let spread = parameters().spread;
    assert!((ratio - spread.extend[5] / spread.extend[1]).abs() < 0.03, "{ratio}");
}

#[test]
fn the_singletons_are_those_of_numpy_on_the_same_memberships() {
    let rows: Vec<Row> = swung(4000).into_iter().filter(|row| row.cylinder == 1).collect();
    let signals: Vec<[f64; 4]> = rows
        .iter()
        .map(|row| {
            let load = row.load_pressure(SOURCES.area_ratio).expect("known");
            [row.spool.unwrap(), row.v1.unwrap(), row.supply.unwrap(), load]
        })
        .collect();
    let input = json!({"signals": signals, "area_ratio": SOURCES.area_ratio});
    let answer: Value = serde_json::from_str(&oracle::run("flow.py", &[], &input.to_string()))
        .expect("the oracle answers in JSON");
    let mut compared = 0;
    for (theirs, curve) in answer.as_array().expect("two").iter().zip(&flow(&rows, SOURCES)[0]) {
        let curve = curve.as_ref().expect("covered");
        let number = |key: &str, j: usize| theirs[key][j].as_f64().expect("a number");
        let largest = (0..20).map(|j| number("values", j).abs()).fold(0.0, f64::max);
        for (j, singleton) in curve.singletons.iter().enumerate() {
            assert!((singleton.centre - number("centres", j)).abs() < 1e-12);
            let Some((value, _)) = singleton.value else { continue };
            assert!((value - number("values", j)).abs() < 1e-10 * largest, "{j}: {curve:?}");
            compared += 1;
        }
    }
    assert!(compared >= 30, "{compared} singletons were compared");
}

/// A second's worth of rows far out is not a curve there, and does not bend what is nearer.
#[test]
fn what_the_data_hardly_visit_is_not_known() {
    let mut rows = swung(6000);
    let before = flow(&rows, SOURCES);
    let mut far = rows[0];
    (far.spool, far.v1) = (Some(0.99), Some(9.0));
    rows.push(far);
    let after = flow(&rows, SOURCES)[0][0].clone().expect("still covered");
    let last = after.singletons[19];
    assert!(last.value.is_none() && last.coverage == 1.0, "{last:?}");
    assert!(after.at(0.98).is_none() && after.at(1.5).is_none());
    let before = before[0][0].as_ref().expect("covered");
    let [old, new] = [before, &after].map(|curve| curve.at(0.3).expect("known"));
    assert!((old - new).abs() < 0.02 * old, "{old} {new}");
}

#[test]
fn what_is_missing_is_named() {
    let rows = swung(200);
    let missing = |change: fn(&mut Row)| {
        let mut rows = rows.clone();
        rows.iter_mut().for_each(change);
        let curves = flow(&rows, SOURCES);
        curves[0][0].as_ref().expect_err("something is missing").to_string()
    };
    type Change = fn(&mut Row);
    let cases: [(Change, &str); 5] = [
        (|row| row.pressure_rod = None, "signals.cylinder.pressure_bottom and pressure_rod"),
        (|row| row.supply = None, "signals.supply"),
        (|row| row.v1 = None, "signals.cylinder.c1_velocity"),
        (|row| row.spool = None, "signals.cylinder.spool"),
        (|row| row.monitored = false, "monitored state"),
    ];
    for (change, words) in cases {
        let told = missing(change);
        assert!(told.contains(words), "{words:?} is not in: {told}");
    }
    let given = FlowSources { supply: Some(240.0), ..SOURCES };
    let mut rows = swung(2000);
    rows.iter_mut().for_each(|row| row.supply = None);
    assert!(flow(&rows, given)[0][0].is_ok(), "a constant stands in for what is not recorded");
}

const SPEEDS: [f64; 8] = [0.012, 0.018, 0.025, 0.04, 0.07, 0.11, 0.16, 0.22];

/// Strokes at constant velocity of cylinder 1 out and in, on a vessel at rest or in waves.
pub fn strokes(waves: f64) -> Vec<Row> {
    let (mut plant, mut inputs) = balanced();
    let mut rows = Vec::new();
    let (load, supply) = (plant.states()[0].pressure, plant.supply_pressure());
    for speed in SPEEDS {
        for way in [-1.0, 1.0, 1.0, -1.0] {
            let (mut low, mut high) = (-1.0, 1.0);
            for _ in 0..50 {
                let middle = 0.5 * (low + high);
                let settled = plant.cylinders()[0].settled_speed(middle, load, supply);
                if settled < way * speed { low = middle } else { high = middle }
            }
            let cycles = (0.7 / speed / TS).min(900.0) as u32;
            for _ in 0..cycles {
                inputs.spools[0] = low;
                let k = rows.len() as u32;
                inputs.accelerations[0] = GRAVITY + waves * (0.7 * f64::from(k) * TS).sin();
                plant.run(&inputs, SUB_STEPS);
                rows.push(seen(&plant, 0, k));
            }
        }
    }
    rows
}

pub fn friction(rows: &[Row]) -> Result<FrictionCurve, NoFriction> {
    let mut stretches = Stretches::new(1, SOURCES.area_ratio);
    rows.iter().for_each(|row| stretches.row(row));
    stretches.curves().remove(0)
}

/// Points within 0.01 bar, that is 20 N of 2 to 12 kN.
#[test]
fn strokes_at_constant_velocity_give_the_stribeck_curve() {
    let curve = friction(&strokes(0.0)).expect("there are strokes");
    let parameters = parameters();
    let bar = parameters.cylinder.piston_area * 1e5;
    println!("{curve:?}");
    assert!(curve.points.len() >= 12, "{curve:?}");
    for point in &curve.points {
        let expected = parameters.friction.force(point.velocity) / bar;
        assert!((point.force - expected).abs() < 0.01, "{point:?}, expected {expected}");
    }
    let near = |found: f64, truth: f64| (found - truth).abs() < 0.01 * truth;
    let friction = parameters.friction;
    assert!(near(curve.viscous, friction.viscous / bar), "{curve:?}");
    assert!(near(curve.coulomb, friction.coulomb / bar), "{curve:?}");
    let (_, speed) = curve.stribeck.expect("the slow strokes show it");
    assert!((speed - friction.stribeck_speed).abs() < 0.03 * friction.stribeck_speed, "{curve:?}");
}

#[test]
fn a_sea_gives_no_friction_curve_and_it_is_said_why() {
    let rows: Vec<Row> = swung(6000).into_iter().filter(|row| row.cylinder == 1).collect();
    let why = friction(&rows).expect_err("nothing is constant").to_string();
    assert!(why.contains("with the vessel at rest"), "{why}");
    let why = friction(&strokes(1.5)).expect_err("the load swings").to_string();
    assert!(why.contains("Figure 3-10") || why.contains("stretches"), "{why}");
    let bare: Vec<Row> = rows.iter().map(|row| Row { pressure_rod: None, ..*row }).collect();
    assert_eq!(friction(&bare), Err(NoFriction::NoPressure));
}
