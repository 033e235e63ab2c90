mod serving;

use super::*;
use tertius_core::alarm::status::Status;
use tertius_core::alarm::{Detector, Encoder, Finding, Level, State};
use tertius_core::blame::Rule;
use tertius_core::monitor::Counts;
use tertius_core::verdict::{Fault, Suspect};

const COUNTS: Counts = Counts {
    used: 0x0102_0304_0506,
    ignored: 2,
    errors: 3,
    cycles: 4,
    incomplete: 5,
    missing: 6,
    late: 7,
    repeated: 8,
    contradicting: 14,
    sync_doubted: 0,
    short: 15,
    held: 9,
    bad_signals: 10,
    unnamed_status_bits: 0,
    backwards: 11,
    time_jumps: 12,
    interruptions: 13,
};

pub(super) fn design() -> NodeDesign {
    let thresholds = CylinderThresholds {
        observer: [0.00075, 0.001],
        difference: [0.001, 0.0015],
        critical: 0.05,
    };
    NodeDesign {
        node: 81,
        heartbeat: 1000,
        shortest_heartbeat: 50,
        autostart: true,
        version: "1.2.3".to_owned(),
        machine: "Ein Gerät mit einem langen Namen, der nicht in ein Segment passt".to_owned(),
        sample_time: 0.02,
        cylinders: vec![thresholds; 6],
        sends_estimates: false,
        calibrated: 0b101,
        configuration: 0x1234_5678,
        calibration: 0x9ABC_DEF0,
        database: 0x9ABC_DEF0,
        bitrate: 500_000,
    }
}

fn at(milliseconds: i64) -> Timestamp {
    Timestamp::from_nanos(milliseconds * 1_000_000)
}

/// A node with whoever speaks to it.
struct Bench {
    node: Node,
    now: Timestamp,
    status: Option<Status>,
    events: Vec<NmtEvent>,
}

impl Bench {
    /// A node that has booted.
    fn new(design: &NodeDesign) -> Self {
        let node = Node::new(design).expect("81 is a node");
        let mut bench = Self { node, now: at(0), status: None, events: vec![] };
        assert_eq!(bench.send(0x080, &[]), [(0x751, vec![0])], "boot-up");
        bench
    }

    fn send(&mut self, id: u32, data: &[u8]) -> Vec<(u32, Vec<u8>)> {
        let id = Id::standard(id).expect("11 bits");
        self.take(&Frame::new(self.now, id, Kind::Data, data))
    }

    fn take(&mut self, frame: &Frame) -> Vec<(u32, Vec<u8>)> {
        let mut sent = vec![];
        let view = NodeView { counts: &COUNTS, status: self.status.as_ref() };
        let event = self.node.take(frame, view, &mut |frame| sent.push(wire(&frame)));
        self.events.extend(event);
        sent
    }

    fn advance(&mut self, milliseconds: i64) -> Vec<(u32, Vec<u8>)> {
        let mut sent = vec![];
        self.now = at(milliseconds);
        self.node.advance(self.now, &mut |frame| sent.push(wire(&frame)));
        sent
    }

    fn warn(&mut self, warning: &Warning) -> Vec<(u32, Vec<u8>)> {
        let mut sent = vec![];
        self.node.warning(warning, &mut |frame| sent.push(wire(&frame)));
        sent
    }

    fn command(&mut self, command: u8, node: u8) -> Vec<(u32, Vec<u8>)> {
        self.send(0x000, &[command, node])
    }

    fn request(&mut self, request: [u8; 8]) -> [u8; 8] {
        let answers = self.send(0x651, &request);
        let [(0x5D1, answer)] = &answers[..] else { panic!("{answers:?}") };
        answer[..].try_into().expect("an answer has eight bytes")
    }

