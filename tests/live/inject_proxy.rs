//! The proxy between two embedded buses: what comes out is what the injector makes of a recording of
//! the same frames, byte for byte, whatever the rhythm and whatever befalls the buses.

use std::cell::Cell;
use std::collections::VecDeque;
use std::path::Path;
use std::rc::Rc;
use std::time::Duration;
use tertius::bus::embedded::{BusState, Clock, EmbeddedBus, Endpoint, ManualClock};
use tertius::bus::{Identifiers, Port, Unrestricted, UnrestrictedPort};
use tertius::config;
use tertius::dbc::{Database, text};
use tertius::frame::{Frame, Id, Kind};
use tertius::inject::{Fault, Injector, place};
use tertius::live::proxy::{self, Bench, LaneCounts, LaneLimits, Proxy, Side};
use tertius::time::{Span, Timestamp};
use tertius_testing::machine::{Cycle, MS, START};

type Socket = Unrestricted<Endpoint>;

const LIMITS: LaneLimits = LaneLimits { waiting: 4096, age: Span::from_nanos(100 * MS) };

/// One of each kind that keeps something between frames, and one that depends on the time.
const FAULTS: [&str; 6] = [
    "step,cylinder=1,at=1.0,size=0.00175,until=2.5",
    "noise,cylinder=2,sensor=c2,size=0.002",
    "drift,cylinder=3,at=0.5,rate=0.01",
    "stale,cylinder=4,at=1.005,until=2",
    "loss,cylinder=5,sensor=c2,probability=0.3",
    "spike,cylinder=6,size=0.01,probability=0.2",
];

fn injector() -> Injector {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let loaded = config::load(&root.join("config/e-type.toml")).expect("it ships");
    let database = Database::parse(&text::from_bytes(&loaded.dbc_text)).expect("it ships");
    let placed = FAULTS.map(|fault| {
        let fault = Fault::parse(fault).expect("it is well formed");
        place(&fault, &loaded.settings, &database).expect("the machine has it")
    });
    Injector::new(&placed, 7)
}

/// Cycles of the machine: 4 s.
fn traffic() -> Vec<Frame> {
    (0..200).flat_map(|k| Cycle::new(k).frames()).collect()
}

/// What `injector` makes of `frames`, those that it loses left out.
fn injected(injector: &mut Injector, frames: &[Frame]) -> Vec<Frame> {
    frames.iter().filter_map(|frame| injector.take(frame).cloned()).collect()
}

/// Every frame is accounted for.
fn assert_whole(counts: &LaneCounts, waiting: usize) {
    let LaneCounts { received, sent, lost, too_old, crowded_out, away, rejected, .. } = *counts;
    let known = sent + lost + too_old + crowded_out + away + rejected + waiting as u64;
    assert_eq!(received, known, "{counts:?} and {waiting} that wait");
}

fn frame(id: Option<Id>, kind: Kind, bytes: &[u8]) -> Frame {
    Frame::new(Timestamp::default(), id.expect("it is in range"), kind, bytes)
}

/// Without time stamps: what is on the wire.
fn wire(frames: &[Frame]) -> Vec<(Id, Kind, &[u8])> {
    frames.iter().map(|frame| (frame.id, frame.kind, frame.data())).collect()
}

/// Two buses, a machine on one, a gateway on the other, a proxy between.
struct Two {
    clock: ManualClock,
    buses: [EmbeddedBus; 2],
    machine: Socket,
    gateway: Socket,
    from: Socket,
    to: Socket,
    proxy: Proxy,
    /// By the machine, by the gateway.
    heard: [Vec<Frame>; 2],
}

impl Two {
    fn new(limits: LaneLimits) -> Self {
        let clock = ManualClock::new(Timestamp::from_nanos(START));
        let buses = [(); 2].map(|()| EmbeddedBus::new(Clock::Manual(clock.clone())));
        let [machine, from, gateway, to] = [0, 0, 1, 1].map(|bus: usize| open(&buses[bus]));
        let (proxy, heard) = (Proxy::new(injector(), limits), [vec![], vec![]]);
        Self { clock, buses, machine, gateway, from, to, proxy, heard }
    }

    fn turn(&mut self) {
        let outcomes = self.proxy.turn(Some(&mut self.from), Some(&mut self.to));
        assert!(outcomes.iter().all(Result::is_ok), "{outcomes:?}");
        assert_whole(self.proxy.there().counts(), self.proxy.there().waiting());
        assert_whole(self.proxy.back().counts(), self.proxy.back().waiting());
        let [at_machine, at_gateway] = &mut self.heard;
        listen(&mut self.machine, at_machine);
        listen(&mut self.gateway, at_gateway);
    }

