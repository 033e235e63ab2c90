//! The live gateway on the embedded bus: the same frames as a replay, whatever the rhythm in which
//! the gateway gets its turn; and what it does when the bus goes away.

use std::time::Duration;
use tertius::alarm::Warning;
use tertius::bus::embedded::{BusState, Clock, EmbeddedBus, Endpoint, ManualClock};
use tertius::bus::{Identifiers, Port, PortError, UnrestrictedPort};
use tertius::canopen::node::NmtEvent;
use tertius::frame::{Frame, Id, Kind};
use tertius::incident::Incident;
use tertius::live::gateway::{Gateway, Journal, NotSent, Silent};
use tertius::live::outbox::OutboxLimits;
use tertius::monitor::{Notice, Record};
use tertius::time::{Span, Timestamp};
pub use tertius_testing::machine::gateway_of;
use tertius_testing::machine::{self, Collected, Cycle, MS, estimating, monitor, play};

/// Frames with a transducer that steps and comes back, lost frames and a lost stretch.
pub fn bus_traffic() -> Vec<Frame> {
    let cycles = (0..400).filter(|k| !(150..160).contains(k) && k % 37 != 0);
    let frames = cycles.flat_map(|k| {
        let offset = if (230..260).contains(&k) { 30 } else { 0 };
        Cycle { offset, ..Cycle::new(k) }.frames()
    });
    frames.enumerate().filter(|(i, _)| i % 101 != 0).map(|(_, frame)| frame).collect()
}

pub fn gateway() -> Gateway {
    gateway_of(monitor(), 0.05)
}

/// What a gateway told.
#[derive(Debug, Default)]
pub struct Notes {
    pub records: Vec<Record>,
    pub warnings: Vec<Warning>,
    pub incidents: Vec<Incident>,
    pub commands: Vec<NmtEvent>,
    pub notices: Vec<Notice>,
}

impl Journal for Notes {
    fn record(&mut self, record: &Record) {
        self.records.push(*record);
    }

    fn warning(&mut self, warning: &Warning) {
        self.warnings.push(*warning);
    }

    fn incident(&mut self, incident: &Incident) {
        self.incidents.push(*incident);
    }

    fn nmt(&mut self, event: &NmtEvent) {
        self.commands.push(*event);
    }

    fn notice(&mut self, notice: &Notice) {
        self.notices.push(*notice);
    }
}

/// The embedded bus with a machine, a gateway and someone who listens.
pub struct Bench {
    pub clock: ManualClock,
    pub bus: EmbeddedBus,
    pub gateway: Gateway,
    pub port: Endpoint,
    pub heard: Vec<Frame>,
    pub notes: Notes,
}

impl Bench {
    pub fn new() -> Self {
        let clock = ManualClock::new(Timestamp::from_nanos(machine::START));
        let bus = EmbeddedBus::new(Clock::Manual(clock.clone()));
        let port = bus.open(&Identifiers::All, 4096).expect("the bus is up");
        Self { clock, bus, gateway: gateway(), port, heard: Vec::new(), notes: Notes::default() }
    }

    pub fn turn(&mut self) -> Result<(), PortError> {
        self.gateway.turn(&mut self.port, Duration::ZERO, &mut self.notes).map(drop)
    }

    pub fn stop(&mut self) -> Result<(), NotSent> {
        self.gateway.stop(&mut self.port, Duration::ZERO, &mut Silent)
    }

    /// Puts `frames` on the bus at their times and lets the gateway have a turn every `rhythm`-th
    /// frame, as a busy box would.
    pub fn run(&mut self, frames: &[Frame], rhythm: usize) {
        let mut machine = self.bus.open_unrestricted(&Identifiers::All, 4096).expect("up");
        for (index, frame) in frames.iter().enumerate() {
            self.be_silent_until(frame.timestamp, &mut machine);
            self.clock.set(frame.timestamp);
            machine.send_unrestricted(frame).expect("the bus is up");
            if index % rhythm == 0 {
                self.turn().expect("the bus is up");
                self.listen(&mut machine);
            }
        }
        self.turn().expect("the bus is up");
        self.listen(&mut machine);
    }

    /// Turns go on while nothing comes.
    pub fn be_silent_until(&mut self, end: Timestamp, ear: &mut impl Port) {
        let patience = Span::from_seconds(0.025);
        while end.since(self.clock.now()) > patience {
            self.clock.advance(patience);
            self.turn().expect("the bus is up");
            self.listen(ear);
        }
    }

