//! Faults of hydraulics or command beside readings that part.

use super::*;
use WarningPlace::PlausibilityOfCommand;

/// A supply that is short is no reading's fault, nor does it make C1 and C2 differ.
#[test]
fn what_is_of_the_hydraulics_and_readings_that_part_are_two_stories_in_either_order() {
    let mut story = Story::new();
    story.raise(10.0, Process, Fault::Supply, Suspect::Process, 0.0);
    story.cycle(10.0, [0.1; 3]);
    // What the observers see of it is its.
    story.raise(12.0, Fde1, Fault::Incipient, Suspect::Undecided, 1.2);
    story.cycle(12.0, [1.2, 0.9, 0.1]);
    assert_eq!(story.numbers(Progress::Opened), [1]);
    for (t, place) in [(200.0, Sequential), (201.0, Fde3)] {
        story.raise(t, place, Fault::Incipient, Suspect::Undecided, 1.6);
        story.cycle(t, [0.1, 0.1, 1.6]);
    }
    assert_eq!(story.numbers(Progress::Opened), [1, 2]);
    assert_eq!((story.newest().suspect, story.newest().begin), (Suspect::Undecided, at(200.0)));

    let hydraulics = [(Process, Fault::Leakage), (PlausibilityOfCommand, Fault::Stale)];
    let parting = [(Fde3, Suspect::Undecided), (Fde1, Suspect::C1), (Fde2, Suspect::C2)];
    let parting = parting.into_iter().chain([(Sequential, Suspect::C1)]);
    for ((place, fault), (other, suspect)) in
        hydraulics.into_iter().flat_map(|one| parting.clone().map(move |other| (one, other)))
    {
        // An observer that is raised with a fault of the hydraulics sees it, too.
        if place == Process && matches!(other, Fde1 | Fde2) {
            continue;
        }
        let (own, of_reading) =
            ((place, fault, Suspect::Process, 0.0), (other, Fault::Incipient, suspect, 60.0));
        for raised in [[own, of_reading], [of_reading, own]] {
            let mut story = Story::new();
            for (t, (place, fault, suspect, residual)) in [10.0, 10.05].into_iter().zip(raised) {
                story.raise(t, place, fault, suspect, residual);
            }
            story.follow(10.05, [Some(0.06); 4]);
            assert_eq!(story.numbers(Progress::Opened), [1, 2], "{raised:?}");
            for incident in &story.told {
                let of_oil = incident.suspect == Suspect::Process;
                // Others' sizes are not its own, but that they were judged is told.
                assert_eq!(incident.worst().is_none(), of_oil, "{incident:?}");
                assert!(incident.peaks[Quantity::R1 as usize].is_some(), "{incident:?}");
                assert!(of_oil || incident.suspect == suspect, "{raised:?} {incident:?}");
            }
        }
    }
}

/// What is wrong with the oil stays when the command comes again, and has a name of its own.
#[test]
fn a_command_that_does_not_come_is_not_what_is_wrong_with_the_hydraulics() {
    let leak = (Process, Fault::Leakage);
    let command = (PlausibilityOfCommand, Fault::Stale);
    for raised in [[leak, command], [command, leak]] {
        let mut story = Story::new();
        for (t, (place, fault)) in [10.0, 11.0].into_iter().zip(raised) {
            story.raise(t, place, fault, Suspect::Process, 0.0);
            story.cycle(t, [0.1; 3]);
        }
        assert_eq!(story.numbers(Progress::Opened), [1, 2], "{raised:?}");
        for (incident, (_, fault)) in story.told.iter().zip(raised) {
            assert_eq!(incident.fault, fault);
        }
    }
}

/// C1 is lost and C2 steps 30 s later. FDE2 is undecided until the step has lasted, though within one event.
#[test]
fn the_fault_of_the_last_transducer_is_an_incident_of_its_own() {
    for (rule, expected) in [(Rule::LastTransducer, 2), (Rule::OneObserver, 1)] {
        let mut story = Story::new();
        story.raise(220.0, PlausibilityOfC1, Fault::Stale, Suspect::C1, 0.0);
        story.follow(220.0, [None, Some(1e-4), None, None]);
        story.raise(250.0, Fde2, Fault::Abrupt, Suspect::Undecided, 9.9);
        story.follow(250.0, [None, Some(9.9e-3), None, None]);
        assert_eq!(story.numbers(Progress::Opened), [1], "it may be C1's");
        let latched = Finding { rule, ..finding(Fault::Abrupt, Suspect::C2, 0.1e-3) };
        story.say(250.05, Fde2, State::Changed, latched);
        story.follow(250.05, [None, Some(1e-4), None, None]);
        let opened = story.numbers(Progress::Opened);
        assert_eq!(opened.len(), expected, "{rule:?}");
        let suspect =
            |number: u32| story.told.iter().rfind(|it| it.number == number).map(|it| it.suspect);
        assert_eq!(suspect(1), Some(Suspect::C1));
        if expected == 2 {
            assert_eq!(suspect(2), Some(Suspect::C2));
            let own = story.told.iter().find(|it| it.number == 2).expect("it was reported");
            // It began as the step did, and was as large.
            let largest = own.worst().expect("FDE2 had found it").1;
            assert_eq!((own.begin, largest.value), (at(250.0), 9.9e-3));
            assert_eq!(own.part(Fde2).and_then(|it| it.finding.residual), Some(9.9e-3));
            let first = story.incidents.standing(at(251.0)).find(|it| it.number == 1);
            let first = first.expect("C1 is still out");
            assert!(first.part(Fde2).is_none() && first.part(PlausibilityOfC1).is_some());
            assert_eq!((first.fault, first.size), (Fault::Stale, None), "the step was C2's");
        }
    }
}

/// C1 is out for minutes. FDE2 was raised for a moment, undecided, and is raised again for what C2 is named for.
#[test]
fn what_the_observer_had_found_before_stays_where_it_was() {
    let mut story = Story::new();
    story.raise(220.0, PlausibilityOfC1, Fault::Stale, Suspect::C1, 0.0);
    story.raise(220.5, Fde2, Fault::Noise, Suspect::Undecided, 1.2);
    story.clear(221.5, Fde2);
    story.raise(223.0, Fde2, Fault::Abrupt, Suspect::Undecided, 9.9);
    let latched =
        Finding { rule: Rule::LastTransducer, ..finding(Fault::Abrupt, Suspect::C2, 0.1e-3) };
    story.say(223.3, Fde2, State::Changed, latched);
    story.follow(223.3, [None, Some(1e-4), None, None]);
    let own = story.told.iter().find(|it| it.suspect == Suspect::C2).expect("it is its own");
    assert_eq!(own.begin, at(223.3), "when it was named: the part began for another reason");
    let first = story.incidents.standing(at(224.0)).find(|it| it.suspect == Suspect::C1);
    let part = *first.as_ref().and_then(|it| it.part(Fde2)).expect("it had been raised");
    assert!(!part.stands && part.raises == 2);
}