    fn play(&mut self, frames: &[Frame], rhythm: usize) {
        for (index, frame) in frames.iter().enumerate() {
            self.clock.set(frame.timestamp);
            self.machine.send_unrestricted(frame).expect("the bus is up");
            if index % rhythm == 0 {
                self.turn();
            }
        }
        self.turn();
    }
}

fn open(bus: &EmbeddedBus) -> Socket {
    bus.open_unrestricted(&Identifiers::All, 4096).expect("the bus is up")
}

fn listen(port: &mut Socket, heard: &mut Vec<Frame>) {
    let mut taken = 1;
    while taken > 0 {
        let received = port.receive(Duration::ZERO, &mut |frame| heard.push(frame.clone()));
        taken = received.map_or(0, |received| received.frames);
    }
}

#[test]
fn what_comes_out_is_what_the_injector_makes_of_a_recording() {
    let frames = traffic();
    let mut injector = injector();
    let expected = injected(&mut injector, &frames);
    for rhythm in [1, 7, 60, 90] {
        let mut two = Two::new(LIMITS);
        two.play(&frames, rhythm);
        assert!(wire(&two.heard[1]) == wire(&expected), "rhythm {rhythm}");
        assert_eq!(two.proxy.injector().tallies(), injector.tallies());
        let counts = two.proxy.there().counts();
        assert!(counts.lost > 20 && counts.changed > 200, "{counts:?}");
        let changed = frames.len() - injected_unchanged(&frames);
        assert_eq!(counts.changed + counts.lost, changed as u64);
        assert!(two.heard[0].is_empty(), "the machine hears nothing of itself");
    }
}

/// Frames that pass the injector as they are.
fn injected_unchanged(frames: &[Frame]) -> usize {
    let mut injector = injector();
    frames.iter().filter(|frame| injector.take(frame).is_some_and(|out| out == *frame)).count()
}

#[test]
fn the_way_back_changes_nothing_and_nothing_goes_round() {
    let frames = traffic();
    let mut two = Two::new(LIMITS);
    // All kinds, and identifiers that have faults in the other direction.
    let answers: Vec<Frame> = (0..200_u32)
        .map(|k| match k % 4 {
            0 => frame(Id::standard(0x181), Kind::Data, &[k as u8; 6]),
            1 => frame(Id::standard(0x192), Kind::Fd { flags: 1 }, &[k as u8; 48]),
            2 => frame(Id::standard(0x1D1), Kind::Remote { length: 3 }, &[]),
            _ => frame(Id::extended(0x1_0000 + k), Kind::Data, &[1]),
        })
        .collect();
    for (cycle, answer) in frames.chunks(20).zip(&answers) {
        two.gateway.send_unrestricted(answer).expect("the bus is up");
        two.play(cycle, 5);
    }
    assert!(wire(&two.heard[0]) == wire(&answers));
    assert_eq!(two.proxy.back().counts().changed, 0);
    assert!(wire(&two.heard[1]) == wire(&injected(&mut injector(), &frames)));
    let counts = [*two.proxy.there().counts(), *two.proxy.back().counts()];
    (0..10).for_each(|_| two.turn());
    assert_eq!([*two.proxy.there().counts(), *two.proxy.back().counts()], counts);
}

#[test]
fn error_frames_stay_on_their_bus_and_do_not_start_the_time_of_the_faults() {
    let frames = traffic();
    let error = frame(Id::extended(0x20), Kind::Error, &[0; 8]);
    let mut two = Two::new(LIMITS);
    two.clock.set(Timestamp::from_nanos(START - 400 * MS));
    two.machine.send_unrestricted(&error).expect("the bus is up");
    two.gateway.send_unrestricted(&error).expect("the bus is up");
    two.turn();
    two.play(&frames, 20);
    assert!(two.heard[0].is_empty());
    assert!(wire(&two.heard[1]) == wire(&injected(&mut injector(), &frames)));
    let lanes = [two.proxy.there(), two.proxy.back()];
    assert!(lanes.iter().all(|lane| lane.counts().error_frames == 1));
}

#[test]
fn a_full_far_side_is_waited_for_but_nothing_is_sent_late() {
    let frames = traffic();
    let expected = injected(&mut injector(), &frames);
    let mut two = Two::new(LIMITS);
    two.play(&frames[..400], 5);
    two.buses[1].set_state(BusState::Jammed);
    two.play(&frames[400..480], 5);
    two.buses[1].set_state(BusState::Up);
    two.play(&frames[480..1000], 5);
    let whole = wire(&expected)[..two.heard[1].len()].to_vec();
    assert!(wire(&two.heard[1]) == whole, "80 ms late, but whole and in order");
    assert_eq!(two.proxy.there().counts().too_old, 0);

    two.buses[1].set_state(BusState::Jammed);
    two.play(&frames[1000..2000], 5);
    two.buses[1].set_state(BusState::Up);
    two.heard[1].clear();
    two.play(&frames[2000..], 5);
    let counts = *two.proxy.there().counts();
    // A second of which the last tenth is young enough.
    let dropped = counts.too_old as usize;
    assert!((880..=900).contains(&(dropped + lost(&frames[..2000], 1000))), "{counts:?}");
    let rest = expected.len() - two.heard[1].len();
    assert!(wire(&two.heard[1]) == wire(&expected)[rest..], "the newest, in order");
}

