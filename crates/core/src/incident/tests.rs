//! One cause, one incident: sequences of warnings as the detectors give them.

use super::{Ending, Incident, Incidents, MOST_AT_ONCE, Progress, Quantities, Quantity};
use crate::alarm::detector::{DETECTORS, WarningPlace};
use crate::alarm::{Evidence, Finding, Level, State, Warning};
use crate::blame::Rule;
use crate::incident::EventTiming;
use crate::time::{Span, Timestamp};
use crate::verdict::{Fault, Suspect};
use WarningPlace::{Fde1, Fde2, Fde3, PlausibilityOfC1, PlausibilityOfC2, Process, Sequential};

mod kinds;
mod machine;
mod telling;

const TIMING: EventTiming = EventTiming {
    coincidence: Span::from_nanos(100_000_000),
    clear: Span::from_nanos(1_000_000_000),
};
const CYCLE: Span = Span::from_nanos(20_000_000);
const LIMITS: [f64; 4] = [1e-3, 1e-3, 1.5e-3, 0.05];

/// A cylinder of which the detectors say something now and then.
struct Story {
    incidents: Incidents,
    told: Vec<Incident>,
    /// Whether an incident is left that is not closed.
    goes_on: bool,
}

fn at(seconds: f64) -> Timestamp {
    Timestamp::default().after(Span::from_seconds(seconds))
}

fn finding(fault: Fault, suspect: Suspect, residual: f64) -> Finding {
    let (residual, threshold) = (Some(residual), Some(1e-3));
    Finding {
        fault,
        suspect,
        rule: Rule::OneObserver,
        level: Level::Yellow,
        residual,
        threshold,
        evidence: None,
        device: None,
    }
}

impl Story {
    fn new() -> Self {
        Self::of(1)
    }

    /// Of a machine with so many cylinders.
    fn of(cylinders: usize) -> Self {
        let each = (0..cylinders).map(|_| (LIMITS, TIMING));
        let incidents = Incidents::new(each, CYCLE);
        Self { incidents, told: Vec::new(), goes_on: false }
    }

    fn say(&mut self, t: f64, place: WarningPlace, state: State, finding: Finding) {
        let place = place as usize;
        let detector = DETECTORS[place];
        let warning = Warning { timestamp: at(t), cylinder: 1, detector, place, state, finding };
        self.incidents.take(&warning);
    }

    fn raise(&mut self, t: f64, place: WarningPlace, fault: Fault, suspect: Suspect, mm: f64) {
        self.say(t, place, State::Raised, finding(fault, suspect, mm * 1e-3));
    }

    fn clear(&mut self, t: f64, place: WarningPlace) {
        let finding = finding(Fault::Abrupt, Suspect::Undecided, 0.0);
        self.say(t, place, State::Cleared, finding);
    }

    /// A cycle with these R1, R2, R3, mm.
    fn cycle(&mut self, t: f64, mm: [f64; 3]) {
        let [r1, r2, r3] = mm.map(|value| Some(value * 1e-3));
        self.follow(t, [r1, r2, r3, None]);
    }

    fn follow(&mut self, t: f64, quantities: Quantities) {
        let told = &mut self.told;
        self.goes_on = self.incidents.follow(0, [at(t), at(t)], &quantities, |it| told.push(*it));
        self.incidents.follow_machine(at(t), |it| told.push(*it));
    }

    /// A step of C1 at `t`, as FDE1 and FDE3 see it.
    fn step(&mut self, t: f64, mm: f64) {
        self.raise(t, Fde1, Fault::Abrupt, Suspect::C1, mm);
        self.raise(t, Fde3, Fault::Abrupt, Suspect::C1, mm);
        self.cycle(t, [mm, 0.1, mm]);
        self.clear(t + 1.0, Fde1);
        self.cycle(t + 1.0, [0.1, 0.1, mm]);
    }

    /// The end of that step at `t`.
    fn step_back(&mut self, t: f64, mm: f64) {
        self.raise(t, Fde1, Fault::Abrupt, Suspect::C1, -mm);
        self.cycle(t, [-mm, 0.1, 0.1]);
        self.clear(t + 1.0, Fde3);
        self.clear(t + 1.1, Fde1);
        self.cycle(t + 1.1, [0.1; 3]);
    }

    fn numbers(&self, progress: Progress) -> Vec<u32> {
        let of = self.told.iter().filter(|incident| incident.progress == progress);
        of.map(|incident| incident.number).collect()
    }

    fn newest(&self) -> &Incident {
        self.told.last().expect("something was told")
    }
}

