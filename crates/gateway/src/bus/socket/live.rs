//! The port over a RAW socket.

use std::os::fd::{AsFd, AsRawFd, BorrowedFd};
use std::time::Duration;

use nix::errno::Errno;

use super::batch::{BATCH, Batch, Message};
use super::drops::Drops;
use super::error::OpenError;
use super::open::{self, Opened, Options, Stamping, errno};
use super::stamp::Choice;
use super::wire::{self, Outgoing};
use crate::bus::port::{Port, PortCounts, PortError, Received, Sent, Stamps, carried, system_time};
use crate::bus::unrestricted::{HandOver, Unrestricted};
use tertius_core::alarm::OwnFrame;
use tertius_core::frame::{Frame, Id, Kind};
use tertius_core::time::Timestamp;

/// Most batches in one call: 256 frames, 10 ms of a full bus at 1 Mbit/s.
const BATCHES: usize = 4;

/// Shortest wait: the kernel takes a shorter one for an infinite one.
const SHORTEST_WAIT: Duration = Duration::from_micros(1);
const LONGEST_WAIT: Duration = Duration::from_secs(3600);

/// A SocketCAN interface. It sends only the gateway's own frames.
pub struct SocketPort {
    interface: String,
    opened: Opened,
    batch: Batch,
    intake: Intake,
    /// Whether more frames are or may be waiting.
    waiting: bool,
    /// Time that the kernel was told to wait.
    patience: Option<Duration>,
    ended: Option<Ended>,
    sent: u64,
    refused: u64,
}

/// Final state of the interface, for this socket.
#[derive(Clone, Copy)]
enum Ended {
    Down,
    Gone,
}

/// Converts the kernel's messages to frames.
struct Intake {
    frame: Frame,
    choice: Choice,
    drops: Drops,
    counts: PortCounts,
}

impl SocketPort {
    /// Opens the interface of this name. It must be called again after the interface went down or
    /// was deleted.
    ///
    /// # Errors
    /// See [`OpenError`]; [`OpenError::may_pass`] tells whether to try again.
    pub fn open(interface: &str, options: &Options) -> Result<Self, OpenError> {
        Ok(Self {
            interface: interface.to_owned(),
            opened: open::open(interface, options)?,
            batch: Batch::new(),
            intake: Intake::new(),
            waiting: false,
            patience: None,
            ended: None,
            sent: 0,
            refused: 0,
        })
    }

    /// Index of the interface in the kernel that this port is bound to.
    pub fn index(&self) -> u32 {
        self.opened.index
    }

    /// Receive buffer, bytes as the kernel counts them.
    pub fn receive_buffer(&self) -> usize {
        self.opened.buffer
    }

    /// Time in which a full bus fills the receive buffer, s.
    pub fn buffer_lasts(&self) -> f64 {
        self.opened.rates.lasts(self.opened.buffer as u64)
    }

    /// Sets the waiting time. The kernel waits in ticks of up to 10 ms, but a frame costs no second
    /// system call.
    fn be_patient(&mut self, patience: Duration) -> Result<(), PortError> {
        let patience = patience.clamp(SHORTEST_WAIT, LONGEST_WAIT);
        if self.patience != Some(patience) {
            self.opened.socket.set_patience(patience)?;
            self.patience = Some(patience);
        }
        Ok(())
    }

    /// Time up to which everything has been taken, after a read that began at `looked_at`, if it
    /// did not wait.
    fn drained_at(&self, frames: usize, looked_at: Option<Timestamp>) -> Option<Timestamp> {
        if self.waiting {
            return None;
        }
        // Frames come in the order of their stamps.
        let last = (frames > 0).then_some(self.intake.frame.timestamp);
        last.max(looked_at)
    }

    fn finish(&mut self, ended: Ended) -> PortError {
        self.ended = Some(ended);
        ended.into()
    }
}

impl HandOver for SocketPort {
    fn hand_over(&mut self, frame: &Frame) -> Result<Sent, PortError> {
        carried(frame)?;
        if let Some(ended) = self.ended {
            return Err(ended.into());
        }
        match self.opened.socket.send(Outgoing::new(frame).as_bytes()) {
            Ok(_) => {
                self.sent += 1;
                Ok(Sent::Taken)
            }
            Err(error) => match errno(&error) {
                Errno::EAGAIN | Errno::ENOBUFS => {
                    self.refused += 1;
                    Ok(Sent::Full)
                }
                code => Err(Ended::from_errno(code)
                    .map_or(PortError::Io(error), |ended| self.finish(ended))),
            },
        }
    }
}

