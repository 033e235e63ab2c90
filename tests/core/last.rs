//! One transducer of a cylinder is out, and the last one fails: its observer alone finds it and names it, and nothing
//! calls it healthy, or the estimate valid, until there is evidence.

use crate::sequential_support::{EPOCH, Setup, fine, setup};
use std::path::Path;
use tertius::alarm::status::Health;
use tertius::alarm::{Detector, Level, State as Said, Warning};
use tertius::config::design;
use tertius::controller::State;
use tertius::dbc::{Database, text};
use tertius::estimate::{Estimate, Source};
use tertius::incident::{Incident, Progress};
use tertius::monitor::{Estimates, Monitor, Sink};
use tertius::simulator::{Options, Tables};
use tertius::time::Span;
use tertius::verdict::{Fault, Suspect};

/// What the monitor passes on.
#[derive(Default)]
struct Seen {
    warnings: Vec<Warning>,
    incidents: Vec<Incident>,
    /// Of each cylinder: time, s, and estimate.
    estimates: Vec<(u8, f64, Option<Estimate>)>,
}

impl Sink for Seen {
    fn warning(&mut self, warning: &Warning) {
        self.warnings.push(*warning);
    }

    fn incident(&mut self, incident: &Incident) {
        self.incidents.push(*incident);
    }

    fn estimate(
        &mut self,
        at: tertius::time::Timestamp,
        cylinder: u8,
        estimate: Option<&Estimate>,
    ) {
        self.estimates.push((cylinder, at.since(EPOCH).as_seconds(), estimate.copied()));
    }
}

impl Seen {
    /// Time, s, and finding of each warning that begins to name a suspect of a cylinder with an observer or a check.
    fn named(&self, cylinder: u8, suspect: Suspect) -> Vec<(f64, Detector, Level, Fault)> {
        let of_it = self.warnings.iter().filter(|it| it.cylinder == cylinder);
        let named = of_it.filter(|it| it.state != Said::Cleared && it.finding.suspect == suspect);
        let told = |it: &Warning| {
            let at = it.timestamp.since(EPOCH).as_seconds();
            (at, it.detector, it.finding.level, it.finding.fault)
        };
        named.map(told).collect()
    }

    /// Time, s, of the first warning of a cylinder that names the suspect at the level of both.
    fn black(&self, cylinder: u8, suspect: Suspect) -> Option<f64> {
        let named = self.named(cylinder, suspect);
        named.iter().find(|it| it.2 == Level::Black).map(|it| it.0)
    }

    /// Times, s, in which the estimate of a cylinder was valid.
    fn valid(&self, cylinder: u8) -> Vec<f64> {
        let of_it = self.estimates.iter().filter(|it| it.0 == cylinder);
        of_it.filter(|it| it.2.is_some_and(|it| it.valid)).map(|it| it.1).collect()
    }

    /// Suspects of the incidents of a cylinder, as they were last told.
    fn incidents(&self, cylinder: u8) -> Vec<(u32, Suspect, Progress)> {
        let mut last: Vec<(u32, Suspect, Progress)> = Vec::new();
        for it in self.incidents.iter().filter(|it| it.scope.has(cylinder.into())) {
            let said = (it.number, it.suspect, it.progress);
            match last.iter_mut().find(|known| known.0 == it.number) {
                Some(known) => *known = said,
                None => last.push(said),
            }
        }
        last
    }
}

/// The machine with the thresholds of the thesis.
fn machine(tables: Tables) -> Setup {
    let top = Path::new(env!("CARGO_MANIFEST_DIR"));
    let loaded = tertius::config::load(&top.join("config/e-type-simulated.toml"));
    let loaded = loaded.expect("it is sound");
    let database = Database::parse(&text::from_bytes(&loaded.dbc_text)).expect("it is sound");
    Setup { tables, settings: loaded.settings, database }
}

fn play(setup: &Setup, seconds: f64, options: &Options) -> Seen {
    let mut design = design::judging(&setup.settings, &setup.database).expect("they fit");
    design.estimates = Estimates::Computed;
    let (mut simulator, mut monitor) = (setup.simulator(options), Monitor::new(design));
    let mut seen = Seen::default();
    for _ in 0..(seconds / 0.02) as u64 {
        simulator.step(&mut |frame| monitor.take(frame, &mut seen));
    }
    monitor.finish(&mut seen);
    seen
}

