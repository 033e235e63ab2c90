use super::*;
use tertius_core::alarm::{Evidence, Finding, State, Warning};
use tertius_core::blame::Rule;
use tertius_core::incident::{EventTiming, Incidents, Progress};
use tertius_core::verdict::Testimony;

const TIMING: EventTiming = EventTiming {
    coincidence: Span::from_nanos(200_000_000),
    clear: Span::from_nanos(1_000_000_000),
};
const LIMITS: [f64; 4] = [1e-3, 1e-3, 1.5e-3, 0.05];
const CYCLE: Span = Span::from_nanos(20_000_000);

fn at(seconds: f64) -> Timestamp {
    Timestamp::default().after(Span::from_seconds(seconds))
}

fn finding(suspect: Suspect, by: Option<Testimony>) -> Finding {
    let location = by.map(|_| if suspect == Suspect::C1 { 9.2 } else { -9.2 });
    let evidence = Evidence { fault: 31.0, location, by, onset: at(0.0), gain: None, size: None };
    Finding {
        fault: Fault::Incipient,
        suspect,
        rule: Rule::OneObserver,
        level: Level::Yellow,
        residual: Some(4e-4),
        threshold: None,
        evidence: Some(evidence),
        device: None,
    }
}

/// The incident of a sequential warning that blames nobody at first and then, after 4 s, `suspect`.
fn told(suspect: Suspect, by: Testimony) -> Incident {
    let mut incidents = Incidents::new([(LIMITS, TIMING)], CYCLE);
    let mut newest = None;
    let warnings = [
        (1.0, State::Raised, finding(Suspect::Undecided, None)),
        (5.0, State::Changed, finding(suspect, Some(by))),
    ];
    for (seconds, state, finding) in warnings {
        incidents.take(&Warning {
            timestamp: at(seconds),
            cylinder: 1,
            detector: Detector::Sequential,
            place: WarningPlace::Sequential as usize,
            state,
            finding,
        });
        let quiet = [Some(1.2e-4), Some(-2e-4), Some(1.1e-3), None];
        incidents.follow(0, [at(seconds); 2], &quiet, |it| newest = Some(*it));
    }
    newest.filter(|it| it.progress == Progress::Revised).expect("it was revised")
}

/// The incident of a warning of FDE1 about a cylinder without C2.
fn alone(suspect: Suspect, fault: Fault) -> Incident {
    let finding = Finding { fault, residual: Some(1.2e-3), ..finding(suspect, None) };
    alone_by(WarningPlace::Fde1, finding, 1.2e-3)
}

/// The incident of a finding about a cylinder without C2, with that R1, m.
fn alone_by(place: WarningPlace, finding: Finding, r1: f64) -> Incident {
    let limits = [1e-3, f64::INFINITY, f64::INFINITY, f64::INFINITY];
    let mut incidents = Incidents::new([(limits, TIMING); 3], CYCLE);
    incidents.take(&Warning {
        timestamp: at(1.0),
        cylinder: 3,
        detector: tertius_core::alarm::detector::DETECTORS[place as usize],
        place: place as usize,
        state: State::Raised,
        finding,
    });
    let mut newest = None;
    let quantities = [Some(r1), None, None, None];
    for seconds in [1.0, 1.5] {
        incidents.follow(2, [at(seconds); 2], &quantities, |it| newest = Some(*it));
    }
    newest.expect("it was told")
}

#[test]
fn nothing_is_compared_on_a_cylinder_without_c2() {
    let incident = alone(Suspect::C1, Fault::Incipient);
    let told = evidence(&incident);
    assert_eq!(told, "C1's observer rose; there is no second transducer to ask, so C1 is blamed");
    let told = advice(&incident, &MachineNames::default());
    let cylinder = "If nothing is wrong there, look at the cylinder, its valve and its supply.";
    assert!(told.contains("magnet of C1") && told.ends_with(cylinder), "{told}");

    let open = alone(Suspect::Undecided, Fault::Noise);
    assert!(
        line(&open, &MachineNames::default())
            .starts_with("cylinder 3, C1 or the cylinder, yellow: "),
        "{}",
        line(&open, &MachineNames::default())
    );
    let told = advice(&open, &MachineNames::default());
    assert!(told.contains("if C1 reads another length there than before"), "{told}");
    let process = alone(Suspect::Process, Fault::Unclassified);
    assert!(
        line(&process, &MachineNames::default()).starts_with("cylinder 3, not C1, yellow: "),
        "{}",
        line(&process, &MachineNames::default())
    );
    for it in [incident, open, process] {
        let all = [
            evidence(&it),
            line(&it, &MachineNames::default()),
            advice(&it, &MachineNames::default()),
        ]
        .concat();
        assert!(!all.contains("C2") && !all.contains("difference"), "{all}");
        assert!(!all.contains("neither") && !all.contains("which of the two"), "{all}");
    }
}

