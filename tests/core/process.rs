//! Process detectors, taught by one recording of a simulated machine with imperfect hydraulics, on others of it.

use crate::sequential_support::setup;
use std::sync::LazyLock;
use tertius::alarm::status::Health;
use tertius::alarm::{Detector, Level, State, Warning};
use tertius::config;
use tertius::config::design;
use tertius::config::settings::{Cylinder, Settings};
use tertius::controller::State as ControllerState;
use tertius::dbc::{Database, text};
use tertius::frame::Frame;
use tertius::inject::{Fault, Wanted, place};
use tertius::monitor::{Monitor, MonitorDesign};
use tertius::relate::{LearntProcess, ProcessRefusal, ProcessRows, SupplyRows};
use tertius::simulator::{Change, EPOCH, Options, Simulator, Tables};
use tertius::survey::{Ranking, Survey, Window};
use tertius::time::Span;
use tertius::verdict::{Fault as Kind, Suspect};
use tertius_testing::support::top;

/// The machine, and what it has taught.
pub struct Taught {
    settings: Settings,
    database: Database,
    tables: Tables,
    learnt: Vec<LearntProcess>,
    /// Why nothing was learnt of the supply.
    unsupplied: Option<ProcessRefusal>,
    pub design: MonitorDesign,
}

pub static TAUGHT: LazyLock<Taught> = LazyLock::new(|| Taught::by(&[], 700.0));

fn parsed(faults: &[&str]) -> Vec<Fault> {
    faults.iter().map(|text| Fault::parse(text).expect(text)).collect()
}

/// The machine with these faults, which the controller reads.
fn simulator(
    tables: &Tables,
    settings: &Settings,
    database: &Database,
    seed: u64,
    faults: &[&str],
) -> Simulator {
    let (ailments, readings): (Vec<Fault>, Vec<Fault>) =
        parsed(faults).into_iter().partition(|it| matches!(it.wanted, Wanted::Machine(_)));
    let faults = readings.iter().map(|it| place(it, settings, database).expect("it has a place"));
    let options =
        Options { seed, faults: faults.collect(), ailments, in_loop: true, ..Options::default() };
    Simulator::new(tables, settings, database, &options).expect("it can be simulated")
}

impl Taught {
    /// By `seconds` of a recording with these faults, in the plant's own sea.
    fn by(faults: &[&str], seconds: f64) -> Self {
        Self::in_a_sea(None, faults, seconds)
    }

    /// The same in a sea of a significant height in m and a peak period in s.
    fn in_a_sea(sea: Option<[f64; 2]>, faults: &[&str], seconds: f64) -> Self {
        Self::on(|_| (), sea, faults, seconds)
    }

    /// The machine of a configuration without C2.
    pub fn alone() -> Self {
        let without = |settings: &mut Settings| {
            let own = &mut settings.signals.cylinder;
            (own.c2, own.c2_velocity, own.c2_status, own.c2_counter) = (None, None, None, None);
        };
        Self::on(without, None, &[], 700.0)
    }

    /// The machine of the configuration after a `change`.
    fn on(
        change: impl Fn(&mut Settings),
        sea: Option<[f64; 2]>,
        faults: &[&str],
        seconds: f64,
    ) -> Self {
        let loaded = config::load(&top().join("config/e-type-simulated.toml")).expect("it ships");
        let database = Database::parse(&text::from_bytes(&loaded.dbc_text)).expect("it ships");
        let plant = std::fs::read_to_string(top().join("config/e-type-hydraulic-plant.toml"));
        let tables = Tables::parse(&plant.expect("it ships")).expect("it ships");
        let mut settings = loaded.settings;
        change(&mut settings);
        let surveying = design::surveying(&settings, &database).expect("they fit");
        let mut rows = (ProcessRows::new(&settings), SupplyRows::new(&settings));
        let (mut monitor, mut survey) =
            (Monitor::new(surveying), Survey::new(EPOCH, Window::ALL, &mut rows));
        let mut lesson = tables.clone();
        [lesson.sea.height, lesson.sea.period] =
            sea.unwrap_or([tables.sea.height, tables.sea.period]);
        let mut simulator = simulator(&lesson, &settings, &database, 7, faults);
        for _ in 0..(seconds / 0.02) as u64 {
            simulator.step(&mut |frame: &Frame| monitor.take(frame, &mut survey));
        }
        let gains: Vec<f64> = (1..=6).map(|n| settings.comparator_of(n).0).collect();
        let (rows, supply) = rows;
        let learnt = rows.learn(&settings, &Ranking::default(), &gains);
        let supply = supply.learn(&Ranking::default(), settings.process_level());
        let unsupplied = supply.as_ref().err().copied();
        settings.process.supply = supply.ok();
        for one in &learnt {
            let process = one.table(0.02);
            match settings.cylinder.iter_mut().find(|own| own.n == one.number) {
                Some(own) => own.process = process,
                None => settings.cylinder.push(Cylinder { process, ..Cylinder::new(one.number) }),
            }
        }
        let design = design::judging(&settings, &database).expect("they fit");
        Self { settings, database, tables, learnt, unsupplied, design }
    }

