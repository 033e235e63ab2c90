//! Interfaces that go and come.

use std::time::Duration;

use tertius::bus::socket::{OpenError, Options, SocketPort};
use tertius::bus::{Identifiers, Port, PortError, UnrestrictedPort};

use super::traffic::{number, numbered, receive, receive_end, send, standard};
use super::vcan::Vcan;

#[test]
fn after_down_and_up_an_opening_works_again() {
    let vcan = Vcan::new("t-down");
    let mut gateway = vcan.open_all();
    let mut machine = vcan.machine();
    for n in 0..100 {
        send(&mut machine, &numbered(standard(0x181), n));
    }
    vcan.down();

    let opened = SocketPort::open("t-down", &Options::default());
    assert!(matches!(&opened, Err(error @ OpenError::Down { .. }) if error.may_pass()));
    let sent = machine.send_unrestricted(&numbered(standard(0x181), 1000));
    assert!(matches!(sent, Err(PortError::Down)), "{sent:?}");
    // What had come before is given first.
    let (came, end) = receive_end(&mut gateway);
    assert!(came.iter().map(number).eq(0..100), "{} frames", came.len());
    assert!(matches!(end, PortError::Down));

    vcan.up();
    let again = gateway.receive(Duration::from_millis(1), &mut |_| {});
    assert!(matches!(again, Err(PortError::Down)), "a port that ended stays so: {again:?}");
    let sent = machine.send_unrestricted(&numbered(standard(0x181), 1001));
    assert!(matches!(sent, Err(PortError::Down)), "{sent:?}");

    let (mut gateway, mut machine) = (vcan.open_all(), vcan.machine());
    send(&mut machine, &numbered(standard(0x181), 1002));
    let came: Vec<u32> = receive(&mut gateway, 1).iter().map(number).collect();
    assert_eq!(came, [1002], "what was refused before must not come now");
}

#[test]
fn an_interface_created_anew_is_found_by_its_name() {
    let vcan = Vcan::new("t-gone");
    let mut gateway = vcan.open_all();
    let mut machine = vcan.machine();
    let first = gateway.index();
    send(&mut machine, &numbered(standard(0x181), 1));
    vcan.delete();

    let (came, end) = receive_end(&mut gateway);
    assert_eq!(came.len(), 1);
    // An interface is brought down before it is deleted, and whoever asks in between is told so.
    assert!(matches!(end, PortError::Gone | PortError::Down), "{end:?}");
    let sent = machine.send_unrestricted(&numbered(standard(0x181), 2));
    assert!(matches!(sent, Err(PortError::Gone)), "{sent:?}");
    let opened = SocketPort::open("t-gone", &Options::default());
    assert!(matches!(&opened, Err(error @ OpenError::NoInterface { .. }) if error.may_pass()));

    vcan.create();
    let (mut gateway, mut machine) = (vcan.open_all(), vcan.machine());
    assert_ne!(gateway.index(), first);
    send(&mut machine, &numbered(standard(0x181), 3));
    assert_eq!(number(&receive(&mut gateway, 1)[0]), 3);
}

#[test]
fn a_waiting_port_hears_of_the_end_at_once() {
    let vcan = Vcan::new("t-wait");
    let mut gateway = vcan.open_all();
    std::thread::scope(|threads| {
        let waiting =
            threads.spawn(move || gateway.receive(Duration::from_secs(3600), &mut |_| {}));
        std::thread::sleep(Duration::from_millis(20));
        vcan.delete();
        let ended = waiting.join().unwrap();
        assert!(matches!(ended, Err(PortError::Gone | PortError::Down)), "{ended:?}");
    });
}

#[test]
fn what_cannot_be_opened_says_why() {
    let opened = SocketPort::open("lo", &Options::default());
    assert!(matches!(&opened, Err(error @ OpenError::NotCan { .. }) if !error.may_pass()));
    let vcan = Vcan::new("t-many");
    let ids = |count| Identifiers::Only((0..count).map(standard).collect());
    let options = |count| Options { identifiers: ids(count), ..Options::default() };
    vcan.open(&options(512));
    let opened = SocketPort::open("t-many", &options(513));
    assert!(matches!(opened, Err(OpenError::TooManyIdentifiers { count: 513, .. })));
}

#[test]
fn the_description_says_what_was_got() {
    let vcan = Vcan::new("t-describe");
    let options = Options {
        identifiers: Identifiers::Only(vec![standard(1), standard(1), standard(2)]),
        ..Options::default()
    };
    let said = vcan.open(&options).description();
    for part in ["t-describe", "2 identifiers", "software", "1.00 s of a full bus", "1000 kbit/s"] {
        assert!(said.contains(part), "{part} is not in: {said}");
    }
    let small = Options { receive_buffer: Some(64 * 1024), ..Options::default() };
    let said = vcan.open(&small).description();
    assert!(said.contains("64 KiB") && said.contains("rmem_max"), "{said}");
}
