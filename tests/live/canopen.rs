//! The gateway as a CANopen node on the embedded bus: what it sends beside its PDOs, and that nothing
//! that arrives for the node changes what is judged.

use crate::live_gateway::{Bench, bus_traffic, gateway_of, of, wire};
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::collections::BTreeSet;
use tertius::alarm::State;
use tertius::bus::{Identifiers, UnrestrictedPort};
use tertius::canopen::node::{CylinderThresholds, NmtCommand, Node, NodeDesign, NodeState};
use tertius::frame::{Frame, Id, Kind};
use tertius::live::outbox::OutboxLimits;
use tertius::monitor::Monitor;
use tertius::time::{Span, Timestamp};
use tertius_testing::machine::{estimating, monitor};

/// The identifiers of node 81: EMCY, TPDOs, SDO answers, heartbeat.
const OWN: [u32; 5] = [0x0D1, 0x1D1, 0x2D1, 0x5D1, 0x751];

/// Hostile frames; `scripts/hostile` asks for more.
fn hostile_frames() -> usize {
    let asked = std::env::var("TERTIUS_HOSTILE_FRAMES").ok();
    asked.map_or(80_000, |number| number.parse().expect("a number of frames"))
}

fn design() -> NodeDesign {
    let thresholds = CylinderThresholds {
        observer: [0.00075, 0.001],
        difference: [0.001125, 0.0015],
        critical: 0.05,
    };
    NodeDesign {
        node: 81,
        heartbeat: 1000,
        shortest_heartbeat: 50,
        autostart: true,
        version: "0.1.0".to_owned(),
        machine: "Ampelmann E-type".to_owned(),
        sample_time: 0.02,
        cylinders: vec![thresholds; 6],
        sends_estimates: false,
        calibrated: 0,
        configuration: 1,
        calibration: 2,
        database: 2,
        bitrate: 500_000,
    }
}

/// A bus with a gateway that is a node.
fn bench_of(monitor: Monitor, share: f64) -> Bench {
    let node = Node::new(&design()).expect("81 is a node");
    Bench { gateway: gateway_of(monitor, share).with_node(node), ..Bench::new() }
}

fn bench() -> Bench {
    bench_of(monitor(), 0.05)
}

fn frame(at: Timestamp, id: u32, data: &[u8]) -> Frame {
    Frame::new(at, Id::standard(id).expect("11 bits"), Kind::Data, data)
}

/// `traffic` with `frames` put in at the time of the frame before them.
fn beside(traffic: &[Frame], mut frames: impl FnMut(Timestamp) -> Vec<Frame>) -> Vec<Frame> {
    let mut both = Vec::new();
    for machine in traffic {
        both.push(machine.clone());
        both.extend(frames(machine.timestamp));
    }
    both
}

/// What a node should never be sent, and what one client should not do to another.
struct Hostile(ChaCha8Rng);

impl Hostile {
    const INDICES: [u16; 10] =
        [0x1000, 0x1001, 0x1003, 0x1008, 0x1017, 0x1018, 0x1A00, 0x2000, 0x2101, 0xFFFF];

    fn frame(&mut self, at: Timestamp, with_nmt: bool) -> Frame {
        let rng = &mut self.0;
        let length = if rng.random_bool(0.8) { 8 } else { rng.random_range(0..=8) };
        let mut data: [u8; 8] = rng.random();
        if rng.random_bool(0.8) {
            let index = Self::INDICES[rng.random_range(0..Self::INDICES.len())];
            data[1..3].copy_from_slice(&index.to_le_bytes());
            data[3] = rng.random_range(0..6);
        }
        match rng.random_range(0..20) {
            // Requests of every command specifier, some of them truncated.
            0..8 => frame(at, 0x651, &data[..length]),
            // Two clients that read the longest text at once, and one that goes on with the other's.
            8..10 => frame(at, 0x651, &[0x40, 0x08, 0x10, 0, 0, 0, 0, 0]),
            10..14 => frame(at, 0x651, &[0x60 | data[0] & 0x10, 0, 0, 0, 0, 0, 0, 0]),
            14..17 if with_nmt => {
                let node = [0, 81, data[1]][rng.random_range(0..3)];
                let command = [0x01, 0x02, 0x80, 0x81, 0x82, data[0]][rng.random_range(0..6)];
                frame(at, 0x000, &[command, node, 0][..rng.random_range(0..=3)])
            }
            // PDOs for the node, and its own identifiers.
            17 => frame(at, [0x251, 0x351, 0x451, 0x551][length % 4], &data[..length]),
            18 => frame(at, OWN[rng.random_range(0..OWN.len())], &data[..length]),
            _ => self.other(at),
        }
    }