#[test]
fn what_the_deck_says_of_a_single_transducer_is_evidence_of_its_own() {
    let of_deck = finding(Suspect::C1, Some(Testimony::Attitude));
    let of_deck = Finding { residual: Some(-9.5e-3), ..of_deck };
    let incident = alone_by(WarningPlace::Sequential, of_deck, 0.2e-3);
    let told = evidence(&incident);
    let expected = "the deck stood as if C1 were off by 9.50 mm, as no other cylinder explains (9 nats); C1's observer \
                    stayed quiet (0.20 mm of 1.00 mm); so it is C1";
    assert_eq!(told, expected);
    assert_eq!((incident.suspect, incident.fault), (Suspect::C1, Fault::Incipient));
    assert_eq!((incident.onset, incident.size), (at(0.0), Some(-9.5e-3)));
}

/// The observer rose by a residual of its own before.
#[test]
fn a_departure_from_dead_reckoning_is_told_with_what_looks_the_same() {
    let mut incidents = Incidents::new([(LIMITS, TIMING)], CYCLE);
    let by_way = finding(Suspect::C2, Some(Testimony::Way));
    let by_way = Finding { residual: Some(-0.0166), threshold: Some(0.0131), ..by_way };
    let rose = Finding { evidence: None, ..finding(Suspect::Undecided, None) };
    for (seconds, state, finding) in [(1.0, State::Raised, rose), (2.0, State::Changed, by_way)] {
        incidents.take(&Warning {
            timestamp: at(seconds),
            cylinder: 1,
            detector: Detector::Fde2,
            place: WarningPlace::Fde2 as usize,
            state,
            finding,
        });
        incidents.follow(0, [at(seconds); 2], &[None, Some(0.6e-3), None, None], |_| {});
    }
    let mut incident = None;
    incidents.finish(at(2.0), |it| incident = Some(*it));
    let incident = incident.expect("it stands");
    let told = evidence(&incident);
    let departs = "C2 departed from the rod's way by dead reckoning, by 16.6 mm (limit 13.1 mm)";
    assert!(told.contains(departs) && !told.contains("rose"), "{told}");
    let end = "C2 is blamed, but a cylinder that leaks or a valve that has changed looks the same";
    assert!(told.ends_with(end), "{told}");
    let line = line(&incident, &MachineNames::default());
    assert!(line.contains("beside its way by 16.6 mm (limit 13.1 mm)"), "{line}");
    let advice = advice(&incident, &MachineNames::default());
    assert!(advice.contains("look at the cylinder, its valve"), "{advice}");
}

#[test]
fn what_both_readings_share_is_told_as_such() {
    let words = [
        (
            Testimony::Innovations,
            "both jumped by 30.0 mm, as no rod does, so it is what C1 and C2 share",
        ),
        (
            Testimony::Way,
            "either C1 and C2 share a fault, or the cylinder does not follow its valve",
        ),
    ];
    for (by, end) in words {
        let shared = Finding {
            residual: Some(0.03),
            threshold: Some(0.012),
            ..finding(Suspect::Process, Some(by))
        };
        let incident = alone_by(WarningPlace::Fde1, shared, 0.2e-3);
        let told = evidence(&incident);
        assert!(told.ends_with(end), "{told}");
        let advice = advice(&incident, &MachineNames::default());
        assert!(advice.starts_with("Look at what C1 and C2 share"), "{advice}");
    }
}

#[test]
fn what_named_the_side_is_told_where_both_observers_stayed_quiet() {
    let by_flow = evidence(&told(Suspect::C1, Testimony::Flow));
    let end = "C2's observer stayed quiet (0.20 mm of 1.00 mm); the difference stayed quiet (1.10 mm of 1.50 mm); the \
               oil that passed the valve agrees with C2 and not with C1 (9 nats); so it is C1 (named after 4.0 s)";
    assert!(by_flow.ends_with(end), "{by_flow}");
    assert!(by_flow.contains("the evidence of many samples (31 nats) showed it"), "{by_flow}");
    let by_deck = evidence(&told(Suspect::C2, Testimony::Attitude));
    let end = "the attitude of the deck agrees with C1 and not with C2 (9 nats); so it is C2 (named after 4.0 s)";
    assert!(by_deck.ends_with(end), "{by_deck}");
}

