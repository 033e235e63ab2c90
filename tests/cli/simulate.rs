//! The simulated machine as a whole: what it sends, and what the monitor makes of it.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use std::path::Path;
use tertius::alarm::{Detector, Warning};
use tertius::bus::LogWriter;
use tertius::config::design;
use tertius::config::{self, Settings};
use tertius::controller::{State, soft};
use tertius::dbc::{Database, text};
use tertius::evaluate::Grade;
use tertius::frame::Frame;
use tertius::inject::{self, Fault, Shape, Wanted, place, table};
use tertius::monitor::{Monitor, Record, Sink};
use tertius::simulator::{
    LayoutError, Options, Simulator, SimulatorError, TableError, Tables, truth,
};
use tertius::transducer::Transducer;
use tertius_testing::oracle;
use tertius_testing::support::{self, Scratch};

const CONFIG: &str = "config/e-type-simulated.toml";
const COARSE: &str = "config/e-type-coarse.toml";
const PLANT: &str = include_str!("../../config/e-type-plant.toml");

struct Setup {
    settings: Settings,
    database: Database,
}

fn setup() -> Setup {
    let loaded = config::load(&support::top().join(CONFIG)).expect("it is sound");
    let database = Database::parse(&text::from_bytes(&loaded.dbc_text)).expect("it is sound");
    Setup { settings: loaded.settings, database }
}

impl Setup {
    fn simulator(&self, options: &Options) -> Simulator {
        Simulator::new(&Tables::default(), &self.settings, &self.database, options)
            .expect("the default machine can be simulated")
    }

    fn with_fault(&self, fault: &str) -> Options {
        let fault = Fault::parse(fault).expect("a fault");
        let faults = vec![place(&fault, &self.settings, &self.database).expect("it has a place")];
        Options { seed: 1, faults, ..Options::default() }
    }

    fn monitor(&self) -> Monitor {
        Monitor::new(design::judging(&self.settings, &self.database).expect("they fit"))
    }
}

/// What the monitor made of a simulation.
#[derive(Default)]
struct Seen {
    warnings: Vec<Warning>,
    judged: u64,
    beyond: u64,
    largest: [f64; 3],
}

impl Sink for Seen {
    fn warning(&mut self, warning: &Warning) {
        self.warnings.push(*warning);
    }

    fn record(&mut self, record: &Record) {
        if record.gated {
            return;
        }
        for (largest, residual) in self.largest.iter_mut().zip(record.residuals) {
            *largest = largest.max(residual.expect("nothing is missing").abs());
        }
        self.judged += 2;
        let observers = &record.residuals[..2];
        self.beyond += observers.iter().flatten().filter(|one| one.abs() > 1e-3).count() as u64;
    }
}

fn watched(setup: &Setup, options: &Options, seconds: u32) -> Seen {
    let (mut simulator, mut monitor) = (setup.simulator(options), setup.monitor());
    let mut seen = Seen::default();
    for _ in 0..50 * seconds {
        simulator.step(&mut |frame| monitor.take(frame, &mut seen));
    }
    monitor.finish(&mut seen);
    seen
}

fn bytes(setup: &Setup, options: &Options, cycles: u32) -> Vec<u8> {
    let mut writer = LogWriter::new(Vec::new(), "can0");
    let mut simulator = setup.simulator(options);
    for _ in 0..cycles {
        simulator.step(&mut |frame| writer.write(frame).expect("memory takes it"));
    }
    writer.into_inner()
}

#[test]
fn the_same_seed_gives_the_same_bytes_and_another_seed_others() {
    let setup = setup();
    let run = |seed| bytes(&setup, &Options { seed, ..Options::default() }, 500);
    assert_eq!(run(5), run(5));
    assert_ne!(run(5), run(6));
}

#[test]
fn the_frames_come_in_the_order_of_the_bus_within_the_cycle() {
    let setup = setup();
    let mut simulator = setup.simulator(&Options::default());
    let mut expected = vec![0x080];
    (1..=6).for_each(|n| expected.extend([0x180 + n, 0x190 + n]));
    expected.extend([0x1B1, 0x2B1, 0x1C1]);
    expected.extend((1..=6).map(|n| 0x1A0 + n));
    for _ in 0..100 {
        let opening = simulator.opening();
        let mut frames: Vec<Frame> = Vec::new();
        simulator.step(&mut |frame| frames.push(frame.clone()));
        let ids: Vec<u32> = frames.iter().map(|frame| frame.id.value()).collect();
        assert_eq!(ids, expected);
        let after = |frame: &Frame| frame.timestamp.since(opening).as_seconds();
        assert!(frames.windows(2).all(|pair| pair[0].timestamp < pair[1].timestamp));
        assert!(after(&frames[0]) < 0.5e-3, "Sync");
        assert!(after(&frames[15]) < 6e-3, "what is sampled");
        let valves = (after(&frames[16]), after(&frames[21]));
        assert!(valves.0 > 6e-3 && valves.1 < 9e-3, "the answer: {valves:?}");
    }
}

