//! The embedded bus against what a real one does.

use std::time::{Duration, Instant};

use tertius::alarm::Encoder;
use tertius::alarm::status::Status;
use tertius::bus::embedded::{BusState, Clock, EmbeddedBus, ManualClock};
use tertius::bus::{Identifiers, Port, PortError, Sent, UnrestrictedPort};
use tertius::frame::{Frame, Id, Kind};
use tertius::time::{Span, Timestamp};

const SECOND: i64 = 1_000_000_000;
const START: Timestamp = Timestamp::from_nanos(1_700_000_000 * SECOND);

fn standard(id: u32) -> Id {
    Id::standard(id).unwrap()
}

fn frame(id: Id, kind: Kind, data: &[u8]) -> Frame {
    Frame::new(Timestamp::default(), id, kind, data)
}

fn data(id: u32, byte: u8) -> Frame {
    frame(standard(id), Kind::Data, &[byte])
}

fn manual() -> (EmbeddedBus, ManualClock) {
    let clock = ManualClock::new(START);
    (EmbeddedBus::new(Clock::Manual(clock.clone())), clock)
}

/// One call's frames and what it said of the queue.
fn take(port: &mut impl Port) -> (Vec<Frame>, Option<Timestamp>) {
    let mut frames = Vec::new();
    // Patience that would hang the test if it were waited for on a clock that stands.
    let received =
        port.receive(Duration::from_secs(3600), &mut |frame| frames.push(frame.clone())).unwrap();
    assert_eq!(received.frames, frames.len());
    (frames, received.drained_at)
}

fn stamped(at: Timestamp, mut frame: Frame) -> Frame {
    frame.timestamp = at;
    frame
}

#[test]
fn each_endpoint_gets_what_the_others_send_in_order_and_on_the_buss_clock() {
    let (bus, clock) = manual();
    let mut machine = bus.open_unrestricted(&Identifiers::All, 10).unwrap();
    let mut simulator = bus.open_unrestricted(&Identifiers::All, 10).unwrap();
    let mut gateway = bus.open(&Identifiers::All, 10).unwrap();
    let later = START.after(Span::from_nanos(20_000_000));
    let status = Encoder::new(81).unwrap().status(Timestamp::default(), &Status::default());

    assert_eq!(machine.send_unrestricted(&data(0x181, 1)).unwrap(), Sent::Taken);
    clock.set(later);
    assert_eq!(gateway.send(&status).unwrap(), Sent::Taken);
    simulator.send_unrestricted(&data(0x191, 2)).unwrap();

    let first = stamped(START, data(0x181, 1));
    let second = stamped(later, status.as_frame().clone());
    let third = stamped(later, data(0x191, 2));
    assert_eq!(take(&mut gateway), (vec![first.clone(), third.clone()], Some(later)));
    assert_eq!(take(&mut machine), (vec![second.clone(), third], Some(later)));
    assert_eq!(take(&mut simulator), (vec![first, second], Some(later)));
    assert_eq!(take(&mut gateway), (vec![], Some(later)));
    assert_eq!((gateway.counts().sent, gateway.counts().received), (1, 2));
}

#[test]
fn only_data_frames_of_the_named_identifiers_and_error_frames_pass() {
    let (bus, _) = manual();
    let mut machine = bus.open_unrestricted(&Identifiers::All, 10).unwrap();
    let named = Identifiers::Only(vec![standard(0x181)]);
    let mut gateway = bus.open(&named, 10).unwrap();
    let wanted = [
        frame(standard(0x181), Kind::Data, &[1]),
        frame(standard(0x181), Kind::Fd { flags: 1 }, &[2; 64]),
        frame(Id::extended(0x40).unwrap(), Kind::Error, &[0; 8]),
    ];
    let other = [
        frame(standard(0x182), Kind::Data, &[1]),
        frame(Id::extended(0x181).unwrap(), Kind::Data, &[1]),
        frame(standard(0x181), Kind::Remote { length: 1 }, &[]),
    ];
    for (wanted, other) in wanted.iter().zip(&other) {
        machine.send_unrestricted(other).unwrap();
        machine.send_unrestricted(wanted).unwrap();
    }
    assert_eq!(take(&mut gateway).0, wanted.map(|frame| stamped(START, frame)));
    assert_eq!(gateway.counts().error_frames, 1);
}

#[test]
fn what_the_queue_does_not_hold_is_dropped_and_counted() {
    let (bus, _) = manual();
    let mut machine = bus.open_unrestricted(&Identifiers::All, 1).unwrap();
    let mut gateway = bus.open(&Identifiers::All, 3).unwrap();
    for n in 0..8 {
        machine.send_unrestricted(&data(0x181, n)).unwrap();
    }
    assert_eq!(gateway.counts().dropped, 5);
    let kept: Vec<u8> = take(&mut gateway).0.iter().map(|frame| frame.data()[0]).collect();
    assert_eq!(kept, [0, 1, 2]);
    machine.send_unrestricted(&data(0x181, 9)).unwrap();
    assert_eq!(take(&mut gateway).0.len(), 1);
    assert_eq!(machine.counts().dropped, 0);
}