/// C1 of each cylinder is out from 40 s on, and C2 has `fault` from 60 s on, each cylinder a tenth of a second after the
/// one before: what all of them show at once is one incident of the machine.
fn faults(out: &str, fault: &str) -> Vec<String> {
    let of = |n: u8| {
        [
            format!("{out},cylinder={n},sensor=c1,at={}", 40.0 + later(n)),
            format!("{fault},cylinder={n},sensor=c2,at={}", 60.0 + later(n)),
        ]
    };
    (1..=6).flat_map(of).collect()
}

/// How much later the faults of a cylinder begin, s.
fn later(n: u8) -> f64 {
    0.1 * f64::from(n)
}

#[test]
fn a_step_of_the_last_transducer_is_its_own_and_latched() {
    let setup = machine(fine(&[], ""));
    for out in ["loss", "freeze", "broken_wire", "step,size=0.01"] {
        for size in ["0.0025", "-0.06"] {
            let step = format!("step,size={size}");
            let seen = play(&setup, 90.0, &setup.options(11, &faults(out, &step)));
            for cylinder in 1..=6 {
                let what = format!("{out}, {size}, cylinder {cylinder}");
                let black = seen
                    .black(cylinder, Suspect::C2)
                    .unwrap_or_else(|| panic!("{what}: {:?}", seen.named(cylinder, Suspect::C2)));
                let onset = 60.0 + later(cylinder);
                assert!((onset - 1e-3..onset + 0.34).contains(&black), "{what}: {black}");
                let cleared = seen.warnings.iter().any(|it| {
                    it.cylinder == cylinder
                        && it.state == Said::Cleared
                        && it.finding.suspect == Suspect::C2
                });
                assert!(!cleared, "{what}: it is taken for healthy again");
                let suspects: Vec<_> =
                    seen.incidents(cylinder).iter().map(|it| (it.1, it.2)).collect();
                let standing = |suspect| (suspect, Progress::Standing);
                assert_eq!(suspects, [standing(Suspect::C1), standing(Suspect::C2)], "{what}");
                let valid = seen.valid(cylinder);
                assert!(valid.iter().any(|at| (50.0..60.0).contains(at)), "{what}");
                let after = valid.iter().find(|at| **at >= onset);
                assert_eq!(after, None, "{what}: valid after the step");
                let newest = seen.estimates.iter().rfind(|it| it.0 == cylinder).and_then(|it| it.2);
                let without = newest.expect(&what).without;
                assert!((without - 30.0 + later(cylinder)).abs() < 0.1, "{what}: {without}");
            }
        }
    }
}

/// Its command passes through rest at each turn of the sea.
#[test]
fn a_last_transducer_that_freezes_is_found_within_seconds() {
    let setup = machine(fine(&[], ""));
    for seed in 1..=3 {
        for in_loop in [false, true] {
            // In the loop the controller reads C1, so that C2 is out there.
            let (out, last, suspect) =
                if in_loop { ("c2", "c1", Suspect::C1) } else { ("c1", "c2", Suspect::C2) };
            let of = |n: u8| {
                let loss = format!("loss,cylinder={n},sensor={out},at=40");
                [loss, format!("freeze,cylinder={n},sensor={last},at={}", 60 + 3 * n)]
            };
            let faults: Vec<String> = (1..=6).flat_map(of).collect();
            let options = Options { in_loop, ..setup.options(seed, &faults) };
            let seen = play(&setup, 100.0, &options);
            for cylinder in 1..=6 {
                let at = f64::from(60 + 3 * cylinder);
                let named = seen.named(cylinder, suspect);
                let what = format!("{seed}, {in_loop}, {cylinder}: {named:?}");
                let frozen = named.iter().find(|it| it.3 == Fault::Frozen && it.2 == Level::Black);
                let delay = frozen.expect(&what).0 - at;
                assert!((0.0..6.0).contains(&delay), "{what}: {delay}");
                let late = seen.valid(cylinder).into_iter().find(|it| *it > at + delay);
                assert_eq!(late, None, "{what}");
            }
        }
    }
}