/// Ten minutes without a fault, thesis's observer and thresholds: no warning, and R1 and R2 within
/// 1e-3 m in at least 99.99 % of the samples.
#[test]
fn a_healthy_machine_is_healthy() {
    let setup = setup();
    let seen = watched(&setup, &Options { seed: 1, ..Options::default() }, 600);
    assert!(seen.warnings.is_empty(), "{:?}", seen.warnings);
    assert!(seen.judged > 6 * 2 * 29_000, "{}", seen.judged);
    assert!(seen.beyond * 10_000 <= seen.judged, "{} of {}", seen.beyond, seen.judged);
    // It is no dead machine either: residuals, but small ones.
    assert!(seen.largest.iter().all(|one| (2e-4..1.5e-3).contains(one)), "{:?}", seen.largest);
}

/// Figure 5-14: C1 and C2 differ by up to 8 mm over the workspace, more than R3's bound allows, and
/// a straight line takes it away (5-20). (5-3): whole counts, 1 to 27648.
#[test]
fn c1_and_c2_are_calibrated_differently_and_read_whole_counts() {
    let tables = Tables::default();
    let pair = |cylinder| {
        [&tables.c1, &tables.c2]
            .map(|errors| Transducer::new(&tables.transducer, errors, cylinder, 0.02))
    };
    let mut largest = 0.0_f64;
    for (cylinder, correction) in setup().settings.cylinder.iter().enumerate() {
        let [c1, c2] = pair(cylinder);
        for step in -100..=100 {
            let [one, two] = [c1, c2].map(|one| one.calibrated(0.0, f64::from(step) / 100.0));
            largest = largest.max((one - two).abs());
            let rest = one - (correction.c2_gain * two + correction.c2_offset);
            assert!(rest.abs() < 5e-4, "cylinder {}: {rest}", cylinder + 1);
        }
    }
    assert!((6e-3..8e-3).contains(&largest), "{largest} m");
    let [mut c1, _] = pair(0);
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let count = |length: f64| (length + 1.5) / 3.0 * 27_648.0;
    for step in -200..200 {
        let count = count(c1.read(0.0, [f64::from(step) / 100.0, 0.1], [0.0; 2], &mut rng).length);
        assert!((count - count.round()).abs() < 1e-6, "{count}");
        assert!((0.9..27_648.1).contains(&count), "{count}");
    }
}

#[test]
fn a_step_is_found_on_the_right_transducer() {
    let setup = setup();
    for (sensor, detector) in [("c1", Detector::Fde1), ("c2", Detector::Fde2)] {
        let fault = format!("step,cylinder=3,sensor={sensor},at=20,size=0.0025");
        let seen = watched(&setup, &setup.with_fault(&fault), 25);
        let first = seen.warnings.first().expect("a warning");
        assert_eq!((first.cylinder, first.detector), (3, detector), "{:?}", seen.warnings);
        assert!(seen.warnings.iter().all(|warning| warning.cylinder == 3), "{:?}", seen.warnings);
    }
}

/// C1 reads 20 mm too much: where the controller sees that it draws the cylinder in by as much;
/// where it does not, nothing moves otherwise than before, to the bit.
#[test]
fn a_fault_in_the_loop_moves_the_cylinder_and_one_beside_it_does_not() {
    let setup = setup();
    let lengths = |options: &Options| {
        let mut simulator = setup.simulator(options);
        let step = |_| {
            simulator.step(&mut |_| {});
            simulator.machine().states().map(|state| state.length)
        };
        (0..1000).map(step).collect::<Vec<[f64; 6]>>()
    };
    let beside = setup.with_fault("step,cylinder=2,at=5,size=0.02");
    let within = Options { in_loop: true, ..beside.clone() };
    let healthy = lengths(&Options { seed: 1, ..Options::default() });
    assert_eq!(lengths(&beside), healthy);
    let moved = lengths(&within);
    assert_eq!(moved[..249], healthy[..249], "before the fault");
    let apart = |k: usize, leg: usize| moved[k][leg] - healthy[k][leg];
    let mean = |leg: usize| (600..1000).map(|k| apart(k, leg)).sum::<f64>() / 400.0;
    assert!((mean(1) + 0.02).abs() < 2e-3, "{} m", mean(1));
    for leg in [0, 2, 3, 4, 5] {
        assert!(mean(leg).abs() < 5e-4, "cylinder {}: {} m", leg + 1, mean(leg));
    }
}

