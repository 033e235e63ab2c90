//! A proxy between two interfaces: what comes on one goes to the other with faults, what comes on
//! the other goes back unchanged.
//!
//! It sends whatever identifiers it hears, so it is for test benches only; the gateway has no part
//! in it. A port never hears its own frames, and nothing goes back to where it came from, so a
//! proxy makes no loop.

mod keeper;
mod lane;
mod side;

use crate::bus::{Port, PortError, UnrestrictedPort};
use crate::frame::{Frame, Kind};
use crate::inject::Injector;
pub use keeper::{Bench, run};
pub use lane::{Lane, LaneCounts, Limits};
pub use side::{Open, Side};
use std::time::Duration;

/// The data path of the proxy. It has no clock: the ports' time stamps say how late it is.
#[derive(Clone, Debug)]
pub struct Proxy {
    injector: Injector,
    /// A frame was given to the injector, whose time runs since.
    begun: bool,
    there: Lane,
    back: Lane,
}

/// What a turn did at one interface: the frames received, or why its port is finished.
pub type Outcome = Result<usize, PortError>;

impl Proxy {
    pub fn new(injector: Injector, limits: Limits) -> Self {
        Self { injector, begun: false, there: Lane::new(limits), back: Lane::new(limits) }
    }

    pub const fn injector(&self) -> &Injector {
        &self.injector
    }

    /// From the first interface to the second, with the faults.
    pub const fn there(&self) -> &Lane {
        &self.there
    }

    /// From the second interface to the first, unchanged.
    pub const fn back(&self) -> &Lane {
        &self.back
    }

    /// Takes what both ports have received, without waiting, and passes it on. A port that is not
    /// there now is `None`; what should go to it is dropped and counted.
    ///
    /// Every frame of the first port passes the injector in the order of arrival, so that what
    /// comes out is what the injector makes of a recording of that port, less what was dropped.
    /// Only while no frame has passed yet and the second port is away, nothing is injected: the time
    /// of the faults begins with the first frame that can go through.
    pub fn turn<P: UnrestrictedPort>(
        &mut self,
        mut from: Option<&mut P>,
        mut to: Option<&mut P>,
    ) -> [Outcome; 2] {
        let Self { injector, begun, there, back } = self;
        let (from_is_there, to_is_there) = (from.is_some(), to.is_some());
        let mut at_from = receive(from.as_deref_mut(), there, |frame, lane| {
            *begun |= to_is_there;
            let passed = if *begun { injector.take(frame) } else { Some(frame) };
            let Some(passed) = passed else { return lane.counts_mut().lost += 1 };
            lane.counts_mut().changed += u64::from(passed.data() != frame.data());
            pass(passed, lane, to_is_there);
        });
        // At once: each call in between would be part of the delay.
        let sent = send(there, to.as_deref_mut());
        let received = receive(to, back, |frame, lane| pass(frame, lane, from_is_there));
        let at_to = sent.and(received);
        if at_from.is_ok()
            && let Err(error) = send(back, from)
        {
            at_from = Err(error);
        }
        if at_from.is_err() || at_to.is_err() {
            there.clear();
            back.clear();
        }
        [at_from, at_to]
    }

    /// Frames that wait for room on either interface.
    pub fn waiting(&self) -> usize {
        self.there.waiting() + self.back.waiting()
    }
}

/// Gives `forward` each frame that `port` has and that may leave its bus.
fn receive(
    port: Option<&mut impl Port>,
    lane: &mut Lane,
    mut forward: impl FnMut(&Frame, &mut Lane),
) -> Outcome {
    let Some(port) = port else { return Ok(0) };
    let received = port.receive(Duration::ZERO, &mut |frame| {
        lane.set_time(frame.timestamp);
        if frame.kind == Kind::Error {
            return lane.counts_mut().error_frames += 1;
        }
        lane.counts_mut().received += 1;
        forward(frame, lane);
    })?;
    if let Some(drained) = received.drained_at {
        lane.set_time(drained);
    }
    Ok(received.frames)
}

fn pass(frame: &Frame, lane: &mut Lane, far_side_is_there: bool) {
    if far_side_is_there {
        lane.put(frame);
    } else {
        lane.counts_mut().away += 1;
    }
}

fn send(lane: &mut Lane, port: Option<&mut impl UnrestrictedPort>) -> Result<(), PortError> {
    port.map_or(Ok(()), |port| lane.send(port))
}
