//! The faults of a recording told on the layout of CANopen devices: the same verdicts.

use tertius::frame::{Frame, Id, Kind};
use tertius::time::Timestamp;
use tertius_testing::process::{read as read_log, write};
use tertius_testing::support::{E_TYPE, Scratch, recording, replay, tertius};

/// The code of a broken wire, and the unit of the transducers' counts, m.
const BROKEN_WIRE: u16 = 32_767;
const COUNT: f64 = 3.0 / 27_648.0;

/// Counts of a valve's set point, m/s each: full speed is 2 m/s at 16384.
const SET_POINT: f64 = 2.0 / 16_384.0;

/// A transducer that tells of itself what the recorded ones have in their counts and counters.
#[derive(Clone, Copy, Default)]
struct Transducer {
    counter: Option<u8>,
    fails: bool,
}

impl Transducer {
    /// The frames of a CiA 406 encoder for a recorded frame. One that repeats itself, which only an alive
    /// counter shows, sends nothing; one with a broken wire says that it has an error.
    fn frames(&mut self, frame: &Frame) -> Vec<Frame> {
        let data = frame.data();
        let (raw, velocity) = (u16::from_le_bytes([data[0], data[1]]), &data[2..4]);
        if self.counter.replace(data[5]) == Some(data[5]) {
            return Vec::new();
        }
        let micrometres = ((f64::from(raw) * COUNT - 1.5) * 1e6).round() as i32;
        let mut payload = micrometres.to_le_bytes().to_vec();
        payload.extend(velocity);
        payload.push(0);
        let fails = raw == BROKEN_WIRE || data[4] & 3 != 0;
        let changed = std::mem::replace(&mut self.fails, fails) != fails;
        let emergency: [u8; 8] = if fails { [0x00, 0x50, 0x81, 0, 0, 0, 0, 0] } else { [0; 8] };
        let said = changed.then(|| made(frame.timestamp, frame.id.value() - 0x100, &emergency));
        said.into_iter().chain([made(frame.timestamp, frame.id.value(), &payload)]).collect()
    }
}

fn made(at: Timestamp, id: u32, data: &[u8]) -> Frame {
    Frame::new(at, Id::standard(id).expect("11 bits"), Kind::Data, data)
}

/// The recorded machine with CANopen devices.
fn told_anew(frames: &[Frame]) -> Vec<Frame> {
    let mut transducers = [Transducer::default(); 0x20];
    let tell = |frame: &Frame| match frame.id.value() {
        id @ (0x181..=0x186 | 0x191..=0x196) => transducers[id as usize & 0x1F].frames(frame),
        id @ 0x1A1..=0x1A6 => {
            let speed = f64::from(i16::from_le_bytes([frame.data()[0], frame.data()[1]])) * 1e-4;
            let [low, high] = ((speed / SET_POINT).round() as i16).to_le_bytes();
            let valve = [7, 0, low, high, 0, 0];
            vec![made(frame.timestamp, id + 0x520 - 0x1A0, &valve)]
        }
        _ => vec![frame.clone()],
    };
    frames.iter().flat_map(tell).collect()
}

/// Faults of the data beside the recorded ones.
const FAULTS: [&str; 3] = [
    "broken_wire,cylinder=4,sensor=c2,at=100,until=110",
    "loss,cylinder=6,sensor=c1,at=120,until=125",
    "stale,cylinder=5,sensor=c2,at=150,until=155",
];

/// A warning as it is told: cylinder, detector, fault, suspect, level, state.
type Told = (f64, u64, [String; 5]);

fn warnings(log: &str, config: &str) -> Vec<Told> {
    let told = replay(&[log], config, &[]).ok().warnings().into_iter().map(|warning| {
        let word = |key: &str| warning[key].as_str().expect("a word").to_owned();
        let words = ["detector", "fault", "suspect", "level", "state"].map(word);
        let t = warning["t"].as_f64().expect("a time");
        (t, warning["cylinder"].as_u64().expect("a number"), words)
    });
    told.collect()
}

#[test]
fn a_recording_with_every_fault_comes_to_the_same_verdicts_on_either_layout() {
    let scratch = Scratch::new();
    let read = |name: &str| {
        let path = tertius_testing::top().join(name);
        std::fs::read_to_string(path).expect("it ships")
    };
    let recorded = read("tests/recordings/e-type.toml");
    let corrections = recorded.find("[[cylinder]]").expect("it has them");
    let dbc = tertius_testing::top().join("dbc");
    let text = read("config/e-type-canopen.toml").replace("../dbc", dbc.to_str().expect("plain"));
    let config = scratch.write("machine.toml", text + &recorded[corrections..]);
    let log = scratch.path("canopen.log");
    // The recorded faults, and those of the data that it does not have.
    let all = scratch.path("all.log");
    let mut arguments = vec!["inject", "--config", E_TYPE, "--output", &all];
    arguments.extend(FAULTS.iter().flat_map(|fault| ["--fault", fault]));
    let recorded = recording("e-type-faults.log.zst");
    arguments.push(&recorded);
    tertius(&arguments, b"").ok();
    write(log.as_ref(), "can0", &told_anew(&read_log(all.as_ref())));
    let signals = warnings(&all, E_TYPE);
    let objects = warnings(&log, &config);
    let verdict = |(_, cylinder, words): &Told| (*cylinder, words.clone());
    let verdicts = |told: &[Told]| told.iter().map(verdict).collect::<Vec<_>>();
    let faults = ["broken_wire", "stale", "frozen", "abrupt", "noise", "incipient"];
    let has = |fault: &str| signals.iter().any(|(_, _, words)| words[1] == fault);
    assert!(faults.into_iter().all(has), "{signals:?}");
    assert!(signals.len() > 80, "{}", signals.len());
    assert_eq!(verdicts(&objects), verdicts(&signals));
    for (signals, objects) in signals.iter().zip(&objects) {
        assert!((signals.0 - objects.0).abs() < 0.03, "{signals:?} {objects:?}");
    }
}
