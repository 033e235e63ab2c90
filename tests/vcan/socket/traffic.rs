//! Frames to and from ports.

use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use tertius::bus::{Port, PortError, Sent, UnrestrictedPort};
use tertius::frame::{Frame, Id, Kind};
use tertius::time::Timestamp;

/// Far more than any of it takes; who waits this long has failed.
const PATIENCE: Duration = Duration::from_secs(10);

pub fn standard(id: u32) -> Id {
    Id::standard(id).unwrap()
}

pub fn extended(id: u32) -> Id {
    Id::extended(id).unwrap()
}

pub fn frame(id: Id, kind: Kind, data: &[u8]) -> Frame {
    Frame::new(Timestamp::default(), id, kind, data)
}

/// A data frame that carries a number.
pub fn numbered(id: Id, number: u32) -> Frame {
    frame(id, Kind::Data, &number.to_le_bytes())
}

pub fn number(frame: &Frame) -> u32 {
    u32::from_le_bytes(frame.data().try_into().unwrap())
}

/// Sends it, however long the queue stays full.
pub fn send(port: &mut impl UnrestrictedPort, frame: &Frame) {
    let started = Instant::now();
    while port.send_unrestricted(frame).unwrap() == Sent::Full {
        assert!(started.elapsed() < PATIENCE, "the queue stays full");
        std::thread::yield_now();
    }
}

/// Receives until `enough` says so of what has come.
pub fn receive_until(port: &mut impl Port, enough: impl Fn(&[Frame]) -> bool) -> Vec<Frame> {
    let started = Instant::now();
    let mut frames = Vec::new();
    while !enough(&frames) {
        let late = started.elapsed() > PATIENCE;
        assert!(!late, "only {} frames came: {:?}", frames.len(), frames.last());
        port.receive(Duration::from_millis(100), &mut |frame| frames.push(frame.clone())).unwrap();
    }
    frames
}

pub fn receive(port: &mut impl Port, count: usize) -> Vec<Frame> {
    receive_until(port, |frames| frames.len() >= count)
}

/// What ends the port, and what came before that.
pub fn receive_end(port: &mut impl Port) -> (Vec<Frame>, PortError) {
    let started = Instant::now();
    let mut frames = Vec::new();
    while started.elapsed() < PATIENCE {
        let took =
            port.receive(Duration::from_millis(100), &mut |frame| frames.push(frame.clone()));
        if let Err(error) = took {
            return (frames, error);
        }
    }
    panic!("the port has not ended");
}

/// Without the stamps, to compare what was sent with what came.
pub fn unstamped(mut frames: Vec<Frame>) -> Vec<Frame> {
    frames.iter_mut().for_each(|frame| frame.timestamp = Timestamp::default());
    frames
}

pub fn clock() -> Timestamp {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap();
    Timestamp::from_nanos(i64::try_from(since.as_nanos()).unwrap())
}
