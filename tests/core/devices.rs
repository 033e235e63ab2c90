//! CANopen devices that tell of themselves: emergency messages and heartbeats beside the readings.

use tertius::alarm::{Detector, State, Warning};
use tertius::frame::{BusNumber, Frame, Id, Kind};
use tertius::monitor::subscriptions::{DeviceService, SubscribedService, Target};
use tertius::monitor::{Monitor, Notice};
use tertius::sample::device::{DeviceDesign, DeviceNews, DeviceState};
use tertius::sample::emergency::Emergency;
use tertius::sample::{DeviceReason, DeviceRole, Quality, Transducer};
use tertius::time::{Span, Timestamp};
use tertius::verdict::{Fault, Suspect};
use tertius_testing::machine::{Collected, Cycle, MS, START, design_of_default};

/// Cycles without a heartbeat after which a device is lost.
const HEARTBEAT: u32 = 8;

const MAGNET: [u8; 8] = [0x00, 0x50, 0x81, 0, 0, 0, 0, 0];
const OVER: [u8; 8] = [0; 8];
const OPERATIONAL: u8 = 5;
const PRE_OPERATIONAL: u8 = 127;

/// The default machine, whose transducers and valves are nodes 1 to 6, 17 to 22 and 33 to 38.
fn monitor() -> Monitor {
    let mut design = design_of_default();
    for index in 0..6_u8 {
        for (role, first) in DeviceRole::ALL.into_iter().zip([1, 17, 33]) {
            let node = first + index;
            let watched = DeviceDesign { node, heartbeat: Some(HEARTBEAT) };
            design.cylinders[usize::from(index)].devices[role as usize] = Some(watched);
            for (base, service) in
                [(0x080, DeviceService::Emergency), (0x700, DeviceService::Heartbeat)]
            {
                let id = Id::standard(base + u32::from(node)).expect("11 bits");
                let devices = vec![(index, role)];
                let of_device = SubscribedService { service, devices };
                design.subscriptions.subscribe(BusNumber::First, id).service = Some(of_device);
            }
        }
    }
    Monitor::new(design)
}

/// The time `late` after cycle `k` opened, ms.
fn at(k: i64, late: i64) -> Timestamp {
    Timestamp::from_nanos(START + (20 * k + late) * MS)
}

fn frame(at: Timestamp, id: u32, data: &[u8]) -> Frame {
    Frame::new(at, Id::standard(id).expect("11 bits"), Kind::Data, data)
}

/// A machine on the bus, a command of 0.1 m/s to nobody, and what the monitor says of it.
struct Bench {
    monitor: Monitor,
    seen: Collected,
    k: i64,
    /// Identifiers that are silent.
    silent: Vec<u32>,
    /// Nodes and states that beat every 100 ms.
    beats: Vec<(u32, u8)>,
}

impl Bench {
    fn new() -> Self {
        let (monitor, seen) = (monitor(), Collected::default());
        Self { monitor, seen, k: 0, silent: Vec::new(), beats: Vec::new() }
    }

    /// Runs `cycles` cycles, with `more` frames in the first.
    fn run(&mut self, cycles: i64, more: &[Frame]) {
        for cycle in 0..cycles {
            let mut frames = Cycle::new(self.k).frames();
            frames.retain(|frame| !self.silent.contains(&frame.id.value()));
            if self.k % 5 == 0 {
                let beat =
                    |(node, state): &(u32, u8)| frame(at(self.k, 6), 0x700 + node, &[*state]);
                frames.extend(self.beats.iter().map(beat));
            }
            if cycle == 0 {
                frames.extend_from_slice(more);
                frames.sort_by_key(|frame| frame.timestamp);
            }
            frames.iter().for_each(|frame| self.monitor.take(frame, &mut self.seen));
            self.k += 1;
        }
    }

    /// What was said of the readings in the newest cycle: qualities of C1 and C2.
    fn qualities(&self, cylinder: u8) -> [Quality; 2] {
        self.seen.record(self.k - 2, cylinder).qualities
    }

    fn warnings(&self) -> Vec<(Timestamp, State, Fault, Suspect)> {
        let told = |it: &Warning| (it.timestamp, it.state, it.finding.fault, it.finding.suspect);
        self.seen.warnings.iter().map(told).collect()
    }

    fn news(&self) -> Vec<(u8, DeviceNews)> {
        let of_device = |notice: &Notice| match *notice {
            Notice::Device { node, news, .. } => Some((node, news)),
            _ => None,
        };
        self.seen.notices.iter().filter_map(of_device).collect()
    }
}