/// A quarter of a millimetre is 2.3 counts: after rounding it is two or three of them, and a quarter of
/// a millimetre in the mean. On transducers that read in steps of four counts it is one step or none.
#[test]
fn a_fault_is_in_the_length_before_it_is_rounded() {
    let setup = setup();
    let (message, c1) = setup.database.signal("Cyl2_C1.Position").expect("it is there");
    for (grade, steps) in [(Grade::Fine, [2, 3]), (Grade::Coarse, [0, 4])] {
        let counts = |options: &Options| {
            let tables = grade.apply(&Tables::default());
            let simulator = Simulator::new(&tables, &setup.settings, &setup.database, options);
            let mut simulator = simulator.expect("it can be simulated");
            let mut counts = Vec::new();
            for _ in 0..6000 {
                simulator.step(&mut |frame| {
                    if let Some(value) =
                        c1.plan.decode(frame).value().filter(|_| frame.id == message.id)
                    {
                        counts.push((c1.plan.unscaled(value.physical)).round() as i32);
                    }
                });
            }
            counts
        };
        let faulty = setup.with_fault("step,cylinder=2,at=0,size=0.00025");
        let healthy = counts(&Options { seed: 1, ..Options::default() });
        let apart: Vec<i32> = counts(&faulty).iter().zip(&healthy).map(|(a, b)| a - b).collect();
        assert!(apart.iter().all(|counts| steps.contains(counts)), "{grade:?}");
        let mean = f64::from(apart.iter().sum::<i32>()) / apart.len() as f64 * 3.0 / 27_648.0;
        assert!((mean - 2.5e-4).abs() < 1.2e-5, "{grade:?}: {mean} m");
        // A value that is put in its place is none that a transducer has rounded.
        let out = counts(&setup.with_fault("out_of_range,cylinder=2,at=0,value=1.8001"));
        let read = c1.plan.unscaled(1.8001).round() as i32;
        assert!(out.iter().all(|count| *count == read), "{grade:?}: {} for {read}", out[0]);
    }
}

/// A frame of C1 that is lost leaves the controller with the reading before.
#[test]
fn a_controller_that_loses_c1_goes_on_with_what_it_had() {
    let setup = setup();
    let mut options = setup.with_fault("loss,cylinder=1,at=5,until=5.1,probability=1");
    options.in_loop = true;
    let (mut simulator, mut frames) = (setup.simulator(&options), 0);
    for _ in 0..500 {
        simulator.step(&mut |frame| frames += u32::from(frame.id.value() == 0x181));
    }
    assert_eq!(frames, 495);
    assert_eq!(simulator.tallies()[0].altered, 5);
    assert!(simulator.machine().states()[0].length.abs() < 1.0);
}

#[test]
fn from_safe_to_engaged_the_platform_goes_through_all_states_without_a_jolt() {
    let setup = setup();
    let options = Options { start: State::Safe, seed: 2, ..Options::default() };
    let mut simulator = setup.simulator(&options);
    simulator.request(State::Engaged);
    let retracted = Tables::default().cylinder.ends[0];
    assert!(simulator.machine().states().iter().all(|state| state.length == retracted));
    let (mut states, mut fastest, mut jolt) = (Vec::new(), 0.0_f64, 0.0_f64);
    let mut before = [0.0; 6];
    for _ in 0..50 * 40 {
        simulator.step(&mut |_| {});
        let machine = simulator.machine();
        if states.last() != Some(&machine.state()) {
            states.push(machine.state());
        }
        for (state, before) in machine.states().iter().zip(&mut before) {
            fastest = fastest.max(state.speed.abs());
            jolt = jolt.max((state.speed - *before).abs() / 0.02);
            *before = state.speed;
        }
    }
    assert_eq!(states, [State::Safe, State::Settled, State::Neutral, State::Engaged]);
    assert!((0.2..1.0).contains(&fastest), "{fastest} m/s");
    assert!(jolt < 3.0, "{jolt} m/s²");
}

