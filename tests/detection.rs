//! What the detectors must show: faults of every kind, put into the healthy recording at seeded
//! times by the injector, through the whole monitor. `--nocapture` prints what was found how fast.

mod detection_support;

use detection_support::{BEFORE, Healthy, Outcome, Said, Try, tries};
use std::sync::OnceLock;
use tertius::alarm::{Detector, State, Warning};
use tertius::verdict::{Fault, Suspect};

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
