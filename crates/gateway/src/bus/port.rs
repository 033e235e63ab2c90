//! Live CAN interfaces.

use std::fmt;
use std::io;
use std::os::fd::BorrowedFd;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use tertius_core::alarm::OwnFrame;
use tertius_core::frame::{Buses, Frame, Id, Kind};
use tertius_core::time::{Span, Timestamp};

/// A live CAN interface. It is the only object with a clock: it tells the time on the clock of its
/// time stamps.
///
/// It sends only the gateway's own frames:
///
/// ```compile_fail,E0308
/// # use tertius_gateway::bus::Port;
/// # use tertius_core::frame::Frame;
/// fn misuse(port: &mut dyn Port, frame: &Frame) {
///     let _ = port.send(frame);
/// }
/// ```
pub trait Port {
    /// Waits at most `patience` for a frame (plus a tick of the kernel, up to 10 ms), then passes
    /// the frames that are there to `take`, oldest first; their number is bounded, so that other
    /// work gets its turn. A signal ends the waiting early. Calls are cheapest with the same
    /// patience each time.
    ///
    /// # Errors
    /// Once the interface is down or gone, and everything before has been taken, this port
    /// is finished: every call returns the error, and the port has to be opened again. After
    /// [`PortError::Io`] it may be called again.
    fn receive(
        &mut self,
        patience: Duration,
        take: &mut dyn FnMut(&Frame),
    ) -> Result<Received, PortError>;

    /// Hands a frame to the interface without waiting. Its time stamp is not used.
    ///
    /// # Errors
    /// See [`Self::receive`]. A queue without room is not an error but [`Sent::Full`].
    fn send(&mut self, frame: &OwnFrame) -> Result<Sent, PortError>;

    /// Counts of this port since it was opened.
    fn counts(&self) -> PortCounts;

    /// Source of the frames' time stamps at present.
    fn stamps(&self) -> Stamps;

    /// Description for the log at the start: interface, filters, time stamps, buffer.
    fn description(&self) -> String;

    /// What is readable while frames or the end of the interface are to be received, for waiting on several at once;
    /// `None` where there is nothing to wait for.
    fn descriptor(&self) -> Option<BorrowedFd<'_>> {
        None
    }
}

/// Frames to receive. Error frames are always received, own frames never.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Identifiers {
    /// All frames, remote frames included.
    #[default]
    All,
    /// The data frames, classic and FD, of exactly these identifiers.
    Only(Vec<Id>),
}

/// Result of one call of [`Port::receive`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Received {
    /// Number of frames taken, error frames included.
    pub frames: usize,
    /// Time before which every frame has been taken, apart from frames on their way from the
    /// controller to the queue (the caller's guard). `None` while more frames are or may be
    /// waiting.
    pub drained_at: Option<Timestamp>,
    /// Buses whose interfaces were lost, of several; the others go on.
    pub lost: Buses,
}

/// Result of sending a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sent {
    /// The interface has accepted it.
    Taken,
    /// There is no room for it now: ENOBUFS or EAGAIN. Nothing of it was kept.
    Full,
}

/// Why a port cannot continue.
#[derive(Debug, thiserror::Error)]
pub enum PortError {
    /// The interface is down (ENETDOWN).
    #[error("the interface is down")]
    Down,
    /// The interface was deleted or unplugged (ENODEV, ENXIO). One with the same name may return,
    /// with another index.
    #[error("the interface is gone")]
    Gone,
    #[error("the interface failed: {0}")]
    Io(#[from] io::Error),
}

/// Counts of a port since it was opened.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PortCounts {
    /// Frames passed to the caller, error frames included.
    pub received: u64,
    /// Error frames among the frames received.
    pub error_frames: u64,
    /// Frames lost because the receive queue was full. The number is exact as of the last frame
    /// received, since the kernel reports it with each frame.
    pub dropped: u64,
    /// Reads that returned frames; [`Self::received`] over this is the mean batch.
    pub batches: u64,
    /// Frames in the largest batch.
    pub largest_batch: u64,
    /// Data that were read but are no frame: shorter or longer than one. This is not known to
    /// occur.
    pub malformed: u64,
    /// Frames without a time stamp, which got the time of their reading.
    pub unstamped: u64,
    /// Frames handed to the interface.
    pub sent: u64,
    /// Frames refused as [`Sent::Full`].
    pub refused: u64,
}

impl PortCounts {
    /// The counts of this port and of another one.
    pub fn with(&self, other: &Self) -> Self {
        Self {
            received: self.received + other.received,
            error_frames: self.error_frames + other.error_frames,
            dropped: self.dropped + other.dropped,
            batches: self.batches + other.batches,
            largest_batch: self.largest_batch.max(other.largest_batch),
            malformed: self.malformed + other.malformed,
            unstamped: self.unstamped + other.unstamped,
            sent: self.sent + other.sent,
            refused: self.refused + other.refused,
        }
    }
}

/// Source of the frames' time stamps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stamps {
    /// The kernel, when the driver hands a frame over.
    Software,
    /// The controller, whose clock agrees with the system's.
    Hardware,
    /// The kernel: the controller also has time stamps, but its clock was ahead of the kernel's
    /// stamp of the same frame by this span (behind, if negative).
    SoftwareAsHardwareDiffers(Span),
    /// The embedded bus, when a frame is sent.
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

/// Refuses a frame that no bus can carry: more than 8 bytes in a classic one, or a length that CAN
/// FD does not have.
pub(super) fn carried(frame: &Frame) -> Result<(), PortError> {
    let length = frame.length();
    let carried = match frame.kind {
        Kind::Data | Kind::Error => length <= 8,
        Kind::Remote { length: asked } => length == 0 && asked <= 8,
        Kind::Fd { .. } => matches!(length, 0..=8 | 12 | 16 | 20 | 24 | 32 | 48 | 64),
    };
    if carried {
        return Ok(());
    }
    let reason = format!("no bus carries {length} bytes as {:?}", frame.kind);
    Err(PortError::Io(io::Error::new(io::ErrorKind::InvalidInput, reason)))
}

/// The system's clock, which is also the kernel's for time stamps.
pub(super) fn system_time() -> Timestamp {
    // A clock set to before 1970 is wrong, and 1970 is as good.
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    Timestamp::from_nanos(i64::try_from(since.as_nanos()).unwrap_or(i64::MAX))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_frames_that_a_bus_carries_are_sent() {
        let frame = |kind, length| {
            let id = Id::standard(1).unwrap();
            Frame::new(Timestamp::default(), id, kind, &[0; 64][..length])
        };
        let fd = Kind::Fd { flags: 0 };
        for (kind, length) in [
            (Kind::Data, 8),
            (Kind::Error, 8),
            (Kind::Remote { length: 8 }, 0),
            (fd, 8),
            (fd, 12),
            (fd, 48),
            (fd, 64),
        ] {
            assert!(carried(&frame(kind, length)).is_ok(), "{kind:?} of {length}");
        }
        for (kind, length) in [
            (Kind::Data, 9),
            (Kind::Error, 9),
            (Kind::Remote { length: 9 }, 0),
            (Kind::Remote { length: 1 }, 1),
            (fd, 9),
            (fd, 63),
        ] {
            assert!(carried(&frame(kind, length)).is_err(), "{kind:?} of {length}");
        }
    }
}