#[test]
fn both_that_freeze_at_once_are_both_named() {
    for tables in [fine(&[], ""), fine(&[("counts = 27648.0", "counts = 6912.0")], "")] {
        let setup = machine(tables);
        let of =
            |n: u8| ["c1", "c2"].map(|sensor| format!("freeze,cylinder={n},sensor={sensor},at=60"));
        let faults: Vec<String> = (1..=6).flat_map(of).collect();
        let seen = play(&setup, 90.0, &setup.options(5, &faults));
        for cylinder in 1..=6 {
            for suspect in [Suspect::C1, Suspect::C2] {
                let black = seen.black(cylinder, suspect).expect("both");
                assert!((60.0..65.0).contains(&black), "{cylinder}, {suspect:?}: {black}");
                let late = seen.valid(cylinder).into_iter().find(|at| *at > black);
                assert_eq!(late, None, "{cylinder}");
            }
        }
    }
}

/// Such a reading is not known to be right, whether it counts as frozen yet or not.
#[test]
fn readings_that_stand_under_a_command_that_travels_are_not_healthy() {
    let setup = machine(fine(&[], ""));
    for begin in [60.0, 61.0, 62.0, 63.0, 64.0, 65.0] {
        let of = |n: u8| {
            ["c1", "c2"].map(|sensor| format!("freeze,cylinder={n},sensor={sensor},at={begin}"))
        };
        let faults: Vec<String> = (1..=6).flat_map(of).collect();
        let design = design::judging(&setup.settings, &setup.database).expect("they fit");
        let (mut simulator, mut monitor) =
            (setup.simulator(&setup.options(5, &faults)), Monitor::new(design));
        let (mut seen, mut was_healthy, mut late) = (Seen::default(), 0, Vec::new());
        for cycle in 0..4000_u32 {
            simulator.step(&mut |frame| monitor.take(frame, &mut seen));
            let at = 0.02 * f64::from(cycle);
            let status = monitor.status(EPOCH.after(Span::from_seconds(at)));
            let healthy = status.transducers.iter().flatten().filter(|it| **it == Health::Healthy);
            match healthy.count() {
                count if at < begin => was_healthy = was_healthy.max(count),
                0 => {}
                _ => late.push(at - begin),
            }
        }
        assert_eq!(was_healthy, 12);
        assert!(late.iter().all(|after| *after < 1.2), "{begin}: {late:?}");
    }
}

/// A stop is evidence: the last transducer reads there what it read before, or is off by as much as it was.
#[test]
fn the_latch_ends_on_a_stop_where_the_reading_is_right_again() {
    let setup = machine(fine(&[], ""));
    let of = |n: u8| {
        let until = if n <= 3 { ",until=205" } else { "" };
        [
            format!("loss,cylinder={n},sensor=c1,at={},probability=1", 180.0 + later(n)),
            format!("step,cylinder={n},sensor=c2,at={},size=0.02{until}", 200.0 + later(n)),
        ]
    };
    let faults: Vec<String> = (1..=6).flat_map(of).collect();
    let design = design::judging(&setup.settings, &setup.database).expect("they fit");
    let (mut simulator, mut monitor) =
        (setup.simulator(&setup.options(5, &faults)), Monitor::new(design));
    let mut seen = Seen::default();
    for (state, seconds) in
        [(State::Engaged, 30), (State::Safe, 90), (State::Engaged, 110), (State::Safe, 120)]
    {
        simulator.request(state);
        for _ in 0..50 * seconds {
            simulator.step(&mut |frame| monitor.take(frame, &mut seen));
        }
    }
    for cylinder in 1..=6 {
        let black = seen.black(cylinder, Suspect::C2).expect("it steps");
        assert!((200.0..202.0).contains(&black), "{cylinder}: {black}");
        let ends = |it: &&Warning| {
            let is_c2 = it.cylinder == cylinder && it.finding.suspect == Suspect::C2;
            is_c2 && it.state == Said::Cleared
        };
        let cleared =
            seen.warnings.iter().find(ends).map(|it| it.timestamp.since(EPOCH).as_seconds());
        let on_the_stop = cleared.is_some_and(|it| it > 230.0);
        assert_eq!(
            (cleared.is_some(), on_the_stop),
            (cylinder <= 3, cylinder <= 3),
            "{cylinder}: {cleared:?}"
        );
    }
}

