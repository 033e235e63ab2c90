//! The embedded bus with a player, and a place for the gateway.

use super::Failure;
use super::files::Writer;
use super::player::{Pace, Player};
use crate::alarm::OwnFrame;
use crate::bus::embedded::{Clock, EmbeddedBus, Endpoint, ManualClock};
use crate::bus::{
    Identifiers, LogWriter, Port, PortCounts, PortError, Received, Recording, Sent, Source, Stamps,
};
use crate::frame::Frame;
use crate::live::outbox::OutboxLimits;
use crate::live::supervisor::Opener;
use crate::time::{Span, Timestamp};
use std::cell::RefCell;
use std::rc::Rc;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// Most frames that wait for a listener: two turns of the gateway, each with everything that it may
/// send at once. The player lets the gateway have a turn after each frame.
const CAPACITY: usize = 2 * (OutboxLimits::BURST as usize + 1);

/// A file of frames in the format of `candump -l`.
pub type Record = LogWriter<Writer>;

/// The embedded bus and its player. Clones are the same one.
pub struct Stage<S>(Rc<RefCell<Play<S>>>);

impl<S> Clone for Stage<S> {
    fn clone(&self) -> Self {
        Self(Rc::clone(&self.0))
    }
}

struct Play<S> {
    bus: EmbeddedBus,
    player: Player<S>,
    record: Option<Record>,
    /// First failure of the record.
    failure: Option<Failure>,
    /// Flag that is set when everything has been played.
    stop: Arc<AtomicBool>,
}

impl<S: Source + 'static> Stage<S> {
    /// A bus on which `source` is played; it ends `rest` after the last frame. Frames of the
    /// gateway also go into `record`.
    ///
    /// # Errors
    /// None in practice, since the bus is new.
    pub fn new(source: S, pace: Pace, rest: Span, record: Option<Record>) -> Result<Self, Failure> {
        let clock = ManualClock::new(Timestamp::default());
        let bus = EmbeddedBus::new(Clock::Manual(clock.clone()));
        let player = Player::new(source, &bus, clock, pace, rest).map_err(refused)?;
        let play = Play { bus, player, record, failure: None, stop: Arc::default() };
        Ok(Self(Rc::new(RefCell::new(play))))
    }

    /// An opener of the bus for a gateway that receives `identifiers`.
    pub fn opener(&self, identifiers: Identifiers) -> Box<dyn Opener> {
        Box::new(Seat { stage: self.clone(), identifiers })
    }

    /// An endpoint that receives all frames.
    ///
    /// # Errors
    /// None in practice, since nobody takes this bus down.
    pub fn listener(&self) -> Result<Endpoint, Failure> {
        self.0.borrow().bus.open(&Identifiers::All, CAPACITY).map_err(refused)
    }

    /// Sets `stop` once everything is played.
    pub fn stop_at_end(&self, stop: Arc<AtomicBool>) {
        self.0.borrow_mut().stop = stop;
    }

    /// Sets another pace.
    pub fn set_pace(&self, pace: Pace) {
        self.0.borrow_mut().player.set_pace(pace);
    }

    /// Time of the bus.
    pub fn now(&self) -> Timestamp {
        self.0.borrow().bus.now()
    }
}

impl Stage<Recording> {
    /// Finishes the record.
    ///
    /// # Errors
    /// The recording could not be played completely, or the record could not be written.
    pub fn finish(&self) -> Result<(), Failure> {
        let mut play = self.0.borrow_mut();
        if let Some(failure) = play.failure.take() {
            return Err(failure);
        }
        if let Some(record) = play.record.take() {
            record.into_inner().finish().map_err(|error| Failure::writing("the record", &error))?;
        }
        play.player.finish()
    }
}

fn refused(error: PortError) -> Failure {
    Failure::Failed(format!("the embedded bus: {error}"))
}

/// The gateway's place on the bus.
struct Seat<S> {
    stage: Stage<S>,
    identifiers: Identifiers,
}

impl<S: Source + 'static> Opener for Seat<S> {
    fn open(&mut self) -> Result<Box<dyn Port>, String> {
        let opened = self.stage.0.borrow().bus.open(&self.identifiers, CAPACITY);
        let endpoint = opened.map_err(|error| error.to_string())?;
        Ok(Box::new(Played { endpoint, stage: self.stage.clone() }))
    }
}

/// The gateway's port, which plays the next frame when the gateway listens.
struct Played<S> {
    endpoint: Endpoint,
    stage: Stage<S>,
}

impl<S: Source> Port for Played<S> {
    fn receive(
        &mut self,
        patience: Duration,
        take: &mut dyn FnMut(&Frame),
    ) -> Result<Received, PortError> {
        let mut play = self.stage.0.borrow_mut();
        if !play.player.step(patience) {
            play.stop.store(true, Ordering::Relaxed);
        }
        drop(play);
        self.endpoint.receive(patience, take)
    }

    fn send(&mut self, frame: &OwnFrame) -> Result<Sent, PortError> {
        let sent = self.endpoint.send(frame)?;
        if sent == Sent::Taken {
            self.stage.0.borrow_mut().write(frame);
        }
        Ok(sent)
    }

    fn counts(&self) -> PortCounts {
        self.endpoint.counts()
    }

    fn stamps(&self) -> Stamps {
        self.endpoint.stamps()
    }

    fn description(&self) -> String {
        self.endpoint.description()
    }
}

impl<S> Play<S> {
    /// Records a frame of the gateway, at the time of the bus.
    fn write(&mut self, frame: &OwnFrame) {
        let Some(record) = &mut self.record else { return };
        let mut frame = frame.as_frame().clone();
        frame.timestamp = self.bus.now();
        if let Err(error) = record.write(&frame) {
            self.record = None;
            self.failure = Some(Failure::writing("the record", &error));
            // There is no use in going on.
            self.stop.store(true, Ordering::Relaxed);
        }
    }
}
