//! Faults of the simulated machine itself, against what its equations say.

use tertius::controller::{Readings, State};
use tertius::inject::{Fault, PlaceError, Wanted, place, table};
use tertius::plant::{Ailment, Cylinder, CylinderState, Drive, Wear};
use tertius::simulator::{Machine, Options, Tables, truth};

const SAMPLE_TIME: f64 = 0.02;
const HYDRAULIC: &str = include_str!("../../config/e-type-hydraulic-plant.toml");

fn fault(text: &str) -> Fault {
    Fault::parse(text).unwrap_or_else(|error| panic!("{text}: {error}"))
}

fn machine(tables: &Tables, faults: &[&str], start: State) -> Machine {
    let ailments = faults.iter().map(|text| fault(text)).collect();
    let options = Options { seed: 3, start, ailments, ..Options::default() };
    let mut machine = Machine::new(tables, SAMPLE_TIME, &options).unwrap();
    machine.request(start);
    machine
}

/// The machine's next cycle: spool of the first cylinder and the command that it gets, both at the Sync.
fn cycle(machine: &mut Machine) -> [f64; 2] {
    let sample = machine.sample();
    let readings = Readings {
        lengths: sample.transducers.map(|pair| pair[0].length),
        speeds: sample.transducers.map(|pair| pair[0].speed),
        pressures: sample.load_pressures,
        pose: sample.motion.pose,
        rate: sample.motion.rate,
    };
    let commands = machine.command(&readings);
    machine.advance();
    [sample.spools[0], commands.spools[0]]
}

/// Largest error of the first cylinder's spool against one that is told `told(commands, k)`.
fn spool_error(fault: &str, told: impl Fn(&[f64], usize, f64) -> f64) -> f64 {
    let tables = Tables::default();
    let mut machine = machine(&tables, &[fault], State::Engaged);
    let (mut spools, mut commands) = (Vec::new(), Vec::new());
    for _ in 0..500 {
        let [spool, command] = cycle(&mut machine);
        spools.push(spool);
        commands.push(command);
    }
    let decay = |time: f64| (-time / tables.valve.lag).exp();
    let [before, after] = [tables.controller.latency, SAMPLE_TIME - tables.controller.latency];
    // It begins where its target has been for long.
    let mut targets = vec![told(&commands, 0, spools[0])];
    let mut largest = 0.0_f64;
    for k in 1..499 {
        targets.push(told(&commands, k, targets[k - 1]));
        let middle = targets[k - 1] + (spools[k] - targets[k - 1]) * decay(before);
        let end = targets[k] + (middle - targets[k]) * decay(after);
        // The first cycles have no older commands.
        if k > 20 {
            largest = largest.max((end - spools[k + 1]).abs());
        }
    }
    largest
}

#[test]
fn a_spool_does_what_its_fault_makes_of_the_command() {
    type Told = fn(&[f64], usize, f64) -> f64;
    let sound: Told = |commands, k, _| commands[k];
    for (text, told) in [
        ("leakage,cylinder=1,rate=1", sound),
        ("spool_offset,cylinder=2,size=0.02", sound),
        ("spool_offset,cylinder=1,size=0.02", |commands, k, _| commands[k] + 0.02),
        ("late_command,cylinder=1", |commands, k, _| commands[k.saturating_sub(1)]),
        ("late_command,cylinder=1,cycles=3", |commands, k, _| commands[k.saturating_sub(3)]),
        ("wrong_command,cylinder=1,gain=-0.1", |commands, k, _| 0.9 * commands[k]),
        ("sticking,cylinder=1,band=0.02", |commands, k, before| {
            if (commands[k] - before).abs() < 0.02 { before } else { commands[k] }
        }),
    ] {
        let error = spool_error(text, told);
        assert!(error < 1e-9, "{text}: {error}");
    }
    assert!(spool_error("sticking,cylinder=1,band=0.02", sound) > 1e-3);
    assert!(spool_error("late_command,cylinder=1", sound) > 1e-3);
}

