//! A gateway on several buses: it says what a replay of the same frames says, and goes on where one of them is lost.

use std::time::Duration;
use tertius::bus::embedded::{BusState, Clock, EmbeddedBus, ManualClock};
use tertius::bus::{Identifiers, Port, UnrestrictedPort};
use tertius::frame::{BusNumber, Frame};
use tertius::live::gateway::{Gateway, Journal};
use tertius::live::several::SeveralOpener;
use tertius::live::supervisor::Opener;
use tertius::monitor::{Monitor, MonitorDesign, Notice, Record};
use tertius::time::{Span, Timestamp};
use tertius_testing::machine::{self, Collected, MS, gateway_of};
use tertius_testing::support::Seeded;

use crate::live_gateway::{bus_traffic, wire};

const SECOND: BusNumber = BusNumber::Second;

/// Guard of the port: frames of one bus wait so long for those of the other.
const GUARD: Span = Span::from_nanos(10 * MS);

struct OfBus(EmbeddedBus);

impl Opener for OfBus {
    fn open(&mut self) -> Result<Box<dyn Port>, String> {
        let opened = self.0.open(&Identifiers::All, 4096);
        opened.map(|port| Box::new(port) as Box<dyn Port>).map_err(|error| error.to_string())
    }
}

#[derive(Default)]
struct Notes {
    records: Vec<Record>,
    notices: Vec<Notice>,
}

impl Journal for Notes {
    fn record(&mut self, record: &Record) {
        self.records.push(*record);
    }

    fn notice(&mut self, notice: &Notice) {
        self.notices.push(*notice);
    }
}

fn design() -> MonitorDesign {
    machine::design_of("config/e-type-two-buses.toml")
}

/// The traffic of one machine, its C2 on the second bus.
fn traffic() -> Vec<Frame> {
    let on = |frame: Frame| match frame.id.value() {
        0x191..=0x196 => frame.on(SECOND),
        _ => frame,
    };
    bus_traffic().into_iter().map(on).collect()
}

/// Two buses, a machine on both, and a gateway.
struct Bench {
    clock: ManualClock,
    buses: [EmbeddedBus; 2],
    gateway: Gateway,
    port: Box<dyn Port>,
    heard: Vec<Frame>,
    notes: Notes,
}

impl Bench {
    fn new() -> Self {
        let clock = ManualClock::new(Timestamp::from_nanos(machine::START));
        let buses = [0, 1].map(|_| EmbeddedBus::new(Clock::Manual(clock.clone())));
        let openers = {
            let buses = buses.clone();
            move || {
                let numbered = BusNumber::ALL.into_iter().zip(&buses);
                let opener = |(number, bus): (BusNumber, &EmbeddedBus)| {
                    (number, Box::new(OfBus(bus.clone())) as Box<dyn Opener>)
                };
                numbered.map(opener).collect()
            }
        };
        let port = SeveralOpener::new(openers, GUARD).open().expect("both are up");
        let gateway = gateway_of(Monitor::new(design()), 0.05);
        Self { clock, buses, gateway, port, heard: Vec::new(), notes: Notes::default() }
    }

    fn turn(&mut self) {
        let turned = self.gateway.turn(&mut *self.port, Duration::ZERO, &mut self.notes);
        turned.expect("one of the buses is up");
    }

    /// Puts `frames` on their buses at their times; the gateway gets a turn every `rhythm`-th frame.
    fn run(&mut self, frames: &[Frame], rhythm: usize) {
        let open = |bus: &EmbeddedBus| bus.open_unrestricted(&Identifiers::All, 4096).ok();
        let mut machine = self.buses.each_ref().map(open);
        for (index, frame) in frames.iter().enumerate() {
            while frame.timestamp.since(self.clock.now()) > GUARD {
                self.clock.advance(GUARD);
                self.turn();
            }
            self.clock.set(frame.timestamp);
            if let Some(port) = &mut machine[frame.bus.index()] {
                // On a bus that is down nothing is sent.
                _ = port.send_unrestricted(frame);
            }
            if index % rhythm == 0 {
                self.turn();
            }
        }
        self.clock.advance(Span::from_seconds(0.021));
        self.turn();
        if let Some(ear) = &mut machine[0] {
            let heard = &mut self.heard;
            ear.receive(Duration::ZERO, &mut |frame| heard.push(frame.clone())).expect("up");
        }
    }
}

