//! What several cylinders have in common.

use super::*;
use crate::incident::{Cylinders, Scope};
use crate::verdict::Testimony;

impl Story {
    /// Raises or clears a warning of the cylinder `n`, counted from 1.
    fn of_cylinder(&mut self, t: f64, n: u8, place: WarningPlace, state: State, finding: Finding) {
        let (detector, place) = (DETECTORS[place as usize], place as usize);
        let warning = Warning { timestamp: at(t), cylinder: n, detector, place, state, finding };
        self.incidents.take(&warning);
    }

    /// A cycle of all cylinders in which nothing is judged.
    fn machine(&mut self, t: f64) {
        for index in 0..6 {
            let told = &mut self.told;
            let quantities = [None; 4];
            self.incidents.follow(index, [at(t); 2], &quantities, |it| told.push(*it));
        }
        let told = &mut self.told;
        self.incidents.follow_machine(at(t), |it| told.push(*it));
    }

    fn facts(&mut self, t: f64, cylinders: impl IntoIterator<Item = u8>, state: State) {
        for n in cylinders {
            for (place, suspect) in
                [(PlausibilityOfC1, Suspect::C1), (PlausibilityOfC2, Suspect::C2)]
            {
                let stale = Finding { level: Level::Black, ..finding(Fault::Stale, suspect, 0.0) };
                self.of_cylinder(t, n, place, state, stale);
            }
        }
    }

    fn numbers_of(&self, numbers: &[u8]) -> Scope {
        let mut cylinders = Cylinders::NONE;
        numbers.iter().for_each(|n| cylinders.insert(usize::from(*n) - 1));
        Scope::Machine(cylinders)
    }
}

/// All frames come too late: C1 and C2 of every cylinder, some of them a cycle later.
#[test]
fn what_most_cylinders_show_in_one_moment_is_one_incident_of_the_machine() {
    let mut story = Story::of(6);
    story.facts(10.0, 1..=3, State::Raised);
    story.machine(10.0);
    assert!(story.told.is_empty(), "others may show it, too");
    story.facts(10.02, 4..=5, State::Raised);
    story.machine(10.02);
    story.facts(10.04, 6..=6, State::Raised);
    for t in [10.04, 10.06, 11.0] {
        story.machine(t);
    }
    assert_eq!(story.numbers(Progress::Opened), [1]);
    let told = *story.newest();
    assert_eq!(told.scope, story.numbers_of(&[1, 2, 3, 4, 5, 6]));
    assert_eq!(
        (told.suspect, told.fault, told.level),
        (Suspect::Process, Fault::Stale, Level::Black)
    );
    assert_eq!(told.begin, at(10.0));
    assert!(told.parts.iter().flatten().all(|part| part.finding.suspect == Suspect::Process));
    story.facts(12.0, 1..=6, State::Cleared);
    for t in [12.0, 15.9, 16.1] {
        story.machine(t);
    }
    let over = story.newest();
    assert_eq!((over.progress, over.end), (Progress::Closed, Some((at(12.0), Ending::Returned))));
    assert_eq!(story.numbers(Progress::Closed), [1]);
    // Nothing of it is left: the next fault is a cylinder's own.
    story.facts(30.0, 2..=2, State::Raised);
    for t in [30.0, 30.04] {
        story.machine(t);
    }
    assert_eq!(story.newest().scope, Scope::Cylinder(2));
    assert_eq!(story.numbers(Progress::Opened), [1, 2, 3]);
}

#[test]
fn what_half_of_the_cylinders_show_or_show_one_after_another_is_theirs() {
    let mut half = Story::of(6);
    half.facts(10.0, 1..=3, State::Raised);
    for t in [10.0, 10.02, 10.04] {
        half.machine(t);
    }
    assert_eq!(half.numbers(Progress::Opened), [1, 2, 3, 4, 5, 6]);
    let mut one_by_one = Story::of(6);
    for n in 1..=6 {
        let t = 10.0 + 0.06 * f64::from(n);
        one_by_one.facts(t, n..=n, State::Raised);
        one_by_one.machine(t);
    }
    one_by_one.machine(11.0);
    assert!(one_by_one.told.iter().all(|it| it.scope.cylinder().is_some()));
}

/// The frames come again, but for those of one cylinder.
#[test]
fn a_cylinder_that_does_not_recover_with_the_others_has_a_fault_of_its_own() {
    let mut story = Story::of(6);
    story.facts(10.0, 1..=6, State::Raised);
    story.machine(10.0);
    story.facts(12.0, (1..=6).filter(|n| *n != 4), State::Cleared);
    for t in [12.0, 12.5, 12.98] {
        story.machine(t);
    }
    assert_eq!(story.numbers(Progress::Opened), [1]);
    for t in [13.0, 13.02] {
        story.machine(t);
    }
    assert_eq!(story.numbers(Progress::Opened), [1, 2, 3]);
    let own: Vec<Suspect> =
        story.told[story.told.len() - 2..].iter().map(|it| it.suspect).collect();
    assert_eq!((own, story.newest().scope), (vec![Suspect::C1, Suspect::C2], Scope::Cylinder(4)));
    story.machine(20.0);
    assert_eq!(story.numbers(Progress::Closed), [1]);
}