/// And back: what is left at once is reported at once, and at the end all cylinders are in.
#[test]
fn a_platform_that_is_asked_to_settle_retracts() {
    let setup = setup();
    let mut simulator = setup.simulator(&Options::default());
    (0..100).for_each(|_| simulator.step(&mut |_| {}));
    simulator.request(State::Settled);
    (0..2).for_each(|_| simulator.step(&mut |_| {}));
    assert_eq!(simulator.machine().state(), State::Neutral);
    (0..50 * 30).for_each(|_| simulator.step(&mut |_| {}));
    assert_eq!(simulator.machine().state(), State::Settled);
    let retracted = Tables::default().cylinder.ends[0];
    assert!(simulator.machine().states().iter().all(|state| state.length == retracted));
}

/// The soft limit bends; it has no kink and no jump, and its rate is its derivative.
#[test]
fn the_workspace_is_a_limit_without_a_kink() {
    let at = |value: f64| soft(value, 1.0, 1.0);
    assert_eq!(at(0.5), (0.5, 1.0));
    assert!(at(5.0).0 <= 1.0 && at(-5.0).0 >= -1.0);
    for tenth in -30..30 {
        let value = f64::from(tenth) * 0.1 + 0.05;
        let slope = (at(value + 1e-6).0 - at(value - 1e-6).0) / 2e-6;
        assert!((slope - at(value).1).abs() < 1e-6, "at {value}");
    }
}

/// python-can reads it, cantools decodes all of it, and the thesis's linear model, identified on it,
/// accounts for the motion: VAF ≥ 90 % in position and velocity for all six cylinders.
#[test]
fn the_recording_passes_for_real_elsewhere() {
    let scratch = Scratch::new();
    let log = scratch.path("simulated.log");
    let arguments = ["simulate", "--config", CONFIG, "--duration", "240", "--seed", "3"];
    support::tertius(&[&arguments[..], &["--output", &log]].concat(), b"").ok();
    let judged = oracle::run("simulate.py", &["dbc/e-type.dbc", &log], "");
    let rows: Vec<Vec<f64>> = judged
        .lines()
        .map(|line| line.split(' ').map(|word| word.parse().expect("a number")).collect())
        .collect();
    assert_eq!(rows[0], [240.0 * 50.0 * 22.0, 0.0, 0.0, 0.0], "{judged}");
    for row in &rows[1..7] {
        assert!(row[1] >= 90.0 && row[2] >= 90.0, "{judged}");
    }
    // θ2, θ4, γ1 and γ2 have the signs of Table 4-1, and the poles its size.
    let [_, theta2, _, theta4, _, gamma1, gamma2] = rows[7][..] else { panic!("{judged}") };
    assert!(theta2 < -0.05 && theta2 > -0.4 && theta4 < 0.0, "{judged}");
    assert!((gamma1 / -theta2 - 1.0).abs() < 0.35 && gamma2 > 0.0, "{judged}");
}

#[test]
fn replay_takes_the_recording_like_any_other_and_the_truth_is_a_table_of_faults() {
    let scratch = Scratch::new();
    let (log, truth) = (scratch.path("faulty.log"), scratch.path("truth.csv"));
    let run = support::tertius(
        &[
            "simulate",
            "--config",
            CONFIG,
            "--duration",
            "30",
            "--seed",
            "1",
            "--output",
            &log,
            "--truth",
            &truth,
            "--fault",
            "step,cylinder=5,sensor=c2,at=20,size=-0.0025,until=25",
        ],
        b"",
    )
    .ok();
    assert!(run.stderr.contains("33000 frames"), "{}", run.stderr);
    assert!(run.stderr.contains("250 of 250 frames"), "{}", run.stderr);
    assert_eq!(
        scratch.read("truth.csv"),
        "cylinder,sensor,kind,t0,magnitude,parameter,t1\n5,C2,step,20,-0.0025,,25\n"
    );
    let replayed = support::replay(&[&log], CONFIG, &[]).ok();
    assert_eq!(replayed.summary()["bad_lines"], 0);
    assert_eq!(replayed.summary()["incomplete_cycles"], 0);
    let warnings = replayed.warnings();
    assert!(!warnings.is_empty());
    for warning in &warnings {
        assert_eq!(warning["cylinder"], 5, "{warning}");
    }
    assert_eq!(warnings[0]["detector"], "fde2");
    assert_eq!(warnings[0]["suspect"], "c2");
    let t = warnings[0]["t"].as_f64().expect("a time");
    assert!((20.0..20.1).contains(&t), "{t}");
}

