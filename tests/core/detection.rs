//! What the detectors must show: faults of every kind, put into the healthy recording at seeded
//! times by the injector, through the whole monitor. `--nocapture` prints what was found how fast.

use std::sync::OnceLock;
use tertius::alarm::{Detector, Level, State, Warning};
use tertius::inject::Fault as Injected;
use tertius::verdict::{Fault, Suspect};
use tertius_testing::detection::{BEFORE, Healthy, Outcome, Said, Try, tries};
use tertius_testing::support::{self, HANGING_LOAD, Scratch, recording, replay, tertius};

fn healthy() -> &'static Healthy {
    static HEALTHY: OnceLock<Healthy> = OnceLock::new();
    HEALTHY.get_or_init(Healthy::load)
}

/// One cycle, s.
fn cycle() -> f64 {
    healthy().sample_time().as_seconds()
}

/// The fault `kind` with its own `keys` at the place of `one`.
fn spec(one: &Try, kind: &str, keys: &str) -> String {
    format!("{kind},cylinder={},sensor={},at={}{keys}", one.cylinder, one.sensor(), one.t)
}

/// Whatever is wrong beside what a test asks for: false alarms, and blame for the wrong one.
fn assert_nothing_beside(said: &Said, spec: &str) {
    assert_eq!(said.beside, 0, "{spec}: warnings about another cylinder, or too early");
    assert_eq!(said.wrongly, 0, "{spec}: somebody else was blamed");
}

/// Plays steps of `size` and counts those found at once and blamed right.
fn steps(size: f64, count: u64) -> u64 {
    let mut good = 0;
    for one in tries(healthy(), count, 20, 2.0) {
        let spec = spec(&one, "step", &format!(",size={}", one.sign * size));
        let outcome = healthy().play_fault(&spec, one.t, 2.0, 0);
        let said = Said::of(&outcome, &one);
        assert_nothing_beside(&said, &spec);
        assert!(said.delay.is_none() || said.blames(one.suspect), "{spec}: {said:?}");
        good += u64::from(said.at_once(healthy()));
    }
    println!("step {:5.2} mm: {good} of {count} within one cycle, blamed right", size * 1e3);
    good
}

#[test]
fn every_step_from_1_75_mm_is_found_within_one_cycle_and_blamed_right() {
    for size in [1.75e-3, 2e-3, 2.5e-3, 5e-3, 10e-3, 25e-3] {
        assert_eq!(steps(size, 96), 96, "{size} m");
    }
}

#[test]
fn steps_of_1_25_mm_are_found_in_at_least_eight_of_ten() {
    let count = 240;
    let good = steps(1.25e-3, count);
    assert!(10 * good >= 8 * count, "{good} of {count}");
}

/// The first raise of `detector`.
fn raise(outcome: &Outcome, detector: Detector) -> Option<&Warning> {
    outcome.warnings.iter().find(|w| w.detector == detector && w.state == State::Raised)
}

/// The newest warning of `detector` that was not a clearing.
fn newest(outcome: &Outcome, detector: Detector) -> Option<&Warning> {
    outcome.warnings.iter().rfind(|w| w.detector == detector && w.state != State::Cleared)
}

/// φ = 0.07 m grows by 0.97 mm in its first cycle, just below δ_h, and the observer follows: FDE1
/// and FDE2 see some of these faults, and FDE3 all. Who does see it blames the right one.
#[test]
fn the_incipient_fault_of_5_18_is_found_within_80_ms_and_called_incipient() {
    let tries = tries(healthy(), 96, 21, 2.0);
    let (mut slowest, mut located) = (0.0_f64, 0);
    for one in &tries {
        let spec = spec(one, "incipient", &format!(",size={},b=1", one.sign * 0.07));
        let outcome = healthy().play_fault(&spec, one.t, 2.0, 0);
        let said = Said::of(&outcome, one);
        assert_nothing_beside(&said, &spec);
        let first = outcome.warnings.first().unwrap_or_else(|| panic!("{spec}: missed"));
        let delay = first.timestamp.since(healthy().at(one.t)).as_seconds();
        assert!(delay <= 0.08, "{spec}: only after {delay} s");
        slowest = slowest.max(delay);
        let difference = newest(&outcome, Detector::Fde3).expect("70 mm are beyond any bound");
        assert_eq!(difference.finding.fault, Fault::Incipient, "{spec}");
        assert!(said.delay.is_none() || said.blames(one.suspect), "{spec}: {said:?}");
        located += usize::from(said.delay.is_some());
    }
    let count = tries.len();
    println!("incipient 70 mm: slowest of {count} {slowest:.4} s after t0, located {located}");
}