#[test]
fn one_call_takes_a_bounded_number() {
    let (bus, _) = manual();
    let mut machine = bus.open_unrestricted(&Identifiers::All, 1).unwrap();
    let mut gateway = bus.open(&Identifiers::All, 1000).unwrap();
    for _ in 0..300 {
        machine.send_unrestricted(&data(0x181, 1)).unwrap();
    }
    let (frames, drained_at) = take(&mut gateway);
    assert_eq!((frames.len(), drained_at), (256, None));
    let (frames, drained_at) = take(&mut gateway);
    assert_eq!((frames.len(), drained_at), (44, Some(START)));
    assert_eq!((gateway.counts().batches, gateway.counts().largest_batch), (2, 256));
}

#[test]
fn who_takes_a_frame_may_answer_it() {
    let (bus, _) = manual();
    let mut machine = bus.open_unrestricted(&Identifiers::All, 10).unwrap();
    let mut gateway = bus.open(&Identifiers::All, 10).unwrap();
    let mut other = bus.open_unrestricted(&Identifiers::All, 10).unwrap();
    machine.send_unrestricted(&data(0x181, 1)).unwrap();
    gateway
        .receive(Duration::ZERO, &mut |frame| {
            if frame.data() == [1] {
                other.send_unrestricted(&data(0x181, 2)).unwrap();
            }
        })
        .unwrap();
    assert_eq!(take(&mut machine).0, [stamped(START, data(0x181, 2))]);
}

#[test]
fn a_jammed_bus_takes_nothing_and_keeps_nothing() {
    let (bus, _) = manual();
    let mut machine = bus.open_unrestricted(&Identifiers::All, 10).unwrap();
    let mut gateway = bus.open(&Identifiers::All, 10).unwrap();
    bus.set_state(BusState::Jammed);
    assert_eq!(machine.send_unrestricted(&data(0x181, 1)).unwrap(), Sent::Full);
    assert_eq!((machine.counts().sent, machine.counts().refused), (0, 1));
    bus.set_state(BusState::Up);
    assert_eq!(machine.send_unrestricted(&data(0x181, 2)).unwrap(), Sent::Taken);
    assert_eq!(take(&mut gateway).0, [stamped(START, data(0x181, 2))]);
}

#[test]
fn an_endpoint_that_saw_the_bus_go_has_to_be_opened_anew() {
    for (state, expected) in [(BusState::Down, "down"), (BusState::Gone, "gone")] {
        let ended = |error: PortError| {
            assert!(error.to_string().contains(expected), "{error}");
        };
        let (bus, _) = manual();
        let mut machine = bus.open_unrestricted(&Identifiers::All, 10).unwrap();
        let mut gateway = bus.open(&Identifiers::All, 10).unwrap();
        machine.send_unrestricted(&data(0x181, 1)).unwrap();
        bus.set_state(state);
        ended(bus.open(&Identifiers::All, 10).err().unwrap());
        ended(machine.send_unrestricted(&data(0x181, 2)).unwrap_err());
        // What had come before is given first, and nothing is said of what was missed.
        assert_eq!(take(&mut gateway), (vec![stamped(START, data(0x181, 1))], None));
        bus.set_state(BusState::Up);
        ended(gateway.receive(Duration::ZERO, &mut |_| {}).unwrap_err());
        ended(machine.send_unrestricted(&data(0x181, 3)).unwrap_err());

        let mut machine = bus.open_unrestricted(&Identifiers::All, 10).unwrap();
        let mut gateway = bus.open(&Identifiers::All, 10).unwrap();
        machine.send_unrestricted(&data(0x181, 4)).unwrap();
        assert_eq!(take(&mut gateway).0, [stamped(START, data(0x181, 4))]);
    }
}

#[test]
fn an_endpoint_that_left_leaves_nothing_behind() {
    let (bus, _) = manual();
    let machine = bus.open_unrestricted(&Identifiers::All, 10).unwrap();
    for _ in 0..100 {
        drop(bus.open(&Identifiers::All, 10).unwrap());
    }
    assert_eq!(bus.endpoints(), 1);
    drop(machine);
    assert_eq!(bus.endpoints(), 0);
}

#[test]
fn a_frame_that_no_bus_carries_is_refused() {
    let (bus, _) = manual();
    let mut machine = bus.open_unrestricted(&Identifiers::All, 10).unwrap();
    let long = frame(standard(1), Kind::Data, &[0; 9]);
    assert!(matches!(machine.send_unrestricted(&long), Err(PortError::Io(_))));
}

#[test]
fn on_the_systems_clock_a_frame_ends_the_waiting_and_so_does_the_buss_end() {
    let bus = EmbeddedBus::new(Clock::System);
    let mut machine = bus.open_unrestricted(&Identifiers::All, 10).unwrap();
    let mut gateway = bus.open(&Identifiers::All, 10).unwrap();

    let (before, started) = (bus.now(), Instant::now());
    let patience = Duration::from_millis(20);
    let received = gateway.receive(patience, &mut |_| {}).unwrap();
    assert!(started.elapsed() >= patience && received.frames == 0);
    assert!(received.drained_at.unwrap() > before);

    let (ready, go) = std::sync::mpsc::channel();
    let waiting = std::thread::spawn(move || {
        ready.send(()).unwrap();
        let first = gateway.receive(Duration::from_secs(3600), &mut |_| {}).unwrap();
        ready.send(()).unwrap();
        (first.frames, gateway.receive(Duration::from_secs(3600), &mut |_| {}))
    });
    go.recv().unwrap();
    machine.send_unrestricted(&data(0x181, 1)).unwrap();
    go.recv().unwrap();
    bus.set_state(BusState::Gone);
    let (frames, end) = waiting.join().unwrap();
    assert_eq!(frames, 1);
    assert!(matches!(end, Err(PortError::Gone)));
}
