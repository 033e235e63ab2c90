//! What is no fault of a transducer, and what the sequential detectors say of it: nothing.

use crate::sequential_support::{Bench, Heard, Setup, fine, one_each, setup};
use tertius::alarm::{Detector, State as Said, Warning};
use tertius::controller::State;
use tertius::estimate::Estimate;
use tertius::frame::Frame;
use tertius::monitor::{self, Monitor, MonitorDesign, Notice, Sink};
use tertius::simulator::{EPOCH, Tables};
use tertius::time::{Span, Timestamp};
use tertius::verdict::{Suspect, Verdict};

/// As `tune` writes it from half an hour of a good machine, nats.
const LOW_LEVEL: f64 = 12.0;

#[track_caller]
fn nothing(heard: &Heard, what: &str) {
    assert!(heard.warnings.is_empty(), "{what}\n{}", heard.told());
}

/// Single samples, seconds apart, on either transducer, also at a low level.
#[test]
fn spikes() {
    let of = |size: f64| -> Vec<String> {
        let one = |n: u8| {
            let sensor = if n % 2 == 1 { "c1" } else { "c2" };
            format!("spike,size={size},probability=0.005,cylinder={n},sensor={sensor},at=2")
        };
        (1..=6).map(one).collect()
    };
    for size in [0.001, 0.005, -0.005, 0.3] {
        nothing(&setup().run(300.0, false, &of(size)), &format!("{size} m"));
        let low = setup().at_level(LOW_LEVEL).run(300.0, false, &of(size));
        nothing(&low, &format!("{size} m at a low level"));
    }
}

/// The machine with single samples of all transducers off by so many counts, up or down: these shares of
/// those of C1 and of C2.
fn spiky(share: [f64; 2], counts: f64) -> Tables {
    let spikes =
        format!("spikes = {{ time = [0.0, 1e6], share = {share:?}, counts = {counts:?} }}");
    fine(&[], &format!("\n[disturbance]\n{spikes}\n"))
}

/// On either transducer and on both, of all cylinders, which the calibration has never seen.
#[test]
fn many_spikes() {
    for share in [0.001, 0.005, 0.01, 0.02, 0.03] {
        for counts in [2.0, 4.0, 10.0, 40.0] {
            for shares in [[share, 0.0], [0.0, share], [share; 2]] {
                let heard = setup().with(spiky(shares, counts)).run(20.0, false, &[]);
                nothing(&heard, &format!("{shares:?} of {counts} counts"));
            }
        }
    }
    // As long as two of one sign have raised hundreds of alarms in.
    for (share, counts) in [(0.005, 4.0), (0.02, 4.0), (0.02, 40.0)] {
        let heard = setup().with(spiky([share; 2], counts)).run(240.0, false, &[]);
        nothing(&heard, &format!("{share} of {counts} counts"));
    }
}

/// Raises of FDE1, FDE2 and FDE3.
fn by_threshold(heard: &Heard) -> Vec<&Warning> {
    let is_fde =
        |it: &&Warning| matches!(it.detector, Detector::Fde1 | Detector::Fde2 | Detector::Fde3);
    heard.others.iter().filter(is_fde).filter(|it| it.state == Said::Raised).collect()
}

/// Half a sample in a hundred, on all twelve: three spikes a second, the larger ones beyond each threshold. What one leaves in
/// its observer is let pass, too.
#[test]
fn wild_samples_raise_no_threshold_and_hide_no_step() {
    // Spikes as large as the threshold are now and then beyond it and now and then not.
    for (counts, most) in [(10.0, 8), (40.0, 1), (200.0, 2)] {
        let setup = setup().with(spiky([0.005; 2], counts));
        let heard = setup.run(240.0, false, &[]);
        let raised = by_threshold(&heard);
        assert!(raised.len() <= most, "{counts} counts: {raised:?}");
        let step = "step,cylinder=2,sensor=c2,at=100.003,size=0.005".to_owned();
        let heard = setup.run(110.0, false, &[step]);
        let found = by_threshold(&heard);
        let first = found.iter().find(|it| it.cylinder == 2).expect("it is found");
        let delay = first.timestamp.since(EPOCH).as_seconds() - 100.0;
        assert!((0.0..0.1).contains(&delay), "{counts} counts: after {delay} s");
        assert_eq!(first.finding.suspect, Suspect::C2, "{counts} counts");
    }
}

