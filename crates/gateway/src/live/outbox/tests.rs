use super::*;
use tertius_core::alarm::detector::PLACES;
use tertius_core::alarm::status::Status;
use tertius_core::alarm::{Detector, Encoder, Finding, Level, OwnMessage, Register, Warning};
use tertius_core::blame::Rule;
use tertius_core::verdict::{Fault, Suspect};

const MS: i64 = 1_000_000;

fn at(ms: i64) -> Timestamp {
    Timestamp::from_nanos(ms * MS)
}

fn limits() -> OutboxLimits {
    // 13,500 bits a second: 100 frames, one every 10 ms.
    OutboxLimits {
        waiting: 4,
        estimates: 6,
        age: Span::from_seconds(0.05),
        bitrate: 270_000.0,
        share: 0.05,
        burst: 3,
    }
}

fn encoder() -> Encoder {
    Encoder::new(81).expect("81 is a node")
}

fn outbox() -> Outbox {
    Outbox::new(limits())
}

fn warning(encoder: &mut Encoder, ms: i64, cylinder: u8) -> OwnFrame {
    let finding = Finding {
        fault: Fault::Abrupt,
        suspect: Suspect::C1,
        rule: Rule::OneObserver,
        level: Level::Yellow,
        residual: Some(0.0),
        threshold: Some(0.0),
        evidence: None,
        device: None,
    };
    encoder.warning(at(ms), cylinder, Detector::Fde1, &finding, true)
}

#[test]
fn a_storm_keeps_to_its_share_of_the_bus() {
    let (mut outbox, mut encoder) = (outbox(), encoder());
    let mut sent = Vec::new();
    for ms in 0..2000 {
        outbox.put(warning(&mut encoder, ms, 1));
        while outbox.next(at(ms)).is_some() {
            outbox.sent();
            sent.push(ms);
        }
    }
    assert!(sent.len() <= 2 + 200 && sent.len() >= 199, "{}", sent.len());
    for (from, to) in sent.iter().zip(&sent[12..]) {
        assert!(to - from >= 99, "never more than the burst beyond 10 frames in 100 ms");
    }
    assert!(outbox.counts().crowded_out > 1700);
}

#[test]
fn a_status_is_not_displaced_by_warnings() {
    let (mut outbox, mut encoder) = (outbox(), encoder());
    (0..9).for_each(|_| outbox.put(warning(&mut encoder, 0, 1)));
    outbox.put(encoder.status(at(0), &Status::default()));
    let first = outbox.next(at(0)).expect("there is credit").as_frame().id.value();
    assert_eq!(first, 0x1D1);
}

#[test]
fn frames_go_out_in_the_order_in_which_they_came_to_be() {
    let mut encoder = encoder();
    let mut outbox = Outbox::new(OutboxLimits { burst: 9, ..limits() });
    outbox.put(warning(&mut encoder, 0, 1));
    outbox.put(encoder.status(at(0), &Status::default()));
    outbox.put(warning(&mut encoder, 0, 2));
    let mut ids = Vec::new();
    while let Some(frame) = outbox.next(at(0)) {
        ids.push(frame.as_frame().id.value());
        outbox.sent();
    }
    assert_eq!(ids, [0x2D1, 0x1D1, 0x2D1]);
}

#[test]
fn estimates_come_after_all_others_and_the_newest_of_each_cylinder_remain() {
    let mut encoder = encoder();
    let mut outbox = Outbox::new(OutboxLimits { burst: 9, ..limits() });
    for cycle in 0..3 {
        for cylinder in 1..=6 {
            outbox.put(encoder.estimate(at(cycle * 20), cylinder, None));
        }
    }
    outbox.put(warning(&mut encoder, 40, 1));
    outbox.put(encoder.status(at(40), &Status::default()));
    let mut sent = Vec::new();
    while let Some(frame) = outbox.next(at(40)) {
        let frame = frame.as_frame();
        sent.push((frame.id.value(), frame.data()[2], frame.timestamp));
        outbox.sent();
    }
    let estimates = (12..18).map(|counter| (0x3D1, counter, at(40)));
    let expected = [(0x2D1, 0, at(40)), (0x1D1, 0, at(40))].into_iter().chain(estimates);
    assert!(sent.iter().copied().eq(expected), "{sent:?}");
    assert_eq!((outbox.counts().outdated, outbox.counts().superseded), (12, 0));
}

