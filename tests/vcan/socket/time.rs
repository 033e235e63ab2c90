//! Time stamps, and how late the port says it is.

use std::time::{Duration, Instant};

use tertius::bus::{Port, Stamps};
use tertius::time::{Span, Timestamp};

use super::traffic::{clock, number, numbered, receive, send, standard};
use super::vcan::Vcan;

#[test]
fn stamps_are_in_order_and_between_sending_and_receiving() {
    let vcan = Vcan::new("t-stamps");
    let mut gateway = vcan.open_all();
    let mut machine = vcan.machine();
    let mut sending = Vec::new();
    for n in 0..500 {
        let before = clock();
        send(&mut machine, &numbered(standard(0x181), n));
        sending.push((before, clock()));
    }
    let came = receive(&mut gateway, 500);
    // Stamps are in whole microseconds.
    let tick = Span::from_nanos(-1000);
    for (frame, (before, after)) in came.iter().zip(sending) {
        let before = before.after(tick);
        assert!((before..=after).contains(&frame.timestamp), "{before:?} {frame:?} {after:?}");
    }
    assert!(came.is_sorted_by_key(|frame| frame.timestamp));
    assert_eq!(gateway.stamps(), Stamps::Software);
    assert_eq!(gateway.counts().unstamped, 0);
}

#[test]
fn nothing_stamped_before_the_drain_comes_after_it() {
    const FRAMES: u32 = 20_000;
    // On its way from the driver to the queue.
    let guard = Span::from_nanos(-5_000_000);
    let vcan = Vcan::new("t-drain");
    let mut gateway = vcan.open_all();
    let mut machine = vcan.machine();
    let sender = std::thread::spawn(move || {
        for n in 0..FRAMES {
            send(&mut machine, &numbered(standard(0x181), n));
        }
    });
    let mut drained_at = Timestamp::from_nanos(0);
    let (mut next, mut drains) = (0, 0);
    while next < FRAMES {
        let received = gateway.receive(Duration::from_secs(10), &mut |frame| {
            assert_eq!(number(frame), next);
            assert!(frame.timestamp >= drained_at.after(guard), "{frame:?} after {drained_at:?}");
            next += 1;
        });
        if let Some(at) = received.unwrap().drained_at {
            assert!(at >= drained_at && at <= clock());
            (drained_at, drains) = (at, drains + 1);
        }
    }
    sender.join().unwrap();
    assert!(drains > 1, "the queue was never seen empty");
}

#[test]
fn a_quiet_bus_is_waited_for_and_no_longer() {
    let patience = Duration::from_millis(30);
    let vcan = Vcan::new("t-quiet");
    let mut gateway = vcan.open_all();
    let (before, started) = (clock(), Instant::now());
    let received = gateway.receive(patience, &mut |frame| panic!("{frame:?}")).unwrap();
    assert!(started.elapsed() >= patience);
    assert_eq!(received.frames, 0);
    // As late as the end of the wait, though nothing came.
    let waited = Span::from_nanos(patience.as_nanos() as i64);
    assert!(received.drained_at.unwrap() >= before.after(waited));

    let mut machine = vcan.machine();
    let sender = std::thread::spawn(move || {
        std::thread::sleep(Duration::from_millis(20));
        send(&mut machine, &numbered(standard(0x181), 1));
    });
    let started = Instant::now();
    let received = gateway.receive(Duration::from_secs(60), &mut |_| {}).unwrap();
    assert_eq!(received.frames, 1);
    assert!(started.elapsed() < Duration::from_secs(30));
    sender.join().unwrap();
}

#[test]
fn no_patience_is_no_wait_and_much_is_no_error() {
    let vcan = Vcan::new("t-zero");
    // What the eldest has, all have: the kernel serves the youngest first.
    let mut eldest = vcan.open_all();
    let mut gateway = vcan.open_all();
    let mut machine = vcan.machine();
    assert_eq!(gateway.receive(Duration::ZERO, &mut |_| {}).unwrap().frames, 0);
    for patience in [Duration::ZERO, Duration::MAX] {
        send(&mut machine, &numbered(standard(0x181), 1));
        receive(&mut eldest, 1);
        assert_eq!(gateway.receive(patience, &mut |_| {}).unwrap().frames, 1);
    }
}