    pub fn listen(&mut self, ear: &mut impl Port) {
        let heard = &mut self.heard;
        ear.receive(Duration::ZERO, &mut |frame| heard.push(frame.clone())).expect("up");
    }
}

/// What is on the wire: identifier and payload.
pub fn wire(frames: &[Frame]) -> Vec<(Id, Vec<u8>)> {
    frames.iter().map(|frame| (frame.id, frame.data().to_vec())).collect()
}

#[test]
fn live_says_what_a_replay_of_the_same_frames_says() {
    let traffic = bus_traffic();
    let (_, replayed) = play(traffic.iter().cloned());
    assert!(replayed.warnings.len() >= 4 && !replayed.notices.is_empty());
    let (incidents, end) = (replayed.incidents, traffic.last().expect("frames").timestamp);
    assert!(incidents.len() > 1, "{incidents:?}");
    let replayed = wire(&replayed.frames);
    for rhythm in [1, 2, 7, 20, 61] {
        let mut bench = Bench::new();
        bench.run(&traffic, rhythm);
        let live = wire(&bench.heard);
        // What falls due within the guard of the last frame is still to come.
        assert!(replayed.len() - live.len() <= 1, "rhythm {rhythm}");
        assert!(live == replayed[..live.len()], "rhythm {rhythm}");
        let told = &bench.notes.incidents;
        assert!(*told == incidents[..told.len()], "rhythm {rhythm}: {told:?}");
        let left = &incidents[told.len()..];
        // At its end a replay tells of those that are not over.
        assert!(left.iter().all(|it| it.timestamp >= end), "rhythm {rhythm}: {left:?}");
    }
}

#[test]
fn nothing_but_its_own_identifiers_leaves_the_gateway() {
    let mut traffic = bus_traffic();
    // Every standard identifier arrives, its own included.
    let at = traffic[2000].timestamp;
    let strangers = (0..=Id::STANDARD_MAX).map(|id| {
        let id = Id::standard(id).expect("it is in range");
        Frame::new(at, id, tertius::frame::Kind::Data, &[0xFF; 8])
    });
    traffic.splice(2000..2000, strangers);
    let mut bench = Bench::new();
    bench.run(&traffic, 5);
    assert!(bench.heard.len() > 60);
    assert!(bench.heard.iter().all(|frame| [0x1D1, 0x2D1].contains(&frame.id.value())));
}

#[test]
fn what_waited_while_the_bus_was_away_is_not_sent_when_it_returns() {
    let traffic = bus_traffic();
    let split =
        traffic.iter().position(|frame| frame.timestamp.as_nanos() > machine::START + 4_630 * MS);
    let (before, after) = traffic.split_at(split.expect("the traffic lasts eight seconds"));
    let mut bench = Bench::new();
    bench.run(before, 1);
    bench.bus.set_state(BusState::Jammed);
    for _ in 0..200 {
        bench.clock.advance(Span::from_seconds(0.005));
        bench.turn().expect("a jammed bus is not lost");
    }
    bench.bus.set_state(BusState::Down);
    assert!(matches!(bench.turn(), Err(PortError::Down)));
    bench.gateway.lose(&mut Silent);
    assert_eq!(bench.gateway.outbox().waiting(), 0);
    bench.bus.set_state(BusState::Up);
    bench.port = bench.bus.open(&Identifiers::All, 4096).expect("it is up again");
    bench.heard.clear();
    let resumed = bench.clock.now();
    let later: Vec<Frame> =
        after.iter().filter(|frame| frame.timestamp > resumed).cloned().collect();
    bench.run(&later, 1);
    for frame in bench.heard.iter().filter(|frame| frame.id.value() == 0x1D1).take(5) {
        assert_eq!(healthy(frame), 0, "nothing is healthy until it was judged again");
    }
    assert!(bench.gateway.outbox().counts().too_old > 0, "the old ones were dropped and counted");
}

/// How many transducers a status calls healthy.
fn healthy(status: &Frame) -> usize {
    let payload = u64::from_le_bytes(status.data().try_into().expect("eight bytes"));
    (0..12).filter(|i| payload >> (24 + 2 * i) & 0b11 == 1).count()
}

