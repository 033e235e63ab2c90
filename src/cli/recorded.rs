//! The folder that the flight recorder has written, as the input of a replay.

use super::Failure;
use crate::appliance::flight::{FRAMES_FILE, is_recording};
use crate::config::MACHINE_FILE;
use std::path::PathBuf;

/// Recordings, and the configuration by which they are judged.
#[derive(Debug)]
pub struct RecordedInputs {
    pub logs: Vec<PathBuf>,
    pub config: PathBuf,
}

impl RecordedInputs {
    /// The inputs `paths`, recordings or the one folder of an incident, which has a configuration of its own;
    /// `config` takes precedence over it.
    ///
    /// # Errors There is no configuration.
    pub fn of(paths: Vec<PathBuf>, config: Option<PathBuf>) -> Result<Self, Failure> {
        let folder = match paths.as_slice() {
            [folder] if is_recording(folder) => Some(folder.clone()),
            _ => None,
        };
        if let Some(folder) = folder {
            let config = config.unwrap_or_else(|| folder.join(MACHINE_FILE));
            return Ok(Self { logs: vec![folder.join(FRAMES_FILE)], config });
        }
        let Some(config) = config else {
            return Err(Failure::Wrong(
                "the configuration is missing: give --config FILE. Only the folder of one recorded \
                 incident is replayed without"
                    .to_owned(),
            ));
        };
        Ok(Self { logs: paths, config })
    }
}
