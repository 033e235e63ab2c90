//! The attitude of the deck on a simulated machine: what it names, and when it is no evidence.

use crate::sequential_support::{Bench, EPOCH, Heard, Setup, fine, setup};
use std::path::Path;
use tertius::alarm::status::Health;
use tertius::alarm::{Detector, Level, State, Warning};
use tertius::blame::Rule;
use tertius::dbc::{Database, text};
use tertius::decode::Inserted;
use tertius::verdict::{Fault, Suspect};

/// A drift of cylinder 2 and one of cylinder 5, later, and how long both are watched, s.
const DRIFTS: [&str; 2] = [
    "drift,rate=0.0005,cylinder=2,sensor=c1,at=60",
    "drift,rate=-0.0005,cylinder=5,sensor=c2,at=95",
];
const WATCHED: f64 = 125.0;

fn with_top() -> Setup {
    setup().without_process().with_top()
}

fn of_deck(heard: &Heard, cylinder: u8) -> Vec<&Warning> {
    let own = |it: &&Warning| it.finding.rule == Rule::DeckAttitude && it.cylinder == cylinder;
    heard.warnings.iter().filter(own).collect()
}

#[test]
fn it_names_the_transducer_that_drifts_in_the_loop() {
    let setup = with_top();
    let options = setup.options(4, &DRIFTS.map(str::to_owned));
    let options = tertius::simulator::Options { in_loop: true, ..options };
    let (mut simulator, mut bench) = (setup.simulator(&options), Bench::new(&setup));
    bench.run(&mut simulator, WATCHED);
    let heard = &bench.heard;
    for (cylinder, suspect, from) in [(2, Suspect::C1, 60.0), (5, Suspect::C2, 95.0)] {
        let said = of_deck(heard, cylinder);
        let first = said.first().unwrap_or_else(|| panic!("{cylinder}: {}", heard.told()));
        assert_eq!(first.finding.suspect, suspect, "{cylinder}");
        let drifted = 5e-4 * (first.timestamp.since(EPOCH).as_seconds() - from);
        assert!((1e-3..0.0125).contains(&drifted), "{cylinder}: {drifted} m");
        // The detector that found it says the same, and so does the difference, which cannot tell by itself.
        let last = |detector| {
            let mut all = heard.warnings.iter().chain(&heard.others);
            all.rfind(|it| it.detector == detector && it.cylinder == cylinder)
        };
        for detector in [Detector::Sequential, Detector::Fde3] {
            assert_eq!(last(detector).map(|it| it.finding.suspect), Some(suspect), "{detector:?}");
        }
    }
    assert!([1, 3, 4, 6].into_iter().all(|cylinder| of_deck(heard, cylinder).is_empty()));
    let (_, status) = bench.monitor.last_status().expect("it is sent every 100 ms");
    let [c1, c2] = status.transducers[1];
    assert_eq!(c1, Health::Faulty);
    assert_ne!(c2, Health::Suspect, "C2 of cylinder 2 is sound");
    assert_ne!(status.transducers[4][0], Health::Suspect, "C1 of cylinder 5 is sound");
}

#[test]
fn without_its_sensor_or_where_that_is_frozen_nobody_is_named() {
    let setup = with_top();
    let options =
        setup.options(4, &DRIFTS[..1].iter().map(|&it| it.to_owned()).collect::<Vec<_>>());
    let options = tertius::simulator::Options { in_loop: true, ..options };
    let plan = |name| setup.database.signal(name).expect("it is in the DBC");
    let (message, roll) = plan("Top_Attitude.Roll");
    let (_, pitch) = plan("Top_Attitude.Pitch");
    for is_frozen in [true, false] {
        let (mut simulator, mut bench) = (setup.simulator(&options), Bench::new(&setup));
        bench.run_through(&mut simulator, 90.0, |cycle, frame, pass| {
            if frame.id != message.id || cycle < 3000 {
                return pass(frame);
            }
            if is_frozen {
                let mut frame = frame.clone();
                for signal in [roll, pitch] {
                    let inserted = signal.plan.insert_physical(1e-3, frame.buffer_mut());
                    assert_eq!(inserted, Inserted::Whole);
                }
                pass(&frame);
            }
        });
        let heard = &bench.heard;
        assert!((1..=6).all(|cylinder| of_deck(heard, cylinder).is_empty()), "{is_frozen}");
        assert!(heard.of(2, 60.0).is_some(), "it is found all the same");
    }
    // Nor is there such a detector on a machine without the sensor.
    assert!(setup.monitor().tilt().is_some());
    assert!(crate::sequential_support::setup().monitor().tilt().is_none());
}