fn error_frame(class: u32) -> Frame {
    let id = Id::extended(class).expect("classes fit an extended identifier");
    Frame::new(Timestamp::default(), id, Kind::Error, &[0; 8])
}

#[test]
fn nothing_is_sent_while_the_controller_is_bus_off_and_nothing_known_after_it() {
    let traffic = bus_traffic();
    let (before, after) = traffic.split_at(2400);
    let mut bench = Bench::new();
    bench.run(before, 1);
    let newest = bench.heard.iter().rfind(|frame| frame.id.value() == 0x1D1).expect("statuses");
    assert!(healthy(newest) > 0);
    bench.heard.clear();
    let mut driver = bench.bus.open_unrestricted(&Identifiers::All, 64).expect("up");
    driver.send_unrestricted(&error_frame(0x040)).expect("up");
    for _ in 0..60 {
        bench.clock.advance(Span::from_seconds(0.005));
        bench.turn().expect("the interface stays up");
    }
    bench.listen(&mut driver);
    assert!(bench.heard.is_empty(), "{:?}", bench.heard);
    assert_eq!(bench.gateway.health().bus_offs, 1);
    driver.send_unrestricted(&error_frame(0x100)).expect("up");
    let resumed = bench.clock.now();
    let later: Vec<Frame> =
        after.iter().filter(|frame| frame.timestamp > resumed).cloned().collect();
    bench.run(&later, 1);
    let statuses: Vec<&Frame> =
        bench.heard.iter().filter(|frame| frame.id.value() == 0x1D1).collect();
    assert!(statuses[0].timestamp >= resumed && healthy(statuses[0]) == 0);
    assert!(statuses.iter().any(|status| healthy(status) == 12), "it is judged again");
}

#[test]
fn a_clock_set_on_a_quiet_bus_does_not_silence_the_gateway() {
    for hours in [-2.0, 2.0] {
        let mut bench = Bench::new();
        bench.run(&bus_traffic()[..2000], 1);
        bench.clock.advance(Span::from_seconds(hours * 3600.0));
        bench.heard.clear();
        let mut ear = bench.bus.open(&Identifiers::All, 4096).expect("up");
        for _ in 0..200 {
            bench.clock.advance(Span::from_seconds(0.005));
            bench.turn().expect("up");
        }
        bench.listen(&mut ear);
        assert!((9..=11).contains(&bench.heard.len()), "{} in a second", bench.heard.len());
        assert!(bench.heard.iter().all(|status| healthy(status) == 0), "{hours} h");
    }
}

#[test]
fn a_stopping_gateway_says_so() {
    let mut bench = Bench::new();
    bench.run(&bus_traffic()[..2000], 1);
    let mut ear = bench.bus.open(&Identifiers::All, 16).expect("up");
    bench.stop().expect("the bus is up");
    bench.heard.clear();
    bench.listen(&mut ear);
    let [frame] = &bench.heard[..] else { panic!("{:?}", bench.heard) };
    let payload = u64::from_le_bytes(frame.data().try_into().expect("eight bytes"));
    assert_eq!((frame.id.value(), payload >> 51 & 0b111), (0x1D1, 4));
    assert_eq!(payload >> 24 & 0xFF_FFFF, 0, "nothing is healthy once nobody looks");
}

/// The mode of a status.
fn mode(status: &Frame) -> u64 {
    let payload = u64::from_le_bytes(status.data().try_into().expect("eight bytes"));
    payload >> 51 & 0b111
}

/// Whatever went before: a gateway whose share of the bus is used up still says that it stops, and
/// takes no more of the bus for it.
#[test]
fn the_last_words_are_within_the_share_however_much_went_before() {
    let traffic = bus_traffic();
    for (frames, share) in [(2000, 0.003), (5000, 0.003), (traffic.len(), 0.003), (5000, 0.05)] {
        let mut bench = Bench { gateway: gateway_of(estimating(), share), ..Bench::new() };
        bench.run(&traffic[..frames], 1);
        assert!(bench.gateway.outbox().counts().held_back > 0, "its share is used up");
        let mut ear = bench.bus.open(&Identifiers::All, 64).expect("up");
        bench.stop().expect("the bus is up");
        bench.listen(&mut ear);
        let newest = bench.heard.last().expect("it spoke");
        assert_eq!((newest.id.value(), mode(newest)), (0x1D1, 4), "{frames} frames at {share}");
        let seconds = newest.timestamp.since(traffic[0].timestamp).as_seconds();
        let most = share * 500_000.0 / 135.0 * seconds + f64::from(OutboxLimits::BURST);
        assert!(bench.heard.len() as f64 <= most, "{} of {most}", bench.heard.len());
        for _ in 0..40 {
            bench.clock.advance(Span::from_seconds(0.025));
            bench.turn().expect("up");
        }
        bench.heard.clear();
        bench.listen(&mut ear);
        assert!(bench.heard.is_empty(), "nothing follows the stopping status: {:?}", bench.heard);
    }
}

