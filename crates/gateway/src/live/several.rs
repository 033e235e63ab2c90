//! Several interfaces as one port: a machine whose buses the gateway hears side by side.
//!
//! Each bus has a socket of its own, and all are on the data path's one thread. What they receive is sorted by the
//! kernel's time stamps: a frame is passed on as soon as every open interface has been read up to its time, less a
//! guard for frames on their way into the queue. A replay of a recording of the same buses sorts in the same way
//! (`recordings::recording::merge`), so both give the monitor the same frames in the same order.
//!
//! An interface that is lost is opened again here, with waits that double, while the others go on.

use std::time::{Duration, Instant};

use nix::poll::{PollFd, PollFlags, PollTimeout, poll};

use super::supervisor::Opener;
use crate::bus::{Port, PortCounts, PortError, Received, Sent, Stamps};
use tertius_core::alarm::OwnFrame;
use tertius_core::frame::{BusNumber, Frame};
use tertius_core::time::{Span, Timestamp};
use tertius_recordings::Sorter;

/// First and longest wait between two attempts to open an interface again.
const PAUSES: (Duration, Duration) = (Duration::from_millis(50), Duration::from_secs(2));

/// The opener of each bus, anew whenever a port is opened.
type Openers = dyn Fn() -> Vec<(BusNumber, Box<dyn Opener>)>;

/// Opens the interfaces of several buses.
pub struct SeveralOpener {
    /// The opener of each bus. It is taken by the port, and given back by none: a new port takes new ones.
    openers: Box<Openers>,
    guard: Span,
}

impl SeveralOpener {
    /// Interfaces that `openers` open, the first bus among them; frames wait for others by `guard`.
    pub fn new(
        openers: impl Fn() -> Vec<(BusNumber, Box<dyn Opener>)> + 'static,
        guard: Span,
    ) -> Self {
        Self { openers: Box::new(openers), guard }
    }
}

impl Opener for SeveralOpener {
    /// Opens all that can be opened; the others are tried again while the port works.
    fn open(&mut self) -> Result<Box<dyn Port>, String> {
        let mut lines = Vec::new();
        let mut reasons = Vec::new();
        for (bus, mut opener) in (self.openers)() {
            let opened = opener.open();
            let missing = opened.as_ref().err().map(|reason| format!("the {bus} bus: {reason}"));
            reasons.extend(missing.clone());
            lines.push(Line {
                bus,
                opener,
                port: opened.ok(),
                missing: missing.unwrap_or_default(),
                reached: Timestamp::default(),
                pause: PAUSES.0,
                retry: Instant::now() + PAUSES.0,
                closed: PortCounts::default(),
            });
        }
        if lines.iter().all(|line| line.port.is_none()) {
            return Err(reasons.join("; "));
        }
        Ok(Box::new(SeveralPorts { lines, sorter: Sorter::default(), guard: self.guard }))
    }
}

/// The interfaces of several buses as one port. What it sends, it sends on the first bus.
struct SeveralPorts {
    lines: Vec<Line>,
    sorter: Sorter,
    guard: Span,
}

/// One of the buses.
struct Line {
    bus: BusNumber,
    opener: Box<dyn Opener>,
    /// `None` while its interface is lost.
    port: Option<Box<dyn Port>>,
    /// Why it could not be opened at first, for people.
    missing: String,
    /// Time up to which everything has been taken from it.
    reached: Timestamp,
    pause: Duration,
    retry: Instant,
    /// Counts of the ports that were lost.
    closed: PortCounts,
}

impl Line {
    /// Takes what is there, without waiting; returns the number of frames, and whether more may be waiting.
    ///
    /// # Errors
    /// The interface is lost.
    fn receive(&mut self, sorter: &mut Sorter) -> Result<(usize, bool), PortError> {
        let Some(port) = &mut self.port else { return Ok((0, false)) };
        let (bus, reached) = (self.bus, &mut self.reached);
        let received = port.receive(Duration::ZERO, &mut |frame| {
            *reached = frame.timestamp;
            sorter.put(&frame.clone().on(bus));
        })?;
        if let Some(drained) = received.drained_at {
            *reached = drained;
        }
        if received.frames > 0 {
            self.pause = PAUSES.0;
        }
        Ok((received.frames, received.drained_at.is_none()))
    }