    /// Reads an object as CiA 301 says; the abort code where it is refused.
    fn read(&mut self, index: u16, sub: u8) -> Result<Vec<u8>, u32> {
        let [low, high] = index.to_le_bytes();
        let answer = self.request([0x40, low, high, sub, 0, 0, 0, 0]);
        let word = u32::from_le_bytes(answer[4..].try_into().expect("four bytes"));
        if answer[0] == 0x80 {
            return Err(word);
        }
        assert_eq!(answer[1..4], [low, high, sub]);
        if answer[0] & 0b10 != 0 {
            return Ok(answer[4..8 - usize::from(answer[0] >> 2 & 0b11)].to_vec());
        }
        assert_eq!(answer[0], 0x41, "segmented, with its size");
        let mut data = vec![];
        for toggle in [0, 0x10].into_iter().cycle() {
            let segment = self.request([0x60 | toggle, 0, 0, 0, 0, 0, 0, 0]);
            assert_eq!(segment[0] & 0xF0, toggle);
            data.extend(&segment[1..8 - usize::from(segment[0] >> 1 & 0b111)]);
            if segment[0] & 1 == 1 {
                break;
            }
        }
        assert_eq!(data.len(), word as usize);
        Ok(data)
    }

    fn number(&mut self, index: u16, sub: u8) -> u64 {
        let mut bytes = self.read(index, sub).expect("it can be read");
        bytes.resize(8, 0);
        u64::from_le_bytes(bytes.try_into().expect("eight bytes"))
    }

    /// Writes up to four bytes; the abort code where it is refused.
    fn write(&mut self, index: u16, sub: u8, data: &[u8]) -> Result<(), u32> {
        let [low, high] = index.to_le_bytes();
        let mut request = [0x23 | (4 - data.len() as u8) << 2, low, high, sub, 0, 0, 0, 0];
        request[4..4 + data.len()].copy_from_slice(data);
        let answer = self.request(request);
        let word = u32::from_le_bytes(answer[4..].try_into().expect("four bytes"));
        if answer[0] == 0x60 { Ok(()) } else { Err(word) }
    }
}

fn wire(frame: &OwnFrame) -> (u32, Vec<u8>) {
    (frame.as_frame().id.value(), frame.as_frame().data().to_vec())
}

fn warning(state: State, cylinder: u8, place: usize, fault: Fault) -> Warning {
    let detector = tertius_core::alarm::register::DETECTORS[place];
    let (residual, threshold) = (Some(0.00131), Some(0.001));
    let finding = Finding {
        fault,
        suspect: Suspect::C1,
        rule: Rule::OneObserver,
        level: Level::Yellow,
        residual,
        threshold,
        evidence: None,
        device: None,
    };
    Warning { timestamp: at(0), cylinder, detector, place, state, finding }
}

#[test]
fn alone_on_the_bus_it_is_silent_and_the_first_frame_makes_it_boot() {
    let mut node = Node::new(&design()).expect("81 is a node");
    let mut send = |frame| panic!("{frame:?}");
    (0..5000).for_each(|ms| node.advance(at(ms), &mut send));
    node.warning(&warning(State::Raised, 1, 0, Fault::Abrupt), &mut send);
    assert_eq!((node.state(), node.sends_pdos()), (None, false));
    let mut bench = Bench { node, now: at(0), status: None, events: vec![] };
    let error = Frame::new(at(0), Id::standard(4).expect("11 bits"), Kind::Error, &[0; 8]);
    assert_eq!(bench.take(&error), [], "the controller's word is no frame of the bus");
    assert_eq!(bench.send(0x181, &[1, 2]), [(0x751, vec![0])]);
    assert_eq!(bench.send(0x181, &[1, 2]), []);
    assert_eq!((bench.node.state(), bench.node.sends_pdos()), (Some(NodeState::Operational), true));
    assert!(Node::new(&NodeDesign { node: 0, ..design() }).is_none());
    assert!(Node::new(&NodeDesign { node: 128, ..design() }).is_none());
}

