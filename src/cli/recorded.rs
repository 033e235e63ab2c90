//! The folder that the flight recorder has written, as the input of a replay.

use super::Failure;
use crate::appliance::flight::{FRAMES_FILE, STATE_FILE, is_recording};
use crate::config::MACHINE_FILE;
use std::path::{Path, PathBuf};

/// Recordings, and what they are judged by.
#[derive(Debug)]
pub struct RecordedInputs {
    pub logs: Vec<PathBuf>,
    pub config: PathBuf,
    /// File with the monitor's state at the first frame.
    pub state: Option<PathBuf>,
}

impl RecordedInputs {
    /// The inputs `paths`: recordings, or the one folder of an incident, which has a configuration of its own and
    /// mostly a state. Another configuration, `config`, takes precedence over both.
    ///
    /// # Errors
    /// There is no configuration.
    pub fn of(paths: &[PathBuf], config: Option<&Path>) -> Result<Self, Failure> {
        let folder = match paths {
            [folder] => Some(folder).filter(|folder| is_recording(folder)),
            _ => None,
        };
        let logs = folder.map_or_else(|| paths.to_vec(), |folder| vec![folder.join(FRAMES_FILE)]);
        match (config, folder) {
            (Some(config), _) => Ok(Self { logs, config: config.to_owned(), state: None }),
            (None, Some(folder)) => {
                let state = Some(folder.join(STATE_FILE)).filter(|state| state.exists());
                Ok(Self { logs, config: folder.join(MACHINE_FILE), state })
            }
            (None, None) => Err(Failure::Wrong(
                "the configuration is missing: give --config FILE. Only the folder of one recorded \
                 incident is replayed without"
                    .to_owned(),
            )),
        }
    }
}
