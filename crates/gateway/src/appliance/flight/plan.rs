//! What is recorded, and where to.

use std::path::{Path, PathBuf};
use tertius_config::{Fingerprints, Loaded, MachineNames, PortableFile};
use tertius_core::monitor::{DesignChecksum, MonitorDesign};
use tertius_core::time::Span;

/// Name of the frames of a recording in its folder.
pub const FRAMES_FILE: &str = "frames.log.zst";

/// Name of the file in the folder of a recording.
pub const MANIFEST: &str = "incident.json";

/// Name of the monitor's state at the first frame.
pub const STATE_FILE: &str = "monitor.state";

/// What a recorder needs of a configuration.
#[derive(Clone, Debug)]
pub struct FlightPlan {
    /// Folder of the recordings.
    pub folder: PathBuf,
    /// Time recorded before the begin of an incident, and after its opening.
    pub before: Span,
    pub after: Span,
    /// Most bytes that all recordings take.
    pub size: u64,
    /// Name of the machine.
    pub machine: String,
    /// How its cylinders and transducers are called.
    pub names: MachineNames,
    /// Which configuration the recordings are judged by.
    pub fingerprints: Fingerprints,
    /// Names of the buses, by number.
    pub interfaces: Vec<String>,
    /// The configuration and all that it names, as they were read.
    pub files: Vec<PortableFile>,
    /// What the states of the monitor belong to.
    pub design: DesignChecksum,
}

impl FlightPlan {
    /// The plan of the configuration `loaded` from the file `path`, with the monitor's `design`; `None` if it records nothing.
    pub fn new(path: &Path, loaded: &Loaded, design: &MonitorDesign) -> Option<Self> {
        let settings = &loaded.settings.recorder;
        let folder = settings.folder.as_ref()?;
        let base = path.parent().unwrap_or(Path::new(""));
        let taken = [FRAMES_FILE, STATE_FILE, MANIFEST];
        Some(Self {
            folder: base.join(folder),
            before: Span::from_seconds(settings.before),
            after: Span::from_seconds(settings.after),
            size: u64::from(settings.size) * 1_000_000,
            machine: loaded.settings.machine.name.clone(),
            names: loaded.settings.names(),
            fingerprints: loaded.fingerprints(),
            interfaces: loaded.settings.bus.interfaces().map(|(_, name)| name.to_owned()).collect(),
            // It was loaded, so it is TOML.
            files: loaded.portable(&taken).unwrap_or_default(),
            design: design.checksum(),
        })
    }
}
