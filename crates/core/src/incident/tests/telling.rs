//! How bad an incident is, when it is told again, and when its suspect was named.

use super::*;
use crate::incident::{Naming, Outset};

/// Of noise the innovation is larger than the difference, and of two noises the louder one is the worse.
#[test]
fn what_was_largest_against_its_limit_is_the_worst() {
    let noise = |mm: [f64; 3]| {
        let mut story = Story::new();
        story.raise(10.0, Fde1, Fault::Noise, Suspect::C1, 2.0);
        story.raise(10.0, Fde3, Fault::Noise, Suspect::C1, 2.0);
        story.cycle(10.0, mm);
        *story.newest()
    };
    let (loud, quiet) = (noise([9.01, 0.4, 2.87]), noise([4.0, 0.4, 3.13]));
    let worst = loud.worst().map(|(quantity, peak)| (quantity, peak.value));
    assert_eq!(worst, Some((Quantity::R1, 9.01e-3)));
    assert!(loud.severity() > quiet.severity());
    let mut drift = Story::new();
    drift.raise(10.0, Fde3, Fault::Incipient, Suspect::Undecided, 2.0);
    // What no detector of this incident judges is another one's, and C1 − C2 counts where the machine would trip.
    let quantities = |measured| [Some(0.02), Some(1e-4), Some(-0.03), Some(measured)];
    drift.follow(10.0, quantities(-0.04));
    assert_eq!(drift.newest().worst().map(|(quantity, _)| quantity), Some(Quantity::R3));
    drift.follow(16.0, quantities(-0.051));
    drift.clear(17.0, Fde3);
    drift.follow(17.0, quantities(0.0));
    drift.follow(26.0, quantities(0.0));
    let over = drift.newest();
    assert_eq!(over.worst().map(|(quantity, _)| quantity), Some(Quantity::Measured));
    assert!(over.severity() > loud.severity(), "it trips");
}

/// What is told of a drift is never old and small, and never comes in floods.
#[test]
fn an_incident_that_grows_is_told_again() {
    let mut story = Story::new();
    let drift = finding(Fault::Incipient, Suspect::Undecided, 0.53e-3);
    story.say(10.0, Sequential, State::Raised, drift);
    for cycle in 0..2500 {
        let t = 10.0 + f64::from(cycle) * 0.02;
        let mm = 0.53 + 0.5 * (t - 10.0);
        if cycle == 97 {
            story.raise(t, Fde3, Fault::Incipient, Suspect::Undecided, mm);
        }
        story.cycle(t, [0.1, 0.1, mm]);
        let told = story.newest();
        let (_, peak) = told.worst().expect("it is compared");
        let is_new = at(t).since(told.timestamp) < Span::from_seconds(5.0);
        assert!(is_new || mm * 1e-3 <= 1.2501 * peak.value, "{} is told at {t}: {mm}", peak.value);
    }
    let times: Vec<Timestamp> = story.told.iter().map(|it| it.timestamp).collect();
    assert!((8..=10).contains(&times.len()), "{times:?}");
    assert!(times.windows(2).all(|it| it[1].since(it[0]) >= Span::from_seconds(5.0)), "{times:?}");
    assert!(story.told[1..].iter().all(|it| it.progress == Progress::Revised));
    assert!(story.told[1].part(Fde3).is_some(), "a detector that agrees is told, too");
    // A value that falls is no news, but what is told has it.
    let before = story.told.len();
    story.cycle(70.0, [0.1, 0.1, 1.6]);
    assert_eq!(story.told.len(), before);
    story.raise(71.0, Fde1, Fault::Abrupt, Suspect::C1, -1.0);
    story.cycle(71.0, [-1.0, 0.1, 1.5]);
    let told = story.newest();
    assert_eq!(told.worst_now(), Some(1.5e-3));
    assert!(told.worst().is_some_and(|(_, peak)| peak.value > 25e-3));
}

#[test]
fn a_clock_that_was_set_back_silences_no_incident() {
    let mut story = Story::new();
    story.raise(1000.0, Fde3, Fault::Incipient, Suspect::Undecided, 2.0);
    story.cycle(1000.0, [0.1, 0.1, 2.0]);
    story.cycle(400.0, [0.1, 0.1, 4.0]);
    assert_eq!(story.told.len(), 2);
}