#[test]
fn an_emergency_is_a_warning_when_it_arrives_and_lasts_until_readings_are_good_again() {
    let mut bench = Bench::new();
    bench.run(100, &[]);
    // All of the cylinder has arrived and is judged by then.
    bench.run(2, &[frame(at(100, 9), 0x083, &MAGNET)]);
    let [raised] = bench.seen.warnings[..] else { panic!("{:?}", bench.seen.warnings) };
    assert_eq!((raised.timestamp, raised.state), (at(100, 9), State::Raised));
    assert_eq!((raised.cylinder, raised.detector), (3, Detector::Plausibility));
    let finding = raised.finding;
    assert_eq!((finding.fault, finding.suspect), (Fault::BrokenWire, Suspect::C1));
    assert_eq!(finding.level.name(), "orange");
    let text = finding.device.expect("it gave a reason").to_string();
    assert_eq!(text, "node 3 says EMCY 0x5000: device hardware (maker's own)");
    let sent = bench.seen.frames.iter().find(|frame| frame.id.value() == 0x2D1);
    let sent = sent.expect("Fd_Warning was sent");
    assert_eq!(sent.timestamp, at(100, 9));
    assert_eq!(sent.data()[3..5], [0x63, 0b0101_0011], "cylinder 3, plausibility, broken wire, C1");
    bench.run(200, &[]);
    assert_eq!(bench.qualities(3), [Quality::Failed, Quality::Good]);
    assert_eq!(bench.seen.record(200, 3).residuals[0], None, "it is not used");
    assert!(bench.seen.record(200, 3).residuals[1].is_some());
    assert_eq!(bench.seen.status().transducers()[4..6], [3, 1], "C2 stays healthy");
    assert_eq!(bench.seen.warnings.len(), 1);
    let over = bench.k;
    bench.run(49, &[frame(at(over, 1), 0x083, &OVER)]);
    assert_eq!(bench.seen.warnings.len(), 1, "good readings for a second clear it");
    bench.run(5, &[]);
    let [_, cleared] = bench.seen.warnings[..] else { panic!("{:?}", bench.seen.warnings) };
    assert_eq!((cleared.state, cleared.finding.device), (State::Cleared, finding.device));
}

#[test]
fn a_changed_word_is_a_change_and_a_repeated_one_is_none() {
    let mut bench = Bench::new();
    bench.run(10, &[frame(at(0, 9), 0x091, &MAGNET)]);
    bench.run(10, &[frame(at(10, 9), 0x091, &[0x00, 0x50, 0x81, 9, 9, 9, 9, 9])]);
    bench.run(10, &[frame(at(20, 9), 0x091, &[0x10, 0x42, 0x89, 0, 0, 0, 0, 0])]);
    let states: Vec<State> = bench.seen.warnings.iter().map(|it| it.state).collect();
    assert_eq!(states, [State::Raised, State::Changed]);
    let device = bench.seen.warnings[1].finding.device.expect("a reason");
    assert_eq!(device.meaning(), (17, Some(0x4210)));
    assert_eq!(bench.seen.warnings[1].finding.suspect, Suspect::C2);
}

#[test]
fn a_heartbeat_that_stops_is_stale_within_its_time() {
    let mut bench = Bench::new();
    bench.beats = vec![(3, OPERATIONAL), (17, OPERATIONAL)];
    bench.run(101, &[]);
    // Node 3 goes on sending readings. The last heartbeat was 6 ms into cycle 100.
    bench.beats.remove(0);
    bench.run(100, &[]);
    let [raised] = bench.seen.warnings[..] else { panic!("{:?}", bench.seen.warnings) };
    let finding = raised.finding;
    assert_eq!((raised.cylinder, finding.fault, finding.suspect), (3, Fault::Stale, Suspect::C1));
    assert_eq!(finding.device.map(|it| it.reason), Some(DeviceReason::HeartbeatLost));
    let after = raised.timestamp.since(at(100, 6)).as_seconds();
    let most = f64::from(HEARTBEAT + 1) * 0.02;
    assert!((most - 0.02..=most).contains(&after), "{after} s");
    bench.beats.push((3, OPERATIONAL));
    bench.run(60, &[]);
    assert_eq!(bench.seen.warnings.last().map(|it| it.state), Some(State::Cleared));
}

