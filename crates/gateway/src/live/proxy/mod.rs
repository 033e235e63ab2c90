//! A proxy between two interfaces: frames of one go to the other with faults, frames of the other
//! go back unchanged.
//!
//! It forwards all identifiers, so it is for test benches only; the gateway does not use it. A port
//! never receives its own frames, and no frame goes back to its origin, so a proxy makes no loop.

mod keeper;
mod lane;
mod side;

use crate::bus::{Port, PortError, UnrestrictedPort};
pub use keeper::{Bench, run};
pub use lane::{Lane, LaneCounts, LaneLimits};
pub use side::{Open, Side};
use std::time::Duration;
use tertius_core::frame::{Frame, Kind};
use tertius_machine::inject::Injector;

/// The data path of the proxy. It has no clock: the ports' time stamps provide the time.
#[derive(Clone, Debug)]
pub struct Proxy {
    injector: Injector,
    /// Whether a frame has reached the injector, whose time then runs.
    begun: bool,
    there: Lane,
    back: Lane,
}

/// Result of a turn at one interface: the number of frames received, or why its port is finished.
pub type Outcome = Result<usize, PortError>;

impl Proxy {
    pub fn new(injector: Injector, limits: LaneLimits) -> Self {
        Self { injector, begun: false, there: Lane::new(limits), back: Lane::new(limits) }
    }

    pub const fn injector(&self) -> &Injector {
        &self.injector
    }

    /// Lane from the first interface to the second, with the faults.
    pub const fn there(&self) -> &Lane {
        &self.there
    }

    /// Lane from the second interface to the first, unchanged.
    pub const fn back(&self) -> &Lane {
        &self.back
    }

    /// Forwards what both ports have received, without waiting. A port that is not there now is
    /// `None`; frames for it are dropped and counted.
    ///
    /// Every frame of the first port passes the injector in the order of arrival, so that the
    /// output equals that of the injector for a recording of that port, except for dropped frames.
    /// The time of the faults begins with the first frame that can be forwarded: nothing is
    /// injected while no frame has passed yet and the second port is away.
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

    /// Number of frames that wait for room on either interface.
    pub fn waiting(&self) -> usize {
        self.there.waiting() + self.back.waiting()
    }
}

/// Passes to `forward` each frame of `port` that may leave its bus.
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
