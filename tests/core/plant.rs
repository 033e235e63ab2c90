//! The hydraulic plant against what its equations say, and against itself with finer steps.

use std::f64::consts::TAU;
use tertius::controller::LookUp;
use tertius::plant::{
    Cylinder, CylinderState, Drive, Friction, Inputs, PASCAL, Parameters, Plant, Supply, Valve,
    Wear,
};
use tertius::simulator::{SUB_STEPS, Tables};

const SAMPLE_TIME: f64 = 0.02;
const GRAVITY: f64 = 9.80665;

fn parameters() -> Parameters {
    Tables::default().plant()
}

/// All cylinders in the middle of their stroke, carrying their load.
fn balanced(parameters: &Parameters, sub_steps: u32) -> (Plant, Inputs) {
    let mut plant = Plant::new(parameters, SAMPLE_TIME / f64::from(sub_steps), 0.0);
    let inputs = Inputs {
        spools: [0.0; 6],
        loads: parameters.spread.load,
        accelerations: [GRAVITY; 6],
        ..Inputs::default()
    };
    for leg in 0..6 {
        let pressure = plant.cylinders()[leg].balance(0.0, inputs.loads[leg], GRAVITY);
        plant.states_mut()[leg].pressure = pressure;
    }
    (plant, inputs)
}

/// Sixty seconds of spools that swing as in a sea, through their overlap at different times.
fn swung(sub_steps: u32) -> Vec<[CylinderState; 6]> {
    let (mut plant, mut inputs) = balanced(&parameters(), sub_steps);
    let sample = |k: u32| {
        let time = f64::from(k) * SAMPLE_TIME;
        inputs.spools = std::array::from_fn(|leg| {
            let phase = leg as f64;
            0.018 + 0.3 * (TAU * time / 8.0 + phase).sin() + 0.1 * (TAU * time / 3.1 - phase).sin()
        });
        inputs.accelerations =
            std::array::from_fn(|leg| GRAVITY + 0.5 * (TAU * time / 8.0 + 2.0 * leg as f64).sin());
        plant.run(&inputs, sub_steps);
        *plant.states()
    };
    (0..3000).map(sample).collect()
}

fn largest(
    a: &[[CylinderState; 6]],
    b: &[[CylinderState; 6]],
    of: fn(&CylinderState) -> f64,
) -> f64 {
    let pairs = a.iter().flatten().zip(b.iter().flatten());
    pairs.map(|(a, b)| (of(a) - of(b)).abs()).fold(0.0, f64::max)
}

/// After a minute without feedback, in which errors of the speed add up, half the step changes the
/// lengths by less than a tenth of the transducers' count of 0.1 mm; a quarter changes them by less
/// again.
#[test]
fn half_the_sub_step_changes_little_and_a_quarter_less() {
    let [coarse, half, quarter] = [SUB_STEPS, 2 * SUB_STEPS, 4 * SUB_STEPS].map(swung);
    let moved = coarse.iter().flatten().map(|state| state.length.abs()).fold(0.0, f64::max);
    assert!((0.5..1.4).contains(&moved), "it moves, and meets no end: {moved} m");
    let length = |state: &CylinderState| state.length;
    let (first, second) = (largest(&coarse, &half, length), largest(&half, &quarter, length));
    assert!(first < 1e-5, "{first:e} m");
    assert!(second < 0.75 * first, "{second:e} m after {first:e} m");
    let speed = largest(&coarse, &half, |state| state.speed);
    assert!(speed < 1e-3, "{speed:e} m/s");
    let pressure = largest(&coarse, &half, |state| state.pressure);
    assert!(pressure < 1.0, "{pressure:e} bar");
}

#[test]
fn the_same_inputs_give_the_same_states() {
    assert_eq!(swung(SUB_STEPS), swung(SUB_STEPS));
}

fn friction() -> Friction {
    Friction { viscous: 4e4, coulomb: 2e3, stiction: 1e3, stribeck_speed: 0.02 }
}

