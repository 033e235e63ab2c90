//! Readings that stand: in the controller's loop until the rod has come to its end, and shortly after
//! something else, on machines of any sample time.

use crate::sequential_support::{Bench, Heard, Setup, fine, setup};
use std::path::Path;
use tertius::alarm::{Detector, State as Said, Warning};
use tertius::dbc::{Database, text};
use tertius::simulator::{EPOCH, Options, Tables};
use tertius::verdict::Suspect;

/// The machine with the thresholds alone.
fn machine(tables: Tables) -> Setup {
    let top = Path::new(env!("CARGO_MANIFEST_DIR"));
    let loaded = tertius::config::load(&top.join("config/e-type-simulated.toml"));
    let loaded = loaded.expect("it is sound");
    let database = Database::parse(&text::from_bytes(&loaded.dbc_text)).expect("it is sound");
    Setup { tables, settings: loaded.settings, database }
}

/// Whom the detectors of a cylinder have suspected since `at`, s, in turn.
fn suspected(heard: &Heard, cylinder: u8, at: f64) -> Vec<(Detector, Suspect)> {
    let of_it = heard.others.iter().filter(|warning| warning.cylinder == cylinder);
    let since =
        of_it.filter(|w| w.state != Said::Cleared && w.timestamp.since(EPOCH).as_seconds() >= at);
    since.map(|warning| (warning.detector, warning.finding.suspect)).collect()
}

/// The controller drives the rod on by a C1 that stands, until its end holds it; then C2 stands, too.
#[test]
fn a_frozen_c1_that_the_controller_reads_is_nobody_elses_fault_to_the_end() {
    let coarse = || fine(&[("counts = 27648.0", "counts = 6912.0")], "");
    let at = |cylinder: u8| 10.0 + 5.0 * f64::from(cylinder);
    for (what, tables) in [("fine", fine(&[], "")), ("coarse", coarse())] {
        let setup = machine(tables);
        for seed in 1..=2 {
            let freeze = |n: u8| format!("freeze,cylinder={n},sensor=c1,at={}", at(n));
            let faults: Vec<String> = (1..=6).map(freeze).collect();
            let options = Options { in_loop: true, ..setup.options(seed, &faults) };
            let heard = setup.play(100.0, &options);
            for cylinder in 1..=6 {
                let suspected = suspected(&heard, cylinder, at(cylinder));
                let wrong = |it: &&(_, Suspect)| matches!(it.1, Suspect::C2 | Suspect::Process);
                let wrong: Vec<_> = suspected.iter().filter(wrong).collect();
                assert!(wrong.is_empty(), "{what}, {seed}, {cylinder}: {wrong:?}");
                let frozen = suspected.contains(&(Detector::Plausibility, Suspect::C1));
                assert!(frozen, "{what}, {seed}, {cylinder}: {suspected:?}");
            }
        }
    }
}

/// It drives the rod to its end by a C1 that drifts, too: there C2 stands, and C1, which is all that says that the rod moves,
/// was apart from it before.
#[test]
fn a_c1_that_drifts_on_while_the_rod_is_at_its_end_does_not_make_c2_frozen() {
    let setup = machine(fine(&[], ""));
    let drift = |n: u8| {
        let rate = if n.is_multiple_of(2) { 0.03 } else { -0.03 };
        format!("drift,cylinder={n},sensor=c1,at=10,rate={rate},until=85")
    };
    let faults: Vec<String> = (1..=6).map(drift).collect();
    let options = Options { in_loop: true, ..setup.options(3, &faults) };
    let heard = setup.play(84.0, &options);
    for cylinder in 1..=6 {
        let suspected = suspected(&heard, cylinder, 10.0);
        assert!(suspected.iter().any(|it| it.0 == Detector::Fde3), "{cylinder}: {suspected:?}");
        assert!(!suspected.contains(&(Detector::Plausibility, Suspect::C2)), "{cylinder}");
    }
}

/// Noise is no difference: C1, which has it, says as well as before that the rod moves.
#[test]
fn beside_a_noisy_one_a_frozen_reading_is_found_as_soon() {
    let at = |n: u8| 55.0 + 0.7 * f64::from(n);
    let fault = |n: u8| {
        let noise = format!("noise,cylinder={n},sensor=c1,at=30,size=0.0004");
        [noise, format!("freeze,cylinder={n},sensor=c2,at={}", at(n))]
    };
    let faults: Vec<String> = (1..=6).flat_map(fault).collect();
    let heard = setup().play(60.0, &setup().options(5, &faults));
    for cylinder in 1..=6 {
        let (after, _) = heard.of(cylinder, 30.0).expect("the noise is found");
        assert!(after < 20.0, "{cylinder}: after {after} s");
        let is_frozen =
            |it: &&Warning| it.cylinder == cylinder && it.detector == Detector::Plausibility;
        let frozen = heard.others.iter().find(is_frozen).expect("it is found");
        let after = frozen.timestamp.since(EPOCH).as_seconds() - at(cylinder);
        assert_eq!(frozen.finding.suspect, Suspect::C2);
        assert!((0.0..1.0).contains(&after), "{cylinder}: after {after} s");
    }
}

/// Runs machines of `sample_time` s, whose models these are, with both faults on a cylinder.
fn after(
    sample_time: f64,
    (theta, gamma): ([f64; 5], [f64; 2]),
    faults: [&str; 2],
    judge: impl Fn(Heard),
) {
    let mut setup = machine(fine(&[], ""));
    setup.settings.machine.sample_time = sample_time;
    let model = &mut setup.settings.model;
    (model.theta, model.gamma, model.sample_time) = (theta, gamma, Some(sample_time));
    for seed in 0..3 {
        let options = setup.options(seed, &faults.map(|fault| format!("{fault},cylinder=1")));
        let (mut simulator, mut bench) = (setup.simulator(&options), Bench::new(&setup));
        (0..(22.0 / sample_time) as u32).for_each(|_| bench.step(&mut simulator));
        judge(bench.heard);
    }
}

/// What coincides is a matter of seconds: at 50 ms, C2 that has stepped a third of a second before C1
/// freezes has stepped; at 7 ms, what drifted for 150 ms and then froze is one fault.
#[test]
fn what_froze_explains_what_came_just_before_at_any_sample_time() {
    // As `identify` has them from a quarter of an hour.
    let of_50_ms = ([-0.00886, -0.4375, -7.7975e-6, -14.7224, -2.869e-4], [0.42084, 14.3726]);
    let of_7_ms = ([-0.002314, -0.06594, -9.796e-7, -6.01246, -1.034e-4], [0.063602, 5.8194]);
    let stepped = ["step,size=0.02,sensor=c2,at=20", "freeze,sensor=c1,at=20.35"];
    after(0.05, of_50_ms, stepped, |heard| {
        let fde2: Vec<_> = suspected(&heard, 1, 20.0)
            .into_iter()
            .filter(|(detector, _)| *detector == Detector::Fde2)
            .collect();
        assert!(!fde2.is_empty(), "it was found");
        assert!(fde2.iter().all(|(_, suspect)| *suspect == Suspect::C2), "{fde2:?}");
    });
    let drifted = ["drift,rate=0.05,sensor=c1,at=20", "freeze,sensor=c1,at=20.15"];
    after(0.007, of_7_ms, drifted, |heard| {
        let suspected = suspected(&heard, 1, 20.0);
        let fde3 = suspected.iter().rfind(|(detector, _)| *detector == Detector::Fde3);
        assert_eq!(fde3, Some(&(Detector::Fde3, Suspect::C1)), "{suspected:?}");
    });
}