/// A table of faults does what the same faults in the call do, and comes back as the truth.
#[test]
fn a_written_truth_makes_the_same_recording() {
    let scratch = Scratch::new();
    let simulate = |name: &str, faults: &[&str]| {
        let log = scratch.path(&format!("{name}.log"));
        let truth = scratch.path(&format!("{name}.csv"));
        let call = ["simulate", "--config", CONFIG, "--duration", "6", "--seed", "4"];
        let out = ["--output", &log, "--truth", &truth];
        let run = support::tertius(&[&call[..], &out, faults].concat(), b"").ok();
        (scratch.read(&format!("{name}.log")), scratch.read(&format!("{name}.csv")), run)
    };
    let [step, noise] =
        ["step,cylinder=5,sensor=c2,at=2,size=-0.0025,until=4", "noise,cylinder=2,size=0.001,at=3"];
    let (log, truth, _) = simulate("called", &["--fault", step, "--fault", noise]);
    let table = scratch.path("called.csv");
    let (same, again, run) = simulate("table", &["--faults", &table]);
    assert!(log == same, "the recordings differ");
    assert_eq!(truth, again);
    let named = format!("{table}: line 2: 100 of 100 frames changed");
    assert!(run.stderr.contains(&named), "{}", run.stderr);
    // Those of the table act first, and the randomness of each is its own.
    scratch.write("first.csv", truth.lines().take(2).collect::<Vec<_>>().join("\n"));
    let (same, _, _) =
        simulate("both", &["--faults", &scratch.path("first.csv"), "--fault", noise]);
    assert!(log == same, "a table and a call differ from a call");
    let (healthy, _, _) = simulate("healthy", &[]);
    assert_ne!(log, healthy);
}

/// Where a machine sends its load pressure itself, it is P_bot − α P_rod (3-4) of the pressures that
/// it sends.
#[test]
fn a_load_pressure_on_the_bus_is_that_of_the_chambers() {
    let mut setup = setup();
    let mut dbc = std::fs::read_to_string(support::top().join("dbc/e-type.dbc")).expect("ships");
    for n in 1..=6 {
        dbc += &format!(
            "\nBO_ {} Cyl{n}_Load: 2 Valve{n}\n SG_ LoadPressure : 0|16@1- (0.01,0) [-200|300] \
             \"bar\" Gateway\n",
            0x2A0 + n
        );
    }
    setup.database = Database::parse(&dbc).expect("it is sound");
    setup.settings.signals.cylinder.load_pressure = Some("Cyl{n}_Load.LoadPressure".to_owned());
    let mut simulator = setup.simulator(&Options { seed: 1, ..Options::default() });
    let mut seen = [[0.0; 3]; 6];
    let read = |frame: &Frame, signal: &str| {
        let message = setup.database.message_by_id(frame.id).expect("it is in the DBC");
        let value = message.signal(signal).and_then(|it| it.plan.decode(frame).value());
        value.expect("it is there").physical
    };
    let mut largest = 0.0_f64;
    for _ in 0..100 {
        simulator.step(&mut |frame| match frame.id.value() {
            id @ 0x1A1..=0x1A6 => {
                let row = &mut seen[id as usize - 0x1A1];
                row[0] = read(frame, "PressureBottom");
                row[1] = read(frame, "PressureRod");
            }
            id @ 0x2A1..=0x2A6 => seen[id as usize - 0x2A1][2] = read(frame, "LoadPressure"),
            _ => {}
        });
        for [bottom, rod, load] in seen {
            assert!((load - (bottom - 0.5 * rod)).abs() < 0.02, "{load} of {bottom} and {rod}");
            largest = largest.max(load.abs());
        }
    }
    assert!(largest > 10.0, "tens of bar, as the thesis measured: {largest}");
}