/// Of a drift nobody knows whose it was until it ends.
#[test]
fn when_the_suspect_was_named_is_told() {
    let mut drift = Story::new();
    drift.raise(10.0, Fde3, Fault::Incipient, Suspect::Undecided, 1.6);
    drift.cycle(10.0, [0.1, 0.1, 1.6]);
    assert_eq!(drift.newest().named, None);
    drift.cycle(128.0, [0.1, 0.1, 58.0]);
    drift.raise(128.7, Fde1, Fault::Abrupt, Suspect::C1, -58.0);
    drift.cycle(128.7, [-58.0, 0.1, 0.1]);
    let named = Some(Naming { at: at(128.7), by_its_end: true });
    assert_eq!((drift.newest().suspect, drift.newest().named), (Suspect::C1, named));
    assert_eq!(drift.newest().namer(), Some(Fde1));
    let mut step = Story::new();
    step.step(10.0, 3.0);
    step.step_back(20.0, 3.0);
    let named = Some(Naming { at: at(10.0), by_its_end: false });
    assert_eq!(step.newest().named, named, "its end names nobody whom its begin has named");
    let mut weighed = Story::new();
    let gained = |suspect| finding(Fault::Incipient, suspect, 0.6e-3);
    weighed.say(10.0, Sequential, State::Raised, gained(Suspect::Undecided));
    weighed.cycle(10.0, [0.1, 0.1, 0.6]);
    for (t, suspect) in [(30.0, Suspect::C2), (40.0, Suspect::C2), (50.0, Suspect::Undecided)] {
        weighed.say(t, Sequential, State::Changed, gained(suspect));
        weighed.cycle(t, [0.1, 0.1, 0.6]);
    }
    let told: Vec<Option<Naming>> = weighed.told.iter().map(|it| it.named).collect();
    assert_eq!(told, [None, Some(Naming { at: at(30.0), by_its_end: false }), None]);
}

/// An observer is raised by the third sample that is beyond its threshold. The difference is gone by then.
#[test]
fn a_drift_that_goes_back_at_once_is_named_by_its_end() {
    let mut drift = Story::new();
    drift.raise(10.0, Sequential, Fault::Incipient, Suspect::Undecided, 1.6);
    drift.cycle(10.0, [0.1, 0.1, 1.6]);
    drift.cycle(69.98, [0.1, 0.1, 17.8]);
    drift.cycle(70.0, [-17.8, 0.1, 0.1]);
    drift.cycle(70.02, [-12.0, 0.1, 0.1]);
    drift.raise(70.04, Fde1, Fault::Abrupt, Suspect::C1, -17.8);
    drift.cycle(70.04, [-8.0, 0.1, 0.1]);
    assert_eq!(drift.numbers(Progress::Opened), [1]);
    let named = Some(Naming { at: at(70.04), by_its_end: true });
    assert_eq!((drift.newest().suspect, drift.newest().named), (Suspect::C1, named));
    assert_eq!(drift.newest().fault, Fault::Incipient);
}

/// C1 − C2 as measured also has what the readings differ by when nothing is wrong.
#[test]
fn a_step_is_as_large_as_what_the_readings_parted_by() {
    let mut story = Story::new();
    let black = Finding {
        level: Level::Black,
        threshold: Some(0.05),
        ..finding(Fault::Abrupt, Suspect::Undecided, -57.3e-3)
    };
    story.say(10.0, Fde3, State::Raised, black);
    story.follow(10.0, [None, None, Some(-60e-3), Some(-57.3e-3)]);
    assert_eq!(story.newest().size, Some(-60e-3));
    story.follow(10.02, [None, None, Some(-61e-3), Some(-58.3e-3)]);
    story.raise(10.04, Fde2, Fault::Abrupt, Suspect::Undecided, 1.2);
    story.cycle(10.04, [0.1, 1.2, -61.0]);
    story.clear(11.0, Fde3);
    story.clear(11.0, Fde2);
    story.cycle(20.0, [0.1; 3]);
    assert_eq!(story.newest().size, Some(-60e-3), "of its onset");
}

/// An observer that stayed quiet says little if it did not judge when the others were raised.
#[test]
fn who_judged_at_the_begin_is_told() {
    let mut story = Story::new();
    story.raise(10.0, Fde1, Fault::Abrupt, Suspect::Undecided, 2.0);
    story.follow(10.0, [Some(2e-3), None, Some(1e-4), None]);
    story.cycle(16.0, [4.0, 0.1, 0.1]);
    let judged = Outset { judged: [true, false, true], elsewhere: [false; 3] };
    assert_eq!(story.newest().outset, judged, "at the begin, and not later");
    story.raise(20.0, PlausibilityOfC2, Fault::Frozen, Suspect::C2, 0.0);
    story.cycle(20.0, [4.0, 0.1, 0.1]);
    let other = story.newest();
    assert_eq!((other.fault, other.outset.elsewhere), (Fault::Frozen, [true, false, false]));
}