#[test]
fn heartbeats_keep_their_period_whatever_the_clock_does() {
    let mut bench = Bench::new(&design());
    let beat = [(0x751, vec![5])];
    let beats = |bench: &mut Bench, from: i64, to: i64| {
        (from..to).filter(|ms| bench.advance(*ms) == beat).collect::<Vec<_>>()
    };
    assert_eq!(beats(&mut bench, 0, 3500), [1000, 2000, 3000]);
    // Late once, and not for ever.
    assert_eq!(bench.advance(4_900), beat);
    assert_eq!(beats(&mut bench, 4_901, 6_100), [5000, 6000]);
    // A clock set ahead, and one set back.
    assert_eq!(bench.advance(100_000), beat);
    assert_eq!(beats(&mut bench, 100_001, 101_500), [101_000]);
    assert_eq!(beats(&mut bench, 50, 2_100), [1050, 2050]);
    // By SDO: another time, none, and one that is too short.
    assert_eq!(bench.write(0x1017, 0, &[200, 0]), Ok(()));
    assert_eq!(beats(&mut bench, 2_100, 2_600), [2299, 2499]);
    assert_eq!(bench.write(0x1017, 0, &[49, 0]), Err(0x0609_0032));
    assert_eq!(bench.number(0x1017, 0), 200);
    assert_eq!(bench.write(0x1017, 0, &[0, 0]), Ok(()));
    assert_eq!(beats(&mut bench, 2_600, 9_000), []);
    // After a reset it is as configured.
    assert_eq!(bench.command(0x82, 81), [(0x751, vec![0])]);
    assert_eq!((bench.number(0x1017, 0), beats(&mut bench, 9_000, 10_500)), (1000, vec![10_000]));
}

#[test]
fn nmt_decides_what_is_sent_and_the_errors_stay() {
    let mut bench = Bench::new(&NodeDesign { autostart: false, ..design() });
    let raised = warning(State::Raised, 1, 0, Fault::Abrupt);
    let cleared = Warning { state: State::Cleared, ..raised };
    let mut encoder = Encoder::new(81).expect("a node");
    let pdo = encoder.status(at(0), &Status::default());
    // State, PDOs, emergencies, SDO.
    let rights = |bench: &mut Bench| {
        let sdo = bench.send(0x651, &[0x40, 0, 0x10, 0, 0, 0, 0, 0]).len();
        let emergencies = bench.warn(&raised).len() + bench.warn(&cleared).len();
        (bench.node.state(), bench.node.transmit(&pdo), emergencies, sdo)
    };
    let pre_operational = (Some(NodeState::PreOperational), false, 2, 1);
    let operational = (Some(NodeState::Operational), true, 2, 1);
    let stopped = (Some(NodeState::Stopped), false, 0, 0);
    assert_eq!(rights(&mut bench), pre_operational);
    for (command, node, expected, heartbeat) in [
        (0x01, 81, operational, 5),
        (0x80, 81, pre_operational, 127),
        (0x02, 81, stopped, 4),
        (0x01, 0, operational, 5),
        (0x02, 80, operational, 5),
        (0x33, 81, operational, 5),
        (0x02, 0, stopped, 4),
    ] {
        assert_eq!(bench.command(command, node), []);
        assert_eq!(rights(&mut bench), expected, "{command:x} to {node}");
        let now = bench.now.as_nanos() / 1_000_000;
        bench.advance(now + 1);
        assert_eq!(bench.advance(now + 1001), [(0x751, vec![heartbeat])]);
    }
    bench.warn(&raised);
    for command in [0x81, 0x82] {
        bench.command(0x02, 81);
        assert_eq!(bench.command(command, 81), [(0x751, vec![0])], "boot-up");
        assert_eq!(rights(&mut bench), pre_operational);
        bench.warn(&raised);
        assert_eq!(bench.number(0x1001, 0), 0x81, "what stands is not reset");
    }
    for wrong in [&[][..], &[1], &[1, 81, 0], &[1, 200]] {
        assert_eq!(bench.send(0x000, wrong), [], "{wrong:?}");
        assert_eq!(bench.node.state(), Some(NodeState::PreOperational));
    }
    let names: Vec<_> = bench.events.iter().map(|it| (it.command.name(), it.everyone)).collect();
    assert_eq!(names[..2], [("start", false), ("enter pre-operational", false)]);
    assert_eq!(names[3..5], [("start", true), ("stop", true)]);
    assert_eq!(bench.events.len(), 9);
}

