//! `tertius run` on `interface = "virtual"`: a recording is played onto the embedded bus.

use super::Failure;
use super::files::{Inputs, Mark, Overwriting};
use super::machine::Machine;
use super::player::Pace;
use super::stage::{Record, Stage};
use crate::bus::embedded::NAME;
use crate::bus::{LogWriter, Options, Recording};
use crate::config::Overrides;
use crate::time::Span;
use clap::Args;
use std::path::{Path, PathBuf};

/// What is played on the embedded bus.
#[derive(Args, Debug)]
pub struct PlayOptions {
    /// With interface = "virtual": plays recordings onto the embedded bus, one after the other, and
    /// ends when they end
    #[arg(long = "play", value_name = "LOG", num_args = 1..)]
    logs: Vec<PathBuf>,
    /// Speed as a multiple of that of the recording; max: as fast as possible
    #[arg(long, value_name = "N", default_value = "1", requires = "logs")]
    speed: Pace,
    /// Plays only the frames of this interface of the recordings [default: the only one]
    #[arg(long, value_name = "NAME", requires = "logs", visible_alias = "channel")]
    interface: Option<String>,
    /// Writes the frames that the gateway sends on the embedded bus in the format of candump -l
    #[arg(long, value_name = "FILE.log", requires = "logs")]
    record: Option<PathBuf>,
    #[command(flatten)]
    overwriting: Overwriting,
}

impl PlayOptions {
    /// The embedded bus with its player, if anything is to be played.
    ///
    /// # Errors
    /// A wrong recording or configuration, or a record that cannot be written.
    pub fn stage(
        &self,
        config: &Path,
        overrides: &Overrides,
    ) -> Result<Option<Stage<Recording>>, Failure> {
        if self.logs.is_empty() {
            return Ok(None);
        }
        let machine = Machine::load(config, overrides)?;
        let settings = &machine.loaded.settings;
        wanted(Some(()), &settings.bus.interface)?;
        let interfaces = machine.interfaces(self.interface.as_deref())?;
        let options = Options { interfaces, ..Options::default() };
        let recording = Recording::open(&self.logs, options)?;
        let record = self.record(config, &machine)?;
        // The last open cycle ends, and what follows from it gets past the guard.
        let rest = settings.gateway.guard + settings.machine.sample_time;
        Stage::new(recording, self.speed, Span::from_seconds(rest), record).map(Some)
    }

    fn record(&self, config: &Path, machine: &Machine) -> Result<Option<Record>, Failure> {
        let logs = self.logs.iter().map(PathBuf::as_path);
        let inputs = Inputs::new(logs.chain(machine.files(config)));
        let [record] = inputs.claim([(self.record.as_deref(), Mark::None)], self.overwriting)?;
        record.map(|record| Ok(LogWriter::new(record.open()?, NAME))).transpose()
    }
}

/// The `stage`, if the configuration's interface is the embedded bus; `None` if it is a real one.
///
/// # Errors
/// There is nothing to play on the embedded bus, or something on a real one.
pub fn wanted<S>(stage: Option<S>, interface: &str) -> Result<Option<S>, Failure> {
    match (stage, interface == NAME) {
        (Some(_), false) => Err(Failure::Wrong(format!(
            "--play is for the embedded bus, but bus.interface is {interface:?}; set it to \
             {NAME:?}, or omit --play and play on {interface} with canplayer"
        ))),
        (None, true) => Err(Failure::Wrong(format!(
            "bus.interface is {NAME:?}, the embedded bus, on which nothing else sends; give a \
             recording to be played on it (--play LOG), or name a CAN interface"
        ))),
        (stage, _) => Ok(stage),
    }
}