/// Stale are readings after 5 cycles, and a device after 8 without a heartbeat.
#[test]
fn silence_is_told_by_what_is_missed_first_and_then_with_its_reason() {
    let mut bench = Bench::new();
    bench.beats = vec![(3, OPERATIONAL)];
    bench.run(101, &[]);
    (bench.beats, bench.silent) = (Vec::new(), vec![0x183]);
    bench.run(100, &[]);
    let reasons: Vec<(State, Fault, bool)> = bench
        .seen
        .warnings
        .iter()
        .map(|it| (it.state, it.finding.fault, it.finding.device.is_some()))
        .collect();
    assert_eq!(
        reasons,
        [(State::Raised, Fault::Stale, false), (State::Changed, Fault::Stale, true)]
    );
    // The last heartbeat came five cycles before the readings stopped.
    let mut bench = Bench::new();
    bench.beats = vec![(3, OPERATIONAL)];
    bench.run(101, &[]);
    bench.beats.clear();
    bench.run(6, &[]);
    bench.silent = vec![0x183];
    bench.run(100, &[]);
    let first = bench.seen.warnings[0];
    assert_eq!(first.finding.device.map(|it| it.reason), Some(DeviceReason::HeartbeatLost));
    assert!(first.timestamp < at(107 + 5, 0), "before five readings were missed");
}

/// What of a device comes too late does not make it one that is heard.
#[test]
fn a_device_that_is_lost_stays_so_though_its_readings_come_too_late() {
    let mut bench = Bench::new();
    bench.beats = vec![(3, OPERATIONAL)];
    bench.run(101, &[]);
    bench.beats.clear();
    bench.run(5, &[]);
    bench.silent = vec![0x183];
    for k in 106..112 {
        let mut sent = Cycle::new(k - 1).frames();
        sent.retain(|frame| frame.id.value() == 0x183);
        let late = frame(at(k, 5), 0x183, sent[0].data());
        bench.run(1, &[late]);
    }
    let raised = bench.seen.warnings[0];
    assert_eq!(raised.finding.device.map(|it| it.reason), Some(DeviceReason::HeartbeatLost));
    assert_eq!(bench.qualities(3)[0], Quality::Stale);
}

#[test]
fn a_device_without_heartbeats_is_judged_by_its_readings_alone() {
    let mut bench = Bench::new();
    // It has only said that it has started.
    bench.run(100, &[frame(at(0, 9), 0x703, &[0])]);
    assert_eq!(bench.warnings(), []);
    bench.silent = vec![0x183];
    bench.run(50, &[]);
    let [raised] = bench.seen.warnings[..] else { panic!("{:?}", bench.seen.warnings) };
    assert_eq!((raised.finding.fault, raised.finding.device), (Fault::Stale, None));
    let after = raised.timestamp.since(at(100, 0)).as_seconds();
    assert!((0.08..0.12).contains(&after), "{after} s");
}

#[test]
fn a_device_that_is_not_operational_is_unknown_and_not_to_blame() {
    for (state, told) in [(PRE_OPERATIONAL, DeviceState::PreOperational), (4, DeviceState::Stopped)]
    {
        let mut bench = Bench::new();
        bench.beats = vec![(3, OPERATIONAL)];
        bench.run(101, &[]);
        bench.beats = vec![(3, state)];
        bench.silent = vec![0x183];
        bench.run(100, &[frame(at(101, 0), 0x703, &[state])]);
        assert_eq!(bench.warnings(), []);
        assert_eq!(bench.qualities(3)[0], Quality::NotOperational);
        assert_eq!(bench.seen.status().transducers()[4..6], [0, 1]);
        assert_eq!(bench.seen.status().mode(), 3, "degraded");
        assert_eq!(bench.news(), [(3, DeviceNews::State(told))]);
        // It is started, and its next heartbeat is 80 ms away.
        bench.run(1, &[]);
        (bench.silent, bench.beats) = (Vec::new(), vec![(3, OPERATIONAL)]);
        bench.run(100, &[]);
        assert_eq!(bench.news()[1..], [(3, DeviceNews::State(DeviceState::Operational))]);
        assert_eq!(bench.seen.status().transducers()[4..6], [1, 1]);
        assert_eq!(bench.warnings(), []);
    }
}

