//! The sequential detectors on a simulated machine that they were calibrated to: what they find, how
//! soon, whom they blame, and what they let pass.

mod calibrated_support;
mod support;

use std::sync::OnceLock;
use tertius::alarm::{Detector, State as Said, Warning};
use tertius::config::settings::Settings;
use tertius::controller::State;
use tertius::decode::{Database, text};
use tertius::inject::{Fault, place};
use tertius::monitor::{Monitor, MonitorDesign, Sink};
use tertius::sequential::{Blame, Dwell, Moved};
use tertius::simulator::{EPOCH, Options, Simulator, Tables};
use tertius::verdict::{Fault as Kind, Suspect};

const SAMPLE_TIME: f64 = 0.02;

struct Setup {
    tables: Tables,
    settings: Settings,
    database: Database,
}

/// The machine, calibrated once.
fn setup() -> &'static Setup {
    static SETUP: OnceLock<Setup> = OnceLock::new();
    SETUP.get_or_init(|| {
        let loaded = tertius::config::load(&support::top().join("config/e-type-simulated.toml"))
            .expect("it is sound");
        let database = Database::parse(&text::from_bytes(&loaded.dbc_text)).expect("it is sound");
        let mut setup =
            Setup { tables: calibrated_support::fine(), settings: loaded.settings, database };
        setup.settings.sequential.stop_states = Some(vec!["safe".to_owned()]);
        calibrated_support::calibrate(&setup.tables, &mut setup.settings, &setup.database);
        setup
    })
}

impl Setup {
    fn simulator(&self, options: &Options) -> Simulator {
        let simulator = Simulator::new(&self.tables, &self.settings, &self.database, options);
        let mut simulator = simulator.expect("the default machine can be simulated");
        simulator.request(State::Engaged);
        simulator
    }

    /// What the detectors say of a machine with these faults, for so many seconds.
    fn run(&self, seconds: f64, in_loop: bool, faults: &[String]) -> Heard {
        let placed = faults.iter().map(|fault| {
            let fault = Fault::parse(fault).expect("a fault");
            place(&fault, &self.settings, &self.database).expect("it has a place")
        });
        let faults = placed.collect();
        let options = Options { seed: 4, in_loop, faults, ..Options::default() };
        let mut simulator = self.simulator(&options);
        let mut monitor = self.monitor();
        let mut heard = Heard::default();
        for _ in 0..(seconds / SAMPLE_TIME) as u64 {
            simulator.step(&mut |frame| monitor.take(frame, &mut heard));
        }
        heard
    }

    fn monitor(&self) -> Monitor {
        Monitor::new(MonitorDesign::new(&self.settings, &self.database).expect("they fit"))
    }
}

/// The warnings of the sequential detectors.
#[derive(Default)]
struct Heard {
    warnings: Vec<Warning>,
    dwells: Vec<(u8, Dwell, Option<Moved>)>,
}

impl Sink for Heard {
    fn warning(&mut self, warning: &Warning) {
        if warning.detector == Detector::Sequential {
            self.warnings.push(*warning);
        }
    }

    fn dwell(&mut self, cylinder: u8, dwell: &Dwell, moved: Option<&Moved>) {
        self.dwells.push((cylinder, *dwell, moved.copied()));
    }
}

impl Heard {
    /// For a person.
    fn told(&self) -> String {
        let line = |w: &Warning| {
            let (at, finding) = (w.timestamp.since(EPOCH).as_seconds(), &w.finding);
            let (fault, suspect) = (finding.fault.name(), finding.suspect.name());
            format!("{at:.2} s {}: {} {fault} {suspect}\n", w.cylinder, w.state.name())
        };
        self.warnings.iter().take(20).map(line).collect()
    }

    /// Of a cylinder: s from `at` to the first raise, and the last word on it before it was cleared.
    fn of(&self, cylinder: u8, at: f64) -> Option<(f64, Warning)> {
        let own = || self.warnings.iter().filter(|warning| warning.cylinder == cylinder);
        let first = own().find(|warning| warning.state == Said::Raised)?;
        let last = own().take_while(|warning| warning.state != Said::Cleared).last()?;
        Some((first.timestamp.since(EPOCH).as_seconds() - at, *last))
    }
}

/// One fault on each cylinder, C1 of the odd ones, 5 s apart.
fn one_each(fault: &str) -> (Vec<String>, Vec<(u8, Suspect, f64)>) {
    (1..=6_u8)
        .map(|cylinder| {
            let (sensor, suspect) =
                if cylinder % 2 == 1 { ("c1", Suspect::C1) } else { ("c2", Suspect::C2) };
            let at = 10.0 + 5.0 * f64::from(cylinder);
            let text = format!("{fault},cylinder={cylinder},sensor={sensor},at={at}");
            (text, (cylinder, suspect, at))
        })
        .unzip()
}

#[test]
fn a_healthy_machine_is_left_alone() {
    let heard = setup().run(900.0, false, &[]);
    assert!(heard.warnings.is_empty(), "{}", heard.told());
}