    /// A frame of another kind with an identifier of the node.
    fn other(&mut self, at: Timestamp) -> Frame {
        let rng = &mut self.0;
        let id = [0x000, 0x651, 0x751][rng.random_range(0..3)];
        let standard = Id::standard(id).expect("11 bits");
        let mut data = [0; 64];
        rng.fill_bytes(&mut data);
        match rng.random_range(0..3) {
            0 => Frame::new(at, standard, Kind::Remote { length: rng.random_range(0..=8) }, &[]),
            1 => Frame::new(at, standard, Kind::Fd { flags: 0 }, &data),
            _ => Frame::new(at, Id::extended(id).expect("29 bits"), Kind::Data, &data[..8]),
        }
    }
}

/// The residuals and warnings that a gateway told, to the bit.
fn told(bench: &Bench) -> (Vec<[Option<u64>; 3]>, String) {
    let bits = |residuals: [Option<f64>; 3]| residuals.map(|it| it.map(f64::to_bits));
    let residuals = bench.notes.records.iter().map(|record| bits(record.residuals)).collect();
    (residuals, format!("{:?}", bench.notes.warnings))
}

fn identifiers(heard: &[Frame]) -> BTreeSet<u32> {
    heard.iter().map(|frame| frame.id.value()).collect()
}

#[test]
fn hostile_frames_change_no_residual_and_no_warning_and_make_nothing_grow() {
    let traffic = bus_traffic();
    let mut plain = Bench::new();
    plain.run(&traffic, 3);
    let (residuals, warnings) = told(&plain);
    assert!(residuals.len() > 2000 && plain.notes.warnings.len() >= 4);

    let each = hostile_frames().div_ceil(traffic.len());
    let mut hostile = Hostile(ChaCha8Rng::seed_from_u64(81));
    let (mut bench, mut sent) = (bench(), 0);
    // In parts, so that ten million need no more memory than one.
    for part in traffic.chunks(100) {
        let both = beside(part, |at| (0..each).map(|_| hostile.frame(at, true)).collect());
        bench.run(&both, 3);
        sent += both.len() as u64;
        assert!(bench.gateway.outbox().waiting() <= 2 * OutboxLimits::WAITING + 3 + 6);
        let strange = identifiers(&bench.heard).into_iter().find(|id| !OWN.contains(id));
        assert_eq!(strange, None, "an identifier of the node's own only");
        bench.heard.clear();
    }
    let (beside_residuals, beside_warnings) = told(&bench);
    assert!(beside_residuals == residuals, "the same to the bit");
    assert_eq!(beside_warnings, warnings);
    let counts = bench.gateway.monitor().counts();
    assert_eq!(counts.used + counts.ignored, sent, "none was lost on the way");
    let commands = bench.notes.commands.len();
    assert!(commands > each, "NMT was among them");
    println!(
        "{sent} frames, of which {} hostile; {commands} NMT commands",
        sent as usize - traffic.len()
    );

    // It serves the next client as if nothing had been.
    let mut client = bench.bus.open_unrestricted(&Identifiers::All, 4096).expect("up");
    let mut ask = |bench: &mut Bench, id, data: &[u8]| {
        bench.clock.advance(Span::from_seconds(1.0));
        bench.heard.clear();
        client.send_unrestricted(&frame(bench.clock.now(), id, data)).expect("up");
        bench.turn().expect("up");
        bench.listen(&mut client);
        wire(&bench.heard).into_iter().map(|(id, data)| (id.value(), data)).collect::<Vec<_>>()
    };
    let booted = ask(&mut bench, 0x000, &[0x82, 81]);
    assert!(booted.contains(&(0x751, vec![0])), "{booted:?}");
    let answered = ask(&mut bench, 0x651, &[0x40, 0x18, 0x10, 2, 0, 0, 0, 0]);
    let answer = vec![0x43, 0x18, 0x10, 2, 1, 0, 0, 0];
    assert!(answered.contains(&(0x5D1, answer)), "{answered:?}");
}

