//! Plays a recording, or a simulated machine, onto the embedded bus, and drives the clock of the
//! bus.

use super::Failure;
use crate::bus::embedded::{EmbeddedBus, Endpoint, ManualClock};
use crate::bus::{Identifiers, PortError, Recording, Source, Unrestricted, UnrestrictedPort};
use crate::frame::Frame;
use crate::time::{Span, Timestamp};
use std::str::FromStr;
use std::time::{Duration, Instant};
use tracing::warn;

/// Largest step of the bus's clock while no frame comes, so that whatever falls due in a pause is
/// done in time.
const STEP: Span = Span::from_nanos(5_000_000);

/// Longest pause in which time passes; a longer one, or a negative one, means that the clock was
/// set. The monitor uses the same limit.
const LARGEST_PAUSE: Span = Span::from_nanos(3600 * 1_000_000_000);

/// Speed at which frames are played.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pace {
    /// Multiple of real time.
    Times(f64),
    /// As fast as the gateway takes the frames.
    Max,
}

impl FromStr for Pace {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text == "max" {
            return Ok(Self::Max);
        }
        let times = text.parse().ok().filter(|times| (1e-3..=1e6).contains(times));
        times
            .map(Self::Times)
            .ok_or_else(|| "expected a number from 0.001 to 1000000, or max".into())
    }
}

/// Plays frames onto a bus.
pub struct Player<S> {
    source: S,
    port: Unrestricted<Endpoint>,
    clock: ManualClock,
    pace: Pace,
    /// Next frame, at its own time.
    next: Option<Frame>,
    /// Time of the end, once there are no more frames.
    end: Option<Timestamp>,
    /// Time from the last frame to the end.
    rest: Span,
    /// An instant, and the bus's time at it.
    anchor: Option<(Instant, Timestamp)>,
    /// Number of frames that no bus carries.
    refused: u64,
    failure: Option<Failure>,
}

impl<S: Source> Player<S> {
    /// A player that ends `rest` after the last frame of `source`. `clock` is the bus's.
    ///
    /// # Errors
    /// The bus is not up.
    pub fn new(
        source: S,
        bus: &EmbeddedBus,
        clock: ManualClock,
        pace: Pace,
        rest: Span,
    ) -> Result<Self, PortError> {
        // It listens to nothing.
        let port = bus.open_unrestricted(&Identifiers::Only(Vec::new()), 1)?;
        let (next, end, anchor) = (None, None, None);
        let mut player =
            Self { source, port, clock, pace, next, end, rest, anchor, refused: 0, failure: None };
        player.fetch();
        if let Some(next) = &player.next {
            player.clock.set(next.timestamp);
        }
        Ok(player)
    }

    /// Sends the next frame, or lets some time pass, at most `patience`. Returns `false` at the
    /// end.
    pub fn step(&mut self, patience: Duration) -> bool {
        let now = self.clock.now();
        let Some(goal) = self.next.as_ref().map(|next| next.timestamp).or(self.end) else {
            return false;
        };
        let ahead = goal.since(now);
        if ahead < Span::ZERO || ahead > LARGEST_PAUSE {
            self.anchor = None;
            self.clock.set(goal);
        } else {
            let step = now.after(ahead.min(STEP));
            let reached = self.wait(now, step, patience);
            self.clock.set(reached);
        }
        if self.clock.now() == goal {
            self.arrive();
        }
        true
    }

    /// Sets another pace.
    pub fn set_pace(&mut self, pace: Pace) {
        if self.pace != pace {
            self.pace = pace;
            self.anchor = None;
        }
    }

    /// Waits until the bus's time is `goal`, at most for `patience`; returns the bus's time.
    fn wait(&mut self, now: Timestamp, goal: Timestamp, patience: Duration) -> Timestamp {
        let Pace::Times(times) = self.pace else { return goal };
        let (instant, stamp) = *self.anchor.get_or_insert((Instant::now(), now));
        let due = Duration::from_secs_f64(goal.since(stamp).as_seconds().max(0.0) / times);
        let left = due.saturating_sub(instant.elapsed());
        if left <= patience {
            std::thread::sleep(left);
            return goal;
        }
        std::thread::sleep(patience);
        let passed = Span::from_seconds(instant.elapsed().as_secs_f64() * times);
        // Never back, never beyond.
        stamp.after(passed).clamp(now, goal)
    }

    /// Advances the bus's time to that of the next frame, or of the end.
    fn arrive(&mut self) {
        let Some(frame) = self.next.take() else {
            self.end = None;
            return;
        };
        // The embedded bus is never jammed here: nobody could.
        self.refused += u64::from(self.port.send_unrestricted(&frame).is_err());
        self.fetch();
        if self.next.is_none() {
            self.end = Some(frame.timestamp.after(self.rest));
        }
    }

    fn fetch(&mut self) {
        self.next = match self.source.next_frame() {
            Ok(next) => next.cloned(),
            Err(error) => {
                self.failure = Some(error.into());
                None
            }
        };
    }
}

impl Player<Recording> {
    /// Reports what could not be played.
    ///
    /// # Errors
    /// The recording could not be read to its end.
    pub fn finish(&mut self) -> Result<(), Failure> {
        if self.refused > 0 {
            warn!(frames = self.refused, "no bus carries some of the recording's frames");
        }
        let statistics = self.source.statistics();
        if let Some(line) = statistics.first_bad_lines.first() {
            warn!(lines = statistics.bad_lines, "lines were not frames and are left out: {line}");
        }
        if let Some(failure) = self.failure.take() {
            return Err(failure);
        }
        match statistics.damage.first() {
            Some(damage) => Err(Failure::Failed(damage.to_string())),
            None => Ok(()),
        }
    }
}