/// `identify` takes it like any other: one cylinder's model, fitted on the first half, accounts for
/// at least 90 % of the position of every cylinder in the second.
#[test]
fn identify_finds_a_model_in_a_simulated_recording() {
    let scratch = Scratch::new();
    let log = scratch.path("healthy.log");
    let call = ["simulate", "--config", CONFIG, "--duration", "240", "--seed", "3"];
    support::tertius(&[&call[..], &["--output", &log]].concat(), b"").ok();
    let page = support::tertius(&["identify", &log, "--config", CONFIG], b"").ok().stdout;
    let (_, below) = page.split_once("the model of cylinder ").expect("one is taken");
    let chosen = &below[..1];
    let (_, table) = page.split_once("simulated open loop (Figure 4-3)").expect("it was tried");
    let row = table.lines().find(|line| line.split_whitespace().next() == Some(chosen));
    let vafs: Vec<f64> = row
        .expect("a row for each cylinder's model")
        .split_whitespace()
        .skip(1)
        .map(|word| word.parse().expect("a number"))
        .collect();
    assert_eq!(vafs.len(), 7, "six cylinders and the worst of them: {page}");
    assert!(vafs.iter().all(|vaf| (90.0..100.0).contains(vaf)), "{page}");
}

#[test]
fn a_truth_reads_back_as_the_faults_that_it_was_made_from() {
    let words = [
        "step,cylinder=1,sensor=c2,at=1.5,size=-0.00175,until=2",
        "noise,cylinder=2,size=0.001",
        "incipient,cylinder=3,size=0.07,b=0.5,at=3",
        "drift,cylinder=4,rate=1e-5",
        "scale,cylinder=5,gain=0.01",
        "freeze,cylinder=6,sensor=c1_velocity",
        "spike,cylinder=1,size=0.01,probability=0.25",
        "stale,cylinder=2,at=7",
        "loss,cylinder=3,probability=0.5",
        "out_of_range,cylinder=4",
        "broken_wire,cylinder=5",
    ];
    let faults: Vec<Fault> = words.iter().map(|text| Fault::parse(text).expect(text)).collect();
    let read = table::parse(&truth::table(&faults)).expect("a table");
    let read: Vec<Fault> = read.into_iter().map(|(_, fault)| fault).collect();
    assert_eq!(read, faults);
    assert!(matches!(faults[0].wanted, Wanted::Shape(Shape::Step { .. })));
    assert_eq!(inject::SENSORS.len(), 11, "a new sensor needs its own line here");
}

/// The loads, the pump, the spools and the valves, each for itself, and only in its time.
#[test]
fn what_befalls_the_process_moves_the_machine_and_not_before() {
    let plain = setup();
    let valve = PLANT.split("\n\n").find(|table| table.starts_with("[valve]")).expect("a table");
    let valve = valve.replace("[valve]", "[disturbance.valve]");
    let options = Options { seed: 3, ..Options::default() };
    let with = |more: &str| {
        let tables = Tables::parse(&format!("{PLANT}\n{more}\n")).expect("it is sound");
        Simulator::new(&tables, &plain.settings, &plain.database, &options).expect("a machine")
    };
    for (more, from) in [
        ("[disturbance]\nload = { time = [20.0, 30.0], part = 1.3 }", 20.0),
        ("[disturbance]\npump = { time = [20.0, 30.0], part = 0.0 }", 20.0),
        ("[disturbance]\nsticking = { time = [20.0, 30.0], band = 0.02 }", 20.0),
        (&valve.replace("overlap = 0.01", "overlap = 0.02"), 0.0),
        (&valve, 30.0),
    ] {
        let (mut one, mut two) = (plain.simulator(&options), with(more));
        let mut first = None;
        for cycle in 0..1500 {
            if one.machine().states() != two.machine().states() {
                first.get_or_insert(f64::from(cycle) * 0.02);
            }
            one.step(&mut |_| {});
            two.step(&mut |_| {});
        }
        let at = first.unwrap_or(30.0);
        assert!((from..from + 0.1).contains(&at), "{more}: at {at} s");
    }
}