#[test]
fn a_node_sends_its_five_identifiers_whatever_identifier_arrives() {
    let mut traffic = bus_traffic();
    let at = traffic[2000].timestamp;
    let strangers = (0..=Id::STANDARD_MAX).map(|id| frame(at, id, &[0xFF; 8]));
    traffic.splice(2000..2000, strangers);
    let mut bench = bench();
    bench.run(&traffic, 5);
    assert_eq!(identifiers(&bench.heard), BTreeSet::from(OWN));
}

#[test]
fn a_node_says_beside_what_a_gateway_says() {
    let traffic = bus_traffic();
    let mut plain = Bench::new();
    plain.run(&traffic, 2);
    let mut bench = bench();
    bench.run(&traffic, 2);
    for id in [0x1D1, 0x2D1] {
        assert!(of(&bench.heard, id) == of(&plain.heard, id), "{id:x}");
    }
    assert_eq!(told(&bench), told(&plain));
    let beats = of(&bench.heard, 0x751);
    let states: Vec<u8> = beats.iter().map(|(_, data)| data[0]).collect();
    assert_eq!(states, [0, 5, 5, 5, 5, 5, 5, 5], "boot-up, then each second of eight");
    // An emergency for each that was raised or cleared, with the bytes of its Fd_Warning.
    let changed = |state| move |warning: &&tertius::alarm::Warning| warning.state != state;
    let expected = bench.notes.warnings.iter().filter(changed(State::Changed)).count();
    let emergencies = of(&bench.heard, 0x0D1);
    assert!(emergencies.len() == expected && expected >= 4, "{expected}");
    let warnings = of(&bench.heard, 0x2D1);
    for (_, emergency) in &emergencies {
        assert!(warnings.iter().any(|(_, warning)| warning[3..] == emergency[3..]));
    }
    let last = emergencies.last().expect("there are some");
    assert_eq!(last.1[..3], [0, 0, 0], "all is cleared in the end");
}

/// A client that asks without pause, beside a machine with a fault and estimates.
#[test]
fn who_asks_without_pause_takes_nothing_from_warnings_and_the_share_holds() {
    let traffic = bus_traffic();
    for (estimates, share) in [(false, 0.05), (true, 0.15)] {
        let machine = || if estimates { estimating() } else { monitor() };
        let mut plain = Bench { gateway: gateway_of(machine(), share), ..Bench::new() };
        plain.run(&traffic, 1);
        let mut bench = bench_of(machine(), share);
        let ask = |at| vec![frame(at, 0x651, &[0x40, 0x00, 0x10, 0, 0, 0, 0, 0]); 2];
        bench.run(&beside(&traffic, ask), 1);
        for id in [0x1D1, 0x2D1] {
            assert!(of(&bench.heard, id) == of(&plain.heard, id), "{id:x}");
        }
        let seconds = traffic[traffic.len() - 1].timestamp.since(traffic[0].timestamp);
        let rate = share * 500_000.0 / 135.0;
        let most = rate * seconds.as_seconds() + f64::from(OutboxLimits::BURST);
        assert!(bench.heard.len() as f64 <= most, "{} of {most}", bench.heard.len());
        let [answers, sent] = [0x5D1, 0x3D1].map(|id| of(&bench.heard, id).len());
        assert!(answers > 400, "{answers} answers");
        let wanted = of(&plain.heard, 0x3D1).len();
        assert!(sent * 2 > wanted || !estimates, "{sent} of {wanted} estimates");
    }
}

