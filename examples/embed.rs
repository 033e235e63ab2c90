//! A monitor on any driver of `embedded_can`, here a SocketCAN interface.
//!
//! `cargo run --example embed -- config/e-type.toml vcan0`

use embedded_can::blocking::Can;
use std::error::Error;
use std::path::Path;
use std::time::SystemTime;
use tertius::alarm::{OwnFrame, Warning};
use tertius::config::{self, design, devices};
use tertius::dbc::{Database, text};
use tertius::frame::Frame;
use tertius::monitor::{Monitor, Sink};
use tertius::time::Timestamp;

/// Sends the monitor's frames and prints its warnings.
struct Bus<C>(C);

impl<C: Can> Sink for Bus<C> {
    fn transmit(&mut self, frame: &OwnFrame) {
        let sent = frame.as_frame().for_driver().map(|frame| self.0.transmit(&frame));
        if let Some(Err(error)) = sent {
            eprintln!("not sent: {error:?}");
        }
    }

    fn warning(&mut self, warning: &Warning) {
        println!("cylinder {}: {warning:?}", warning.cylinder);
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let (Some(path), Some(interface)) = (arguments.next(), arguments.next()) else {
        return Err("expected a configuration and an interface".into());
    };
    let loaded = config::load(Path::new(&path))?;
    let mut database = Database::parse(&text::from_bytes(&loaded.dbc_text))?;
    devices::connect(&loaded.settings, &loaded.sheets, &mut database)
        .map_err(|it| format!("{it:?}"))?;
    let design = design::judging(&loaded.settings, &database).map_err(|it| format!("{it:?}"))?;
    let mut monitor = Monitor::new(design);
    let mut bus = Bus(<socketcan::CanSocket as socketcan::Socket>::open(&interface)?);
    loop {
        let frame = bus.0.receive().map_err(|error| format!("{error:?}"))?;
        let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH)?;
        let now = Timestamp::from_nanos(i64::try_from(now.as_nanos())?);
        monitor.take(&Frame::received(now, &frame), &mut bus);
    }
}