#[test]
fn noise_from_two_sigma_is_found_by_the_right_observer_and_called_noise() {
    const SIGMA: f64 = 4.34e-4;
    for n in 2..=6 {
        let tries = tries(healthy(), 48, 22, 3.0);
        let (mut called, mut slowest) = (0, 0.0_f64);
        for one in &tries {
            let spec = spec(one, "noise", &format!(",size={}", f64::from(n) * SIGMA));
            let outcome = healthy().play_fault(&spec, one.t, 3.0, one.number);
            let said = Said::of(&outcome, one);
            assert_nothing_beside(&said, &spec);
            assert!(said.blames(one.suspect), "{spec}: {said:?}");
            slowest = slowest.max(said.delay.unwrap_or(f64::INFINITY));
            called += usize::from(said.finally.is_some_and(|f| f.fault == Fault::Noise));
        }
        let count = tries.len();
        println!("noise {n} σ: slowest {slowest:.3} s, called noise {called} of {count}");
        assert!(slowest <= 1.0, "{n} σ: {slowest} s");
        assert!(10 * called >= 9 * count, "{n} σ: called noise {called} of {count}");
    }
}

/// Plays `kind` and asserts that each is found as `fault` of the right transducer within `limit`
/// seconds of its first frame, where `due` says that it must be; returns how many were due.
fn implausible(kind: &str, fault: Fault, limit: f64, due: impl Fn(&Outcome, &Try) -> bool) -> u64 {
    let (mut slowest, mut count) = (0.0_f64, 0);
    for one in tries(healthy(), 48, 23, 2.0) {
        let spec = spec(&one, kind, "");
        let outcome = healthy().play_fault(&spec, one.t, 2.0, 0);
        assert_nothing_beside(&Said::of(&outcome, &one), &spec);
        let raised = raise(&outcome, Detector::Plausibility);
        if let Some(raised) = raised {
            let found = (raised.finding.fault, raised.finding.suspect);
            assert_eq!(found, (fault, one.suspect), "{spec}");
        }
        if !due(&outcome, &one) {
            continue;
        }
        let first = outcome.first_faulty.expect("the fault changes frames");
        let raised = raised.unwrap_or_else(|| panic!("{spec}: missed"));
        let delay = raised.timestamp.since(first).as_seconds();
        assert!(delay < limit, "{spec}: only after {delay} s");
        slowest = slowest.max(delay);
        count += 1;
    }
    println!("{kind}: slowest of {count} {slowest:.4} s");
    count
}

#[test]
fn what_needs_no_model_is_found_in_the_configured_times() {
    let always = |_: &Outcome, _: &Try| true;
    let stale = 0.1 + cycle();
    assert_eq!(implausible("broken_wire", Fault::BrokenWire, cycle(), always), 48);
    assert_eq!(implausible("out_of_range", Fault::OutOfRange, cycle(), always), 48);
    assert_eq!(implausible("stale", Fault::Stale, stale, always), 48);
    assert_eq!(implausible("loss", Fault::Stale, stale, always), 48);
}