#[test]
fn live_on_two_buses_says_what_a_replay_of_their_frames_says() {
    let traffic = traffic();
    let (mut monitor, mut expected) = (Monitor::new(design()), Collected::default());
    traffic.iter().for_each(|frame| monitor.take(frame, &mut expected));
    assert!(!expected.warnings.is_empty() && expected.records.len() > 2000);
    for rhythm in [1, 3, 7, 61] {
        let mut bench = Bench::new();
        bench.run(&traffic, rhythm);
        let records = &bench.notes.records;
        assert!(expected.records.len() - records.len() <= 12, "rhythm {rhythm}: {}", records.len());
        assert!(*records == expected.records[..records.len()], "rhythm {rhythm}");
        let (live, replayed) = (wire(&bench.heard), wire(&expected.frames));
        assert!(!live.is_empty() && live == replayed[..live.len()], "rhythm {rhythm}");
    }
}

/// The buses are read one after the other: what came first may be read last.
#[test]
fn frames_are_sorted_across_the_buses_by_their_stamps() {
    let mut seeded = Seeded(3);
    let mut bench = Bench::new();
    let frames = traffic();
    let (mut begin, mut taken) = (0, Vec::new());
    let mut machine = bench
        .buses
        .each_ref()
        .map(|bus| bus.open_unrestricted(&Identifiers::All, 4096).expect("up"));
    while begin < 2000 {
        let end = begin + 1 + seeded.below(40) as usize;
        for frame in &frames[begin..end] {
            bench.clock.set(frame.timestamp);
            machine[frame.bus.index()].send_unrestricted(frame).expect("up");
        }
        begin = end;
        let port = &mut bench.port;
        port.receive(Duration::ZERO, &mut |frame| taken.push(frame.clone())).expect("up");
    }
    let key = |frame: &Frame| (frame.timestamp, frame.bus, frame.id);
    assert!(taken.len() > 1900, "{}", taken.len());
    assert!(taken.iter().map(key).eq(frames[..taken.len()].iter().map(key)));
}

#[test]
fn a_bus_that_is_lost_takes_only_its_own_with_it_and_is_opened_again() {
    for lost in [0, 1] {
        let frames: Vec<Frame> = traffic().into_iter().take(2000).collect();
        let mut bench = Bench::new();
        bench.run(&frames[..1000], 1);
        bench.buses[lost].set_state(BusState::Down);
        bench.notes = Notes::default();
        bench.run(&frames[1000..1500], 1);
        let is_lost = |it: &&Notice| matches!(it, Notice::Interruption { bus: Some(bus), .. } if bus.index() == lost);
        assert_eq!(bench.notes.notices.iter().filter(is_lost).count(), 1);
        let records = &bench.notes.records;
        let newest = records.iter().rev().find(|record| record.cylinder == 1).expect("cycles");
        let read = [newest.c1.is_some(), newest.c2.is_some()];
        assert_eq!(read, [lost != 0, lost != 1], "{newest:?}");
        bench.buses[lost].set_state(BusState::Up);
        bench.notes = Notes::default();
        let reopened = std::time::Instant::now();
        while bench.buses[lost].endpoints() == 0 {
            assert!(reopened.elapsed() < Duration::from_secs(10), "it is not opened again");
            bench.turn();
        }
        bench.run(&frames[1500..], 1);
        let newest = bench.notes.records.last().expect("cycles");
        assert!(newest.c1.is_some() && newest.c2.is_some(), "{newest:?}");
    }
}
