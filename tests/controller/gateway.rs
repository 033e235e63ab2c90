//! `tertius run` on a controller.

use crate::port::the_bus;
use std::time::{Duration, Instant};
use tertius::bus::socket::{Options, SocketPort};
use tertius::bus::{Port, Unrestricted, UnrestrictedPort};
use tertius::frame::Frame;
use tertius_testing::bench::{Bench, Status, excerpt, ip, wait_for};

/// The machine on the other end of the bus, and what it hears.
struct Machine {
    port: Unrestricted<SocketPort>,
    frames: Vec<Frame>,
    next: usize,
    heard: Vec<String>,
}

impl Machine {
    fn new() -> Self {
        let port = Unrestricted::<SocketPort>::open("can0", &Options::default()).expect("it is up");
        Self { port, frames: excerpt(20.0, 40.0), next: 0, heard: Vec::new() }
    }

    /// Sends frames one after the other, about as fast as the bus would carry them, until `done`.
    fn play_until(&mut self, what: &str, mut done: impl FnMut(&[String]) -> bool) {
        let started = Instant::now();
        while !done(&self.heard) {
            assert!(started.elapsed() < Duration::from_secs(60), "{what} took more than 60 s");
            let frame = &self.frames[self.next % self.frames.len()];
            self.next += 1;
            // A bus whose other end is down takes nothing, which is no matter here.
            _ = self.port.send_unrestricted(frame);
            let heard = &mut self.heard;
            let hear = &mut |frame: &Frame| {
                let data: String = frame.data().iter().map(|byte| format!("{byte:02X}")).collect();
                heard.push(format!("{:03X}#{data}", frame.id.value()));
            };
            self.port.receive(Duration::from_millis(1), hear).expect("can0 stays up");
        }
    }
}

#[test]
fn the_gateway_outlives_its_controller_going_down() {
    let _bus = the_bus();
    let bench = Bench::new("can1");
    let statuses = |heard: &[String]| heard.iter().filter(|it| Status::read(it).is_some()).count();
    let mut machine = Machine::new();
    let gateway = bench.gateway();
    assert_eq!(bench.said("500 kbit/s"), 1, "the bit rate is said at the start");
    wait_for("the controller's state", || bench.said("the controller is error-active") == 1);
    machine.play_until("ten statuses", |heard| statuses(heard) >= 10);
    let own = |it: &&String| it.starts_with("1D1#") || it.starts_with("2D1#");
    assert!(machine.heard.iter().all(|it| own(&it)), "{:?}", machine.heard);

    ip(&["link", "set", "can1", "down"]);
    wait_for("it to notice", || bench.said("is down") >= 1);
    wait_for("the controller's state", || bench.said("the controller is stopped") == 1);
    ip(&["link", "set", "can1", "up"]);
    wait_for("it to return", || bench.said("open: can1") == 2);
    machine.heard.clear();
    machine.play_until("statuses again", |heard| statuses(heard) >= 3);
    let first = machine.heard.iter().find_map(|it| Status::read(it)).expect("there are some");
    assert_eq!(first.healthy(), 0, "nothing is healthy until it was judged again");
    gateway.signal("TERM");
    wait_for("the end", || bench.said("INFO stopped") == 1);
    println!("{}", std::fs::read_to_string(bench.path("gateway.log")).expect("it was written"));
}