/// A reading that does not change is a fault only while the command moves the cylinder.
#[test]
fn a_frozen_reading_is_found_in_the_configured_time_while_the_command_moves() {
    let moving = |outcome: &Outcome, one: &Try| {
        let first = outcome.first_faulty.expect("a cylinder at sea does not stand still");
        let of_cylinder = outcome.records.iter().filter(|record| record.cylinder == one.cylinder);
        of_cylinder
            .filter(|r| (-0.03..0.1).contains(&r.timestamp.since(first).as_seconds()))
            .all(|record| record.command.is_some_and(|u| u.abs() > 0.02))
    };
    let count = implausible("freeze", Fault::Frozen, 0.1 + cycle(), moving);
    assert!(count >= 36, "the command moves nearly always, yet only in {count} of 48");
}

/// The kind that FDE3 gives a drift, with how many of `count` were found and undecided (all).
fn drifts(rate: f64, count: u64, after: f64) -> u64 {
    let mut incipient = 0;
    for one in tries(healthy(), count, 24, after) {
        let spec = spec(&one, "drift", &format!(",rate={}", one.sign * rate));
        let outcome = healthy().play_fault(&spec, one.t, after, 0);
        let said = Said::of(&outcome, &one);
        assert_nothing_beside(&said, &spec);
        assert!(said.delay.is_none() || said.blames(one.suspect), "{spec}: {said:?}");
        let found = newest(&outcome, Detector::Fde3).unwrap_or_else(|| panic!("{spec}: missed"));
        assert_eq!(found.finding.suspect, Suspect::Undecided, "{spec}");
        incipient += u64::from(found.finding.fault == Fault::Incipient);
    }
    println!("drift {:.1} mm/s: found {count} of {count}, incipient {incipient}", rate * 1e3);
    incipient
}

#[test]
fn a_drift_is_found_by_fde3_and_nobody_is_blamed() {
    assert_eq!(drifts(1e-4, 24, 20.0), 24);
    // From about 1 mm/s on, R3 of the last second is neither yet a step nor clearly a ramp.
    assert!(drifts(1e-3, 96, 5.0) > 48);
}

#[test]
fn without_a_fault_there_is_no_warning_in_the_whole_engaged_part() {
    let [begin, end] = healthy().engaged;
    let outcome = healthy().play(&[], [begin - BEFORE, end], 0);
    assert_eq!(outcome.warnings, []);
    let judged = outcome.records.iter().filter(|record| !record.gated).count();
    println!("no fault: no warning in {judged} judged cycles of a cylinder");
    assert!(judged > 6 * 16_900, "{judged}");
}

/// Measured, C1 of cylinder 2 is this much more than C2 in the middle of the stroke: b of (5-20), m.
fn offset() -> f64 {
    let text = std::fs::read_to_string(support::top().join(support::E_TYPE)).expect("it is there");
    let (settings, _) = tertius::config::parse("e-type.toml", &text).expect("it is sound");
    settings.comparator_of(2).1
}

/// The machine trips where the readings as they are measured are 50 mm apart. What they should differ by
/// is nothing that it knows.
#[test]
fn critical_is_what_the_machine_itself_measures() {
    let beyond = 0.5 * offset().abs();
    assert!(beyond > 2e-4, "measured and corrected are the same");
    for (size, critical) in [(0.05 - beyond, true), (-(0.05 + beyond), false)] {
        let size = size * offset().signum();
        let (mut black, mut found) = (0, 0);
        for one in tries(healthy(), 24, 25, 1.0).iter().filter(|one| one.cylinder == 2) {
            let spec = format!("step,cylinder=2,sensor=c1,at={},size={size}", one.t);
            let outcome = healthy().play_fault(&spec, one.t, 1.0, 0);
            let fde3 =
                newest(&outcome, Detector::Fde3).expect("50 mm are beyond any bound").finding;
            // The other direction of stroke, or its non-linearity, adds its own millimetre.
            let measured = outcome.records.iter().filter(|record| record.cylinder == 2);
            let measured = measured.filter_map(|r| Some((r.c1? - r.c2?).abs())).fold(0.0, f64::max);
            assert_eq!(fde3.level == Level::Black, measured > 0.05, "{spec}: {measured}");
            if fde3.level == Level::Black {
                assert_eq!(fde3.threshold, Some(0.05), "{spec}");
                assert_eq!(fde3.suspect, Suspect::C1, "{spec}");
            }
            black += u64::from(fde3.level == Level::Black);
            found += 1;
        }
        println!("{:.2} mm: {black} of {found} critical", size * 1e3);
        assert_eq!(black > 0, critical, "{size}");
    }
}