#[test]
fn a_warning_is_an_emergency_when_it_is_raised_and_when_it_is_cleared() {
    let mut bench = Bench::new(&design());
    let first = warning(State::Raised, 3, 0, Fault::Abrupt);
    let mut encoder = Encoder::new(81).expect("a node");
    let bytes = |encoder: &mut Encoder, warning: &Warning, raised| {
        let Warning { timestamp, cylinder, detector, finding, .. } = warning;
        let frame = encoder.warning(*timestamp, *cylinder, *detector, finding, raised);
        frame.as_frame().data()[3..].to_vec()
    };
    let info = bytes(&mut encoder, &first, true);
    assert_eq!(bench.warn(&first), [(0x0D1, [&[0x11, 0xFF, 0x81], &info[..]].concat())]);
    let second = warning(State::Raised, 3, 4, Fault::Stale);
    let stale = bytes(&mut encoder, &second, true);
    assert_eq!(bench.warn(&second), [(0x0D1, [&[0x47, 0xFF, 0x91], &stale[..]].concat())]);
    assert_eq!(bench.warn(&Warning { state: State::Changed, ..first }), []);
    let cleared = Warning { state: State::Cleared, ..first };
    let info_cleared = bytes(&mut encoder, &first, false);
    assert_eq!(bench.warn(&cleared), [(0x0D1, [&[0, 0, 0x11], &info_cleared[..]].concat())]);
    assert_eq!((bench.number(0x1001, 0), bench.number(0x1003, 0)), (0x11, 2));
    let word = |code: u64, info: &[u8]| code | u64::from(info[0]) << 16 | u64::from(info[1]) << 24;
    assert_eq!(bench.number(0x1003, 1), word(0xFF47, &stale), "newest first");
    assert_eq!(bench.number(0x1003, 2), word(0xFF11, &info));
    assert_eq!(bench.read(0x1003, 3), Err(0x0800_0024));
    assert_eq!(bench.write(0x1003, 0, &[1]), Err(0x0609_0030));
    assert_eq!(bench.write(0x1003, 1, &[0; 4]), Err(0x0601_0002));
    assert_eq!(bench.write(0x1003, 0, &[0]), Ok(()));
    assert_eq!((bench.number(0x1001, 0), bench.number(0x1003, 0)), (0x11, 0));
    let [(_, last)] = &bench.warn(&Warning { state: State::Cleared, ..second })[..] else {
        panic!("one message")
    };
    assert_eq!((&last[..3], bench.number(0x1001, 0)), (&[0, 0, 0][..], 0), "no error is left");
    // The history is bounded.
    for n in 0..40 {
        let fault = if n == 39 { Fault::Frozen } else { Fault::Noise };
        bench.warn(&warning(State::Raised, 1, 0, fault));
    }
    assert_eq!(bench.number(0x1003, 0), 16);
    let codes: Vec<u64> = (1..=16).map(|sub| bench.number(0x1003, sub) & 0xFFFF).collect();
    assert_eq!((codes[0], codes[1], codes[15]), (0xFF16, 0xFF12, 0xFF12));
    let nobody = Warning { cylinder: 7, ..first };
    assert_eq!(bench.warn(&nobody), [], "there is no seventh");
    assert_eq!(Detector::Fde1 as u8, 1);
}