#[test]
fn tables_are_refused_for_what_is_wrong_with_them() {
    assert_eq!(Tables::parse(PLANT), Ok(Tables::default()));
    let changed = |from: &str, to: &str| Tables::parse(&support::changed(PLANT, &[(from, to)]));
    let Err(TableError::Form(message)) = changed("[friction]", "[frictions]") else {
        panic!("an unknown table");
    };
    assert!(message.contains("frictions"), "{message}");
    let error = changed("lag = 0.06", "lag = 0.0").expect_err("no lag");
    assert!(matches!(&error, TableError::Range { key, .. } if key == "valve.lag"), "{error}");
    let error = changed("load_mass = 1.0e4", "load_mass = nan").expect_err("no mass");
    assert!(error.to_string().contains("cylinder.load_mass is NaN"), "{error}");
    let error = changed("ends = [-1.48, 1.48]", "ends = [1.0, -1.0]").expect_err("turned round");
    assert!(matches!(error, TableError::Order { key: "cylinder.ends", .. }), "{error}");
    let befallen = |more: &str| Tables::parse(&format!("{PLANT}\n[disturbance]\n{more}\n"));
    let error = befallen("load = { time = [1.0, 2.0], part = 20.0 }").expect_err("too much");
    assert!(error.to_string().contains("disturbance.load.part is 20"), "{error}");
    let error = befallen("pump = { time = [2.0, 1.0], part = 0.0 }").expect_err("turned round");
    assert!(matches!(error, TableError::Order { key: "disturbance.pump.time", .. }), "{error}");
    let Err(TableError::Form(message)) = befallen("wind = 1.0") else { panic!("an unknown key") };
    assert!(message.contains("wind"), "{message}");
}

#[test]
fn a_machine_has_no_more_cylinders_than_a_hexapod() {
    let mut setup = setup();
    setup.settings.machine.cylinders = 7;
    let tables = Tables::default();
    let made = Simulator::new(&tables, &setup.settings, &setup.database, &Options::default());
    let error = made.expect_err("seven legs");
    assert_eq!(error, SimulatorError::Layout(LayoutError::Cylinders(7)));
}

/// The monitor's view of the simulated machine is the default one but for the C2 corrections.
#[test]
fn the_configuration_of_the_simulated_machine_is_the_default_with_corrections() {
    let load = |path: &str| config::load(&support::top().join(Path::new(path))).expect("sound");
    let mut simulated = load(CONFIG).settings;
    assert_eq!(simulated.cylinder.len(), 6);
    simulated.cylinder.clear();
    assert_eq!(simulated, load("config/e-type.toml").settings);
}

/// What is of the grade of the transducers is the weights and their thresholds, and nothing else.
#[test]
fn the_configuration_of_coarse_transducers_is_the_default_but_for_the_observers() {
    let load = |path: &str| config::load(&support::top().join(Path::new(path))).expect("sound");
    let (fine, mut coarse) = (load("config/e-type.toml").settings, load(COARSE).settings);
    assert!(coarse.observer != fine.observer && coarse.fde.high > fine.fde.high);
    (coarse.observer, coarse.fde) = (fine.observer.clone(), fine.fde.clone());
    assert_eq!(coarse, fine);
    support::tertius(&["check", COARSE], b"").ok();
}

#[test]
fn a_wrong_call_ends_with_2_and_says_what_was_expected() {
    let run = |arguments: &[&str]| {
        support::tertius(&[&["simulate", "--config", CONFIG], arguments].concat(), b"")
    };
    run(&["--duration", "0"]).failed(2, &["--duration is 0", "expected seconds"]);
    run(&["--sea", "2"]).failed(2, &["--sea is \"2\"", "such as 2.5,9"]);
    run(&["--sea", "12,9"]).failed(2, &["take a calmer sea"]);
    run(&["--sea", "2,0.1"]).failed(2, &["peak period is 0.1 s", "2 to 30"]);
    run(&["--fault", "leakag,cylinder=1"]).failed(2, &["nearest: leakage", "wrong_command"]);
    run(&["--fault", "stop,cylinder=1"]).failed(2, &["no fault is called \"stop\"", "step"]);
    run(&["--fault", "step,cylinder=7,size=1"]).failed(2, &["there is no cylinder 7"]);
    run(&["--plant", "no/such.toml"]).failed(2, &["no/such.toml", "cannot be read"]);
    run(&["--output", "no/such/folder.log"]).failed(2, &["cannot be created"]);
    run(&["--speed", "2"]).failed(2, &["--interface"]);
    run(&["--interface", "vcan0", "--speed", "0"]).failed(2, &["or max"]);
    run(&["--faults", "no/such.csv"]).failed(2, &["no/such.csv: cannot be read"]);
    run(&["--faults", "Cargo.toml"]).failed(2, &["Cargo.toml: line 1", "expected the header"]);
    run(&["--states", "60:save"]).failed(2, &["\"60:save\"", "such as 60:safe"]);
    run(&["--states=-1:safe"]).failed(2, &["expected seconds and a state"]);
    run(&["--fault", "leakage,cylinder=7,rate=1"]).failed(2, &["there is no cylinder 7"]);
    // What would have no effect is not simulated as if it had.
    let scratch = Scratch::new();
    let table =
        "cylinder,sensor,kind,t0,magnitude,parameter,t1\n1,C1,step,2,1e-3,,\n2,C1,step,9,1e-3,,\n";
    let table = scratch.write("late.csv", table);
    for (fault, named) in [
        (["--fault", "step,cylinder=1,size=0.001,at=2.5"], "--fault \"step"),
        (["--fault", "leakage,cylinder=1,rate=1,at=4"], "--fault \"leakage"),
        (["--faults", &table], "late.csv: line 3"),
    ] {
        let log = scratch.path("late.log");
        let words = [named, "begins at", "the simulation ends at 2.5 s", "--duration"];
        run(&[&["--duration", "2.5", "--output", &log], &fault[..]].concat()).failed(2, &words);
        assert!(!std::fs::exists(&log).expect("it can be looked for"));
    }
    let words = ["--duration is 0.019 s", "at least 0.02 s", CONFIG];
    run(&["--duration", "0.019"]).failed(2, &words);
    let cycle = run(&["--duration", "0.02", "--fault", "step,cylinder=1,size=0.001"]).ok();
    assert!(cycle.stdout.lines().count() > 12, "{}", cycle.stdout);
    let help = support::tertius(&["simulate", "--help"], b"").ok();
    assert!(help.stdout.contains("Examples:"), "{}", help.stdout);
}