#[test]
fn what_the_samples_themselves_say_stays_with_them() {
    let told = evidence(&told(Suspect::C1, Testimony::Innovations));
    assert!(told.contains("the evidence of many samples (31 nats; 9 for C1) showed it"), "{told}");
    assert!(told.ends_with("(1.10 mm of 1.50 mm); so it is C1 (named after 4.0 s)"), "{told}");
}

/// The incident of warnings that each come at their own time.
fn of(warnings: &[(f64, WarningPlace, Finding)]) -> Incident {
    let mut incidents = Incidents::new([(LIMITS, TIMING)], CYCLE);
    let mut end = at(0.0);
    for (seconds, place, finding) in warnings {
        incidents.take(&Warning {
            timestamp: at(*seconds),
            cylinder: 1,
            detector: tertius_core::alarm::detector::DETECTORS[*place as usize],
            place: *place as usize,
            state: State::Raised,
            finding: *finding,
        });
        let loud = [Some(2e-3), Some(2e-3), Some(2e-3), None];
        end = at(*seconds);
        incidents.follow(0, [end; 2], &loud, |_| {});
    }
    let mut standing = None;
    incidents.finish(end, |it| standing = Some(*it));
    standing.expect("it stands")
}

#[test]
fn what_spoke_up_is_told_in_the_order_of_time() {
    let of_samples = finding(Suspect::C1, None);
    let compared = Finding { evidence: None, suspect: Suspect::C1, ..of_samples };
    let (fde1, fde2, fde3) = (WarningPlace::Fde1, WarningPlace::Fde2, WarningPlace::Fde3);
    let sequential = WarningPlace::Sequential;
    let samples_first =
        of(&[(1.0, sequential, of_samples), (2.1, fde3, compared), (50.0, fde2, compared)]);
    let told = "the evidence of many samples (31 nats) showed it first; after 1.1 s the difference rose; after 49.0 s \
                C2's observer rose; ";
    assert!(evidence(&samples_first).starts_with(told), "{}", evidence(&samples_first));
    let samples_between =
        of(&[(1.0, fde1, compared), (1.8, sequential, of_samples), (11.6, fde3, compared)]);
    let told = "C1's observer rose; after 800 ms the evidence of many samples (31 nats) showed it; after 10.6 s the \
                difference rose; ";
    assert!(evidence(&samples_between).starts_with(told), "{}", evidence(&samples_between));
    let frozen = Finding { fault: Fault::Frozen, ..compared };
    let found_late = of(&[(1.0, fde1, compared), (2.0, WarningPlace::PlausibilityOfC1, frozen)]);
    let told = "C1's observer rose; after 1.0 s it was found that C1 did not change while the cylinder was driven; ";
    assert!(evidence(&found_late).starts_with(told), "{}", evidence(&found_late));
}

/// All frames come too late.
#[test]
fn what_the_cylinders_share_is_told_once_and_suspects_no_transducer() {
    let mut incidents = Incidents::new([(LIMITS, TIMING); 3], CYCLE);
    for cylinder in 1..=3 {
        for (place, suspect) in [
            (WarningPlace::PlausibilityOfC1, Suspect::C1),
            (WarningPlace::PlausibilityOfC2, Suspect::C2),
        ] {
            let stale = Finding { fault: Fault::Stale, evidence: None, ..finding(suspect, None) };
            incidents.take(&Warning {
                timestamp: at(1.0),
                cylinder,
                detector: Detector::Plausibility,
                place: place as usize,
                state: State::Raised,
                finding: Finding { level: Level::Black, ..stale },
            });
        }
    }
    let mut told = None;
    incidents.follow_machine(at(1.0), |it| told = Some(*it));
    let told = told.expect("it is the machine's");
    assert_eq!(
        line(&told, &MachineNames::default()),
        "machine (cylinders 1 to 3), black: no messages in time"
    );
    let end = "so no transducer is suspected";
    assert!(evidence(&told).ends_with(end), "{}", evidence(&told));
    assert!(
        advice(&told, &MachineNames::default()).contains("the Sync"),
        "{}",
        advice(&told, &MachineNames::default())
    );
}