/// `commission` leaves a cylinder without a sequential detector where nothing could be learnt for one, and its thresholds are
/// learnt all the same. Those of the thesis warn of each spike, as they do there.
#[test]
fn wild_samples_raise_no_learnt_threshold_without_a_sequential_detector() {
    let mut plain = setup().with(spiky([0.005; 2], 40.0));
    plain.settings.cylinder.iter_mut().for_each(|cylinder| cylinder.sequential = None);
    let mut learnt = plain.clone();
    learnt.settings.fde.command = Some(1.0);
    let [by_the_thesis, by_learnt] =
        [&plain, &learnt].map(|it| by_threshold(&it.run(120.0, false, &[])).len());
    assert!(by_the_thesis > 300 && by_learnt <= 1, "{by_the_thesis}, {by_learnt}");
    let step = "step,cylinder=2,sensor=c2,at=100.003,size=0.005".to_owned();
    let heard = learnt.run(110.0, false, &[step]);
    let found = by_threshold(&heard).into_iter().find(|it| it.cylinder == 2);
    let delay = found.expect("it is found").timestamp.since(EPOCH).as_seconds() - 100.0;
    assert!((0.0..0.1).contains(&delay), "after {delay} s");
}

/// Valid estimates, m, by the cylinder and the time of their cycle.
#[derive(Default)]
struct ValidEstimates(Vec<(u8, Timestamp, f64)>);

impl Sink for ValidEstimates {
    fn estimate(&mut self, at: Timestamp, cylinder: u8, estimate: Option<&Estimate>) {
        let valid = estimate.filter(|estimate| estimate.valid);
        self.0.extend(valid.map(|estimate| (cylinder, at, estimate.position)));
    }
}

/// A spike of 4.3 mm on one of two readings would move their mean by half of it, a hundred times in each ten thousand.
#[test]
fn a_wild_reading_moves_no_estimate() {
    let setup = setup().with(spiky([0.005; 2], 40.0));
    let mut simulator = setup.simulator(&setup.options(3, &[]));
    let (mut seen, mut off) = (0, Vec::new());
    let design = MonitorDesign { estimates: monitor::Estimates::Computed, ..setup.design() };
    let mut monitor = Monitor::new(design);
    for _ in 0..6_000 {
        let truth: [f64; 6] = std::array::from_fn(|leg| simulator.machine().calibrated(leg));
        let opening = simulator.opening();
        let mut estimates = ValidEstimates::default();
        simulator.step(&mut |frame| monitor.take(frame, &mut estimates));
        for (cylinder, at, length) in estimates.0 {
            if at.since(opening).as_seconds().abs() < 0.01 {
                seen += 1;
                let error = length - truth[usize::from(cylinder) - 1];
                off.extend((error.abs() > 1e-3).then_some((cylinder, at, error)));
            }
        }
    }
    assert!(seen > 30_000, "{seen}");
    // Where both are wild at once, nothing tells.
    assert!(off.len() <= 10, "{} of {seen}: {:?}", off.len(), &off[..off.len().min(5)]);
}

/// Twenty calm minutes say nothing of spikes to come, and a level by them alone is one that four of these
/// reach.
#[test]
fn a_tuned_level_is_one_for_spikes_too() {
    let tuned = setup().at_level(setup().tuned());
    let heard = tuned.with(spiky([0.02; 2], 40.0)).run(900.0, false, &[]);
    nothing(&heard, "2 % of 40 counts");
}

/// The machine whose C2 is sampled beside C1 from so many seconds on.
fn apart(from: f64, how: &str) -> Tables {
    let sampling = format!("sampling = {{ time = [{from:?}, 1e6], {how} }}");
    fine(&[], &format!("\n[disturbance]\n{sampling}\n"))
}

/// That C2 is sampled at another time than it was is no transducer's fault, and it is told.
#[test]
fn sampling_that_has_changed_is_told_and_nobody_blamed() {
    for how in ["jitter = 2e-4", "jitter = 5e-4", "skew = 2e-4", "skew = 5e-4"] {
        let heard = setup().with(apart(60.0, how)).run(180.0, false, &[]);
        nothing(&heard, how);
        let [Notice::Timing { at, apart: Some(apart) }] = heard.notices[..] else {
            panic!("{how}: {:?}", heard.notices);
        };
        let after = at.since(EPOCH).as_seconds() - 60.0;
        assert!((0.0..60.0).contains(&after), "{how}: {after} s");
        let found = if how.starts_with("skew") { -apart.mean } else { apart.spread };
        let size = if how.ends_with("5e-4") { 5e-4 } else { 2e-4 };
        assert!((found / size - 1.0).abs() < 0.5, "{how}: {apart:?}");
    }
}