    /// Frames of `seconds` of another recording with these faults.
    pub fn frames(&self, seed: u64, faults: &[&str], seconds: f64) -> Vec<Frame> {
        let mut simulator = simulator(&self.tables, &self.settings, &self.database, seed, faults);
        let mut frames = Vec::new();
        for _ in 0..(seconds / 0.02) as u64 {
            simulator.step(&mut |frame| frames.push(frame.clone()));
        }
        frames
    }

    /// Warnings of `seconds` of another recording with these faults.
    pub fn warnings(&self, seed: u64, faults: &[&str], seconds: f64) -> Vec<Warning> {
        self.by_design(self.design.clone(), seed, faults, seconds)
    }

    /// The same by another monitor.
    fn by_design(
        &self,
        design: MonitorDesign,
        seed: u64,
        faults: &[&str],
        seconds: f64,
    ) -> Vec<Warning> {
        let (mut monitor, mut warnings) = (Monitor::new(design), Vec::new());
        let frames = self.frames(seed, faults, seconds);
        frames.iter().for_each(|frame| monitor.take(frame, &mut warnings));
        monitor.finish(&mut warnings);
        warnings
    }
}

pub fn of_process(warnings: &[Warning]) -> Vec<&Warning> {
    warnings.iter().filter(|it| it.detector == Detector::Process).collect()
}

#[test]
fn a_fault_of_a_cylinder_is_found_and_named_with_its_size() {
    for (fault, kind, size, within) in [
        ("sticking,cylinder=2,at=25,band=0.01", Kind::ValveSticking, Some(1.0), 1.0),
        ("sticking,cylinder=5,at=25,band=0.03", Kind::ValveSticking, Some(3.0), 1.0),
        ("spool_offset,cylinder=1,at=25,size=-0.01", Kind::ValveOffset, Some(-1.0), 0.5),
        ("late_command,cylinder=6,at=25,cycles=2", Kind::Command, Some(2.0), 2.0),
        ("wrong_command,cylinder=3,at=25,gain=0.1", Kind::Command, None, 2.0),
        (
            "step,sensor=pressure_rod,cylinder=4,at=25,size=-5",
            Kind::PressureSensor,
            Some(-5.0),
            0.5,
        ),
        ("freeze,sensor=pressure_bottom,cylinder=4,at=25", Kind::PressureSensor, None, 10.0),
        ("leakage,cylinder=2,at=25,rate=2.2", Kind::Leakage, Some(2.2 / 7000.0 * 24.0), 8.0),
        ("null_shift,cylinder=5,at=25,size=0.01", Kind::ValveOffset, Some(1.0), 8.0),
        ("dead_band,cylinder=3,at=25,size=0.02", Kind::ValveDeadBand, Some(2.0), 8.0),
        ("friction,cylinder=3,at=25,factor=4", Kind::Friction, None, 20.0),
    ] {
        let warnings = TAUGHT.warnings(21, &[fault], 55.0);
        let found = of_process(&warnings);
        let first = found.first().unwrap_or_else(|| panic!("{fault}: nothing was found"));
        let delay = first.timestamp.since(EPOCH).as_seconds() - 25.0;
        assert!((0.0..within).contains(&delay), "{fault}: after {delay} s");
        let cylinder = parsed(&[fault])[0].cylinder;
        assert!(found.iter().all(|it| it.cylinder == cylinder), "{fault}: {found:?}");
        let last = found.last().expect("there is a first").finding;
        assert_eq!((last.fault, last.suspect), (kind, Suspect::Process), "{fault}");
        let told = last.evidence.and_then(|it| it.size);
        if let Some(size) = size {
            let told = told.unwrap_or_else(|| panic!("{fault}: no size"));
            assert!((told - size).abs() < 0.2 * f64::abs(size), "{fault}: {told}");
        }
        let blamed = |it: &&Warning| matches!(it.finding.suspect, Suspect::C1 | Suspect::C2);
        assert_eq!(warnings.iter().find(blamed), None, "{fault}");
    }
}