#[test]
fn half_a_millimetre_is_found_and_the_right_transducer_blamed() {
    for size in ["0.0005", "-0.0005"] {
        let (faults, truth) = one_each(&format!("step,size={size}"));
        let heard = setup().run(45.0, false, &faults);
        for (cylinder, suspect, at) in truth {
            let (delay, last) = heard.of(cylinder, at).expect("it is found");
            assert!((0.0..0.2).contains(&delay), "{cylinder}: {delay}");
            assert_eq!(last.finding.suspect, suspect, "{cylinder}: {:?}", last.finding);
            assert_eq!(last.finding.fault, Kind::Abrupt, "{cylinder}");
            let size = last.finding.residual.expect("it has a size").abs();
            assert!((size - 5e-4).abs() < 1.5e-4, "{cylinder}: {size}");
            let evidence = last.finding.evidence.expect("it has evidence");
            let onset = evidence.onset.since(EPOCH).as_seconds();
            assert!((onset - at).abs() < 0.1, "{cylinder}: {onset} for {at}");
            assert!(evidence.location.is_some_and(|nats| nats.abs() > 5.0), "{evidence:?}");
        }
    }
}

/// Ten millimetres are in the variance, too, and sooner than in the mean.
#[test]
fn a_large_step_is_no_noise() {
    for size in ["0.003", "-0.025"] {
        let (faults, truth) = one_each(&format!("step,size={size}"));
        let heard = setup().run(45.0, false, &faults);
        for (cylinder, suspect, at) in truth {
            let (delay, last) = heard.of(cylinder, at).expect("it is found");
            assert!((0.0..0.2).contains(&delay), "{cylinder}: {delay}");
            let told = (last.finding.suspect, last.finding.fault);
            assert_eq!(told, (suspect, Kind::Abrupt), "{size} {cylinder}\n{}", heard.told());
        }
    }
}

#[test]
fn noise_is_told_from_a_step_and_its_transducer_blamed() {
    let (faults, truth) = one_each("noise,size=0.000868");
    let heard = setup().run(45.0, false, &faults);
    for (cylinder, suspect, at) in truth {
        let (delay, last) = heard.of(cylinder, at).expect("it is found");
        assert!((0.0..0.4).contains(&delay), "{cylinder}: {delay}");
        let told = (last.finding.suspect, last.finding.fault);
        assert_eq!(told, (suspect, Kind::Noise), "{cylinder}\n{}", heard.told());
    }
}

/// In the closed loop the controller follows C1, and C2 is the one that looks wrong.
#[test]
fn a_slow_drift_is_found_and_nobody_is_blamed_for_it() {
    for in_loop in [false, true] {
        for rate in [1e-3, 1e-4] {
            let (faults, truth) = one_each(&format!("drift,rate={rate}"));
            let heard = setup().run(50.0, in_loop, &faults);
            for (cylinder, _, at) in truth {
                let (delay, last) = heard.of(cylinder, at).expect("it is found");
                assert!((0.0..4.0).contains(&delay), "{cylinder}: {delay}");
                assert_eq!(last.finding.suspect, Suspect::Undecided, "{cylinder} {in_loop} {rate}");
                if rate > 2e-4 {
                    assert_eq!(last.finding.fault, Kind::Incipient, "{cylinder} {in_loop}");
                }
            }
        }
    }
}

/// Spikes of single samples and lost frames are no faults of a transducer's length.
#[test]
fn single_wild_samples_and_lost_frames_are_let_pass() {
    let faults = [
        "spike,size=0.01,probability=0.005,cylinder=2,sensor=c1,at=20",
        "loss,probability=0.02,cylinder=4,sensor=c2,at=20",
    ];
    let heard = setup().run(120.0, false, &faults.map(str::to_owned));
    assert!(heard.warnings.is_empty(), "{}", heard.told());
}

/// The machine goes down to its stops again and again; C1 of cylinder 3 drifts meanwhile.
#[test]
fn the_stop_tells_which_transducer_has_drifted() {
    let setup = setup();
    let fault = "drift,rate=0.00001,cylinder=3,sensor=c1,at=400";
    let fault = Fault::parse(fault).expect("a fault");
    let placed = place(&fault, &setup.settings, &setup.database).expect("it has a place");
    let options =
        Options { seed: 9, start: State::Safe, faults: vec![placed], ..Options::default() };
    let mut simulator = setup.simulator(&options);
    let mut monitor = setup.monitor();
    let mut heard = Heard::default();
    for round in 0..10 {
        for (state, seconds) in [(State::Engaged, 60.0), (State::Safe, 60.0)] {
            simulator.request(state);
            for _ in 0..(seconds / SAMPLE_TIME) as u64 {
                simulator.step(&mut |frame| monitor.take(frame, &mut heard));
            }
        }
        assert!(round < 3 || heard.dwells.len() >= 6 * 3, "{round}: {}", heard.dwells.len());
    }
    let (_, last) = heard.of(3, 400.0).expect("the drift is found");
    assert_eq!(last.finding.suspect, Suspect::C1, "{}", heard.told());
    assert!(heard.warnings.iter().all(|warning| warning.cylinder == 3), "{}", heard.told());
    let blames = |n: u8| {
        let own = heard.dwells.iter().filter(move |(cylinder, ..)| *cylinder == n);
        own.filter_map(|(_, _, moved)| Some(moved.as_ref()?.blame()))
    };
    assert_eq!(blames(3).next_back(), Some(Blame::C1));
    assert!((1..=6).filter(|n| *n != 3).flat_map(blames).all(|blame| blame == Blame::Neither));
    let (_, detector) = monitor.sequential().find(|(n, _)| *n == 3).expect("it has one");
    let trend = detector.dwells().trend(0).expect("there is a history");
    assert!(trend.per_month > 10.0 * trend.error, "{trend:?}");
}
