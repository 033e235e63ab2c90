//! A monitor that takes up a saved state goes on as the one that saved it, whatever the frames were and wherever the
//! cut is; and whatever a file has in it, it is refused or goes on without a panic.

use crate::fluctuating::FLUCTUATING;
use crate::process::TAUGHT;
use crate::sequential_support::setup;
use crc::{CRC_64_XZ, Crc};
use std::fmt::{self, Write as _};
use tertius::alarm::Warning;
use tertius::config::design;
use tertius::frame::{BusNumber, Frame, Id, Kind};
use tertius::monitor::{Estimates, MAX_STATE, Monitor, MonitorDesign, SavedState, StateRefusal};
use tertius::time::Timestamp;
use tertius::verdict::Fault;
use tertius_testing::candump::read;
use tertius_testing::machine::{self, Collected, Cycle, design_of_default, design_without};
use tertius_testing::support::{Scratch, Seeded, between, recorded, tertius};

const CRC: Crc<u64> = Crc::<u64>::new(&CRC_64_XZ);

/// The design of a configuration, with estimates.
fn design_of(config: &str) -> MonitorDesign {
    MonitorDesign { estimates: Estimates::Sent, ..machine::design_of(config) }
}

fn frames_of(log: &str) -> Vec<Frame> {
    read(log.as_bytes()).0
}

/// What another monitor makes of the state of `monitor`, by way of a file.
fn resumed(monitor: &Monitor, design: &MonitorDesign) -> Monitor {
    let saved = SavedState::of(monitor, design.checksum(), Timestamp::default());
    let read = SavedState::from_bytes(&saved.to_bytes()).expect("it was saved");
    assert_eq!(read, saved);
    read.resume(design.clone()).expect("the design is the same")
}

/// Compares what is written to it with a text, as it comes: a monitor with all of its tables is megabytes.
struct Same<'a>(&'a str);

impl fmt::Write for Same<'_> {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        self.0 = self.0.strip_prefix(text).ok_or(fmt::Error)?;
        Ok(())
    }
}

/// Compares all fields of both monitors, design and state.
#[track_caller]
fn assert_same(one: &Monitor, other: &Monitor, what: &str) {
    let expected = format!("{one:?}");
    let mut same = Same(&expected);
    if write!(same, "{other:?}").is_err() || !same.0.is_empty() {
        let before = expected.len() - same.0.len();
        let begin = expected[..before].char_indices().nth_back(300).map_or(0, |(at, _)| at);
        panic!("{what}: another monitor after {}", &expected[begin..before]);
    }
}

/// Cuts the reading of `frames` at `cuts` places, and compares there, and over the next `after` frames.
fn cut(design: &MonitorDesign, frames: &[Frame], cuts: u64, after: usize) {
    let mut seeded = Seeded(frames.len() as u64);
    let mut places: Vec<usize> =
        (0..cuts).map(|_| seeded.below(frames.len() as u64) as usize).collect();
    places.sort_unstable();
    let (mut monitor, mut seen) = (Monitor::new(design.clone()), Collected::default());
    let mut next = 0;
    for place in places {
        frames[next..place].iter().for_each(|frame| monitor.take(frame, &mut seen));
        next = place;
        let mut other = resumed(&monitor, design);
        assert_same(&monitor, &other, &format!("cut before frame {place}"));
        let mut ahead = monitor.clone();
        let [mut ours, mut theirs] = [Collected::default(), Collected::default()];
        for frame in frames[place..].iter().take(after) {
            ahead.take(frame, &mut ours);
            other.take(frame, &mut theirs);
        }
        ahead.finish(&mut ours);
        other.finish(&mut theirs);
        assert!(format!("{ours:?}") == format!("{theirs:?}"), "cut before frame {place}");
        assert_same(&ahead, &other, &format!("after a cut before frame {place}"));
    }
}

/// With faults, warnings and incidents, the tables of a calibration and estimates.
#[test]
fn a_recording_with_faults_is_cut_anywhere() {
    let design = design_of("tests/recordings/e-type-sequential.toml");
    let frames = frames_of(&between(&recorded("e-type-faults.log.zst"), 100.0, 130.0));
    cut(&design, &frames, 12, 3000);
}