    fn lose(&mut self) {
        if let Some(port) = self.port.take() {
            self.closed = self.counts_with(port.counts());
        }
        self.retry = Instant::now() + self.pause;
    }

    /// Tries to open the interface again, if it is time to.
    fn reopen(&mut self) {
        if self.port.is_some() || Instant::now() < self.retry {
            return;
        }
        self.pause = (2 * self.pause).min(PAUSES.1);
        self.retry = Instant::now() + self.pause;
        self.port = self.opener.open().ok();
    }

    fn counts(&self) -> PortCounts {
        self.port.as_ref().map_or(self.closed, |port| self.counts_with(port.counts()))
    }

    fn counts_with(&self, more: PortCounts) -> PortCounts {
        self.closed.with(&more)
    }
}

impl SeveralPorts {
    fn first(&mut self) -> Option<&mut Box<dyn Port>> {
        let first = self.lines.iter_mut().find(|line| line.bus == BusNumber::First)?;
        first.port.as_mut()
    }

    /// Waits at most `patience` until any interface has something to read.
    fn wait(&self, patience: Duration) {
        let descriptors = self.lines.iter().filter_map(|line| line.port.as_ref()?.descriptor());
        let mut watched: Vec<PollFd<'_>> =
            descriptors.map(|fd| PollFd::new(fd, PollFlags::POLLIN)).collect();
        if !watched.is_empty() {
            let longest = PollTimeout::try_from(patience).unwrap_or(PollTimeout::MAX);
            // A signal ends the waiting, as it should.
            _ = poll(&mut watched, longest);
        }
    }
}

impl Port for SeveralPorts {
    fn receive(
        &mut self,
        patience: Duration,
        take: &mut dyn FnMut(&Frame),
    ) -> Result<Received, PortError> {
        if !patience.is_zero() {
            self.wait(patience);
        }
        let mut received = Received::default();
        let (mut waiting, mut ended) = (false, None);
        for line in &mut self.lines {
            line.reopen();
            match line.receive(&mut self.sorter) {
                Ok((_, more)) => waiting |= more,
                Err(error) => {
                    received.lost.insert(line.bus);
                    line.lose();
                    ended = Some(error);
                }
            }
        }
        let open = self.lines.iter().filter(|line| line.port.is_some());
        let reached = open.map(|line| line.reached).min();
        let back = Span::from_nanos(self.guard.as_nanos().saturating_neg());
        // What a lost interface has received is passed on with the rest.
        let until = reached.map_or(Timestamp::from_nanos(i64::MAX), |reached| reached.after(back));
        while let Some(frame) = self.sorter.take(until) {
            take(&frame);
            received.frames += 1;
        }
        match (ended, reached) {
            (Some(error), None) => Err(error),
            _ => Ok(Received { drained_at: reached.filter(|_| !waiting), ..received }),
        }
    }

    fn send(&mut self, frame: &OwnFrame) -> Result<Sent, PortError> {
        match self.first().map(|port| port.send(frame)) {
            Some(Ok(sent)) => Ok(sent),
            // That it is lost, receiving will find out.
            Some(Err(PortError::Down | PortError::Gone)) | None => Ok(Sent::Full),
            Some(Err(error)) => Err(error),
        }
    }

    fn counts(&self) -> PortCounts {
        let none = PortCounts::default();
        self.lines.iter().fold(none, |all, line| all.with(&line.counts()))
    }

    fn stamps(&self) -> Stamps {
        let known = self.lines.iter().find_map(|line| line.port.as_ref());
        known.map_or(Stamps::Software, |port| port.stamps())
    }

    fn description(&self) -> String {
        let lines = self.lines.iter().map(|line| match &line.port {
            Some(port) => port.description(),
            None => line.missing.clone(),
        });
        lines.collect::<Vec<_>>().join("; ")
    }
}