/// (3-13): at the least speed Coulomb's and static friction, then falling, then viscous.
#[test]
fn the_stribeck_curve_falls_and_rises_and_is_odd() {
    let friction = friction();
    assert!((friction.force(1e-9) - 3e3).abs() < 0.1);
    let at = |speed: f64| 4e4 * speed + 2e3 + 1e3 * (-speed / 0.02).exp();
    for speed in [0.001, 0.01, 0.02, 0.1, 0.5, 2.0] {
        assert!((friction.force(speed) - at(speed)).abs() < 1e-3, "at {speed}");
        assert_eq!(friction.force(-speed), -friction.force(speed));
    }
    assert!(friction.force(0.005) < friction.force(0.0001), "the jump at rest");
    assert_eq!(friction.force(0.0), 0.0, "at rest there is what holds");
}

/// One cylinder without valve flow, leakage or supply to speak of.
fn closed(change: impl FnOnce(&mut Parameters)) -> (Cylinder, f64) {
    let mut parameters = parameters();
    parameters.cylinder.leakage = 0.0;
    parameters.cylinder.stiffness = 0.0;
    parameters.spread.load = [1.0; 6];
    change(&mut parameters);
    let sub_step = 1e-3;
    (Cylinder::new(&parameters, 0, sub_step), sub_step)
}

fn pushed(cylinder: &Cylinder, force: f64) -> CylinderState {
    let mut state = CylinderState {
        pressure: force / (parameters().cylinder.piston_area * PASCAL),
        ..CylinderState::default()
    };
    let drive =
        Drive { spool: 0.0, load: 1.0, acceleration: 0.0, supply: 240.0, wear: Wear::default() };
    for _ in 0..10 {
        cylinder.step(&mut state, &drive);
    }
    state
}

/// (3-10), with the minimum around |F_ext|: what is pushed less than static friction stays, to the
/// bit and in either direction; a little more, and it goes where it is pushed.
#[test]
fn a_piston_sticks_until_it_is_pushed_harder_than_static_friction() {
    let (cylinder, _) = closed(|parameters| parameters.friction = friction());
    for sign in [1.0, -1.0] {
        let held = pushed(&cylinder, sign * 2990.0);
        assert_eq!((held.length, held.speed), (0.0, 0.0));
        let moved = pushed(&cylinder, sign * 3010.0);
        assert!(moved.length * sign > 0.0 && moved.speed * sign > 0.0, "{moved:?}");
    }
}

/// A piston that friction brings to rest rests, and does not creep back.
#[test]
fn a_moving_piston_comes_to_rest_and_stays() {
    let (cylinder, _) = closed(|parameters| {
        parameters.friction = friction();
        // Hardly any spring: friction alone.
        parameters.cylinder.pressure_rise = 1.0;
    });
    let mut state = CylinderState { speed: 0.05, ..CylinderState::default() };
    let drive =
        Drive { spool: 0.0, load: 1.0, acceleration: 0.0, supply: 240.0, wear: Wear::default() };
    let mut rest = None;
    for step in 0..2000 {
        cylinder.step(&mut state, &drive);
        if state.speed == 0.0 {
            rest.get_or_insert((step, state.length));
        }
    }
    let (step, length) = rest.expect("it comes to rest");
    // 0.05 m/s lost at 2 to 5 kN on 10 t.
    assert!((80..300).contains(&step), "{step} ms");
    assert_eq!(state.length, length);
}

/// Oil as a spring: ω² = A_p α / m, (3-8) with (3-9). A heavier load swings more slowly.
#[test]
fn a_load_on_locked_oil_swings_at_its_natural_frequency() {
    for load in [1.0, 2.0] {
        let (cylinder, sub_step) = closed(|parameters| {
            parameters.friction =
                Friction { viscous: 0.0, coulomb: 0.0, stiction: 0.0, stribeck_speed: 0.02 };
        });
        let table = parameters().cylinder;
        let expected =
            (table.piston_area * PASCAL * table.pressure_rise / (table.load_mass * load)).sqrt();
        let drive =
            Drive { spool: 0.0, load, acceleration: 0.0, supply: 240.0, wear: Wear::default() };
        let mut state = CylinderState { speed: 0.1, ..CylinderState::default() };
        let (mut crossings, mut last, mut first) = (0, 0.0, None);
        for step in 1..5000 {
            let before = state.speed;
            cylinder.step(&mut state, &drive);
            if before < 0.0 && state.speed >= 0.0 {
                last = f64::from(step) * sub_step;
                first.get_or_insert(last);
                crossings += 1;
            }
        }
        let period = (last - first.expect("it swings")) / f64::from(crossings - 1);
        assert!((TAU / period / expected - 1.0).abs() < 2e-3, "{period} s, load {load}");
    }
}