#[test]
fn a_fault_and_its_end_are_one() {
    let mut story = Story::new();
    story.step(10.0, 3.0);
    story.step_back(20.0, 3.0);
    assert_eq!(story.numbers(Progress::Opened), [1], "its end is no other fault");
    story.cycle(25.2, [0.1; 3]);
    let over = story.newest();
    assert_eq!((over.progress, over.end), (Progress::Closed, Some((at(21.1), Ending::Returned))));
    assert_eq!((over.suspect, over.fault), (Suspect::C1, Fault::Abrupt));
    assert_eq!((over.begin, over.size), (at(10.0), Some(3e-3)));
    let part = over.part(Fde1).expect("FDE1 was raised");
    assert_eq!((part.raises, part.raised), (2, at(10.0)));
    assert!(!story.goes_on);
}

#[test]
fn a_fault_after_the_end_of_another_is_another() {
    let mut story = Story::new();
    story.step(10.0, 3.0);
    story.step_back(15.0, 3.0);
    // Not even a cycle came in between.
    story.step(20.3, 5.0);
    assert_eq!(story.numbers(Progress::Opened), [1, 2]);
    // A loose contact comes again at once.
    let mut loose = Story::new();
    loose.step(10.0, 3.0);
    loose.step_back(12.0, 3.0);
    loose.step(14.0, 3.0);
    assert_eq!(loose.numbers(Progress::Opened), [1]);
}

#[test]
fn a_drift_near_its_bound_is_one_that_comes_and_goes() {
    let mut story = Story::new();
    for t in [100.0, 110.0, 120.0] {
        story.raise(t, Fde3, Fault::Incipient, Suspect::Undecided, 1.6);
        story.cycle(t, [0.1, 0.1, 1.6]);
        story.clear(t + 3.0, Fde3);
        story.cycle(t + 3.0, [0.1, 0.1, 0.7]);
    }
    assert_eq!(story.numbers(Progress::Opened), [1]);
    story.cycle(123.9, [0.1, 0.1, 1.3]);
    // Where it goes away at once, the observer says whose it was.
    story.raise(124.0, Fde1, Fault::Abrupt, Suspect::C1, -1.4);
    story.cycle(124.0, [-1.4, 0.1, 0.1]);
    let revised = story.newest();
    assert_eq!((revised.progress, revised.suspect), (Progress::Revised, Suspect::C1));
    assert_eq!(revised.fault, Fault::Incipient, "its end does not name it");
    story.clear(125.1, Fde1);
    for t in [125.1, 129.0, 129.2] {
        story.cycle(t, [0.1; 3]);
    }
    assert_eq!(story.newest().end, Some((at(125.1), Ending::Returned)));
}

/// Friction is found before anybody knows how much of it there is.
#[test]
fn an_incident_is_told_anew_when_its_size_is_known_and_not_with_every_size() {
    let mut story = Story::new();
    let sized = |size: Option<f64>| {
        let evidence =
            Evidence { fault: 30.0, location: None, by: None, onset: at(9.0), gain: None, size };
        let finding = finding(Fault::Friction, Suspect::Process, 0.0);
        Finding { residual: None, threshold: None, evidence: Some(evidence), ..finding }
    };
    for (t, state, size, told) in [
        (10.0, State::Raised, None, 1),
        (20.0, State::Changed, Some(1.5), 2),
        (30.0, State::Changed, Some(1.6), 2),
    ] {
        story.say(t, WarningPlace::Process, state, sized(size));
        story.cycle(t, [0.1; 3]);
        assert_eq!(story.told.len(), told, "{t} s");
    }
    assert_eq!(story.newest().progress, Progress::Revised);
}

#[test]
fn what_is_quiet_for_long_is_over_but_not_proved_to_be_gone() {
    let mut story = Story::new();
    story.raise(100.0, Fde3, Fault::Incipient, Suspect::Undecided, 1.6);
    story.cycle(100.0, [0.1, 0.1, 1.6]);
    story.clear(103.0, Fde3);
    story.cycle(103.0, [0.1, 0.1, 0.7]);
    story.cycle(110.9, [0.1, 0.1, 0.7]);
    assert_eq!(story.numbers(Progress::Closed), [0_u32; 0]);
    story.cycle(111.0, [0.1, 0.1, 0.7]);
    assert_eq!(story.newest().end, Some((at(103.0), Ending::Quiet)));
}