impl Port for SocketPort {
    fn receive(
        &mut self,
        patience: Duration,
        take: &mut dyn FnMut(&Frame),
    ) -> Result<Received, PortError> {
        let mut wait = !self.waiting && self.ended.is_none() && !patience.is_zero();
        if wait {
            self.be_patient(patience)?;
        }
        let mut received = Received::default();
        // The clock is not asked where frames come without waiting on: their stamps say enough.
        let mut looked_at = None;
        self.waiting = true;
        for _ in 0..=BATCHES {
            if !wait && received.frames == 0 {
                looked_at = Some(system_time());
            }
            let socket = self.opened.socket.as_raw_fd();
            match self.batch.read(socket, wait, |message| {
                received.frames += usize::from(self.intake.take(message, take));
            }) {
                Ok(count) => {
                    self.intake.count_batch(count);
                    self.waiting = count == BATCH;
                }
                // That was the patience. Whether the queue is empty now, the next reading tells.
                Err(Errno::EAGAIN) if wait => {}
                Err(Errno::EAGAIN) => self.waiting = false,
                // Whoever sent the signal wants to be heard.
                Err(Errno::EINTR) => return Ok(received),
                // The frames that came before are still in the queue.
                Err(code) => match Ended::from_errno(code) {
                    Some(ended) => self.ended = Some(ended),
                    None => return Err(PortError::Io(code.into())),
                },
            }
            wait = false;
            if !self.waiting || received.frames >= BATCHES * BATCH {
                break;
            }
        }
        match self.ended {
            Some(ended) if received.frames == 0 => Err(ended.into()),
            Some(_) => Ok(received),
            None => {
                Ok(Received { drained_at: self.drained_at(received.frames, looked_at), ..received })
            }
        }
    }

    fn send(&mut self, frame: &OwnFrame) -> Result<Sent, PortError> {
        self.hand_over(frame.as_frame())
    }

    fn counts(&self) -> PortCounts {
        PortCounts { sent: self.sent, refused: self.refused, ..self.intake.counts() }
    }

    fn stamps(&self) -> Stamps {
        self.intake.choice.stamps()
    }

    fn descriptor(&self) -> Option<BorrowedFd<'_>> {
        Some(self.opened.socket.as_fd())
    }

    fn description(&self) -> String {
        let opened = &self.opened;
        let filters = match opened.filters {
            Some(1) => "1 identifier".to_owned(),
            Some(count) => format!("{count} identifiers"),
            None => "all identifiers".to_owned(),
        };
        let stamps = match (self.stamps(), opened.stamping) {
            (Stamps::Software, Stamping::Both) => {
                "the kernel's (software), the controller's once it sends some that agree".to_owned()
            }
            (stamps, _) => stamps.to_string(),
        };
        let lasts = self.buffer_lasts();
        // Rounding of the kernel's is not worth a word.
        let advice = if lasts < 0.99 {
            "; for a whole second, give CAP_NET_ADMIN or raise net.core.rmem_max"
        } else {
            ""
        };
        format!(
            "{} (SocketCAN, index {}): receives {filters} and error frames, classic and FD; time \
             stamps: {stamps}; receive buffer {} KiB, {lasts:.2} s of a full bus at {}{advice}",
            self.interface,
            opened.index,
            opened.buffer / 1024,
            opened.rates,
        )
    }
}

impl Intake {
    fn new() -> Self {
        let id = Id::standard(0).expect("zero is in range");
        Self {
            frame: Frame::new(Timestamp::default(), id, Kind::Data, &[]),
            choice: Choice::SOFTWARE,
            drops: Drops::default(),
            counts: PortCounts::default(),
        }
    }

    /// Converts a message; returns `false` if it is not a frame.
    fn take(&mut self, message: &Message<'_>, take: &mut dyn FnMut(&Frame)) -> bool {
        if let Some(count) = message.drops {
            self.drops.saw(count);
        }
        if !wire::read(message.bytes, &mut self.frame) {
            self.counts.malformed += 1;
            return false;
        }
        let stamp = self.choice.of(message.software, message.hardware);
        self.counts.unstamped += u64::from(stamp.is_none());
        self.frame.timestamp = as_recorded(stamp.unwrap_or_else(system_time));
        self.counts.received += 1;
        self.counts.error_frames += u64::from(self.frame.kind == Kind::Error);
        take(&self.frame);
        true
    }

    fn count_batch(&mut self, frames: usize) {
        self.counts.batches += 1;
        self.counts.largest_batch = self.counts.largest_batch.max(frames as u64);
    }

    fn counts(&self) -> PortCounts {
        PortCounts { dropped: self.drops.total(), ..self.counts }
    }
}

/// Rounds to whole microseconds, as candump does, so that a deadline between two frames also falls
/// between the same two in a replay of the recording.
fn as_recorded(stamp: Timestamp) -> Timestamp {
    Timestamp::from_nanos(stamp.as_nanos() - stamp.as_nanos().rem_euclid(1000))
}

impl Ended {
    fn from_errno(code: Errno) -> Option<Self> {
        match code {
            Errno::ENETDOWN => Some(Self::Down),
            Errno::ENODEV | Errno::ENXIO => Some(Self::Gone),
            _ => None,
        }
    }
}

impl From<Ended> for PortError {
    fn from(ended: Ended) -> Self {
        match ended {
            Ended::Down => Self::Down,
            Ended::Gone => Self::Gone,
        }
    }
}

impl Unrestricted<SocketPort> {
    /// Opens as [`SocketPort::open`] does, for a port that may send any frame.
    ///
    /// # Errors
    /// See [`SocketPort::open`].
    pub fn open(interface: &str, options: &Options) -> Result<Self, OpenError> {
        SocketPort::open(interface, options).map(Self)
    }
    /// Index of the interface, see [`SocketPort::index`].
    pub fn index(&self) -> u32 {
        self.0.index()
    }
}

/// File descriptor for waiting on several interfaces at once: readable while frames or the end of
/// the interface are to be received.
impl AsFd for Unrestricted<SocketPort> {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.0.opened.socket.as_fd()
    }
}