#[test]
fn a_fault_of_a_transducer_is_none_of_the_cylinder() {
    for fault in [
        "step,cylinder=2,at=25,size=0.005",
        "step,cylinder=2,at=25,size=0.06",
        "drift,cylinder=5,sensor=c2,at=25,rate=0.005",
        "noise,cylinder=1,at=25,size=0.0017",
        "freeze,cylinder=4,at=25",
    ] {
        let warnings = TAUGHT.warnings(22, &[fault], 45.0);
        assert!(!warnings.is_empty(), "{fault}");
        assert_eq!(of_process(&warnings), Vec::<&Warning>::new(), "{fault}");
    }
}

/// Of a C1 with gaps the controller makes a command that leaps as no lesson's does, for which no valve is to blame. A
/// frame that is lost now and then does not matter.
#[test]
fn while_many_readings_are_lost_valve_and_rod_are_not_judged() {
    let (hardly, nearly_always) = (0.0..0.12, 0.75..1.0);
    for (sensor, probability, judged) in
        [("c1", "0.2", &hardly), ("c2", "0.2", &hardly), ("c1", "0.02", &nearly_always)]
    {
        let lost = format!("loss,cylinder=2,sensor={sensor},at=12,probability={probability}");
        let (mut monitor, mut warnings) = (Monitor::new(TAUGHT.design.clone()), Vec::new());
        let frames = TAUGHT.frames(31, &[&lost], 100.0);
        frames.iter().for_each(|frame| monitor.take(frame, &mut warnings));
        let coverages = monitor.tallies().map(|tally| tally.process.expect("it has detectors"));
        for (n, coverage) in (1..).zip(coverages) {
            let judged_by = coverage.judged().map(|it| it.expect("it was taught"));
            // Friction needs nine seconds in which none is lost.
            let [spool, chambers, flow, _, supply] = judged_by;
            let expected = if n == 2 { judged } else { &nearly_always };
            // The supply gives oil to all of them.
            let of_all =
                [(spool, expected), (chambers, expected), (flow, expected), (supply, judged)];
            for (cycles, expected) in of_all {
                let share = cycles as f64 / coverage.monitored as f64;
                assert!(expected.contains(&share), "{sensor}, {probability}, {n}: {share}");
            }
        }
    }
}

/// Every cylinder's sum is off: nobody's sensor but the supply's, of which there is one.
#[test]
fn pressures_that_are_off_everywhere_are_the_supply_s() {
    let faults: Vec<String> =
        (1..=6).map(|n| format!("step,sensor=pressure_bottom,cylinder={n},at=25,size=8")).collect();
    let faults: Vec<&str> = faults.iter().map(String::as_str).collect();
    let warnings = TAUGHT.warnings(23, &faults, 30.0);
    let found = of_process(&warnings);
    let raised = found.iter().filter(|it| it.state == State::Raised);
    assert!(
        raised.clone().count() == 6 && raised.clone().all(|it| it.finding.fault == Kind::Supply),
        "{found:?}"
    );
    let four = TAUGHT.warnings(23, &faults[..2], 30.0);
    assert!(of_process(&four).iter().all(|it| it.finding.fault == Kind::PressureSensor));
}

/// The machine with what was taught of it, and with sequential detectors.
fn beside_sequential() -> MonitorDesign {
    let mut settings = setup().settings.clone();
    settings.process.supply.clone_from(&TAUGHT.settings.process.supply);
    for own in &mut settings.cylinder {
        let taught = TAUGHT.settings.cylinder.iter().find(|it| it.n == own.n);
        own.process = taught.and_then(|it| it.process.clone());
    }
    design::judging(&settings, &TAUGHT.database).expect("they fit")
}