/// Readings stop at once, and the heartbeat that explains it comes later than a reading is stale.
#[test]
fn an_explanation_takes_back_what_was_said_of_the_silence_and_nothing_else() {
    let mut bench = Bench::new();
    bench.run(101, &[]);
    bench.silent = vec![0x183];
    bench.run(20, &[]);
    bench.beats = vec![(3, PRE_OPERATIONAL)];
    bench.run(20, &[]);
    let states: Vec<(State, Fault)> = bench.warnings().iter().map(|it| (it.1, it.2)).collect();
    assert_eq!(states, [(State::Raised, Fault::Stale), (State::Cleared, Fault::Stale)]);
    assert!(
        bench.seen.warnings[1].timestamp <= at(126, 20),
        "in the cycle of the heartbeat or the next"
    );
    // One that has said that it is faulty is not cleared by that.
    let mut bench = Bench::new();
    bench.run(101, &[frame(at(0, 9), 0x083, &MAGNET)]);
    bench.silent = vec![0x183];
    bench.run(200, &[frame(at(101, 9), 0x703, &[0])]);
    assert_eq!(bench.seen.warnings.len(), 1);
    assert_eq!(bench.seen.status().transducers()[4], 3);
}

#[test]
fn a_valve_that_fails_is_the_process_and_one_that_is_not_operational_is_nobody() {
    let mut bench = Bench::new();
    bench.run(101, &[frame(at(100, 9), 0x080 + 35, &[0x10, 0x42, 0x09, 0, 0, 0, 0, 0])]);
    let [raised] = bench.seen.warnings[..] else { panic!("{:?}", bench.seen.warnings) };
    assert_eq!((raised.cylinder, raised.finding.suspect), (3, Suspect::Process));
    assert_eq!(raised.finding.device.map(|it| it.meaning()), Some((35, Some(0x4210))));
    bench.run(5, &[]);
    assert_eq!(bench.qualities(3), [Quality::Good; 2]);

    let mut bench = Bench::new();
    bench.beats = vec![(35, PRE_OPERATIONAL)];
    bench.run(201, &[]);
    assert_eq!(bench.warnings(), []);
    assert_eq!(bench.seen.record(150, 3).judged, [false; 2], "the rod does not follow it");
    assert_eq!(bench.seen.record(150, 2).judged, [true; 2]);
    bench.beats = vec![(35, OPERATIONAL)];
    bench.run(100, &[]);
    assert_eq!(bench.seen.record(290, 3).judged, [true; 2]);
    bench.beats.clear();
    bench.run(100, &[]);
    let [raised] = bench.seen.warnings[..] else { panic!("{:?}", bench.seen.warnings) };
    assert_eq!((raised.finding.fault, raised.finding.suspect), (Fault::Stale, Suspect::Process));
}

#[test]
fn when_all_is_silent_nobody_is_lost() {
    let mut bench = Bench::new();
    bench.beats = (1..=6).chain(17..=22).chain(33..=38).map(|node| (node, OPERATIONAL)).collect();
    bench.run(101, &[]);
    bench.monitor.advance(at(1000, 0), &mut bench.seen);
    bench.k = 1000;
    bench.run(100, &[]);
    assert_eq!(bench.warnings(), []);
    // So it is after a bus-off, of which nobody knows how long it lasted.
    bench.beats.clear();
    bench.run(3, &[]);
    bench.monitor.interrupt(at(bench.k, 0), &mut bench.seen);
    bench.run(6, &[]);
    assert_eq!(bench.warnings(), []);
}

#[test]
fn complaints_about_the_network_are_told_and_blame_nobody() {
    let mut bench = Bench::new();
    let missed = [0x30, 0x81, 0x11, 0, 0, 0, 0, 0];
    bench.run(50, &[frame(at(0, 9), 0x083, &missed), frame(at(0, 10), 0x083, &OVER)]);
    assert_eq!(bench.warnings(), []);
    let emergency = Emergency::read(&missed).expect("it is whole");
    assert_eq!(bench.news(), [(3, DeviceNews::Network(emergency))]);
}