/// A cylinder that moves fast when the others do not may have an alarm before they all know; of 2 ms and more
/// nearly all have one, and most residuals are wild.
#[test]
fn an_alarm_before_the_sampling_is_told_blames_nobody() {
    for (jitter, seeds, least) in [("1e-3", 20, 1), ("2e-3", 6, 20), ("3e-3", 4, 20)] {
        let tables = apart(60.0, &format!("jitter = {jitter}"));
        let setup = setup().at_level(20.0).with(tables);
        let mut alarms = 0;
        for seed in 0..seeds {
            let heard = setup.play(90.0, &setup.options(seed, &[]));
            let blames = |w: &&Warning| w.finding.suspect != Suspect::Undecided;
            let told = heard.told();
            assert_eq!(heard.warnings.iter().find(blames), None, "{jitter} s, {seed}\n{told}");
            alarms += heard.warnings.iter().filter(|w| w.state == Said::Raised).count();
            assert!(
                heard.notices.iter().any(|it| matches!(it, Notice::Timing { apart: Some(_), .. })),
                "{jitter} s, {seed}"
            );
        }
        assert!(alarms >= least, "{jitter} s: {alarms} alarms, and nothing was tried");
    }
}

/// A machine that has always been like that.
#[test]
fn sampling_and_spikes_that_were_calibrated_are_nothing_new() {
    for (what, tables) in
        [("jitter", apart(0.0, "jitter = 5e-4")), ("spikes", spiky([0.01; 2], 4.0))]
    {
        let setup = setup().with(tables).calibrated();
        let heard = setup.run(180.0, false, &[]);
        nothing(&heard, what);
        assert_eq!(heard.notices, [], "{what}");
        // And it sees what it did.
        let (faults, truth) = one_each("step,size=0.001");
        let heard = setup.run(45.0, false, &faults);
        for (cylinder, suspect, at) in truth {
            let (delay, last) = heard.of(cylinder, at).expect("it is found");
            assert!((0.0..0.3).contains(&delay), "{what}, {cylinder}: {delay}");
            assert_eq!(last.finding.suspect, suspect, "{what}, {cylinder}");
        }
    }
}

/// Of C1, C2 and valve of all cylinders: now and then a frame, and bursts of some cycles.
#[test]
fn lost_frames() {
    let losses = |of: &str| -> Vec<String> {
        let sensors = ["c1", "c2", "control_speed"];
        let all = (1..=6).flat_map(|n| sensors.map(|sensor| (n, sensor)));
        all.map(|(n, sensor)| format!("loss,{of},cylinder={n},sensor={sensor}")).collect()
    };
    nothing(&setup().run(300.0, false, &losses("probability=0.02,at=2")), "single ones");
    for cycles in [2, 5, 25, 150] {
        // Of one of the three at a time, and of all at once.
        let until = |at: f64| at + f64::from(cycles) * 0.02;
        let one_by_one: Vec<String> = ["c1", "c2", "control_speed"]
            .iter()
            .enumerate()
            .flat_map(|(i, sensor)| (1..=6).map(move |n| (10.0 + 10.0 * i as f64, sensor, n)))
            .map(|(at, sensor, n)| {
                let until = until(at);
                format!("loss,at={at},until={until},cylinder={n},sensor={sensor}")
            })
            .chain(losses(&format!("at=40,until={}", until(40.0))))
            .collect();
        nothing(&setup().run(120.0, false, &one_by_one), &format!("{cycles} cycles"));
    }
}

/// The bus is silent for some cycles.
#[test]
fn silence() {
    let setup = setup();
    let (mut simulator, mut bench) = (setup.simulator(&setup.options(5, &[])), Bench::new(setup));
    for cycles in [1, 3, 10, 100, 1000] {
        bench.run_through(&mut simulator, 60.0, |cycle, frame, pass| {
            if cycle >= cycles {
                pass(frame);
            }
        });
        nothing(&bench.heard, &format!("{cycles} cycles"));
    }
}

/// Every 20th reading comes with the next cycle, or at least after its own was closed.
#[test]
fn late_frames() {
    for delay in [0.004, 0.012, 0.0185, 0.024] {
        let setup = setup();
        let (mut simulator, mut bench) =
            (setup.simulator(&setup.options(6, &[])), Bench::new(setup));
        let mut held: Vec<Frame> = Vec::new();
        bench.run_through(&mut simulator, 120.0, |cycle, frame, pass| {
            let id = frame.id.value();
            let reading = (0x181..=0x186).contains(&id) || (0x191..=0x196).contains(&id);
            if reading && cycle % 20 == u64::from(id % 16) {
                let mut late = frame.clone();
                late.timestamp = frame.timestamp.after(Span::from_seconds(delay));
                return held.push(late);
            }
            held.retain(|late| {
                let due = late.timestamp <= frame.timestamp;
                if due {
                    pass(late);
                }
                !due
            });
            pass(frame);
        });
        let counts = bench.monitor.counts();
        assert!(delay < 0.018 || counts.late + counts.repeated > 1000, "{delay} s: {counts:?}");
        nothing(&bench.heard, &format!("{delay} s"));
    }
}