#[test]
fn who_stops_a_gateway_hears_that_the_bus_was_not_told() {
    let mut bench = Bench::new();
    bench.run(&bus_traffic()[..2000], 1);
    let mut ear = bench.bus.open(&Identifiers::All, 64).expect("up");
    bench.bus.set_state(BusState::Jammed);
    assert!(matches!(bench.stop(), Err(NotSent::Full)));
    bench.heard.clear();
    bench.listen(&mut ear);
    assert!(bench.heard.is_empty());
    // Once it moves again the stopping status is sent, and once.
    bench.bus.set_state(BusState::Up);
    bench.stop().expect("the bus is up");
    bench.stop().expect("it was said");
    bench.listen(&mut ear);
    assert_eq!(bench.heard.iter().map(mode).collect::<Vec<_>>(), [4]);

    let mut bench = Bench::new();
    bench.run(&bus_traffic()[..2000], 1);
    let mut driver = bench.bus.open_unrestricted(&Identifiers::All, 64).expect("up");
    driver.send_unrestricted(&error_frame(0x040)).expect("up");
    bench.turn().expect("the interface stays up");
    assert!(matches!(bench.stop(), Err(NotSent::BusOff)));
    bench.bus.set_state(BusState::Down);
    assert!(matches!(bench.stop(), Err(NotSent::BusOff | NotSent::Port(_))));
}

/// What has the identifier `id`.
pub fn of(frames: &[Frame], id: u32) -> Vec<(Id, Vec<u8>)> {
    wire(frames).into_iter().filter(|(own, _)| own.value() == id).collect()
}

/// Estimates give way: to other frames, and where a turn brings several cycles, to newer ones.
#[test]
fn live_estimates_what_a_replay_of_the_same_frames_does() {
    let traffic = bus_traffic();
    let mut replayed = Collected::default();
    let mut monitor = estimating();
    traffic.iter().for_each(|frame| monitor.take(frame, &mut replayed));
    for rhythm in [1, 7, 20] {
        let mut bench = Bench { gateway: gateway_of(estimating(), 0.15), ..Bench::new() };
        bench.run(&traffic, rhythm);
        for id in [0x1D1, 0x2D1] {
            let (live, replayed) = (of(&bench.heard, id), of(&replayed.frames, id));
            assert!(replayed.len() - live.len() <= 1, "{id:x} in rhythm {rhythm}");
            assert!(live == replayed[..live.len()], "{id:x} in rhythm {rhythm}");
        }
        let (live, replayed) = (of(&bench.heard, 0x3D1), of(&replayed.frames, 0x3D1));
        assert!(live.len() * 10 > replayed.len() * 9, "rhythm {rhythm}: {}", live.len());
        let mut rest = replayed.iter();
        assert!(live.iter().all(|frame| rest.any(|it| it == frame)), "rhythm {rhythm}");
    }
}

/// With too small a share of the bus estimates are left out, and nothing else is.
#[test]
fn estimates_take_nothing_from_warnings_and_statuses() {
    let traffic = bus_traffic();
    let mut plain = Bench::new();
    plain.run(&traffic, 1);
    let mut bench = Bench { gateway: gateway_of(estimating(), 0.05), ..Bench::new() };
    bench.run(&traffic, 1);
    for id in [0x1D1, 0x2D1] {
        assert!(of(&bench.heard, id) == of(&plain.heard, id), "{id:x}");
    }
    let seconds = 400.0 * 0.02;
    let most = 0.05 * 500_000.0 / 135.0 * seconds + f64::from(OutboxLimits::BURST);
    assert!((bench.heard.len() as f64) < most, "{} of {most}", bench.heard.len());
    assert!(bench.gateway.outbox().counts().outdated > 500);
}