/// The rod of a valve that does not follow its command departs from dead reckoning, as a reading that drifts would.
#[test]
fn a_valve_beside_its_command_is_no_drift_of_the_transducer_that_is_left() {
    let faults = [
        // The controller reads C1: without it the rod would run to an end of its stroke.
        "loss,cylinder=2,sensor=c2,at=150,probability=1",
        "spool_offset,cylinder=2,at=170,size=0.06",
        "freeze,cylinder=3,sensor=c2,at=150",
        "spool_offset,cylinder=3,at=180,size=0.06",
        "loss,cylinder=5,sensor=c2,at=151,probability=1",
        "drift,cylinder=5,sensor=c1,at=170,rate=0.04",
    ];
    let warnings = TAUGHT.by_design(beside_sequential(), 31, &faults, 220.0);
    let blames = |n: u8, suspect| {
        warnings.iter().any(|it| it.cylinder == n && it.finding.suspect == suspect)
    };
    for n in [2, 3] {
        assert!(blames(n, Suspect::Process), "{n}");
        assert!(!blames(n, Suspect::C1), "{n}");
    }
    assert!(blames(5, Suspect::C1), "a drift is found on the same machine");
}

/// Nothing is left to compare C1 with but where the oil takes the rod, though the controller follows it.
#[test]
fn a_drift_of_the_last_transducer_departs_from_the_oil() {
    let faults: Vec<String> = (1..=3)
        .flat_map(|n| {
            let rate = [0.003, -0.005, 0.01][n - 1];
            [
                format!("loss,cylinder={n},sensor=c2,at=250,probability=1"),
                format!("drift,cylinder={n},sensor=c1,at=270,rate={rate}"),
            ]
        })
        .chain((4..=6).map(|n| format!("loss,cylinder={n},sensor=c2,at=250,probability=1")))
        .collect();
    let faults: Vec<&str> = faults.iter().map(String::as_str).collect();
    let warnings = TAUGHT.warnings(33, &faults, 330.0);
    for n in 1..=6 {
        let of_it = |it: &&Warning| it.cylinder == n && it.finding.suspect == Suspect::C1;
        let after = warnings.iter().find(of_it).map(|it| {
            assert_eq!(
                (it.finding.fault, it.finding.level),
                (Kind::Incipient, Level::Black),
                "{n}"
            );
            it.timestamp.since(EPOCH).as_seconds() - 270.0
        });
        assert_eq!(after.is_some_and(|it| (0.0..20.0).contains(&it)), n <= 3, "{n}: {after:?}");
    }
}

/// As where they share a supply or an input card: their difference is zero, and both observers follow. The controller takes
/// the rod back by as much. Of the second cylinder the oil does not give the way when the readings come back.
#[test]
fn both_that_step_alike_depart_from_the_way_until_they_are_back() {
    let faults: Vec<String> = [(3, 0.03), (5, -0.04)]
        .iter()
        .flat_map(|(n, size)| {
            ["c1", "c2"].map(|sensor| {
                format!("step,cylinder={n},sensor={sensor},at=200,until=260,size={size}")
            })
        })
        .collect();
    let faults: Vec<&str> = faults.iter().map(String::as_str).collect();
    let (mut monitor, mut warnings) = (Monitor::new(TAUGHT.design.clone()), Vec::new());
    let mut healthy = Vec::new();
    let mut simulator = simulator(&TAUGHT.tables, &TAUGHT.settings, &TAUGHT.database, 35, &faults);
    for cycle in 0..15_000_u32 {
        simulator.step(&mut |frame| monitor.take(frame, &mut warnings));
        let at = 0.02 * f64::from(cycle);
        let status = monitor.status(EPOCH.after(Span::from_seconds(at)));
        healthy.push((at, status.transducers.map(|it| it == [Health::Healthy; 2])));
    }
    monitor.finish(&mut warnings);
    let other = warnings.iter().find(|it| it.finding.suspect != Suspect::Process);
    assert!(other.is_none(), "{other:?}");
    for n in [3, 5] {
        let is_healthy = |since: f64, until: f64| {
            let during = healthy.iter().filter(|(at, _)| (since..until).contains(at));
            during.map(|(_, of)| of[n - 1]).collect::<Vec<bool>>()
        };
        assert!(is_healthy(190.0, 200.0).iter().all(|it| *it), "{n}");
        assert!(!is_healthy(200.1, 260.0).contains(&true), "{n}");
        // The oil that passed the valve had taken the way back for that of the rod.
        assert!(is_healthy(295.0, 300.0).iter().all(|it| *it), "{n}");
    }
}

