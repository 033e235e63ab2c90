//! Audience of the demonstration.

use super::listener::{Heard, Listener};
use super::scene::Scene;
use super::score::Score;
use super::screen::Screen;
use super::{view, wording};
use crate::bus::embedded::{Endpoint, NAME};
use crate::bus::{LogWriter, Port, append_log_line};
use crate::cli::Failure;
use crate::cli::files::Claimed;
use crate::cli::player::Pace;
use crate::cli::simulation::Simulation;
use crate::cli::stage::{Record, Stage};
use crate::frame::Frame;
use crate::live::gateway::{Gateway, Journal};
use crate::live::supervisor::{Opener, Request, Surroundings};
use crate::monitor;
use crate::simulator::EPOCH;
use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// Receives the frames on the bus, shows what happens, and keeps score.
pub struct Audience {
    pub stage: Stage<Simulation>,
    pub ear: Endpoint,
    pub listener: Listener,
    pub screen: Screen,
    pub record: Option<Record>,
    /// Pace from the first fault on.
    pub pace: Pace,
    /// Limits of R1, R2 and R3, m.
    pub limits: [f64; 3],
    pub over: Arc<AtomicBool>,
    pub interrupted: Arc<AtomicBool>,
    pub scene: Scene,
    pub score: Score,
    /// Number of frames that are unknown or damaged.
    pub strangers: u64,
    /// Number of acts that were announced, and that were announced as over.
    pub begun: [usize; 2],
    pub failure: Option<Failure>,
}

impl Audience {
    /// Shows the frames that have come on the bus since the last call.
    pub fn attend(&mut self) {
        self.scene.now = self.stage.now().since(EPOCH).as_seconds().max(0.0);
        self.announce();
        let mut frames = Vec::new();
        // Nobody takes this bus down while the gateway is on it.
        _ = self.ear.receive(Duration::ZERO, &mut |frame| frames.push(frame.clone()));
        frames.iter().for_each(|frame| self.hear(frame));
        let (scene, limits) = (&self.scene, self.limits);
        let drawn = self.screen.draw(|| view::lines(scene, limits));
        self.note("standard output", drawn);
    }

    fn note(&mut self, what: &str, result: io::Result<()>) {
        if let Err(error) = result {
            self.failure.get_or_insert_with(|| Failure::writing(what, &error));
        }
    }

    /// Prints a line for output without a drawing.
    fn tell(&mut self, line: impl FnOnce() -> String) {
        if !self.screen.is_terminal() {
            let said = self.screen.say(&[line()]);
            self.note("standard output", said);
        }
    }

    fn announce(&mut self) {
        let now = self.scene.now;
        let programme = &self.scene.programme;
        if now >= programme.curtain() {
            self.stage.set_pace(self.pace);
        }
        let [begun, over] = self.begun;
        if over < begun && now >= programme.window(over)[1] {
            self.begun[1] += 1;
            self.tell(|| format!("{now:7.2} s  that is over"));
        }
        let programme = &self.scene.programme;
        if let Some(act) = programme.acts.get(begun)
            && now >= programme.window(begun)[0]
        {
            let line = format!("\n{now:7.2} s  now: {}\n{:11}{}", act.title, "", act.hint);
            self.begun[0] += 1;
            self.tell(|| line);
        }
    }

    fn hear(&mut self, frame: &Frame) {
        if let Some(record) = &mut self.record {
            let written = record.write(frame);
            self.note("the record", written);
        }
        let at = frame.timestamp.since(EPOCH).as_seconds();
        match self.listener.hear(frame) {
            Heard::Machine => {}
            Heard::Platform(state) => {
                if state != self.scene.platform {
                    self.tell(|| format!("{at:7.2} s  the platform is {state}"));
                    self.scene.platform = state;
                }
            }
            Heard::Status(status) => {
                self.scene.sent[0] += 1;
                self.scene.last_status = candump(frame) + "  Fd_Status";
                if status != self.scene.status {
                    let line = candump(frame);
                    self.tell(|| {
                        format!("{at:7.2} s  {}\n{:11}{line}", wording::status(&status), "")
                    });
                    self.scene.status = status;
                }
            }
            Heard::Warning(warning) => {
                self.scene.sent[1] += 1;
                self.scene.send(candump(frame) + "  Fd_Warning");
                if self.score.take(at, &warning) {
                    let level = if warning.raised { &*warning.level } else { "clear" };
                    let line = format!("{at:7.2} s {level:<6} {}", wording::warning(&warning));
                    self.tell(|| format!("{line}\n{:11}{}", "", candump(frame)));
                    self.scene.warn(line);
                }
            }
            Heard::Damaged | Heard::Stranger => self.strangers += 1,
        }
    }
}

/// A frame as candump writes it.
fn candump(frame: &Frame) -> String {
    let mut line = Vec::with_capacity(64);
    append_log_line(&mut line, NAME, frame);
    String::from_utf8_lossy(&line).trim_end().to_owned()
}

impl Journal for Audience {
    fn record(&mut self, record: &monitor::Record) {
        self.scene.record(record);
    }
}

impl Surroundings for Audience {
    fn request(&mut self) -> Request {
        let wanted = [&self.over, &self.interrupted].iter().any(|it| it.load(Ordering::Relaxed));
        if wanted || self.failure.is_some() { Request::Stop } else { Request::GoOn }
    }

    /// Does not wait, since the embedded bus always has room.
    fn wait(&mut self, _: Duration) {}

    fn opened(&mut self, _: &dyn Port) {}

    fn lost(&mut self, reason: &str) {
        self.failure = Some(Failure::Failed(format!("the embedded bus: {reason}")));
    }

    /// Does nothing, since the embedded bus takes every frame.
    fn report_not_sent(&mut self, _: &str) {}

    fn turned(&mut self, _: &Gateway, _: &dyn Port) {
        self.attend();
    }

    fn reload(&mut self, _: &Gateway) -> Option<(Gateway, Box<dyn Opener>)> {
        None
    }
}

/// A file for all frames of the bus.
pub fn record(claimed: Claimed) -> Result<Record, Failure> {
    Ok(LogWriter::new(claimed.open()?, NAME))
}
