//! A port that only listens.

use std::time::Duration;

use super::port::{Port, PortCounts, PortError, Received};
use tertius_core::frame::Frame;

/// A port that receives, and through which nothing can be sent, not even the gateway's own frames.
///
/// ```compile_fail,E0599
/// # use tertius_core::alarm::OwnFrame;
/// # use tertius_gateway::bus::{ListeningPort, Port};
/// fn misuse(port: &mut ListeningPort, frame: &OwnFrame) {
///     let _ = port.send(frame);
/// }
/// ```
pub struct ListeningPort(Box<dyn Port>);

impl ListeningPort {
    /// `port`, from now on for listening only.
    pub fn new(port: impl Port + 'static) -> Self {
        Self(Box::new(port))
    }

    /// Waits for frames and passes them to `take`; see [`Port::receive`].
    ///
    /// # Errors
    /// See [`Port::receive`].
    pub fn receive(
        &mut self,
        patience: Duration,
        take: &mut dyn FnMut(&Frame),
    ) -> Result<Received, PortError> {
        self.0.receive(patience, take)
    }

    /// Counts of this port since it was opened.
    pub fn counts(&self) -> PortCounts {
        self.0.counts()
    }
}
