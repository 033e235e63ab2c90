//! Machines with several buses: each has identifiers of its own, and what is lost with one of them is unknown, and
//! only that.

use tertius::alarm::Detector;
use tertius::config::{self, design};
use tertius::dbc::{Database, text};
use tertius::frame::{BusNumber, Frame, Id, Kind};
use tertius::monitor::{Monitor, MonitorDesign, Notice};
use tertius::sample::Quality;
use tertius::verdict::Fault;
use tertius_testing::machine::{Collected, Cycle, MS, START, play};
use tertius_testing::top;

const FIRST: BusNumber = BusNumber::First;
const SECOND: BusNumber = BusNumber::Second;

/// The machine that ships, with its configuration as `change` makes it.
fn design_of(change: impl Fn(&str) -> String) -> MonitorDesign {
    let path = top().join("config/e-type-two-buses.toml");
    let text = change(&std::fs::read_to_string(&path).expect("it ships"));
    let loaded = config::load_text(&path, &text).expect("it is sound");
    let database = Database::parse(&text::from_bytes(&loaded.dbc_text)).expect("it is sound");
    design::judging(&loaded.settings, &database).expect("it can be monitored")
}

fn shipped() -> MonitorDesign {
    design_of(str::to_owned)
}

fn monitored(design: MonitorDesign, frames: &[Frame]) -> Collected {
    let (mut monitor, mut seen) = (Monitor::new(design), Collected::default());
    frames.iter().for_each(|frame| monitor.take(frame, &mut seen));
    monitor.finish(&mut seen);
    seen
}

/// Frames of `cycles`, those with identifiers in `second` on the second bus.
fn frames(cycles: i64, second: std::ops::Range<u32>) -> Vec<Frame> {
    let frames = (0..cycles).flat_map(|k| Cycle::new(k).frames());
    let on = |frame: Frame| {
        let bus = if second.contains(&frame.id.value()) { SECOND } else { FIRST };
        frame.on(bus)
    };
    frames.map(on).collect()
}

const C2: std::ops::Range<u32> = 0x191..0x197;
const VALVES: std::ops::Range<u32> = 0x1A1..0x1A7;

/// Whether a frame is of cycle `from` or a later one before `until`.
fn is_within(frame: &Frame, from: i64, until: i64) -> bool {
    let cycle = (frame.timestamp.as_nanos() - START).div_euclid(20 * MS);
    (from..until).contains(&cycle)
}

#[test]
fn two_buses_say_what_one_would_say() {
    let one: Vec<Frame> = (0..300).flat_map(|k| Cycle::new(k).frames()).collect();
    let (_, expected) = play(one);
    let seen = monitored(shipped(), &frames(300, C2));
    assert_eq!(seen.records, expected.records);
    assert_eq!(seen.warnings, expected.warnings);
    assert!(seen.records.iter().any(|record| record.residuals[1].is_some()));
}

#[test]
fn each_bus_has_identifiers_of_its_own() {
    let sound = frames(300, C2);
    let expected = monitored(shipped(), &sound);
    // Strangers with the same identifiers as transducers, each on the other bus.
    let strangers = sound.iter().flat_map(|frame| {
        let other = if frame.bus == FIRST { SECOND } else { FIRST };
        let stranger = Frame::new(frame.timestamp, frame.id, frame.kind, &[0xFF; 6]).on(other);
        [stranger, frame.clone()]
    });
    let seen = monitored(shipped(), &strangers.collect::<Vec<_>>());
    assert_eq!(seen.records, expected.records);
    assert!(seen.warnings.is_empty(), "{:?}", seen.warnings);
    // The same messages on both, as of two transducers of one kind.
    let alike = design_of(|text| text.replace("second:Cyl{n}_C2", "second:Cyl{n}_C1"));
    let both = sound.iter().filter(|frame| frame.bus == FIRST).flat_map(|frame| {
        let is_c1 = (0x181..0x187).contains(&frame.id.value());
        [Some(frame.clone()), is_c1.then(|| frame.clone().on(SECOND))].into_iter().flatten()
    });
    let seen = monitored(alike, &both.collect::<Vec<_>>());
    let read = |record: &tertius::monitor::Record| record.c1.is_some() && record.c1 == record.c2;
    assert!(seen.records.len() > 1000 && seen.records.iter().all(read));
}