/// How many of `frames` beyond the first `skipped`, but for the last 5 cycles, are lost to a fault.
fn lost(frames: &[Frame], skipped: usize) -> usize {
    let mut injector = injector();
    let lost: Vec<bool> = frames.iter().map(|frame| injector.take(frame).is_none()).collect();
    lost[skipped..frames.len() - 100].iter().filter(|lost| **lost).count()
}

#[test]
fn few_wait_and_the_oldest_gives_way() {
    let frames = traffic();
    let expected = injected(&mut injector(), &frames[..200]);
    let mut two = Two::new(LaneLimits { waiting: 16, ..LIMITS });
    two.buses[1].set_state(BusState::Jammed);
    for frame in &frames[..200] {
        // All at once, so that none is too old.
        two.clock.set(frame.timestamp);
        two.machine.send_unrestricted(frame).expect("the bus is up");
    }
    two.turn();
    assert_eq!(two.proxy.waiting(), 16);
    two.buses[1].set_state(BusState::Up);
    two.turn();
    assert!(wire(&two.heard[1]) == wire(&expected[expected.len() - 16..]));
    let counts = two.proxy.there().counts();
    assert_eq!(counts.crowded_out, expected.len() as u64 - 16);
}

/// What happens at a time.
enum Event {
    Frame(Frame),
    State(usize, BusState),
}

/// Two buses on which things happen while the proxy runs.
struct Script {
    clock: ManualClock,
    buses: [EmbeddedBus; 2],
    /// The machine and the gateway, while their buses are up.
    ends: [Option<Socket>; 2],
    events: VecDeque<(Timestamp, Event)>,
    heard: Vec<Frame>,
    told: Vec<(Timestamp, usize, bool)>,
    /// Turns left after the last event.
    turns: u32,
}

impl Script {
    fn new(events: impl IntoIterator<Item = (Timestamp, Event)>) -> Self {
        let clock = ManualClock::new(Timestamp::from_nanos(START));
        let buses = [(); 2].map(|()| EmbeddedBus::new(Clock::Manual(clock.clone())));
        let ends = [Some(open(&buses[0])), Some(open(&buses[1]))];
        let mut events: Vec<_> = events.into_iter().collect();
        events.sort_by_key(|(at, _)| *at);
        let (events, heard, told) = (events.into(), vec![], vec![]);
        Self { clock, buses, ends, events, heard, told, turns: 3 }
    }

    fn happen(&mut self, event: Event) {
        match event {
            Event::Frame(frame) => {
                if let Some(machine) = &mut self.ends[0] {
                    machine.send_unrestricted(&frame).expect("the bus is up");
                }
            }
            Event::State(side, state) => {
                self.buses[side].set_state(state);
                match state {
                    BusState::Up => self.ends[side] = Some(open(&self.buses[side])),
                    BusState::Down | BusState::Gone => self.ends[side] = None,
                    BusState::Jammed => {}
                }
            }
        }
    }

    /// Runs a proxy to the end; the proxy and how often each side was tried to be opened.
    fn run(&mut self) -> (Proxy, [u32; 2]) {
        let tries = [(); 2].map(|()| Rc::new(Cell::new(0)));
        let mut sides = [0, 1].map(|side: usize| {
            let (bus, tries) = (self.buses[side].clone(), Rc::clone(&tries[side]));
            Side::new(Box::new(move || {
                tries.set(tries.get() + 1);
                bus.open_unrestricted(&Identifiers::All, 4096).map_err(|error| error.to_string())
            }))
        });
        let mut proxy = Proxy::new(injector(), LIMITS);
        proxy::run(&mut proxy, &mut sides, self);
        assert_whole(proxy.there().counts(), proxy.there().waiting());
        (proxy, tries.map(|tries| tries.get()))
    }

    /// When the side was opened or lost, in turn.
    fn told_of(&self, side: usize, opened: bool) -> Vec<Timestamp> {
        let of = |(at, of, what): &(Timestamp, usize, bool)| {
            (*of == side && *what == opened).then_some(*at)
        };
        self.told.iter().filter_map(of).collect()
    }
}

impl Bench<Socket> for Script {
    fn now(&mut self) -> Duration {
        let since = self.clock.now().as_nanos() - START;
        Duration::from_nanos(since.try_into().expect("time goes on"))
    }