/// C1 stands 10 mm off, and C2 steps to the same place: they agree, and are both wrong.
#[test]
fn two_that_agree_because_the_last_one_stepped_are_both_named() {
    let setup = machine(fine(&[], ""));
    let seen = play(&setup, 90.0, &setup.options(13, &faults("step,size=0.01", "step,size=0.01")));
    for cylinder in 1..=6 {
        let at = 60.0 + later(cylinder);
        for suspect in [Suspect::C1, Suspect::C2] {
            let black = seen.black(cylinder, suspect).expect("both");
            assert!((at - 1e-3..at + 0.34).contains(&black), "{cylinder}, {suspect:?}: {black}");
        }
        let late = seen.valid(cylinder).into_iter().find(|it| *it > at + 0.34);
        assert_eq!(late, None, "{cylinder}");
        let standing = |it: &&(u32, Suspect, Progress)| it.2 == Progress::Standing;
        let told = seen.incidents(cylinder);
        assert!(told.iter().any(|it| standing(&it)), "{cylinder}: {told:?}");
        println!("{told:?}");
    }
    // C1 comes back, and C2 after it: that is evidence.
    let back = |n: u8| {
        let of = |sensor: &str, at: f64, until: f64| {
            format!("step,cylinder={n},sensor={sensor},at={at},size=0.01,until={until}")
        };
        [of("c1", 40.0 + later(n), 70.0), of("c2", 60.0 + later(n), 75.0)]
    };
    let faults: Vec<String> = (1..=6).flat_map(back).collect();
    let seen = play(&setup, 90.0, &setup.options(13, &faults));
    for cylinder in 1..=6 {
        let told = seen.incidents(cylinder);
        assert!(told.iter().all(|it| it.2 == Progress::Closed), "{cylinder}: {told:?}");
        assert!(seen.valid(cylinder).iter().any(|at| *at > 85.0), "{cylinder}");
    }
}

/// A single wild sample, and the motion of a rod that a faulty C1 drives, are not the last transducer's.
#[test]
fn a_sound_last_transducer_is_not_doubted_for_good() {
    let setup = machine(fine(&[], ""));
    let spikes = "spike,size=0.006,probability=0.005";
    let seen = play(&setup, 120.0, &setup.options(3, &faults("loss", spikes)));
    for cylinder in 1..=6 {
        let named = seen.named(cylinder, Suspect::C2);
        assert_eq!(seen.black(cylinder, Suspect::C2), None, "{cylinder}: {named:?}");
        assert!(!seen.named(cylinder, Suspect::C2).is_empty(), "{cylinder}: none was seen");
    }
    for out in [
        "loss",
        "freeze",
        "step,size=0.06",
        "step,size=-0.01",
        "noise,size=0.0026",
        "drift,rate=0.02",
    ] {
        let faults: Vec<String> =
            (1..=6).map(|n| format!("{out},cylinder={n},sensor=c1,at={}", 40 + n)).collect();
        for seed in [3, 4] {
            let options = Options { in_loop: true, ..setup.options(seed, &faults) };
            let seen = play(&setup, 100.0, &options);
            for cylinder in 1..=6 {
                let named = seen.named(cylinder, Suspect::C2);
                let black = seen.black(cylinder, Suspect::C2);
                assert_eq!(black, None, "{out}, {seed}, {cylinder}: {named:?}");
            }
        }
    }
}

/// Beside a sequential detector a wild reading leaves nothing in the observer. With the weights that commissioning finds, the
/// quiet after it confirmed it as an error: one in fifty of both readings had latched both for twenty minutes.
#[test]
fn a_wild_reading_of_the_last_transducer_is_let_pass() {
    let mut setup = setup().clone();
    setup.settings.observer.q = [1.58e-6, 2e-7, 1e4];
    setup.settings.observer.r = [1e-8, 0.0158];
    let spikes = "spike,size=0.004,probability=0.005";
    let seen = play(&setup, 120.0, &setup.options(3, &faults("loss", spikes)));
    for cylinder in 1..=6 {
        let named = seen.named(cylinder, Suspect::C2);
        assert_eq!(seen.black(cylinder, Suspect::C2), None, "{cylinder}: {named:?}");
    }
    // And a step is not.
    let seen = play(&setup, 90.0, &setup.options(3, &faults("loss", "step,size=0.004")));
    for cylinder in 1..=6 {
        let black = seen.black(cylinder, Suspect::C2).expect("it is found");
        let onset = 60.0 + later(cylinder);
        assert!((onset - 1e-3..onset + 0.5).contains(&black), "{cylinder}: {black}");
    }
}