#[test]
fn a_silent_bus_blames_nobody_and_what_the_other_carries_is_judged_on() {
    let all = frames(400, C2);
    let heard = |frame: &&Frame| frame.bus == FIRST || !is_within(frame, 100, 300);
    let seen = monitored(shipped(), &all.iter().filter(heard).cloned().collect::<Vec<_>>());
    assert!(seen.warnings.is_empty(), "{:?}", seen.warnings);
    for k in 100..300 {
        for cylinder in 1..=6 {
            let record = seen.record(k, cylinder);
            assert!(record.judged[0] && record.residuals[0].is_some(), "{record:?}");
            assert_eq!(
                (record.judged[1], record.residuals[1], record.residuals[2]),
                (false, None, None)
            );
            assert_eq!(record.qualities, [Quality::Good, Quality::Missing], "never stale");
        }
    }
    let silences: Vec<(BusNumber, bool)> = { seen.notices.iter() }
        .filter_map(|notice| match notice {
            Notice::Silence { bus, silent, .. } => Some((*bus, *silent)),
            _ => None,
        })
        .collect();
    assert_eq!(silences, [(SECOND, true), (SECOND, false)]);
    // Half a second to settle after it.
    assert!(seen.record(399, 1).judged[1]);
}

#[test]
fn a_transducer_that_is_missing_on_a_bus_that_is_heard_is_blamed() {
    let all = frames(200, C2);
    let heard = |frame: &&Frame| frame.id.value() != 0x193 || !is_within(frame, 100, 150);
    let seen = monitored(shipped(), &all.iter().filter(heard).cloned().collect::<Vec<_>>());
    let first = seen.warnings.first().expect("it is missed");
    assert_eq!((first.cylinder, first.finding.fault), (3, Fault::Stale));
    assert!(seen.warnings.iter().all(|warning| warning.cylinder == 3), "{:?}", seen.warnings);
}

#[test]
fn without_the_bus_of_the_commands_nothing_is_judged_and_nobody_blamed() {
    let of_valves = |text: &str| {
        text.replace("second:Cyl{n}_C2", "Cyl{n}_C2")
            .replace("\"Cyl{n}_Valve", "\"second:Cyl{n}_Valve")
    };
    let design = design_of(of_valves);
    let all = frames(300, VALVES);
    let heard = |frame: &&Frame| frame.bus == FIRST || !is_within(frame, 100, 200);
    let seen = monitored(design, &all.iter().filter(heard).cloned().collect::<Vec<_>>());
    assert!(seen.warnings.is_empty(), "{:?}", seen.warnings);
    for k in 100..200 {
        assert_eq!(seen.record(k, 1).judged, [false; 2], "the model needs commands");
        assert!(seen.record(k, 1).residuals[2].is_some(), "C1 and C2 are compared without");
    }
    assert_eq!(seen.record(299, 1).judged, [true; 2]);
}

#[test]
fn a_bus_that_goes_off_restarts_what_it_carries_and_nothing_else() {
    let mut all = frames(300, C2);
    let id = Id::extended(0x40).expect("29 bits");
    let at = all.iter().position(|frame| is_within(frame, 150, 151)).expect("there are cycles");
    let off = Frame::new(all[at].timestamp, id, Kind::Error, &[0; 8]).on(SECOND);
    all.insert(at, off.clone());
    let seen = monitored(shipped(), &all);
    let restarts: Vec<Detector> = { seen.notices.iter() }
        .filter_map(|notice| match notice {
            Notice::Restart { detector, .. } => Some(*detector),
            _ => None,
        })
        .collect();
    assert_eq!(restarts, [Detector::Fde2; 6]);
    let interruption = Notice::Interruption { at: off.timestamp, bus: Some(SECOND) };
    assert!(seen.notices.contains(&interruption), "{:?}", seen.notices);
    assert!((150..160).all(|k| seen.record(k, 1).judged == [true, false]));
    // Of the only bus of a machine it restarts everything.
    let (_, seen) = play(all.into_iter().map(|frame| frame.on(FIRST)));
    assert!(seen.notices.contains(&Notice::Interruption { at: off.timestamp, bus: None }));
    assert_eq!(seen.record(155, 1).judged, [false; 2]);
}
