//! Fd_TimeJump, from frames to a frame.

use tertius::alarm::{OwnFrame, OwnMessage, e2e};
use tertius::config::{self, design};
use tertius::dbc::Database;
use tertius::frame::{Frame, Id, Kind};
use tertius::monitor::{Monitor, Sink};
use tertius::time::{Span, Timestamp};

#[derive(Default)]
struct Jumps(Vec<OwnFrame>);

impl Sink for Jumps {
    fn transmit(&mut self, frame: &OwnFrame) {
        if frame.message() == OwnMessage::TimeJump {
            self.0.push(frame.clone());
        }
    }
}

#[test]
fn a_clock_that_is_set_back_is_told_on_the_bus() {
    let text = include_str!("../../config/e-type.toml");
    let (settings, _) = config::parse("e-type.toml", text).expect("it ships");
    let database = Database::parse(include_str!("../../dbc/e-type.dbc")).expect("it ships");
    let mut monitor = Monitor::new(design::judging(&settings, &database).expect("they fit"));
    let mut jumps = Jumps::default();
    for seconds in [1000.0, 1000.02, 400.02, 400.04] {
        let at = Timestamp::default().after(Span::from_seconds(seconds));
        let sync = Id::standard(0x80).expect("11 bits");
        monitor.take(&Frame::new(at, sync, Kind::Data, &[]), &mut jumps);
    }
    let [jump] = &jumps.0[..] else { panic!("{} jumps", jumps.0.len()) };
    let frame = jump.as_frame();
    assert_eq!((frame.id.value(), frame.length()), (0x4D1, 8));
    assert_eq!(e2e::check(frame.data(), 0x4D1), Ok(0));
    assert_eq!(frame.data()[3..7], (-600_000_i32).to_le_bytes());
}