#[test]
fn the_valve_is_progressive_leaks_in_its_overlap_and_follows_the_square_root() {
    let table = parameters().valve;
    let valve = Valve::new(&table, [1.0, 1.0], 240.0);
    assert_eq!(valve.flow(0.0, 0.0, 240.0), 0.0);
    let leak = valve.opening(0.5 * table.overlap);
    assert!(leak > 0.0 && leak < table.leakage, "{leak}");
    assert!((valve.opening(table.overlap) - table.leakage).abs() < 1e-15);
    assert!((valve.opening(1.0) - 1.0).abs() < 1e-12);
    let gain = |spool: f64| valve.opening(spool + 1e-4) - valve.opening(spool);
    assert!(gain(0.9) > 2.0 * gain(0.05), "progressive");
    let spools = (-100..100).map(|percent| f64::from(percent) / 100.0);
    let flows: Vec<f64> = spools.map(|spool| valve.flow(spool, 50.0, 240.0)).collect();
    assert!(flows.windows(2).all(|pair| pair[0] < pair[1]), "monotonous");
    // (3-7): a quarter of the pressure difference, half the flow; the load helps on the way in.
    let out = |load| valve.flow(0.5, load, 240.0);
    assert!((out(180.0) / out(0.0) - 0.5).abs() < 1e-12);
    assert!(valve.flow(-0.5, 50.0, 240.0).abs() > valve.flow(-0.5, 0.0, 240.0).abs());
    assert_eq!(out(300.0), 0.0, "no flow against the pressure");
    assert!((out(0.0) - 1.0 * table.extend_speed * valve.opening(0.5)).abs() < 1e-12);
}

#[test]
fn the_supply_sags_under_flow_and_recovers() {
    let table = parameters().supply;
    let sag = |gas_volume: f64| {
        let mut supply = Supply::new(&tertius::plant::SupplyTable { gas_volume, ..table });
        // Twice what the pump can give, for two seconds.
        (0..1000).for_each(|_| supply.step(2.0 * table.pump_flow, [0.0; 2], 2e-3));
        supply
    };
    let mut supply = sag(table.gas_volume);
    let low = supply.pressure();
    assert!(low < table.pressure - 10.0 && low > 100.0, "{low} bar");
    assert!(sag(4.0 * table.gas_volume).pressure() > low, "more gas holds it up");
    // The gas of an accumulator without a pump: P V is constant, so 1/P grows with what is taken.
    let mut alone = Supply::new(&tertius::plant::SupplyTable { pump_gain: 0.0, ..table });
    (0..1000).for_each(|_| alone.step(0.03, [0.0; 2], 2e-3));
    let mut failed = Supply::new(&table);
    (0..1000).for_each(|_| failed.step(0.03, [1.0, 0.0], 2e-3));
    assert_eq!(failed.pressure(), alone.pressure(), "a pump that is lost is none");
    let expected = table.pressure * table.gas_volume / (table.gas_volume + 0.03 * 2.0);
    assert!((alone.pressure() - expected).abs() < 0.1, "{} of {expected} bar", alone.pressure());
    (0..30_000).for_each(|_| supply.step(0.0, [0.0; 2], 2e-3));
    assert!((supply.pressure() - table.pressure).abs() < 0.5, "{} bar", supply.pressure());
}

