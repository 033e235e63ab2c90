//! A CAN interface, live.

use std::fmt;
use std::io;
use std::time::Duration;

use crate::alarm::OwnFrame;
use crate::frame::Frame;
use crate::time::{Span, Timestamp};

/// A CAN interface, live. The only thing with a clock: it says how late it is, on the clock of its
/// time stamps.
///
/// It sends nothing but the gateway's own frames:
///
/// ```compile_fail,E0308
/// # use tertius::bus::Port;
/// # use tertius::frame::Frame;
/// fn misuse(port: &mut dyn Port, frame: &Frame) {
///     let _ = port.send(frame);
/// }
/// ```
pub trait Port {
    /// Waits at most `patience` for a frame, then gives `take` what is there, oldest first; a
    /// bounded number, so that other work gets its turn. A signal ends the waiting early.
    ///
    /// # Errors
    /// Once the interface is down or gone, and all that had come before has been taken, this port
    /// is finished: it says so at every call, and has to be opened anew. After
    /// [`PortError::Io`] it may be called again.
    fn receive(
        &mut self,
        patience: Duration,
        take: &mut dyn FnMut(&Frame),
    ) -> Result<Received, PortError>;

    /// Hands a frame to the interface without waiting. Its time stamp is not used.
    ///
    /// # Errors
    /// As [`Self::receive`]. A queue without room is no error but [`Sent::Full`].
    fn send(&mut self, frame: &OwnFrame) -> Result<Sent, PortError>;

    /// What this port has counted since it was opened.
    fn counts(&self) -> PortCounts;

    /// Whose clock the frames were stamped by, as of now.
    fn stamps(&self) -> Stamps;

    /// What people should know at start: interface, filters, time stamps, buffer.
    fn description(&self) -> String;
}

/// A port that sends whatever it is given: for a proxy that stands in for the machine, a simulator,
/// a test. The gateway has none.
pub trait UnrestrictedPort: Port {
    /// Hands any frame to the interface, as [`Port::send`].
    ///
    /// # Errors
    /// As [`Port::send`]; [`PortError::Io`] where no bus can carry the frame.
    fn send_unrestricted(&mut self, frame: &Frame) -> Result<Sent, PortError>;
}

/// What one call of [`Port::receive`] did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Received {
    /// The frames taken, error frames included.
    pub frames: usize,
    /// Every frame stamped before this has been taken, but for those on their way from the
    /// controller to the queue (the caller's guard). `None` while more are or may be waiting.
    pub drained_at: Option<Timestamp>,
}

/// What became of a frame to be sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sent {
    /// The interface has it.
    Taken,
    /// There is no room for it now: ENOBUFS or EAGAIN. Nothing of it was kept.
    Full,
}

/// Why a port cannot go on.
#[derive(Debug, thiserror::Error)]
pub enum PortError {
    /// ENETDOWN.
    #[error("the interface is down")]
    Down,
    /// ENODEV, ENXIO: the interface was deleted or unplugged. One of its name may come again, under
    /// another index.
    #[error("the interface is gone")]
    Gone,
    #[error("the interface failed: {0}")]
    Io(#[from] io::Error),
}

/// What a port counts, from its opening on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PortCounts {
    /// Frames given to the caller, error frames included.
    pub received: u64,
    /// Of those the error frames.
    pub error_frames: u64,
    /// Frames lost because the receive queue was full. Exact, as of the last frame received: the
    /// kernel tells it with each frame.
    pub dropped: u64,
    /// Reads that brought frames; [`Self::received`] over this is the mean batch.
    pub batches: u64,
    /// Frames in the largest batch.
    pub largest_batch: u64,
    /// What was read and is no frame: shorter or longer than one. None is known to occur.
    pub malformed: u64,
    /// Frames that came without a time stamp and got the time of their reading.
    pub unstamped: u64,
    /// Frames handed to the interface.
    pub sent: u64,
    /// Frames refused as [`Sent::Full`].
    pub refused: u64,
}

/// Whose clock stamps the frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stamps {
    /// The kernel, as the driver hands a frame over.
    Software,
    /// The controller, whose clock agrees with the system's.
    Hardware,
    /// The kernel: the controller stamps too, but its clock was this far ahead of the kernel's
    /// stamp of the same frame (behind, if negative).
    SoftwareAsHardwareDiffers(Span),
    /// The embedded bus, as a frame is sent.
    Embedded,
}

impl fmt::Display for Stamps {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Software => f.write_str("the kernel's (software)"),
            Self::Hardware => f.write_str("the controller's (hardware)"),
            Self::SoftwareAsHardwareDiffers(ahead) => write!(
                f,
                "the kernel's (software); the controller's are {:+.3} ms off, its clock does not \
                 follow the system's",
                ahead.as_seconds() * 1e3
            ),
            Self::Embedded => f.write_str("the embedded bus's"),
        }
    }
}