/// Speed and load pressure that a cylinder reaches with its spool at `spool` under a load that needs 24 bar.
fn settled(spool: f64, wear: Wear) -> [f64; 2] {
    let mut parameters = Tables::default().plant();
    parameters.cylinder.stiffness = 0.0;
    parameters.cylinder.ends = [-100.0, 100.0];
    let cylinder = Cylinder::new(&parameters, 0, 2e-3);
    let force = 24.0 * parameters.cylinder.piston_area * tertius::plant::PASCAL;
    let acceleration = force / parameters.cylinder.load_mass;
    let drive = Drive { spool, load: 1.0, acceleration, supply: 240.0, wear };
    let mut state = CylinderState { spool, pressure: 24.0, ..CylinderState::default() };
    for _ in 0..10_000 {
        let _: f64 = cylinder.step(&mut state, &drive);
    }
    [state.speed, state.pressure]
}

#[test]
fn wear_changes_the_flow_and_the_friction_as_its_equation_says() {
    let table = Tables::default().cylinder;
    let sound = |spool| settled(spool, Wear::default());
    let worn = |spool, ailment| {
        let mut wear = Wear::default();
        wear.add(ailment);
        settled(spool, wear)
    };
    let near = |a: f64, b: f64, tolerance: f64, what: &str| {
        assert!((a - b).abs() < tolerance, "{what}: {a} {b}");
    };
    let [speed, pressure] = worn(0.2, Ailment::Leakage { rate: 0.7 });
    near(speed, sound(0.2)[0] - 0.7 / table.pressure_rise * pressure, 1e-4, "leakage");
    near(worn(0.2, Ailment::NullShift { size: 0.01 })[0], sound(0.21)[0], 1e-9, "null");
    near(worn(-0.2, Ailment::NullShift { size: 0.01 })[0], sound(-0.19)[0], 1e-9, "null");
    near(worn(0.2, Ailment::DeadBand { size: 0.01 })[0], sound(0.19)[0], 1e-9, "dead band");
    near(worn(-0.2, Ailment::DeadBand { size: 0.01 })[0], sound(-0.19)[0], 1e-9, "dead band");
    let leaking = Ailment::ValveLeakage { speed: 0.01 };
    near(worn(0.2, leaking)[0], sound(0.2)[0], 1e-12, "edges far from the middle");
    let friction = Tables::default().friction;
    let [speed, pressure] = worn(0.2, Ailment::Friction { factor: 2.0 });
    let area = table.piston_area * tertius::plant::PASCAL;
    near(pressure, 24.0 + 2.0 * friction.force(speed) / area, 0.01, "friction");
    let lost = sound(0.04)[0] - worn(0.04, Ailment::ValveLeakage { speed: 0.01 })[0];
    near(lost, 0.0, 1e-6, "the edge of the leakage");
    let lost = sound(0.02)[0] - worn(0.02, Ailment::ValveLeakage { speed: 0.01 })[0];
    assert!((0.0015..0.004).contains(&lost), "a quarter of it half way out: {lost}");
}

/// The largest error of a rod's length against the reference over `seconds`, m, and the lowest supply pressure, bar.
fn compensation(faults: &[&str], sea: [f64; 2], seconds: f64) -> (f64, f64, Machine) {
    let ailments = faults.iter().map(|text| fault(text)).collect();
    let options = Options { seed: 3, ailments, sea: Some(sea), ..Options::default() };
    let tables = Tables::default();
    let mut sound =
        Machine::new(&tables, SAMPLE_TIME, &Options { ailments: Vec::new(), ..options.clone() })
            .unwrap();
    let mut machine = Machine::new(&tables, SAMPLE_TIME, &options).unwrap();
    let (mut largest, mut lowest) = (0.0_f64, f64::INFINITY);
    for _ in 0..(seconds / SAMPLE_TIME) as usize {
        cycle(&mut machine);
        cycle(&mut sound);
        lowest = lowest.min(machine.supply_pressure());
        for (state, usual) in machine.states().iter().zip(sound.states()) {
            largest = largest.max((state.length - usual.length).abs());
        }
    }
    (largest, lowest, machine)
}

/// Section 2-1: the accumulator keeps the system operational for 60 s after the pumps have failed, and
/// a shut-down then takes 5 s (Table 2-1).
#[test]
fn the_accumulator_holds_for_a_minute_without_pumps_and_the_platform_is_then_safe_in_five_seconds()
{
    let stands = "supply_loss,cylinder=1,part=1";
    let (error, lowest, mut machine) = compensation(&[stands], [1.5, 8.0], 60.0);
    // The look-up tables are those of the full pressure, so that the rods lag a little more.
    assert!(error < 0.1, "{error} m, {lowest} bar");
    assert!((60.0..220.0).contains(&lowest), "{lowest} bar");
    machine.request(State::Safe);
    for _ in 0..250 {
        cycle(&mut machine);
    }
    assert_eq!(machine.state(), State::Safe);
    assert!(machine.states().iter().all(|it| it.speed.abs() < 0.15), "{:?}", machine.states());
}