#[test]
fn a_coarse_recording_is_cut_anywhere() {
    let frames = frames_of(&between(&recorded("e-type-coarse.log.zst"), 30.0, 45.0));
    cut(&design_of("config/e-type-coarse.toml"), &frames, 8, 2000);
}

/// Emergency messages, heartbeats, and readings by timers.
#[test]
fn a_canopen_recording_is_cut_anywhere() {
    let scratch = Scratch::new();
    let (log, config) = (scratch.path("devices.log"), "config/e-type-canopen.toml");
    let call =
        ["simulate", "--config", config, "--duration", "20", "--seed", "5", "--output", &log];
    let faults = [
        "broken_wire,cylinder=3,sensor=c1_emergency,at=4,until=6",
        "broken_wire,cylinder=6,sensor=valve_emergency,at=8,until=9,code=16912",
        "loss,cylinder=5,sensor=c1,at=9,until=12",
    ];
    let faults: Vec<&str> = faults.iter().flat_map(|fault| ["--fault", fault]).collect();
    tertius(&[&call[..], &faults].concat(), b"").ok();
    cut(&design_of(config), &frames_of(&scratch.read("devices.log")), 12, 2000);
}

/// A deck whose attitude is compared, while nothing is wrong and while a transducer drifts.
#[test]
fn a_tilting_deck_is_cut_anywhere() {
    let setup = setup().without_process().with_top();
    let drift = "drift,rate=0.002,cylinder=2,sensor=c1,at=30".to_owned();
    let mut simulator = setup.simulator(&setup.options(4, &[drift]));
    let mut frames = Vec::new();
    (0..2000).for_each(|_| simulator.step(&mut |frame| frames.push(frame.clone())));
    let design = design::judging(&setup.settings, &setup.database).expect("they fit");
    let mut monitor = Monitor::new(design.clone());
    frames.iter().for_each(|frame| monitor.take(frame, &mut Collected::default()));
    let tilt = format!("{:?}", monitor.tilt());
    assert!(tilt.contains("since: Some") && tilt.contains("healthy: Some"), "{tilt}");
    cut(&design, &frames, 12, 3000);
}

/// Transducers that fluctuate, while nothing is wrong, and while one steps in an excursion of the other.
#[test]
fn a_machine_that_fluctuates_is_cut_anywhere() {
    let setup = FLUCTUATING.without_process();
    let faults = [
        "step,size=0.0006,cylinder=2,sensor=c1,at=20",
        "noise,size=0.0006,cylinder=5,sensor=c2,at=25",
    ];
    let mut simulator = setup.simulator(&setup.options(6, &faults.map(str::to_owned)));
    let mut frames = Vec::new();
    (0..1600).for_each(|_| simulator.step(&mut |frame| frames.push(frame.clone())));
    let design = design::judging(&setup.settings, &setup.database).expect("they fit");
    let (mut monitor, mut seen) = (Monitor::new(design.clone()), Collected::default());
    let (before, after) = frames.split_at(frames.len() - 500);
    before.iter().for_each(|frame| monitor.take(frame, &mut seen));
    for cylinder in [2, 5] {
        assert!(seen.warnings.iter().any(|it| it.cylinder == cylinder), "{:?}", seen.warnings);
    }
    assert!(forge(&design, &monitor, after, 60) > 10);
    cut(&design, &frames[frames.len() / 3..], 12, 3000);
}

/// Spool, pressures and supply that are judged, while nothing is wrong, while a cylinder has a fault and the supply falls
/// short, and while a transducer drifts in the loop.
#[test]
fn a_machine_with_process_detectors_is_cut_anywhere() {
    let faults = [
        "leakage,cylinder=2,at=20,rate=2.2",
        "loss,cylinder=4,at=30,probability=0.1",
        "supply_loss,cylinder=1,at=24,part=0.2",
        "drift,cylinder=5,at=33,rate=0.005",
    ];
    let frames = TAUGHT.frames(41, &faults, 45.0);
    let design = MonitorDesign { estimates: Estimates::Sent, ..TAUGHT.design.clone() };
    let (before, after) = frames.split_at(frames.len() - 500);
    let (mut monitor, mut seen) = (Monitor::new(design.clone()), Collected::default());
    before.iter().for_each(|frame| monitor.take(frame, &mut seen));
    for (n, fault) in [(2, Fault::Unclassified), (1, Fault::Supply)] {
        let told = |it: &Warning| it.cylinder == n && it.finding.fault == fault;
        assert!(seen.warnings.iter().any(told), "{fault:?}: {:?}", seen.warnings);
    }
    assert!(forge(&design, &monitor, after, 60) > 10);
    cut(&design, &frames[frames.len() / 3..], 12, 3000);
}