/// A pump that stands: all cylinders have one supply.
#[test]
fn the_supply_is_the_machines_and_what_a_cylinder_has_besides_is_its_own() {
    let mut story = Story::of(6);
    let supply = finding(Fault::Supply, Suspect::Process, 0.0);
    for n in 1..=6 {
        story.of_cylinder(10.0, n, Process, State::Raised, supply);
    }
    story.machine(10.0);
    assert_eq!(story.numbers(Progress::Opened), [1]);
    let told = *story.newest();
    assert_eq!((told.scope, told.fault), (story.numbers_of(&[1, 2, 3, 4, 5, 6]), Fault::Supply));
    // What the observers see of it is its.
    let seen = finding(Fault::Abrupt, Suspect::Process, 5e-3);
    story.of_cylinder(15.0, 2, Fde1, State::Raised, seen);
    story.machine(15.0);
    // C1 of cylinder 5 is not.
    story.of_cylinder(
        20.0,
        5,
        PlausibilityOfC1,
        State::Raised,
        finding(Fault::Frozen, Suspect::C1, 0.0),
    );
    for t in [20.0, 20.04] {
        story.machine(t);
    }
    assert_eq!(story.numbers(Progress::Opened), [1, 2]);
    assert_eq!(story.newest().scope, Scope::Cylinder(5));
    for n in 1..=6 {
        let worse = Finding { level: Level::Orange, ..supply };
        story.of_cylinder(30.0, n, Process, State::Changed, worse);
    }
    story.machine(30.0);
    let revised = story.newest();
    assert_eq!((revised.number, revised.level), (1, Level::Orange));
}

/// The sun comes out: each C1 warms, none of them more than the others.
#[test]
fn slow_drifts_of_most_cylinders_are_one_incident_of_the_machine() {
    let mut story = Story::of(6);
    let drift = finding(Fault::Incipient, Suspect::Undecided, 5e-4);
    for n in 1..=6 {
        let t = 100.0 + 5.0 * f64::from(n);
        story.of_cylinder(t, n, Sequential, State::Raised, drift);
        story.machine(t);
        story.machine(t + 0.1);
    }
    // The first three were their cylinders' own until a fourth showed it, too.
    assert_eq!(story.numbers(Progress::Opened), [1, 2, 3, 4]);
    assert_eq!(story.numbers(Progress::Closed), [1, 2, 3]);
    let mut closed = story.told.iter().filter(|it| it.progress == Progress::Closed);
    let joined = Some((at(120.0), Ending::Joined));
    assert!(closed.all(|it| it.end == joined), "when the fourth has shown it");
    let told = *story.newest();
    assert_eq!((told.number, told.scope), (4, story.numbers_of(&[1, 2, 3, 4, 5, 6])));
    assert_eq!((told.fault, told.suspect), (Fault::Incipient, Suspect::Process));
    // C2 of cylinder 5 is found to be the one: that is no common drift.
    let named = Finding { suspect: Suspect::C2, ..drift };
    story.of_cylinder(200.0, 5, Sequential, State::Changed, named);
    story.machine(200.0);
    story.machine(200.1);
    let own = story.told.iter().rfind(|it| it.scope == Scope::Cylinder(5)).expect("it is told");
    assert_eq!((own.number, own.suspect, own.progress), (5, Suspect::C2, Progress::Opened));
    // What one cylinder is left with for long is its own, too.
    for n in [1, 2, 3, 4] {
        story.of_cylinder(900.0, n, Sequential, State::Cleared, drift);
    }
    for t in [900.0, 910.0, 1199.0] {
        story.machine(t);
    }
    assert_eq!(story.numbers(Progress::Opened), [1, 2, 3, 4, 5]);
    story.machine(1201.0);
    story.machine(1201.1);
    let own = story.told.iter().rfind(|it| it.scope == Scope::Cylinder(6)).expect("it is told");
    assert_eq!((own.number, own.progress), (6, Progress::Opened));
    assert_eq!((story.newest().number, story.newest().progress), (4, Progress::Closed));
}

#[test]
fn slow_drifts_of_half_of_the_cylinders_are_theirs() {
    let mut story = Story::of(6);
    let drift = finding(Fault::Incipient, Suspect::Undecided, 5e-4);
    for n in 1..=3 {
        story.of_cylinder(100.0, n, Sequential, State::Raised, drift);
    }
    // Two more have a fault of their own.
    story.of_cylinder(
        100.5,
        4,
        Sequential,
        State::Raised,
        Finding { suspect: Suspect::C1, ..drift },
    );
    let noise = finding(Fault::Noise, Suspect::Undecided, 5e-4);
    story.of_cylinder(100.9, 5, Sequential, State::Raised, noise);
    for t in [101.0, 101.1] {
        story.machine(t);
    }
    assert_eq!(story.numbers(Progress::Opened).len(), 5);
    assert!(story.told.iter().all(|it| it.scope.cylinder().is_some()));
}

/// What stops have worn by, or their only transducers drifted, is no difference of C1 and C2.
#[test]
fn what_the_stops_find_of_only_transducers_is_theirs() {
    let mut story = Story::of(6);
    let evidence = Evidence {
        fault: 0.0,
        location: None,
        by: Some(Testimony::Stop),
        onset: Timestamp::default(),
        gain: None,
        size: None,
    };
    let worn = finding(Fault::Incipient, Suspect::Undecided, 1e-3);
    let worn = Finding { evidence: Some(evidence), ..worn };
    for n in 1..=6 {
        let t = 100.0 + f64::from(n);
        story.of_cylinder(t, n, Sequential, State::Raised, worn);
        story.machine(t);
        story.machine(t + 0.1);
    }
    assert_eq!(story.numbers(Progress::Opened), [1, 2, 3, 4, 5, 6]);
    assert!(story.told.iter().all(|it| it.scope.cylinder().is_some()));
}