#[test]
fn faults_of_the_machine_are_written_and_read_in_a_table() {
    let faults: Vec<Fault> = [
        "leakage,cylinder=1,rate=0.7,at=5",
        "valve_leakage,cylinder=2,speed=0.005",
        "sticking,cylinder=3,band=0.01,until=8",
        "dead_band,cylinder=4,size=0.005",
        "spool_offset,cylinder=5,size=-0.01",
        "null_shift,cylinder=6,size=0.0025",
        "supply_loss,cylinder=1,part=0.1",
        "friction,cylinder=1,factor=2",
        "late_command,cylinder=1,cycles=2",
        "wrong_command,cylinder=1,gain=-0.2",
    ]
    .map(fault)
    .into();
    let text = truth::table(&faults);
    assert!(text.contains("\n1,MACHINE,leakage,5,0.7,,\n"), "{text}");
    let read: Vec<Fault> = table::parse(&text).unwrap().into_iter().map(|it| it.1).collect();
    assert_eq!(read, faults);
}

#[test]
fn a_fault_of_the_machine_has_no_sensor_and_is_not_injected() {
    let error = |text: &str| Fault::parse(text).unwrap_err().to_string();
    assert!(error("leakage,cylinder=1,rate=1,sensor=c1").contains("no sensor's"));
    assert!(error("late_command,cylinder=1,cycles=16").contains("1 to 15"));
    assert!(error("leackage,cylinder=1").contains("nearest: leakage"));
    let fault = fault("leakage,cylinder=1,rate=1");
    assert!(matches!(fault.wanted, Wanted::Machine(_)));
    let (settings, _) =
        tertius::config::parse("m.toml", include_str!("../../config/e-type.toml")).unwrap();
    let dbc = tertius::dbc::text::from_bytes(include_bytes!("../../dbc/e-type.dbc"));
    let database = tertius::dbc::Database::parse(&dbc).unwrap();
    assert_eq!(place(&fault, &settings, &database), Err(PlaceError::Machine));
}

#[test]
fn the_hydraulic_plant_differs_where_it_says_so() {
    let (plain, less_ideal) = (Tables::default(), Tables::parse(HYDRAULIC).unwrap());
    let sums = |tables: &Tables| {
        let mut machine = machine(tables, &[], State::Engaged);
        let mut largest = 0.0_f64;
        for _ in 0..500 {
            let sample = machine.sample();
            let [bottom, rod] = sample.chambers[1];
            largest = largest.max((bottom + rod - sample.supply).abs());
            cycle(&mut machine);
        }
        largest
    };
    let (ideal, real) = (sums(&plain), sums(&less_ideal));
    assert!(ideal < 3.0 && real > ideal, "{ideal} {real}");
    // A valve that samples 5 ms early reads the spool where it was then.
    let mut aged = less_ideal;
    aged.sensors.spool = 0.0;
    let mut machine = machine(&aged, &[], State::Engaged);
    let decay = (-0.005 / aged.valve.lag).exp();
    let mut last = [0.0; 2];
    for k in 0..200 {
        let sample = machine.sample();
        let (read, now) = (sample.spools[1], machine.states()[1].spool);
        if k > 5 {
            // On the way to `last`, what was left of it 5 ms ago has decayed since.
            let then = last[0] + (now - last[0]) / decay;
            assert!((read - then).abs() < 2e-4, "{read} {then} {now}");
            last[1] += (read - now).abs();
        }
        let readings = Readings {
            lengths: sample.transducers.map(|pair| pair[0].length),
            speeds: sample.transducers.map(|pair| pair[0].speed),
            pressures: sample.load_pressures,
            pose: sample.motion.pose,
            rate: sample.motion.rate,
        };
        last[0] = machine.command(&readings).spools[1];
        machine.advance();
    }
    assert!(last[1] > 0.01, "{last:?}");
}