/// The other one comes back and agrees: that is evidence.
#[test]
fn the_latch_ends_when_the_other_transducer_is_back_and_agrees() {
    let setup = machine(fine(&[], ""));
    let of = |until: &str| {
        vec![
            "loss,cylinder=1,sensor=c1,at=40,until=70".to_owned(),
            format!("step,cylinder=1,sensor=c2,at=60,size=0.01{until}"),
        ]
    };
    let seen = play(&setup, 100.0, &setup.options(7, &of(",until=65")));
    assert!(seen.incidents(1).iter().all(|it| it.2 == Progress::Closed), "{:?}", seen.incidents(1));
    assert!(seen.valid(1).iter().any(|at| *at > 90.0));
    assert!(!seen.valid(1).iter().any(|at| (60.0..70.0).contains(at)));
    let seen = play(&setup, 100.0, &setup.options(7, &of("")));
    let standing = |it: &&(u32, Suspect, Progress)| it.2 == Progress::Standing;
    let left: Vec<_> = seen.incidents(1).into_iter().collect();
    let left: Vec<Suspect> = left.iter().filter(standing).map(|it| it.1).collect();
    assert_eq!(left, [Suspect::C2]);
    let source = |it: &(u8, f64, Option<Estimate>)| it.0 == 1 && it.1 > 95.0;
    let newest = seen.estimates.iter().rfind(|it| source(it)).and_then(|it| it.2);
    assert!(newest.is_some_and(|it| it.source == Source::C1), "{newest:?}");
}

/// C1 has stood 10 mm off for a minute when C2 is lost, or steps, too; then C1 steps again.
#[test]
fn a_step_that_stood_still_is_subtracted_where_nothing_else_is_left() {
    let mut setup = machine(fine(&[], ""));
    let healthy = play(&setup, 130.0, &setup.options(9, &[]));
    setup.settings.estimate.accommodate_after = Some(30.0);
    for last in ["loss", "step,size=-0.02"] {
        let of = |n: u8| {
            let c1 =
                |at: u32, size: &str| format!("step,cylinder={n},sensor=c1,at={at},size={size}");
            [c1(40, "0.01"), format!("{last},cylinder={n},sensor=c2,at=100"), c1(120, "-0.004")]
        };
        let faults: Vec<String> = (1..=6).flat_map(of).collect();
        let seen = play(&setup, 130.0, &setup.options(9, &faults));
        let (mut corrected, mut off) = (0, 0);
        for (told, right) in seen.estimates.iter().zip(&healthy.estimates) {
            let Some((estimate, right)) = told.2.zip(right.2) else { continue };
            let is_wrong = (estimate.position - right.position).abs() > 3.0 * estimate.sigma;
            off += u32::from(estimate.valid && is_wrong && (101.0..120.0).contains(&told.1));
            if estimate.source == Source::C1Corrected && estimate.valid {
                corrected += 1;
                assert!((100.0..120.01).contains(&told.1), "{last}: {told:?}");
            }
        }
        // 20 s of six cylinders, less what it takes until C2 is blamed.
        assert!(corrected > 5800, "{last}: {corrected}");
        assert!(off < corrected / 100, "{last}: {off} of {corrected}");
        let late = (1..=6).find_map(|n| seen.valid(n).into_iter().find(|at| *at > 120.01));
        assert_eq!(late, None, "{last}: C1 stepped again");
    }
}

/// C1 drifts by 0.05 mm/s, which nobody can name, and C2 is lost: what is left may be the one that was wrong.
#[test]
fn a_transducer_that_is_left_of_a_dispute_is_not_valid() {
    let setup = machine(fine(&[], ""));
    let of = |n: u8| {
        [
            format!("drift,cylinder={n},sensor=c1,at=30,rate=0.00005"),
            format!("loss,cylinder={n},sensor=c2,at={}", 100.0 + later(n)),
        ]
    };
    let faults: Vec<String> = (1..=6).flat_map(of).collect();
    let seen = play(&setup, 120.0, &setup.options(17, &faults));
    for cylinder in 1..=6 {
        let (valid, lost) = (seen.valid(cylinder), 100.0 + later(cylinder));
        assert!(valid.iter().any(|at| (90.0..100.0).contains(at)), "{cylinder}: by both");
        let late = valid.into_iter().find(|at| *at > lost + 0.2);
        assert_eq!(late, None, "{cylinder}");
    }
}
