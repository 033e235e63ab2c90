//! `tertius run` on `interface = "virtual"`: a recording is played onto the embedded bus.

use super::Failure;
use super::machine::Machine;
use super::player::{Pace, Player};
use crate::alarm::OwnFrame;
use crate::bus::embedded::{Clock, EmbeddedBus, Endpoint, ManualClock};
use crate::bus::{
    Identifiers, LogWriter, Options, Port, PortCounts, PortError, Received, Recording, Sent, Stamps,
};
use crate::frame::{Frame, Id};
use crate::live::supervisor::Opener;
use crate::time::{Span, Timestamp};
use clap::Args;
use std::cell::RefCell;
use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// The name of the embedded bus in a configuration.
const NAME: &str = "virtual";

/// Frames that may wait for the gateway; the player lets it have a turn after each.
const CAPACITY: usize = 64;

/// What is played on the embedded bus.
#[derive(Args, Debug)]
pub struct PlayOptions {
    /// With interface = "virtual": plays recordings onto the embedded bus, one after the other, and
    /// ends when they end
    #[arg(long = "play", value_name = "LOG", num_args = 1..)]
    logs: Vec<PathBuf>,
    /// How many times as fast as they were recorded; max: as fast as it goes
    #[arg(long, value_name = "N", default_value = "1", requires = "logs")]
    speed: Pace,
    /// Writes what the gateway sends on the embedded bus as candump -l would
    #[arg(long, value_name = "FILE.log", requires = "logs")]
    record: Option<PathBuf>,
}

impl PlayOptions {
    /// The embedded bus with what is to be played, if anything is.
    ///
    /// # Errors
    /// What is wrong with the recordings, the configuration or the file to record to.
    pub fn stage(&self, config: &Path) -> Result<Option<Stage>, Failure> {
        if self.logs.is_empty() {
            return Ok(None);
        }
        let loaded = Machine::load(config)?.loaded;
        let settings = &loaded.settings;
        wanted(Some(()), &settings.bus.interface)?;
        let recording = Recording::open(&self.logs, Options::default())?;
        let inputs = [config, &loaded.dbc_path];
        let record = self.record.as_deref().map(|path| self.create(path, &inputs)).transpose()?;
        // The last open cycle ends, and what follows from it gets past the guard.
        let rest = settings.gateway.guard + settings.machine.sample_time;
        let clock = ManualClock::new(Timestamp::default());
        let bus = EmbeddedBus::new(Clock::Manual(clock.clone()));
        let player = Player::new(recording, &bus, clock, self.speed, Span::from_seconds(rest))
            .map_err(|error| Failure::Failed(format!("the embedded bus: {error}")))?;
        let play = Play { bus, player, record, failure: None, stop: Arc::default() };
        Ok(Some(Stage(Rc::new(RefCell::new(play)))))
    }

    fn create(&self, path: &Path, inputs: &[&Path]) -> Result<Record, Failure> {
        let same = |other: &&Path| match (path.canonicalize(), other.canonicalize()) {
            (Ok(one), Ok(other)) => one == other && one.is_file(),
            _ => false,
        };
        let logs = self.logs.iter().map(PathBuf::as_path);
        if let Some(input) = logs.chain(inputs.iter().copied()).find(same) {
            return Err(Failure::Wrong(format!(
                "--record {} would be written over the input {}; name another file",
                path.display(),
                input.display()
            )));
        }
        let file = File::create(path).map_err(|error| Failure::creating(path, &error))?;
        Ok(LogWriter::new(BufWriter::new(file), NAME))
    }
}

/// `stage`, where the configuration's interface is the embedded bus; `None` where it is a real one.
///
/// # Errors
/// If there is nothing to play on the one, or something on the other.
pub fn wanted<S>(stage: Option<S>, interface: &str) -> Result<Option<S>, Failure> {
    match (stage, interface == NAME) {
        (Some(_), false) => Err(Failure::Wrong(format!(
            "--play is for the embedded bus, but bus.interface is {interface:?}; set it to \
             {NAME:?}, or leave --play out and play on {interface} with canplayer"
        ))),
        (None, true) => Err(Failure::Wrong(format!(
            "bus.interface is {NAME:?}, the embedded bus, where nobody speaks; give a recording to \
             be played on it (--play LOG), or name a CAN interface"
        ))),
        (stage, _) => Ok(stage),
    }
}

type Record = LogWriter<BufWriter<File>>;

/// The embedded bus and who plays on it. Clones are the same one.
#[derive(Clone)]
pub struct Stage(Rc<RefCell<Play>>);

struct Play {
    bus: EmbeddedBus,
    player: Player,
    record: Option<Record>,
    /// The first of the record.
    failure: Option<Failure>,
    /// Set when the recording has ended.
    stop: Arc<AtomicBool>,
}

impl Stage {
    /// What opens the bus for a gateway that listens to `identifiers`.
    pub fn opener(&self, identifiers: Vec<Id>) -> Box<dyn Opener> {
        Box::new(Seat { stage: self.clone(), identifiers: Identifiers::Only(identifiers) })
    }

    /// `stop` is set once all is played.
    pub fn stop_at_end(&self, stop: Arc<AtomicBool>) {
        self.0.borrow_mut().stop = stop;
    }

    /// Ends the record.
    ///
    /// # Errors
    /// What kept the recording from being played whole, or the record from being written.
    pub fn finish(&self) -> Result<(), Failure> {
        let mut play = self.0.borrow_mut();
        if let Some(failure) = play.failure.take() {
            return Err(failure);
        }
        if let Some(record) = &mut play.record {
            record.flush().map_err(|error| Failure::writing("the record", &error))?;
        }
        play.player.finish()
    }
}

/// The gateway's place on the bus.
struct Seat {
    stage: Stage,
    identifiers: Identifiers,
}

impl Opener for Seat {
    fn open(&mut self) -> Result<Box<dyn Port>, String> {
        let opened = self.stage.0.borrow().bus.open(&self.identifiers, CAPACITY);
        let endpoint = opened.map_err(|error| error.to_string())?;
        Ok(Box::new(Played { endpoint, stage: self.stage.clone() }))
    }
}

/// The gateway's port: as it listens, the next is played.
struct Played {
    endpoint: Endpoint,
    stage: Stage,
}

impl Port for Played {
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

impl Play {
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