/// Section 1-1 of the thesis: both components of a sensor that the motion needs are a code black.
#[test]
fn both_transducers_of_a_cylinder_lost_is_black() {
    let one = tries(healthy(), 1, 26, 2.0)[0];
    for (first, second) in
        [("stale", "stale"), ("loss", "broken_wire"), ("out_of_range", "stale"), ("step", "loss")]
    {
        let size = if first == "step" { ",size=0.01" } else { "" };
        let faults = [
            format!("{first},cylinder=1,sensor=c1,at={}{size}", one.t),
            format!("{second},cylinder=1,sensor=c2,at={}", one.t + 0.5),
        ];
        let faults = faults.map(|spec| Injected::parse(&spec).expect("a fault"));
        let outcome = healthy().play(&faults, [one.t - BEFORE, one.t + 2.0], 0);
        let last = newest(&outcome, Detector::Plausibility).expect("a reading is lost");
        assert_eq!(last.finding.level, Level::Black, "{first} and {second}");
        assert_eq!(last.cylinder, 1);
        // One of them alone is not.
        let outcome = healthy().play(&faults[..1], [one.t - BEFORE, one.t + 2.0], 0);
        let level = outcome.warnings.iter().map(|warning| warning.finding.level).max();
        assert!(level < Some(Level::Red), "{first} alone: {level:?}");
    }
}

/// What plausibility, R3 and the sequential detector say of a transducer of the bench that freezes from
/// `at` to `until`: blamed right, and how many blamed the other one.
fn freeze_on_the_bench(config: &str, sensor: &str, at: f64, until: f64) -> (bool, Vec<String>) {
    let scratch = Scratch::new();
    let log = scratch.path("frozen.log");
    let spec = format!("freeze,cylinder=1,sensor={sensor},at={at},until={until}");
    let healthy = recording("hanging-load.log.gz");
    let call = ["inject", "--config", config, "--fault", &spec, "--output", &log, &healthy];
    tertius(&call, b"").ok();
    let warnings = replay(&[&log], config, &[]).ok().warnings();
    let said = warnings.iter().filter(|w| w["state"] != "cleared" && w["t"].as_f64() >= Some(at));
    // Its observers disagree without a fault, too: no command predicts this rod.
    let said: Vec<_> =
        said.filter(|w| w["detector"] != "fde1" && w["detector"] != "fde2").collect();
    let right = said.iter().any(|w| w["suspect"] == sensor);
    let wrong = said.iter().filter(|w| w["suspect"] != sensor && w["suspect"] != "undecided");
    (right, wrong.map(|w| format!("{spec}: {w}")).collect())
}

/// No model knows this rod; that a reading stands while the other one goes on is known all the same.
#[test]
fn on_a_real_rig_the_frozen_transducer_is_blamed_and_not_the_healthy_one() {
    let (mut right, mut count) = (0, 0);
    for config in [HANGING_LOAD, "tests/recordings/hanging-load-sequential.toml"] {
        for (k, at) in [13.3, 38.3, 58.35, 62.4, 146.5, 177.8, 195.8, 230.0].into_iter().enumerate()
        {
            for sensor in ["c1", "c2"] {
                let length = [0.5, 1.0, 2.0, 5.0, 10.0, 30.0][k % 6];
                let (blamed, wrong) = freeze_on_the_bench(config, sensor, at, at + length);
                assert_eq!(wrong, [] as [String; 0], "{config}");
                right += u64::from(blamed);
                count += 1;
            }
        }
    }
    println!("frozen on the bench: blamed right {right} of {count}, none wrong");
    // Where the rod rests nobody can tell; where it moves long enough it is told.
    assert!(right > 0, "{right} of {count}");
}