/// 300 estimates a second, with 100 frames that may be sent at once.
#[test]
fn estimates_keep_to_the_share_and_leave_room_for_a_warning_at_any_time() {
    let (mut outbox, mut encoder) = (outbox(), encoder());
    outbox.limits = OutboxLimits { burst: 20, ..outbox.limits };
    let (mut estimates, mut warnings) = (0, 0);
    for ms in 0..2000 {
        if ms % 20 == 0 {
            (1..=6).for_each(|n| outbox.put(encoder.estimate(at(ms), n, None)));
        }
        let warns = ms % 500 == 499;
        if warns {
            (0..4).for_each(|_| outbox.put(warning(&mut encoder, ms, 1)));
        }
        let before = warnings;
        while let Some(frame) = outbox.next(at(ms)) {
            (estimates, warnings) = match frame.message() == Some(OwnMessage::Estimate) {
                true => (estimates + 1, warnings),
                false => (estimates, warnings + 1),
            };
            outbox.sent();
        }
        assert_eq!(warnings - before, if warns { 4 } else { 0 }, "at once, at {ms}");
    }
    assert!((190..=200 + 20).contains(&(estimates + warnings)), "{estimates} {warnings}");
}

/// Every warning that can stand is raised in one cycle, with a status, after the estimates of two.
#[test]
fn every_place_at_once_goes_out_at_once() {
    let (waiting, burst) = (OutboxLimits::WAITING, OutboxLimits::BURST);
    let mut outbox = Outbox::new(OutboxLimits { waiting, burst, ..limits() });
    let (mut encoder, mut register) = (encoder(), Register::new(MAX_CYLINDERS));
    let finding = Finding {
        fault: Fault::Abrupt,
        suspect: Suspect::C1,
        rule: Rule::OneObserver,
        level: Level::Yellow,
        residual: None,
        threshold: None,
        evidence: None,
        device: None,
    };
    let estimate = |outbox: &mut Outbox, encoder: &mut Encoder, ms| {
        for n in 1..=MAX_CYLINDERS as u8 {
            outbox.put(encoder.estimate(at(ms), n, None));
        }
    };
    let drain = |outbox: &mut Outbox| {
        while outbox.next(at(0)).is_some() {
            outbox.sent();
        }
        assert_eq!(outbox.waiting(), 0);
    };
    for _ in 0..2 {
        estimate(&mut outbox, &mut encoder, 0);
        drain(&mut outbox);
    }
    for index in 0..MAX_CYLINDERS {
        register.update(at(0), index, &[Some(finding); PLACES], |warning| {
            let Warning { cylinder, detector, finding, .. } = warning;
            outbox.put(encoder.warning(at(0), cylinder, detector, &finding, true));
        });
    }
    outbox.put(encoder.status(at(0), &Status::default()));
    drain(&mut outbox);
    let sent = outbox.counts().sent;
    assert_eq!(sent, u64::from(register.standing()) + 1 + 2 * MAX_CYLINDERS as u64);

    // All are cleared and raised again before one could go out.
    for raised in [false, true] {
        for index in 0..MAX_CYLINDERS {
            let found = [raised.then_some(finding); PLACES];
            register.update(at(20), index, &found, |warning| {
                let Warning { cylinder, detector, finding, .. } = warning;
                outbox.put(encoder.warning(at(20), cylinder, detector, &finding, raised));
            });
        }
    }
    estimate(&mut outbox, &mut encoder, 20);
    outbox.put(encoder.status(at(20), &Status::default()));
    assert_eq!(outbox.waiting(), 2 * register.standing() as usize + 1 + MAX_CYLINDERS);
    assert_eq!(*outbox.counts(), OutboxCounts { sent, ..OutboxCounts::default() });
}

#[test]
fn the_stopping_status_goes_out_without_credit_and_is_the_last() {
    let (mut outbox, mut encoder) = (outbox(), encoder());
    (0..4).for_each(|_| outbox.put(warning(&mut encoder, 0, 1)));
    while outbox.next(at(0)).is_some() {
        outbox.sent();
    }
    assert_eq!(outbox.waiting(), 2, "the limit holds them back");
    outbox.close(encoder.status(at(0), &Status::default()));
    // However long the bus is jammed, they stay true.
    let last = outbox.next(at(0)).expect("a place is kept for them").as_frame().clone();
    assert_eq!(last.id.value(), 0x1D1);
    outbox.sent();
    outbox.put(encoder.status(at(1), &Status::default()));
    assert_eq!((outbox.waiting(), outbox.next(at(1000))), (0, None));
    assert_eq!((outbox.counts().sent, outbox.counts().crowded_out), (3, 2));
}