#[test]
fn nmt_silences_pdos_and_monitoring_goes_on() {
    let traffic = bus_traffic();
    // The transducer steps in cycle 230, after 4.6 s.
    let command = |cycle: i64, command: u8, node: u8| {
        let at = traffic[0].timestamp.after(Span::from_seconds(0.02 * cycle as f64 + 0.019));
        frame(at, 0x000, &[command, node])
    };
    let run = |commands: &[Frame]| {
        let mut frames = traffic.clone();
        frames.extend(commands.iter().cloned());
        frames.sort_by_key(|frame| frame.timestamp);
        let mut bench = bench();
        bench.run(&frames, 1);
        bench
    };
    let plain = run(&[]);
    let pdos = |bench: &Bench, from: f64, to: f64| {
        let within = |frame: &&Frame| {
            let since = frame.timestamp.since(traffic[0].timestamp).as_seconds();
            (from..to).contains(&since) && [0x1D1, 0x2D1].contains(&frame.id.value())
        };
        bench.heard.iter().filter(within).count()
    };
    for (silence, state, emergencies) in
        [(0x80, NodeState::PreOperational, true), (0x02, NodeState::Stopped, false)]
    {
        let bench = run(&[command(200, silence, 81), command(300, 0x01, 0)]);
        assert_eq!(told(&bench), told(&plain), "nothing else is judged");
        assert_eq!(pdos(&bench, 4.06, 6.0), 0, "{silence:x}");
        assert!(pdos(&bench, 0.0, 4.0) > 30 && pdos(&bench, 6.1, 8.0) > 15);
        let during = of(&bench.heard, 0x0D1);
        assert_eq!(during == of(&plain.heard, 0x0D1), emergencies, "{silence:x}");
        let beats: BTreeSet<u8> = of(&bench.heard, 0x751).iter().map(|it| it.1[0]).collect();
        assert_eq!(beats, BTreeSet::from([0, 5, state as u8]));
        let [stopped, started] = &bench.notes.commands[..] else { panic!("two commands") };
        assert_eq!((stopped.state, stopped.everyone), (state, false));
        assert_eq!((started.command, started.everyone), (NmtCommand::Start, true));
    }
    // A reset restarts communication, and nothing that was found.
    let bench = run(&[command(240, 0x81, 81), command(242, 0x82, 81)]);
    assert_eq!(told(&bench), told(&plain));
    let boots = of(&bench.heard, 0x751).iter().filter(|it| it.1[0] == 0).count();
    assert_eq!(boots, 3);
}

#[test]
fn a_silenced_gateway_that_stops_sends_nothing_and_one_that_is_operational_says_so() {
    for (command, last) in [(None, 1), (Some(0x02), 0), (Some(0x80), 0)] {
        let traffic = &bus_traffic()[..2000];
        let mut bench = bench();
        bench.run(traffic, 1);
        if let Some(command) = command {
            let mut master = bench.bus.open_unrestricted(&Identifiers::All, 4096).expect("up");
            let command = frame(bench.clock.now(), 0x000, &[command, 81]);
            master.send_unrestricted(&command).expect("up");
            bench.turn().expect("up");
        }
        let mut ear = bench.bus.open(&Identifiers::All, 64).expect("up");
        bench.stop().expect("the bus is up");
        bench.heard.clear();
        bench.listen(&mut ear);
        assert_eq!(bench.heard.len(), last, "{command:?}: {:?}", bench.heard);
    }
}