/// Gas that exchanges no heat is stiffer, and a pump that lags is late.
#[test]
fn the_accumulator_s_gas_keeps_its_exponent_and_the_pump_its_lag() {
    let table = parameters().supply;
    let alone = |exponent: f64| {
        let of = tertius::plant::SupplyTable { exponent, pump_gain: 0.0, ..table };
        let mut supply = Supply::new(&of);
        (0..1000).for_each(|_| supply.step(0.03, [0.0; 2], 2e-3));
        supply.pressure()
    };
    for exponent in [1.0, 1.25, 1.4] {
        let grown = (table.gas_volume + 0.06) / table.gas_volume;
        let expected = table.pressure / grown.powf(exponent);
        assert!((alone(exponent) - expected).abs() < 0.1, "{exponent}: {} bar", alone(exponent));
    }
    // So much gas that the pressure stays where it is: after one time constant the pump gives 1 − 1/e.
    let pump_lag = 0.2;
    let of = tertius::plant::SupplyTable { pump_lag, gas_volume: 1e6, ..table };
    let mut supply = Supply::new(&of);
    let (before, too_low) = (supply.pressure(), [0.0, -0.01]);
    (0..200).for_each(|_| supply.step(0.0, too_low, 1e-3));
    let after = supply.pressure();
    supply.step(0.0, too_low, 1e-3);
    let pumped = (supply.pressure() - after) * 1e6 / (1e-3 * before);
    let whole = table.pump_gain * 0.01 * before;
    assert!((pumped / whole - 0.632).abs() < 0.01, "{} of the whole", pumped / whole);
}

/// All share one supply: what five cylinders take, the sixth lacks.
#[test]
fn a_cylinder_feels_what_the_others_take() {
    let alone = |others: f64| {
        let (mut plant, mut inputs) = balanced(&parameters(), SUB_STEPS);
        inputs.spools = [others; 6];
        inputs.spools[2] = 0.6;
        (0..100).for_each(|_| plant.run(&inputs, SUB_STEPS));
        (plant.states()[2].length, plant.supply_pressure())
    };
    let ((far, high), (near, low)) = (alone(0.0), alone(0.6));
    assert!(low < high - 5.0, "{low} {high} bar");
    assert!(near < far && near > 0.8 * far, "{near} {far} m");
}

/// The controller's table is the inverse of the flow curve: the piston goes as fast as it is told.
#[test]
fn the_look_up_table_makes_the_speed_that_is_asked_for() {
    for (leg, speed) in (0..6).flat_map(|leg| [-0.6, -0.2, -0.05, 0.05, 0.2, 0.6].map(|v| (leg, v)))
    {
        let (mut plant, mut inputs) = balanced(&parameters(), SUB_STEPS);
        let cylinder = &plant.cylinders()[leg];
        let pressure = cylinder.balance(0.0, inputs.loads[leg], GRAVITY);
        let table = LookUp::of(cylinder, 1.2, pressure, plant.supply_pressure());
        inputs.spools[leg] = table.spool(speed);
        (0..50).for_each(|_| plant.run(&inputs, SUB_STEPS));
        let found = plant.states()[leg].speed;
        // Friction, the sag and the table's straight pieces are left.
        let error = (found - speed).abs();
        assert!(error < 0.06 * speed.abs() + 0.006, "{found} of {speed} m/s");
    }
}

#[test]
fn the_piston_stops_at_the_ends_and_leaves_them() {
    let (mut plant, mut inputs) = balanced(&parameters(), SUB_STEPS);
    let [low, high] = parameters().cylinder.ends;
    inputs.spools = [-0.6; 6];
    (0..500).for_each(|_| plant.run(&inputs, SUB_STEPS));
    assert!(plant.states().iter().all(|state| state.length == low && state.speed == 0.0));
    assert!((0..6).all(|leg| {
        let [bottom, rod] = plant.chamber_pressures(leg);
        bottom >= 0.0 && rod <= plant.supply_pressure() + 1e-9
    }));
    inputs.spools = [0.6; 6];
    (0..500).for_each(|_| plant.run(&inputs, SUB_STEPS));
    assert!(plant.states().iter().all(|state| state.length == high && state.speed == 0.0));
}