/// The first one reads on its stop what it read there before. Its readings came back where nothing was monitored.
#[test]
fn what_both_share_ends_on_the_stop_where_they_read_what_they_read_before() {
    let of = |n: u8, until: &str| {
        ["c1", "c2"]
            .map(|sensor| format!("step,cylinder={n},sensor={sensor},at=200{until},size=0.03"))
    };
    let faults = [of(3, ",until=335"), of(5, "")].concat();
    let faults: Vec<&str> = faults.iter().map(String::as_str).collect();
    let mut monitor = Monitor::new(TAUGHT.design.clone());
    let mut simulator = simulator(&TAUGHT.tables, &TAUGHT.settings, &TAUGHT.database, 35, &faults);
    let mut healthy = Vec::new();
    for (state, seconds) in [
        (ControllerState::Engaged, 30_u32),
        (ControllerState::Safe, 60),
        (ControllerState::Engaged, 200),
        (ControllerState::Safe, 70),
        (ControllerState::Engaged, 30),
    ] {
        simulator.request(state);
        let mut warnings: Vec<Warning> = Vec::new();
        for _ in 0..50 * seconds {
            simulator.step(&mut |frame| monitor.take(frame, &mut warnings));
        }
        let status = monitor.status(simulator.opening());
        healthy.push([3, 5].map(|n: usize| status.transducers[n - 1] == [Health::Healthy; 2]));
    }
    assert_eq!((healthy[0], healthy[2], healthy[4]), ([true; 2], [false; 2], [true, false]));
}

/// The controller follows a C1 that drifts until the end of the rod's way holds it. C2, which stands there as the rod does,
/// has only C1 against it, which was apart from it before.
#[test]
fn a_rod_that_a_drifting_c1_has_driven_to_its_end_is_no_frozen_c2() {
    let design = beside_sequential();
    let faults = [
        "drift,cylinder=2,at=40,rate=0.012",
        "drift,cylinder=5,at=40,rate=-0.012",
        "freeze,cylinder=4,sensor=c2,at=60",
    ];
    let warnings = TAUGHT.by_design(design, 31, &faults, 240.0);
    let blames = |n: u8, detector, suspect| {
        let mut of_it = warnings.iter().filter(|it| it.cylinder == n && it.detector == detector);
        of_it.any(|it| it.finding.suspect == suspect)
    };
    for n in [2, 5] {
        assert!(blames(n, Detector::Sequential, Suspect::C1), "{n}");
        assert!(!blames(n, Detector::Plausibility, Suspect::C2), "{n}");
        // Both observers see that the rod goes no further.
        assert!(!blames(n, Detector::Fde2, Suspect::C2), "{n}");
    }
    assert!(blames(4, Detector::Plausibility, Suspect::C2));
}

/// One fault of the machine, which every cylinder tells, and no transducer's.
#[test]
fn a_supply_that_falls_is_found_with_its_size_and_accuses_no_transducer() {
    for (part, size) in [(0.1, -24.0), (0.2, -48.0), (0.3, -72.0)] {
        let fault = format!("supply_loss,cylinder=1,at=25,part={part}");
        let warnings = TAUGHT.warnings(27, &[&fault], 90.0);
        let found = of_process(&warnings);
        assert!(found.iter().all(|it| it.finding.fault == Kind::Supply), "{found:?}");
        for n in 1..=6 {
            let own = || found.iter().filter(|it| it.cylinder == n);
            let raised = own().find(|it| it.state == State::Raised).expect("it is raised");
            let delay = raised.timestamp.since(EPOCH).as_seconds() - 25.0;
            assert!((0.0..3.0).contains(&delay), "{n}: {delay} s");
            let told = own().next_back().and_then(|it| it.finding.size()).expect("it has a size");
            assert!((told - size).abs() < 0.15 * f64::abs(size), "{part} {n}: {told} bar");
        }
        let blamed = |it: &&Warning| matches!(it.finding.suspect, Suspect::C1 | Suspect::C2);
        assert_eq!(warnings.iter().find(blamed), None, "{part}");
    }
}