/// The machine with a sensor of 0.005° on its deck, and without C2.
fn single() -> Setup {
    let top = Path::new(env!("CARGO_MANIFEST_DIR"));
    let loaded = tertius::config::load(&top.join("config/e-type-top.toml")).expect("it is sound");
    let database = Database::parse(&text::from_bytes(&loaded.dbc_text)).expect("it is sound");
    let mut settings = loaded.settings;
    let signals = &mut settings.signals.cylinder;
    (signals.c2, signals.c2_velocity, signals.c2_status, signals.c2_counter) = Default::default();
    let accuracy = 8.7e-5;
    settings.hexapod.as_mut().expect("it has one").top_accuracy = accuracy;
    let mut tables = fine(&[], "");
    (tables.sensors.top.noise, tables.sensors.top.wander) = (accuracy, accuracy);
    Setup { tables, settings, database }
}

#[test]
fn a_single_transducer_that_drifts_or_steps_is_named_on_each_cylinder() {
    let setup = single();
    let options = tertius::simulator::Options { in_loop: true, ..setup.options(4, &[]) };
    let (mut simulator, mut bench) = (setup.simulator(&options), Bench::new(&setup));
    bench.run(&mut simulator, 100.0);
    assert!(bench.heard.others.is_empty(), "{:?}", bench.heard.others);
    assert!(bench.heard.warnings.is_empty(), "{:?}", bench.heard.warnings);
    for cylinder in 1..=6 {
        for (shape, kind) in [
            ("drift,rate=0.002", Fault::Incipient),
            ("drift,rate=-0.002", Fault::Incipient),
            ("step,size=0.01", Fault::Abrupt),
            ("step,size=-0.01", Fault::Abrupt),
        ] {
            let what = format!("{shape} of cylinder {cylinder}");
            let faults = setup.options(4, &[format!("{shape},cylinder={cylinder},sensor=c1,at=1")]);
            let mut simulator = simulator.clone();
            simulator.afflict(&faults.faults, 4);
            let mut bench = Bench { monitor: bench.monitor.clone(), heard: Heard::default() };
            bench.run(&mut simulator, 12.0);
            let own: Vec<_> =
                (1..=6).flat_map(|cylinder| of_deck(&bench.heard, cylinder)).collect();
            let [first] = own[..] else { panic!("{what}: {own:?}") };
            assert_eq!((first.state, first.cylinder), (State::Raised, cylinder), "{what}");
            let finding = first.finding;
            assert_eq!((finding.suspect, finding.fault), (Suspect::C1, kind), "{what}");
            assert_eq!(finding.level, Level::Black, "{what}: there is no other one");
            let size = finding.residual.expect(&what);
            assert!(
                (0.004..0.012).contains(&size.abs()) && (size < 0.0) == shape.contains("=-"),
                "{what}: {size}"
            );
        }
    }
}

#[test]
fn nothing_is_found_of_healthy_single_transducers() {
    let setup = single();
    for (seed, fluctuates) in [(7, false), (8, true)] {
        let mut setup = setup.clone();
        setup.tables.transducer.fluctuation_probability = if fluctuates { 5e-4 } else { 0.0 };
        let (mut simulator, mut bench) =
            (setup.simulator(&setup.options(seed, &[])), Bench::new(&setup));
        bench.run(&mut simulator, 1800.0);
        assert_eq!(bench.heard.warnings.first(), None, "{seed}");
    }
}