    fn is_over(&mut self) -> bool {
        self.turns -= u32::from(self.events.is_empty());
        self.turns == 0
    }

    fn wait(&mut self, _: [Option<&Socket>; 2], longest: Duration) {
        if let Some(gateway) = &mut self.ends[1] {
            listen(gateway, &mut self.heard);
        }
        let until = self.clock.now().after(Span::from_seconds(longest.as_secs_f64()));
        match self.events.pop_front() {
            Some((at, event)) if at <= until => {
                self.clock.set(at);
                self.happen(event);
            }
            later => {
                self.clock.set(until);
                later.into_iter().for_each(|event| self.events.push_front(event));
            }
        }
    }

    fn opened(&mut self, side: usize, _: &Socket) {
        self.told.push((self.clock.now(), side, true));
    }

    fn lost(&mut self, side: usize, _: &str) {
        self.told.push((self.clock.now(), side, false));
    }
}

fn at(ms: i64) -> Timestamp {
    Timestamp::from_nanos(START + ms * MS)
}

fn frame_events(frames: &[Frame]) -> impl Iterator<Item = (Timestamp, Event)> {
    frames.iter().map(|frame| (frame.timestamp, Event::Frame(frame.clone())))
}

#[test]
fn each_side_may_go_and_come_back() {
    let frames = traffic();
    for side in [0, 1] {
        for state in [BusState::Down, BusState::Gone] {
            let states = [(1005, state), (2005, BusState::Up)]
                .map(|(ms, state)| (at(ms), Event::State(side, state)));
            let mut script = Script::new(frame_events(&frames).chain(states));
            let (proxy, _) = script.run();
            let (opened, lost) = (script.told_of(side, true), script.told_of(side, false));
            assert_eq!((opened.len(), lost.as_slice()), (2, &[at(1005)][..]), "told once");
            let back = opened[1];
            assert!(back >= at(2005) && back <= at(2005 + 850), "the back-off is bounded");
            assert_eq!(script.told_of(1 - side, true).len(), 1, "the other one stays");

            // Every frame that the machine sent passed the injector.
            let on_the_bus =
                |frame: &Frame| side == 1 || frame.timestamp < at(1005) || frame.timestamp >= back;
            let sent: Vec<Frame> =
                frames.iter().filter(|frame| on_the_bus(frame)).cloned().collect();
            let mut expected = injected(&mut injector(), &sent);
            expected.retain(|frame| frame.timestamp < at(1005) || frame.timestamp >= back);
            assert!(script.heard == expected, "side {side}, {state:?}");
            assert_eq!(proxy.there().counts().away > 0, side == 1);
        }
    }
}

#[test]
fn what_waited_for_a_side_that_went_is_not_sent_when_it_returns() {
    let frames = traffic();
    // All within the time that a frame may wait.
    let states = [(995, BusState::Jammed), (1015, BusState::Down), (1016, BusState::Up)];
    let states = states.map(|(ms, state)| (at(ms), Event::State(1, state)));
    let mut script = Script::new(frame_events(&frames).chain(states));
    script.run();
    let back = script.told_of(1, true)[1];
    assert!(back <= at(1070));
    let mut expected = injected(&mut injector(), &frames);
    expected.retain(|frame| frame.timestamp < at(995) || frame.timestamp >= back);
    assert!(wire(&script.heard) == wire(&expected));
}

#[test]
fn the_time_of_the_faults_begins_once_the_other_side_is_there() {
    let frames = traffic();
    let states = [(0, BusState::Gone), (305, BusState::Up)];
    let states = states.map(|(ms, state)| (at(ms), Event::State(1, state)));
    let mut script = Script::new(states.into_iter().chain(frame_events(&frames)));
    // It is away before the proxy is there.
    script.buses[1].set_state(BusState::Gone);
    let (proxy, _) = script.run();
    let there = script.told_of(1, true)[0];
    let first = frames.partition_point(|frame| frame.timestamp < there);
    assert!(there >= at(305) && first > 0);
    assert!(script.heard == injected(&mut injector(), &frames[first..]));
    assert_eq!(proxy.there().counts().away, first as u64);
}

#[test]
fn a_side_that_is_never_there_is_told_once_and_seldom_tried() {
    let frames: Vec<Frame> = (0..3000).map(|k| Cycle::new(k).frames().remove(0)).collect();
    let mut script = Script::new(frame_events(&frames));
    script.buses[1].set_state(BusState::Gone);
    script.ends[1] = None;
    let (_, tries) = script.run();
    assert_eq!((script.told_of(1, false).len(), tries[0]), (1, 1));
    // Six within 3.15 s, then one each 2 s of the minute.
    assert!((30..=37).contains(&tries[1]), "{tries:?}");
}
