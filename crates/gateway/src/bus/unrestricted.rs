//! Ports for stand-ins of the machine.

use std::time::Duration;

use super::port::{Port, PortCounts, PortError, Received, Sent, Stamps};
use tertius_core::alarm::OwnFrame;
use tertius_core::frame::Frame;

/// A port that sends any frame: for a proxy, a simulator, a test. The gateway has none.
pub trait UnrestrictedPort: Port {
    /// Hands any frame to the interface, like [`Port::send`].
    ///
    /// # Errors
    /// See [`Port::send`]; also [`PortError::Io`] where no bus can carry the frame.
    fn send_unrestricted(&mut self, frame: &Frame) -> Result<Sent, PortError>;
}

/// The port `P` without its restriction.
pub struct Unrestricted<P>(pub(super) P);

/// Sending by a port once it is established that it may.
pub(super) trait HandOver {
    fn hand_over(&mut self, frame: &Frame) -> Result<Sent, PortError>;
}

impl<P: Port + HandOver> UnrestrictedPort for Unrestricted<P> {
    fn send_unrestricted(&mut self, frame: &Frame) -> Result<Sent, PortError> {
        self.0.hand_over(frame)
    }
}

impl<P: Port> Port for Unrestricted<P> {
    fn receive(
        &mut self,
        patience: Duration,
        take: &mut dyn FnMut(&Frame),
    ) -> Result<Received, PortError> {
        self.0.receive(patience, take)
    }

    fn send(&mut self, frame: &OwnFrame) -> Result<Sent, PortError> {
        self.0.send(frame)
    }

    fn counts(&self) -> PortCounts {
        self.0.counts()
    }

    fn stamps(&self) -> Stamps {
        self.0.stamps()
    }

    fn description(&self) -> String {
        self.0.description()
    }
}
