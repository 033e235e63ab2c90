//! The port over a controller.

use std::process::Command;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use tertius::bus::socket::{ControllerState, LinkState, OpenError, Options, SocketPort};
use tertius::bus::{Port, PortError, Sent, Unrestricted, UnrestrictedPort};
use tertius::frame::{Frame, Id, Kind};
use tertius::time::Timestamp;

/// There is one bus for all tests.
static BUS: Mutex<()> = Mutex::new(());

pub fn the_bus() -> MutexGuard<'static, ()> {
    BUS.lock().unwrap_or_else(PoisonError::into_inner)
}

fn ip(arguments: &[&str]) {
    assert!(Command::new("ip").args(arguments).status().unwrap().success(), "ip {arguments:?}");
}

fn machine() -> Unrestricted<SocketPort> {
    Unrestricted::<SocketPort>::open("can0", &Options::default()).unwrap()
}

fn gateway() -> SocketPort {
    SocketPort::open("can1", &Options::default()).unwrap()
}

fn data(byte: u8) -> Frame {
    Frame::new(Timestamp::default(), Id::standard(0x181).unwrap(), Kind::Data, &[byte; 8])
}

fn receive(port: &mut impl Port, count: usize) -> Vec<Frame> {
    let started = Instant::now();
    let mut frames: Vec<Frame> = Vec::new();
    while frames.len() < count {
        assert!(started.elapsed() < Duration::from_secs(10), "only {} frames came", frames.len());
        port.receive(Duration::from_millis(100), &mut |frame| frames.push(frame.clone())).unwrap();
    }
    frames
}

#[test]
fn a_controllers_bit_rate_state_and_counters_are_read() {
    let _bus = the_bus();
    let link = LinkState::read("can0").unwrap();
    assert!(link.up && !link.is_fd());
    assert_eq!((link.bit_rate, link.data_bit_rate), (Some(500_000), None));
    assert_eq!((link.restart_ms, link.queue_length, link.mtu), (Some(100), Some(10), Some(16)));
    assert_eq!(link.state, Some(ControllerState::ErrorActive));
    assert_eq!((link.transmit_errors, link.receive_errors), (Some(0), Some(0)));
    println!("{link:?}");
}

#[test]
fn frames_cross_the_bus_and_the_buffer_follows_the_bit_rate() {
    let _bus = the_bus();
    let (mut machine, mut gateway) = (machine(), gateway());
    // The emulated bus takes no time, and its controllers' own buffer is that of an SJA1000: some
    // four frames.
    let came: Vec<Frame> = (0..200)
        .flat_map(|n| {
            assert_eq!(machine.send_unrestricted(&data(n)).unwrap(), Sent::Taken);
            receive(&mut gateway, 1)
        })
        .collect();
    assert!(came.iter().map(|frame| frame.data()).eq((0..200).map(|n| [n; 8])));
    assert!(came.is_sorted_by_key(|frame| frame.timestamp));
    assert_eq!((gateway.counts().dropped, gateway.counts().unstamped), (0, 0));
    // 500 kbit/s are 10,639 of the shortest frames a second.
    let said = gateway.description();
    assert!(said.contains("13298 KiB, 1.00 s of a full bus at 500 kbit/s"), "{said}");
    println!("{said}\n{:?}", gateway.counts());

    let fd = Frame::new(Timestamp::default(), data(0).id, Kind::Fd { flags: 0 }, &[0; 12]);
    let sent = machine.send_unrestricted(&fd);
    assert!(matches!(sent, Err(PortError::Io(_))), "a classic controller took CAN FD: {sent:?}");
}

#[test]
fn after_down_and_another_bit_rate_an_opening_works_again() {
    let _bus = the_bus();
    let (mut machine, mut gateway) = (machine(), gateway());
    ip(&["link", "set", "can1", "down"]);
    let ended = gateway.receive(Duration::from_secs(10), &mut |_| {});
    assert!(matches!(ended, Err(PortError::Down)), "{ended:?}");
    let opened = SocketPort::open("can1", &Options::default());
    assert!(matches!(opened, Err(OpenError::Down { .. })));
    let link = LinkState::read("can1").unwrap();
    assert_eq!((link.up, link.state), (false, Some(ControllerState::Stopped)));

    ip(&["link", "set", "can1", "type", "can", "bitrate", "250000"]);
    ip(&["link", "set", "can1", "up"]);
    assert_eq!(LinkState::read("can1").unwrap().bit_rate, Some(250_000));
    let mut gateway = self::gateway();
    assert!(gateway.description().contains("250 kbit/s"), "{}", gateway.description());
    // This bus carries frames whatever the bit rates.
    assert_eq!(machine.send_unrestricted(&data(7)).unwrap(), Sent::Taken);
    assert_eq!(receive(&mut gateway, 1)[0].data(), [7; 8]);

    ip(&["link", "set", "can1", "down"]);
    ip(&["link", "set", "can1", "type", "can", "bitrate", "500000"]);
    ip(&["link", "set", "can1", "up"]);
}