#[test]
fn another_transducer_is_another_incident_unless_it_only_reacts() {
    let mut story = Story::new();
    story.step(10.0, 30.0);
    // Through the controller FDE2 sees it, too.
    story.raise(11.05, Fde2, Fault::Noise, Suspect::C2, 2.0);
    story.cycle(11.05, [0.1, 2.0, 30.0]);
    assert_eq!(story.newest().suspect, Suspect::C1);
    assert_eq!(story.numbers(Progress::Opened), [1]);
    let frozen = Finding {
        level: Level::Orange,
        residual: None,
        ..finding(Fault::Frozen, Suspect::C2, 0.0)
    };
    story.say(40.0, PlausibilityOfC2, State::Raised, frozen);
    story.cycle(40.0, [0.1, 0.1, 30.0]);
    assert_eq!(story.numbers(Progress::Opened), [1, 2]);
    let other = story.newest();
    assert_eq!(
        (other.suspect, other.fault, other.level),
        (Suspect::C2, Fault::Frozen, Level::Orange)
    );
}

/// A difference that nobody calibrated stands all the time. It is not since then that C2 is frozen.
#[test]
fn an_old_undecided_difference_is_not_what_begins_now() {
    let mut story = Story::new();
    story.raise(0.0, Fde3, Fault::Incipient, Suspect::Undecided, 3.0);
    story.cycle(0.0, [0.1, 0.1, 3.0]);
    story.raise(60.0, PlausibilityOfC2, Fault::Frozen, Suspect::C2, 0.0);
    story.cycle(60.0, [0.1, 0.1, 3.0]);
    assert_eq!((story.newest().number, story.newest().begin), (2, at(60.0)));
    story.raise(80.0, Fde1, Fault::Abrupt, Suspect::C1, -1.1);
    story.cycle(80.0, [-1.1, 0.1, 3.0]);
    assert_eq!(story.newest().number, 3, "3 mm do not go by 1.1 mm");
    story.clear(81.0, Fde1);
    story.cycle(87.0, [0.1, 0.1, 3.0]);
    story.raise(88.0, Fde1, Fault::Abrupt, Suspect::C1, 2.0);
    story.cycle(88.0, [2.0, 0.1, 5.0]);
    assert_eq!(story.newest().number, 3, "it grows: that is another fault");
    story.clear(91.0, Fde1);
    story.raise(95.0, Fde1, Fault::Abrupt, Suspect::C1, -2.0);
    story.cycle(95.0, [-2.0, 0.1, 3.0]);
    assert_eq!(story.numbers(Progress::Opened), [1, 2, 3]);
}

/// Where a reading passes the checks again, or comes back, that is seen, whatever the other observer makes of it.
#[test]
fn a_reading_that_comes_back_is_seen_to() {
    let mut frozen = Story::new();
    frozen.raise(10.0, PlausibilityOfC2, Fault::Frozen, Suspect::C2, 0.0);
    frozen.cycle(10.0, [0.1; 3]);
    frozen.clear(12.0, PlausibilityOfC2);
    frozen.cycle(12.0, [0.1; 3]);
    frozen.cycle(16.0, [0.1; 3]);
    assert_eq!(frozen.newest().end, Some((at(12.0), Ending::Returned)));
    let mut loud = Story::new();
    loud.step(10.0, 60.0);
    loud.raise(20.0, Fde1, Fault::Abrupt, Suspect::C1, -60.0);
    loud.cycle(20.0, [-60.0, 0.1, 0.1]);
    loud.raise(20.05, Fde2, Fault::Noise, Suspect::Undecided, 2.0);
    loud.cycle(20.05, [1.0, 2.0, 0.1]);
    for place in [Fde1, Fde2, Fde3] {
        loud.clear(21.5, place);
    }
    loud.cycle(21.5, [0.1; 3]);
    loud.cycle(25.5, [0.1; 3]);
    assert_eq!(loud.newest().end, Some((at(21.5), Ending::Returned)));
}

/// The cycle in which a warning clears is still its own; what follows is not.
#[test]
fn peaks_are_those_of_its_cycles() {
    let mut story = Story::new();
    story.raise(10.0, Fde3, Fault::Abrupt, Suspect::Undecided, 2.0);
    story.cycle(10.0, [0.1, 0.2, 2.0]);
    story.cycle(10.5, [0.1, -0.3, 1.8]);
    story.clear(11.0, Fde3);
    story.cycle(11.0, [0.4, 0.1, 0.1]);
    story.cycle(11.5, [0.9, 0.9, 0.9]);
    story.cycle(19.0, [0.1; 3]);
    let peak = |quantity: Quantity| story.newest().peaks[quantity as usize].map(|it| it.value);
    assert_eq!(Quantity::ALL.map(peak), [Some(0.4e-3), Some(-0.3e-3), Some(2e-3), None]);
}