/// What may be wrong with a sound machine: ripples, warmth, spikes, valves that stick.
#[test]
fn a_harsher_machine_is_simulated_as_its_table_says() {
    let scratch = Scratch::new();
    let run = |arguments: &[&str]| {
        support::tertius(&[&["simulate", "--config", CONFIG], arguments].concat(), b"")
    };
    let plant = support::top().join("config/e-type-harsh-plant.toml");
    let output = scratch.path("harsh.log");
    let harsh = ["--plant", plant.to_str().expect("UTF-8"), "--duration", "60", "--seed", "4"];
    run(&[&harsh[..], &["--output", &output]].concat()).ok();
    let summary = support::replay(&[&output], CONFIG, &[]).ok().summary();
    assert_eq!(summary["judged"], true);
    assert_eq!(summary["warnings"]["plausibility"], 0, "it is sound: {summary}");
    let kind = scratch.path("kind.log");
    run(&["--duration", "60", "--seed", "4", "--output", &kind]).ok();
    let worst = |log: &str| {
        let summary = support::replay(&[log], CONFIG, &[]).ok().summary();
        let cylinders = summary["cylinders"].as_array().expect("six").clone();
        let r3 = cylinders.iter().map(|it| it["worst_r3"].as_f64().expect("m").abs());
        r3.fold(0.0, f64::max)
    };
    let (harsh, kind) = (worst(&output), worst(&kind));
    assert!(harsh > kind + 1e-4, "{harsh} m against {kind} m");
}

/// The platform is released at once, and engages again by way of all states.
#[test]
fn the_platform_goes_through_the_states_that_it_is_asked_for() {
    let run = |arguments: &[&str]| {
        let call = ["simulate", "--config", CONFIG, "--duration", "90", "--output", "-"];
        support::tertius(&[&call[..], arguments].concat(), b"").ok().stdout
    };
    // The first byte of Plc_State.
    let states = |log: &str| {
        let mut states: Vec<(f64, u8)> = Vec::new();
        for line in log.lines() {
            let Some((_, payload)) = line.split_once(" 1C1#") else { continue };
            let stamp = line[1..].split(')').next().expect("a stamp").parse::<f64>().expect("s");
            let state = u8::from_str_radix(&payload[..2], 16).expect("a byte");
            if states.last().is_none_or(|last| last.1 != state) {
                states.push((stamp - 1_700_000_000.0, state));
            }
        }
        states
    };
    let asked = run(&["--states", "0:engaged,40:engaged,10:safe"]);
    let states = states(&asked);
    let order: Vec<u8> = states.iter().map(|it| it.1).collect();
    assert_eq!(order, [3, 0, 1, 2, 3], "{states:?}");
    assert!((states[1].0 - 10.0).abs() < 0.05 && states[2].0 > 40.0, "{states:?}");
    let first = |log: &str| log.lines().take(1000).collect::<Vec<_>>().join("\n");
    assert_eq!(first(&run(&["--states", "0:engaged"])), first(&run(&[])));
}