/// What a calm sea teaches of the chambers at 230 bar says little of them at 200.
#[test]
fn a_supply_that_falls_out_of_what_was_taught_is_no_fault_of_the_sensors_in_chambers() {
    let calm = Taught::in_a_sea(Some([1.3, 6.8]), &[], 700.0);
    let warnings = calm.warnings(27, &["supply_loss,cylinder=1,at=25,part=0.25"], 60.0);
    let found = of_process(&warnings);
    assert!(
        !found.is_empty() && found.iter().all(|it| it.finding.fault == Kind::Supply),
        "{found:?}"
    );
}

#[test]
fn a_healthy_machine_in_another_sea_is_quiet() {
    let warnings = TAUGHT.warnings(24, &[], 400.0);
    assert_eq!(of_process(&warnings), Vec::<&Warning>::new());
}

/// What the oil's temperature and another load do is no fault; nor is a tenth more friction.
#[test]
fn a_worn_machine_with_another_load_is_quiet() {
    let mut worn = Taught::by(&[], 700.0);
    worn.tables.friction.coulomb *= 1.1;
    worn.tables.friction.stiction *= 1.1;
    worn.tables.friction.viscous *= 1.2;
    worn.tables.disturbance.load = Some(Change { time: [0.0, 1e9], part: 1.3 });
    let warnings = worn.warnings(25, &[], 400.0);
    assert_eq!(of_process(&warnings), Vec::<&Warning>::new());
}

/// The plant has 2 kN of Coulomb's and 40 kN s/m of viscous friction over 0.02 m²: 1 bar and 20 bar s/m, less where the
/// oil is warm.
#[test]
fn friction_is_learnt_as_the_plant_has_it() {
    for learnt in &TAUGHT.learnt {
        let Some(Ok(table)) = &learnt.friction else { panic!("{:?}", learnt.remarks()) };
        let [.., viscous, coulomb] = table.coefficients;
        assert!((13.0..23.0).contains(&viscous), "{}: {viscous} bar s/m", learnt.number);
        assert!((0.9..1.4).contains(&coulomb), "{}: {coulomb} bar", learnt.number);
    }
}

#[test]
fn a_recording_with_a_fault_in_it_teaches_nothing_of_that_cylinder() {
    let taught = Taught::by(
        &[
            "sticking,cylinder=2,at=300,until=320,band=0.03",
            "friction,cylinder=5,at=300,until=360,factor=4",
            "step,sensor=pressure_rod,cylinder=4,at=300,until=320,size=6",
            "supply_loss,cylinder=1,at=500,until=530,part=0.15",
        ],
        700.0,
    );
    for learnt in &taught.learnt {
        let is_refused = [
            learnt.spool.as_ref().is_some_and(Result::is_err),
            learnt.chambers.as_ref().is_some_and(Result::is_err),
            learnt.friction.as_ref().is_some_and(Result::is_err),
        ];
        let expected = [2, 4, 5].map(|number| learnt.number == number);
        assert_eq!(is_refused, expected, "{:?}", learnt.remarks());
    }
    let Some(ProcessRefusal::Contradicted { at, .. }) = taught.unsupplied else {
        panic!("{:?}", taught.unsupplied)
    };
    assert!((500.0..540.0).contains(&at), "{at} s");
    let told = taught.learnt[1].remarks();
    assert!(told[0].contains("by the spool") && told[0].contains("is there a fault"), "{told:?}");
    // A minute is no lesson.
    let short = Taught::by(&[], 60.0);
    assert!(short.learnt.iter().all(|it| it.table(0.02).is_none() && it.remarks().len() == 4));
    assert!(matches!(short.unsupplied, Some(ProcessRefusal::Short { .. })));
}