/// Frames that are lost, late, repeated and out of order, so that places wait and hold; with Sync, with transducers that
/// send by timers of their own, and without Sync.
#[test]
fn a_disturbed_bus_is_cut_anywhere() {
    let mut seeded = Seeded(11);
    let mut frames: Vec<Frame> = Vec::new();
    for k in 0..400 {
        let offset = if (100..150).contains(&k) { 40 } else { 0 };
        for mut frame in (Cycle { offset, command: 300, ..Cycle::new(k) }).frames() {
            if seeded.chance(0.04) {
                continue;
            }
            let late = if seeded.chance(0.05) { seeded.below(30_000_000) as i64 } else { 0 };
            frame.timestamp = Timestamp::from_nanos(frame.timestamp.as_nanos() + late);
            frames.extend(seeded.chance(0.02).then(|| frame.clone()));
            frames.push(frame);
        }
    }
    frames.sort_by_key(|frame| frame.timestamp);
    for pair in (0..frames.len() - 1).step_by(37) {
        frames.swap(pair, pair + 1);
    }
    let mut by_timers = design_of_default();
    for id in 0x191..=0x196 {
        by_timers
            .subscriptions
            .subscribe(BusNumber::First, Id::standard(id).expect("11 bits"))
            .by_timer = true;
    }
    for design in [design_of_default(), by_timers, design_without(&["sync = "])] {
        cut(&design, &frames, 40, 300);
    }
}

/// A machine with two buses, one of which falls silent, is lost, and comes back.
#[test]
fn several_buses_are_cut_anywhere() {
    let second = BusNumber::Second;
    let mut frames: Vec<Frame> = Vec::new();
    for k in 0..300 {
        let cycle = Cycle { offset: if k > 250 { 40 } else { 0 }, ..Cycle::new(k) };
        let on = |frame: Frame| match frame.id.value() {
            0x191..=0x196 => frame.on(second),
            _ => frame,
        };
        let heard = |frame: &Frame| frame.bus != second || !(100..140).contains(&k);
        frames.extend(cycle.frames().into_iter().map(on).filter(heard));
    }
    let (at, id) = (frames[4000].timestamp, Id::extended(0x40).expect("29 bits"));
    frames.insert(4000, Frame::new(at, id, Kind::Error, &[0; 8]).on(second));
    cut(&design_of("config/e-type-two-buses.toml"), &frames, 40, 300);
}

/// A monitor of the default machine in the middle of a cycle, with a warning.
fn busy() -> (MonitorDesign, Monitor, Vec<Frame>) {
    let design = design_of_default();
    let mut monitor = Monitor::new(design.clone());
    let frames = |range: std::ops::Range<i64>| -> Vec<Frame> {
        let cycle = |k| Cycle { offset: if k > 30 { 40 } else { 0 }, ..Cycle::new(k) };
        range.flat_map(|k| cycle(k).frames()).collect()
    };
    let mut seen = Collected::default();
    for frame in frames(0..60).iter().rev().skip(7).rev() {
        monitor.take(frame, &mut seen);
    }
    assert!(!seen.warnings.is_empty());
    (design, monitor, frames(60..80))
}