/// Engaged, neutral, settled, safe and back, with rods that stand still and rods on their stops.
fn through_all_states(setup: &Setup) -> Heard {
    let (mut simulator, mut bench) = (setup.simulator(&setup.options(7, &[])), Bench::new(setup));
    use State::{Engaged, Neutral, Safe, Settled};
    for _ in 0..5 {
        for state in [Engaged, Neutral, Settled, Safe, Settled, Neutral, Engaged, Safe] {
            simulator.request(state);
            bench.run(&mut simulator, 45.0);
        }
    }
    bench.heard
}

#[test]
fn changes_of_state() {
    nothing(&through_all_states(setup()), "monitored where it is engaged");
    for states in [vec!["engaged", "neutral"], vec!["safe", "settled", "neutral", "engaged"]] {
        let mut setup = setup().clone();
        let named = states.iter().map(|&state| state.to_owned()).collect();
        setup.settings.machine.monitored_states = Some(named);
        nothing(&through_all_states(&setup), &format!("monitored in {states:?}"));
    }
}

/// What befalls the process from 60 s on, and the tables for it.
fn befallen() -> Vec<(&'static str, Tables)> {
    let plain = |more: &str| fine(&[], &format!("\n[disturbance]\n{more}\n"));
    let valve = |keys: &str| plain(&format!("[disturbance.valve]\n{keys}\n"));
    vec![
        ("nothing", plain("")),
        ("a third more load", plain("load = { time = [60.0, 180.0], part = 1.3 }")),
        ("twice the load", plain("load = { time = [60.0, 180.0], part = 2.0 }")),
        ("half the load", plain("load = { time = [60.0, 180.0], part = 0.5 }")),
        ("the pump fails for 15 s", plain("pump = { time = [60.0, 75.0], part = 0.0 }")),
        ("a third of the pump", plain("pump = { time = [60.0, 180.0], part = 0.33 }")),
        ("spools stick by 1 %", plain("sticking = { time = [60.0, 180.0], band = 0.01 }")),
        ("spools stick by 4 %", plain("sticking = { time = [60.0, 180.0], band = 0.04 }")),
        ("spools stick by 10 %", plain("sticking = { time = [60.0, 180.0], band = 0.1 }")),
        (
            "valves of 1.2 times the flow, linear",
            valve(
                "lag = 0.06\noverlap = 0.01\nprogression = 0.0\nleakage = 0.002\n\
                 extend_speed = 2.16\nretract_speed = 1.92",
            ),
        ),
        (
            "slow valves with twice the overlap",
            valve(
                "lag = 0.09\noverlap = 0.02\nprogression = 0.6\nleakage = 0.002\n\
                 extend_speed = 1.6\nretract_speed = 1.4",
            ),
        ),
    ]
}

/// The process is another one: not a word from what was calibrated on the old one. And where the
/// calibration has been, what the observers say on their fixed model is the process's fault: the
/// readings agree. Beyond the stroke that it covered the observers' word stands, and is printed.
#[test]
fn load_supply_and_valve() {
    println!("the process: sequential; FDE1, FDE2 against C1 or C2, process, nobody; not covered");
    for (what, tables) in befallen() {
        let setup = setup().with(tables);
        let mut simulator = setup.simulator(&setup.options(8, &[]));
        let mut bench = Bench::new(&setup);
        let (mut blamed, mut process, mut nobody, mut uncovered) = (0, 0, 0, 0);
        for _ in 0..9000 {
            let before = bench.heard.others.len();
            bench.step(&mut simulator);
            let new = bench.heard.others[before..].iter();
            for warning in new.filter(|warning| warning.state == Said::Raised) {
                let detectors = bench.monitor.sequential();
                let known = detectors.filter(|(n, _)| *n == warning.cylinder);
                let known =
                    known.map(|(_, detector)| detector.verdict() == Verdict::Healthy).next();
                match warning.finding.suspect {
                    Suspect::C1 | Suspect::C2 if known == Some(true) => blamed += 1,
                    Suspect::C1 | Suspect::C2 => uncovered += 1,
                    Suspect::Process => process += 1,
                    Suspect::Undecided => nobody += 1,
                }
            }
        }
        let count = bench.heard.warnings.len();
        println!("{what:<40} {count:>5} {blamed:>8} {process:>5} {nobody:>5} {uncovered:>8}");
        nothing(&bench.heard, what);
        assert_eq!(blamed, 0, "{what}: a transducer is blamed for the process");
    }
}