#[test]
fn what_is_too_old_is_never_sent() {
    let (mut outbox, mut encoder) = (outbox(), encoder());
    outbox.put(warning(&mut encoder, 0, 1));
    outbox.put(encoder.status(at(0), &Status::default()));
    outbox.put(warning(&mut encoder, 30, 2));
    let next = outbox.next(at(51)).expect("the newest is young enough");
    assert_eq!(next.as_frame().timestamp, at(30));
    assert_eq!(outbox.counts().too_old, 2);
    assert!(outbox.next(at(81)).is_none());
}

#[test]
fn a_clock_that_was_set_back_gives_no_credit() {
    let (mut outbox, mut encoder) = (outbox(), encoder());
    let mut send = |outbox: &mut Outbox, ms| {
        outbox.put(warning(&mut encoder, ms, 1));
        let may = outbox.next(at(ms)).is_some();
        if may {
            outbox.sent();
        }
        may
    };
    assert!(send(&mut outbox, 1_000_000));
    assert!(send(&mut outbox, 1_000_000));
    for _ in 0..100 {
        assert!(!send(&mut outbox, 5), "the burst is used up");
    }
    assert!(send(&mut outbox, 15), "and it goes on from the new time");
}

/// Of the CANopen services none delays a warning, whatever order they came in.
#[test]
fn services_come_after_warnings_and_answers_leave_the_burst_to_them() {
    let mut encoder = encoder();
    let services = tertius_core::alarm::ServiceEncoder::new(81).expect("81 is a node");
    let burst = 20;
    let mut outbox = Outbox::new(OutboxLimits { burst, ..limits() });
    outbox.put(services.answer(at(0), [1; 8]));
    outbox.put(services.answer(at(0), [2; 8]));
    outbox.put(services.heartbeat(at(0), 5));
    outbox.put(services.emergency(at(0), [3; 8]));
    (0..2).for_each(|_| outbox.put(encoder.estimate(at(0), 1, None)));
    outbox.put(warning(&mut encoder, 0, 1));
    outbox.put(encoder.status(at(0), &Status::default()));
    let mut sent = Vec::new();
    while let Some(frame) = outbox.next(at(0)) {
        sent.push((frame.as_frame().id.value(), frame.as_frame().data()[0]));
        outbox.sent();
    }
    let ids: Vec<u32> = sent.iter().map(|(id, _)| *id).collect();
    assert_eq!(ids, [0x2D1, 0x1D1, 0x0D1, 0x751, 0x5D1, 0x3D1, 0x3D1]);
    assert_eq!(sent[4].1, 2, "the newest answer");

    // Who asks without end leaves a burst of eight; two frames of it are always kept from reports.
    let asked = (0..100).filter(|_| {
        outbox.put(services.answer(at(0), [0; 8]));
        let may = outbox.next(at(0)).is_some();
        if may {
            outbox.sent();
        }
        may
    });
    assert_eq!(asked.count(), 20 - 7 - 8);
    for _ in 0..9 {
        outbox.put(services.emergency(at(0), [0; 8]));
        outbox.next(at(0)).is_some().then(|| outbox.sent());
    }
    assert!(outbox.next(at(0)).is_none());
    outbox.put(warning(&mut encoder, 0, 1));
    assert_eq!(outbox.next(at(0)).and_then(OwnFrame::message), Some(OwnMessage::Warning));

    // Old answers and emergency messages are dropped, and a heartbeat stays true.
    outbox.clear();
    outbox.put(services.answer(at(0), [1; 8]));
    outbox.put(services.emergency(at(0), [3; 8]));
    outbox.put(services.heartbeat(at(0), 5));
    let next = outbox.next(at(1000)).expect("the heartbeat").as_frame().id.value();
    assert_eq!((next, outbox.waiting()), (0x751, 1));
    outbox.close(encoder.status(at(1000), &Status::default()));
    assert_eq!(outbox.waiting(), 1, "nothing follows the stopping status");
}

#[test]
fn pdos_that_wait_are_dropped_and_services_are_not() {
    let (mut outbox, mut encoder) = (outbox(), encoder());
    let services = tertius_core::alarm::ServiceEncoder::new(81).expect("81 is a node");
    outbox.put(warning(&mut encoder, 0, 1));
    outbox.put(encoder.status(at(0), &Status::default()));
    outbox.put(encoder.estimate(at(0), 1, None));
    outbox.put(services.heartbeat(at(0), 4));
    outbox.drop_pdos();
    assert_eq!(outbox.waiting(), 1);
    assert_eq!(outbox.next(at(0)).map(|frame| frame.as_frame().data().to_vec()), Some(vec![4]));
}