#[test]
fn a_file_that_was_changed_or_truncated_is_refused() {
    let (design, monitor, _) = busy();
    let bytes = SavedState::of(&monitor, design.checksum(), Timestamp::default()).to_bytes();
    let refused = |bytes: &[u8]| SavedState::from_bytes(bytes).expect_err("it is damaged");
    for length in (0..100).chain((100..bytes.len()).step_by(101)) {
        let expected = if length < 14 { StateRefusal::Other } else { StateRefusal::Damaged };
        assert_eq!(refused(&bytes[..length]), expected, "{length}");
    }
    for place in (0..100).chain((100..bytes.len()).step_by(97)) {
        let mut changed = bytes.clone();
        changed[place] ^= 1 << (place % 8);
        let expected = if place < 14 { StateRefusal::Other } else { StateRefusal::Damaged };
        assert_eq!(refused(&changed), expected, "{place}");
    }
    assert_eq!(refused(&vec![b't'; MAX_STATE + 1]), StateRefusal::TooLong);
    let mut shape = sealed(&bytes, |content| content[14] ^= 1);
    assert!(matches!(refused(&shape), StateRefusal::Version(_)));
    shape.extend(b"more");
    assert_eq!(refused(&shape), StateRefusal::Damaged);
}

#[test]
fn a_state_of_another_design_is_refused() {
    let (design, monitor, _) = busy();
    let saved = SavedState::of(&monitor, design.checksum(), Timestamp::default());
    let mut other = design.clone();
    other.cylinders[3].bank.observer.high += 1e-9;
    assert_eq!(saved.resume(other).expect_err("a threshold differs"), StateRefusal::Design);
    assert!(saved.resume(design).is_ok());
}

/// `bytes` with a change, and the checksum of what they are then.
fn sealed(bytes: &[u8], change: impl FnOnce(&mut [u8])) -> Vec<u8> {
    let mut content = bytes[..bytes.len() - 8].to_vec();
    change(&mut content);
    let checksum = CRC.checksum(&content);
    content.extend(checksum.to_le_bytes());
    content
}

/// Where the state begins in a file.
const STATE: usize = 14 + 8 + 1 + 5 + 8 + 8 + 8;

/// Tells nothing to anybody.
struct Nobody;

impl tertius::monitor::Sink for Nobody {}

/// Puts numbers into the state of `monitor` that may be anything, gives it a valid checksum, and lets `frames` follow
/// where it is taken up; returns how often it was.
fn forge(design: &MonitorDesign, monitor: &Monitor, frames: &[Frame], tried: u32) -> u32 {
    let bytes = SavedState::of(monitor, design.checksum(), Timestamp::default()).to_bytes();
    let (mut seeded, mut taken) = (Seeded(1), 0);
    for _ in 0..tried {
        let forged = sealed(&bytes, |content| {
            for _ in 0..=seeded.below(3) {
                let place = STATE + seeded.below((content.len() - STATE - 8) as u64) as usize;
                let values = [0, 1, u64::MAX, 1 << 63, (1 << 63) - 1, 1 << 55, seeded.next()];
                let value = values[seeded.below(7) as usize].to_le_bytes();
                let length = [1, 4, 8][seeded.below(3) as usize];
                content[place..place + length].copy_from_slice(&value[..length]);
            }
        });
        let read = SavedState::from_bytes(&forged).expect("its checksum is right");
        let Ok(mut monitor) = read.resume(design.clone()) else { continue };
        taken += 1;
        frames.iter().for_each(|frame| monitor.take(frame, &mut Nobody));
        monitor.finish(&mut Nobody);
    }
    taken
}

#[test]
fn a_forged_state_is_refused_or_does_no_harm() {
    let (design, monitor, frames) = busy();
    let taken = forge(&design, &monitor, &frames, 1500);
    assert!((100..1500).contains(&taken), "{taken}");
    let design = design_of("tests/recordings/e-type-sequential.toml");
    let frames = frames_of(&between(&recorded("e-type-faults.log.zst"), 100.0, 122.0));
    let (before, after) = frames.split_at(frames.len() - 500);
    let mut monitor = Monitor::new(design.clone());
    before.iter().for_each(|frame| monitor.take(frame, &mut Nobody));
    assert!(forge(&design, &monitor, after, 60) > 10);
}

#[test]
fn before_the_first_frame_there_is_a_state_too() {
    let design = design_of_default();
    let monitor = Monitor::new(design.clone());
    assert_same(&monitor, &resumed(&monitor, &design), "nothing was read");
    let id = Id::standard(0x7FF).expect("11 bits");
    let mut monitor = monitor;
    monitor.take(&Frame::new(Timestamp::default(), id, Kind::Data, &[]), &mut Nobody);
    assert_same(&monitor, &resumed(&monitor, &design), "an unused frame was read");
}