/// That the observers and the difference stayed quiet is what speaks for the hydraulics.
#[test]
fn of_a_fault_of_the_hydraulics_it_is_told_what_stayed_quiet() {
    let mut incidents = Incidents::new([(LIMITS, TIMING)], CYCLE);
    let leak = Finding { fault: Fault::Leakage, ..finding(Suspect::Process, None) };
    let warning = Warning {
        timestamp: at(1.0),
        cylinder: 1,
        detector: Detector::Process,
        place: WarningPlace::Process as usize,
        state: State::Raised,
        finding: leak,
    };
    incidents.take(&warning);
    // The difference is another fault's, which is told elsewhere.
    incidents.follow(0, [at(1.0); 2], &[Some(2e-4), None, Some(0.06), Some(0.06)], |_| {});
    let mut standing = None;
    incidents.finish(at(1.0), |it| standing = Some(*it));
    let told = evidence(&standing.expect("it stands"));
    for clause in [
        "C1's observer stayed quiet (0.20 mm of",
        "C2's observer was not judged",
        "the difference stands for another fault (60.0 mm of",
    ] {
        assert!(told.contains(clause), "{told}");
    }
}

/// A drift whose transducer nobody knew before it ended.
#[test]
fn a_suspect_that_was_named_late_is_told_as_such() {
    let open = Finding { evidence: None, ..finding(Suspect::Undecided, None) };
    let ends = Finding { suspect: Suspect::C2, residual: Some(2e-3), ..open };
    let late = of(&[(1.0, WarningPlace::Fde3, open), (119.7, WarningPlace::Fde2, ends)]);
    let told = "cylinder 1, C2 (named after 118.7 s, when the fault ended), yellow: growing error, R2 up to 2.00 mm (limit 1.00 mm)";
    assert_eq!(line(&late, &MachineNames::default()), told);
    let told = "; so it is C2 (named by C2's observer after 118.7 s, when the fault ended)";
    assert!(evidence(&late).ends_with(told), "{}", evidence(&late));
    let named = Finding { suspect: Suspect::C2, ..open };
    let at_once = of(&[(1.0, WarningPlace::Fde3, named)]);
    assert!(
        line(&at_once, &MachineNames::default()).starts_with("cylinder 1, C2, yellow"),
        "{}",
        line(&at_once, &MachineNames::default())
    );
}

/// Two incidents with other suspects differ in their evidence, too.
#[test]
fn evidence_tells_why_it_is_not_known_which() {
    let told = |suspect: Suspect, others: Option<f64>| {
        let mut incidents = Incidents::new([(LIMITS, TIMING)], CYCLE);
        let finding = Finding { evidence: None, ..finding(suspect, None) };
        let (detector, place) = (Detector::Fde1, WarningPlace::Fde1 as usize);
        let (timestamp, state) = (at(1.0), State::Raised);
        let warning = Warning { timestamp, cylinder: 1, detector, place, state, finding };
        incidents.take(&warning);
        incidents.follow(0, [at(1.0); 2], &[Some(2e-3), others, Some(1e-4), None], |_| {});
        incidents.follow(0, [at(1.1); 2], &[Some(1e-4); 4], |_| {});
        let mut standing = None;
        incidents.finish(at(2.0), |it| standing = Some(*it));
        evidence(&standing.expect("it stands"))
    };
    let known = told(Suspect::C1, Some(1e-4));
    let open = told(Suspect::Undecided, None);
    assert!(known.contains("C2's observer stayed quiet (0.10 mm of"), "{known}");
    assert!(known.ends_with("; so it is C1"), "{known}");
    assert!(
        open.contains("C2's observer was not judged at first, then stayed quiet (0.10 mm"),
        "{open}"
    );
    assert!(open.ends_with("; so it is not known which of the two is faulty"), "{open}");
}

#[test]
fn what_the_stop_says_of_a_single_transducer_may_be_the_stop() {
    let of_stop = finding(Suspect::Undecided, Some(Testimony::Stop));
    let evidence_of = Evidence { fault: 0.0, location: None, ..of_stop.evidence.expect("some") };
    let of_stop = Finding { residual: Some(-1.31e-3), evidence: Some(evidence_of), ..of_stop };
    let incident = alone_by(WarningPlace::Sequential, of_stop, 0.2e-3);
    let expected = "on its stop C1 read 1.31 mm beside what it read there before; C1's observer stayed quiet (0.20 mm of \
                    1.00 mm); so it is C1 or its stop: one that has worn by more than usual, or is dented, looks the same";
    assert_eq!(evidence(&incident), expected);
    let told = advice(&incident, &MachineNames::default());
    assert!(
        told.starts_with("Look at the cylinder's stop") && told.contains("magnet of C1"),
        "{told}"
    );
}