/// A device that has lost its mind, on a bus with five healthy cylinders.
#[test]
fn a_flood_is_a_few_lines_and_touches_no_other_cylinder() {
    let mut flood = Vec::new();
    for i in 0..3000_i64 {
        let at = Timestamp::from_nanos(at(0, 10).as_nanos() + i * 1000);
        let length = (i % 9) as usize;
        flood.push(frame(
            at,
            0x083,
            &[(i * 7) as u8, (i * 13) as u8, i as u8, 1, 2, 3, 4, 5][..length],
        ));
        flood.push(frame(at, 0x703, &[(i % 256) as u8; 8][..length]));
        flood.push(Frame::new(
            at,
            Id::standard(0x703).expect("11 bits"),
            Kind::Remote { length: 1 },
            &[],
        ));
    }
    let (mut bench, mut quiet) = (Bench::new(), Bench::new());
    for k in 0..50 {
        let later = |it: &Frame| {
            let mut later = it.clone();
            later.timestamp = it.timestamp.after(Span::from_nanos(20 * k * MS));
            later
        };
        let frames: Vec<Frame> = flood.iter().map(later).collect();
        bench.run(1, &frames);
        quiet.run(1, &[]);
    }
    let others = |bench: &Bench| {
        let others = bench.seen.records.iter().filter(|it| it.cylinder != 3);
        others.map(|it| format!("{it:?}")).collect::<Vec<_>>()
    };
    assert_eq!(others(&bench), others(&quiet));
    assert!(bench.seen.warnings.iter().all(|it| it.cylinder == 3));
    assert!(bench.seen.warnings.len() <= 51, "{}", bench.seen.warnings.len());
    assert!(bench.seen.notices.len() <= 3 * 50, "{}", bench.seen.notices.len());
    assert!(bench.monitor.counts().bad_signals > 0);
    assert_eq!(bench.monitor.counts().cycles, quiet.monitor.counts().cycles);
}

/// The default machine whose C1 of cylinder 3 sends by a timer of its own.
fn by_timer() -> Monitor {
    let mut design = design_of_default();
    let alone = design.subscriptions.send_by_timer(|one| {
        let Target::Cylinder(2, field) = one.target else { return false };
        field.transducer() == Some(Transducer::C1)
    });
    assert!(alone, "it has a message of its own");
    Monitor::new(design)
}

/// A reading of C1 of cylinder 3, counts beyond the middle.
fn read_at(at: Timestamp, count: u16) -> Frame {
    let [low, high] = (13_824 + count).to_le_bytes();
    frame(at, 0x183, &[low, high, 0, 0, 0, 0])
}

#[test]
fn of_a_transducer_with_a_timer_the_newest_reading_before_the_sync_counts() {
    let (mut monitor, mut seen) = (by_timer(), Collected::default());
    for k in 0..40 {
        // 17, 13, 9 and 5 ms before the Sync.
        let early = (1..5).map(|i| read_at(at(k, -20 + 4 * i - 1), i as u16));
        let mut frames: Vec<Frame> = early.collect();
        frames.extend(Cycle::new(k).frames().into_iter().filter(|it| it.id.value() != 0x183));
        // Two after it are of the next cycle, and neither opens one nor is late.
        frames.push(read_at(at(k, 5), 70));
        frames.iter().for_each(|frame| monitor.take(frame, &mut seen));
    }
    monitor.finish(&mut seen);
    let count = 3.0 / 27_648.0;
    for k in 1..40 {
        let c1 = seen.record(k, 3).c1.expect("it has come");
        assert!((c1 - 4.0 * count).abs() < 1e-9, "{k}: {c1}");
    }
    let counts = monitor.counts();
    assert_eq!((counts.cycles, counts.incomplete, counts.late, counts.repeated), (40, 0, 0, 0));
}

#[test]
fn a_reading_by_a_timer_that_is_older_than_a_cycle_is_none() {
    let (mut monitor, mut seen) = (by_timer(), Collected::default());
    for k in 0..40 {
        let mut frames: Vec<Frame> = Vec::new();
        if k < 20 {
            frames.push(read_at(at(k, -3), 0));
        }
        frames.extend(Cycle::new(k).frames().into_iter().filter(|it| it.id.value() != 0x183));
        frames.iter().for_each(|frame| monitor.take(frame, &mut seen));
    }
    assert!(seen.record(19, 3).c1.is_some());
    assert!((20..39).all(|k| seen.record(k, 3).c1.is_none()));
    // The bus was silent after the last one.
    monitor.take(&read_at(at(40, -3), 0), &mut seen);
    for frame in Cycle::new(45).frames().iter().filter(|it| it.id.value() != 0x183) {
        monitor.take(frame, &mut seen);
    }
    monitor.finish(&mut seen);
    assert!(seen.record(45, 3).c1.is_none() && seen.record(45, 3).c2.is_some());
    let [raised] = seen.warnings[..] else { panic!("{:?}", seen.warnings) };
    assert_eq!((raised.finding.fault, raised.finding.suspect), (Fault::Stale, Suspect::C1));
}
