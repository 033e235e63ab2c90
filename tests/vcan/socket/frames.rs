//! What passes, and how it arrives.

use tertius::alarm::Encoder;
use tertius::alarm::status::Status;
use tertius::bus::socket::Options;
use tertius::bus::{Identifiers, Port, PortError, Sent, UnrestrictedPort};
use tertius::frame::{Frame, Kind};
use tertius::time::Timestamp;

use super::traffic::{extended, frame, receive, receive_until, send, standard, unstamped};
use super::vcan::Vcan;

fn only(identifiers: Vec<tertius::frame::Id>) -> Options {
    Options { identifiers: Identifiers::Only(identifiers), ..Options::default() }
}

#[test]
fn only_data_frames_of_the_named_identifiers_pass() {
    let vcan = Vcan::new("t-filter");
    let named = vec![standard(0x181), extended(0x181), extended(0x1FFF_FFFF), standard(0x7FE)];
    let mut gateway = vcan.open(&only(named));
    let mut machine = vcan.machine();
    for id in 0..=0x7FE {
        send(&mut machine, &frame(standard(id), Kind::Data, &[1]));
    }
    for id in [0, 0x180, 0x181, 0x182, 0x7FE, 0x800, 0x40_0181, 0x1FFF_FFFE, 0x1FFF_FFFF] {
        send(&mut machine, &frame(extended(id), Kind::Data, &[2]));
    }
    for id in [standard(0x181), standard(0x182), extended(0x181), extended(0x182)] {
        send(&mut machine, &frame(id, Kind::Fd { flags: 1 }, &[3; 16]));
        send(&mut machine, &frame(id, Kind::Remote { length: 4 }, &[]));
    }
    let last = frame(standard(0x7FE), Kind::Data, &[4]);
    send(&mut machine, &last);

    let came = receive_until(&mut gateway, |frames| {
        frames.last().is_some_and(|frame| frame.data() == last.data())
    });
    let expected = vec![
        frame(standard(0x181), Kind::Data, &[1]),
        frame(standard(0x7FE), Kind::Data, &[1]),
        frame(extended(0x181), Kind::Data, &[2]),
        frame(extended(0x1FFF_FFFF), Kind::Data, &[2]),
        frame(standard(0x181), Kind::Fd { flags: 1 }, &[3; 16]),
        frame(extended(0x181), Kind::Fd { flags: 1 }, &[3; 16]),
        last,
    ];
    assert_eq!(unstamped(came), expected);
}

#[test]
fn error_frames_always_pass() {
    let vcan = Vcan::new("t-errors");
    let mut gateway = vcan.open(&only(Vec::new()));
    let mut machine = vcan.machine();
    // CAN_ERR_BUSOFF, then CAN_ERR_CRTL as error-passive with its counters.
    let errors = vec![
        frame(extended(0x40), Kind::Error, &[0; 8]),
        frame(extended(0x204), Kind::Error, &[0, 0x20, 0, 0, 0, 0, 128, 0]),
    ];
    send(&mut machine, &frame(standard(0x40), Kind::Data, &[0; 8]));
    for error in &errors {
        send(&mut machine, error);
    }
    assert_eq!(unstamped(receive(&mut gateway, 2)), errors);
    assert_eq!((gateway.counts().received, gateway.counts().error_frames), (2, 2));
}

#[test]
fn every_kind_of_frame_arrives_as_it_was_sent() {
    let vcan = Vcan::new("t-kinds");
    let mut gateway = vcan.open_all();
    let mut machine = vcan.machine();
    let bytes: Vec<u8> = (1..=64).collect();
    let mut sent: Vec<Frame> = [0, 1, 8, 12, 16, 20, 24, 32, 48, 64]
        .map(|length| frame(extended(length as u32), Kind::Fd { flags: 0 }, &bytes[..length]))
        .into();
    sent.extend((0..=8).map(|n| frame(standard(0x100), Kind::Data, &bytes[..n])));
    sent.extend((0..=8).map(|length| frame(standard(0x200), Kind::Remote { length }, &[])));
    sent.extend((0..=3).map(|flags| frame(standard(0x300), Kind::Fd { flags }, &[1, 2])));
    sent.push(frame(extended(0x1FFF_FFFF), Kind::Data, &bytes[..8]));
    for frame in &sent {
        send(&mut machine, frame);
    }
    assert_eq!(unstamped(receive(&mut gateway, sent.len())), sent);
    assert_eq!(gateway.counts().malformed, 0);
}

#[test]
fn own_frames_are_heard_by_others_and_not_by_oneself() {
    let vcan = Vcan::new("t-own");
    let mut gateway = vcan.open_all();
    let mut listener = vcan.open_all();
    let mut machine = vcan.machine();
    let status = Encoder::new(81).unwrap().status(Timestamp::from_nanos(7), &Status::default());
    assert_eq!(gateway.send(&status).unwrap(), Sent::Taken);
    let after = frame(standard(0x80), Kind::Data, &[]);
    send(&mut machine, &after);

    let heard = unstamped(receive(&mut listener, 2));
    assert_eq!(heard, [unstamped(vec![status.as_frame().clone()]), vec![after.clone()]].concat());
    assert_eq!(unstamped(receive(&mut gateway, 1)), [after]);
    assert_eq!(gateway.counts().sent, 1);
}

#[test]
fn a_frame_that_no_bus_carries_is_refused_and_the_port_goes_on() {
    let vcan = Vcan::new("t-refuse");
    let mut machine = vcan.machine();
    let long = frame(standard(1), Kind::Fd { flags: 0 }, &[0; 63]);
    assert!(matches!(machine.send_unrestricted(&long), Err(PortError::Io(_))));
    let right = frame(standard(1), Kind::Fd { flags: 0 }, &[0; 64]);
    assert_eq!(machine.send_unrestricted(&right).unwrap(), Sent::Taken);
}