#[test]
fn two_facts_are_two_incidents_even_at_once() {
    let mut story = Story::new();
    for (place, suspect) in [(PlausibilityOfC1, Suspect::C1), (PlausibilityOfC2, Suspect::C2)] {
        story.raise(10.0, place, Fault::Stale, suspect, 0.0);
    }
    story.follow(10.0, [None; 4]);
    let suspects: Vec<Suspect> = story.told.iter().map(|incident| incident.suspect).collect();
    assert_eq!(suspects, [Suspect::C1, Suspect::C2]);
}

#[test]
fn facts_go_before_conclusions_and_the_worst_level_stays() {
    let mut story = Story::new();
    story.raise(10.0, Fde3, Fault::Abrupt, Suspect::Undecided, 3.0);
    story.cycle(10.0, [0.1, 0.1, 3.0]);
    story.raise(10.1, PlausibilityOfC1, Fault::Frozen, Suspect::C1, 0.0);
    story.cycle(10.1, [0.1, 0.1, 8.0]);
    let fact = story.newest();
    assert_eq!((fact.suspect, fact.fault), (Suspect::C1, Fault::Frozen));
    let black = Finding { level: Level::Black, ..finding(Fault::Abrupt, Suspect::C1, 0.06) };
    story.say(10.2, Fde3, State::Changed, black);
    story.follow(10.2, [None, None, None, Some(-0.06)]);
    story.say(10.3, Fde3, State::Changed, finding(Fault::Abrupt, Suspect::C1, 2e-3));
    story.cycle(10.3, [0.1, 0.1, 2.0]);
    let worst = story.newest();
    assert_eq!(worst.level, Level::Black, "it has reached it");
    let (quantity, peak) = worst.worst().expect("it was compared");
    assert_eq!((quantity, peak.value, peak.at), (Quantity::Measured, -0.06, at(10.2)));
}

#[test]
fn the_evidence_of_many_samples_dates_the_onset_and_may_take_back_a_side() {
    let mut story = Story::new();
    let gain = |gain| {
        let (fault, location, onset) = (20.0, Some(5.0), at(50.0));
        Some(Evidence { fault, location, by: None, onset, gain, size: None })
    };
    let drift = finding(Fault::Incipient, Suspect::C1, 0.6e-3);
    let drift = Finding { evidence: gain(None), threshold: None, ..drift };
    story.say(100.0, Sequential, State::Raised, drift);
    story.cycle(100.0, [0.1, 0.1, 0.6]);
    let told = story.newest();
    assert_eq!((told.onset, told.begin, told.size), (at(50.0), at(100.0), Some(0.6e-3)));
    let scale = Finding {
        fault: Fault::Unclassified,
        suspect: Suspect::Undecided,
        evidence: gain(Some(2e-3)),
        ..drift
    };
    story.say(110.0, Sequential, State::Changed, scale);
    story.cycle(110.0, [0.1, 0.1, 0.6]);
    let told = story.newest();
    assert_eq!((told.suspect, told.gain), (Suspect::Undecided, Some(2e-3)));
}

#[test]
fn a_loss_ends_what_does_not_stand_and_nothing_else() {
    let mut story = Story::new();
    story.step(10.0, 3.0);
    let told = &mut story.told;
    story.incidents.cut(at(12.0), |incident| told.push(*incident));
    assert_eq!(story.numbers(Progress::Closed), [0_u32; 0], "it stands");
    story.clear(13.0, Fde3);
    story.cycle(13.0, [0.1; 3]);
    let told = &mut story.told;
    story.incidents.cut(at(14.0), |incident| told.push(*incident));
    assert_eq!(story.newest().end, Some((at(13.0), Ending::Cut)));
    story.cycle(14.0, [0.1; 3]);
    assert!(!story.goes_on);
}

/// However often whoever is blamed by whomever, no more incidents are open than there are places for,
/// every warning belongs to one, and each is closed once.
#[test]
fn contradictions_are_bounded() {
    let mut story = Story::new();
    let suspects = [Suspect::C1, Suspect::C2, Suspect::Process];
    for n in 0..3000_usize {
        let (t, place) = (n as f64, [Fde1, Fde2, Fde3][n % 3]);
        story.raise(t, place, Fault::Abrupt, suspects[n / 3 % 3], 2.0);
        story.cycle(t, [2.0; 3]);
        story.clear(t + 0.5, place);
        story.cycle(t + 0.5, [0.1; 3]);
        let open = story.numbers(Progress::Opened).len() - story.numbers(Progress::Closed).len();
        assert!((1..=MOST_AT_ONCE).contains(&open), "{open} at {t} s");
    }
    story.cycle(4000.0, [0.1; 3]);
    assert!(!story.goes_on);
    assert_eq!(story.numbers(Progress::Opened).len(), story.numbers(Progress::Closed).len());
}
