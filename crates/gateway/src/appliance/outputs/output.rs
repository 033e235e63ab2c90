//! What an output is, and what it goes by.

use crate::appliance::telemetry::Recorder;
use std::fmt::Debug;
use std::path::{Path, PathBuf};
use tertius_config::Loaded;
use tertius_config::settings::Settings;

/// What an output goes by.
#[derive(Clone, Debug)]
pub struct OutputPlan {
    pub settings: Settings,
    /// Folder that files of the settings are relative to.
    pub folder: PathBuf,
    /// The event store, if there is one.
    pub store: Option<PathBuf>,
}

impl OutputPlan {
    /// That of the configuration `loaded` from `path`.
    pub fn new(path: &Path, loaded: &Loaded) -> Self {
        Self {
            settings: loaded.settings.clone(),
            folder: path.parent().unwrap_or(Path::new("")).to_owned(),
            store: loaded.store_path.clone(),
        }
    }
}

/// A protocol over which the machine's state is served or published. It ends when this is dropped.
pub trait Output: Debug {
    /// Goes by `plan` from now on, with what `recorder` writes, and logs what has changed. Where it cannot, the output goes on
    /// as before.
    fn follow(&mut self, plan: &OutputPlan, recorder: &Recorder);
}
