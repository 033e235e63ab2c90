//! A configuration with its DBC, ready to be monitored.

use super::Failure;
use crate::config::{self, Document, Loaded, Settings};
use crate::decode::{self, Database};
use crate::monitor::MonitorDesign;
use crate::monitor::design::Flaw;
use std::path::{Path, PathBuf};

/// The simulated machine for the monitor, and its DBC; built in, so that a demonstration needs
/// nothing but the program.
const SIMULATED: &str = include_str!("../../config/e-type-simulated.toml");
const DBC: &[u8] = include_bytes!("../../dbc/e-type.dbc");

/// What a configuration file leads to.
#[derive(Debug)]
pub struct Machine {
    pub loaded: Loaded,
    pub database: Database,
    pub design: MonitorDesign,
}

impl Machine {
    /// Reads the configuration `path` and its DBC.
    ///
    /// # Errors
    /// Everything wrong with either.
    pub fn load(path: &Path) -> Result<Self, Failure> {
        Self::new(config::load(path)?)
    }

    /// The machine of `config/e-type-simulated.toml`, which is built in.
    ///
    /// # Errors
    /// None but those of a program that was built wrongly.
    pub fn simulated() -> Result<Self, Failure> {
        let (settings, document): (Settings, Document) =
            config::parse("config/e-type-simulated.toml", SIMULATED)?;
        let dbc_path = PathBuf::from("dbc/e-type.dbc");
        let dbc_text = DBC.to_vec();
        Self::new(Loaded { settings, document, dbc_path, dbc_text, history_path: None })
    }

    fn new(loaded: Loaded) -> Result<Self, Failure> {
        let text = decode::text::from_bytes(&loaded.dbc_text);
        let database = Database::parse(&text).map_err(|error| {
            refusal(
                &loaded,
                &[Flaw {
                    key: "bus.dbc".to_owned(),
                    message: format!("{}: {error}", loaded.dbc_path.display()),
                    help: "correct the DBC; `tertius check` lists what is wrong with it".to_owned(),
                }],
            )
        })?;
        let design = MonitorDesign::new(&loaded.settings, &database)
            .map_err(|flaws| refusal(&loaded, &flaws))?;
        Ok(Self { loaded, database, design })
    }

    /// A design that reads the pressures, too, for who learns from a recording.
    ///
    /// # Errors
    /// Pressures that cannot be used.
    pub fn surveying(&self) -> Result<MonitorDesign, Failure> {
        MonitorDesign::surveying(&self.loaded.settings, &self.database)
            .map_err(|flaws| refusal(&self.loaded, &flaws))
    }
}

fn refusal(loaded: &Loaded, flaws: &[Flaw]) -> Failure {
    let document = &loaded.document;
    let problems =
        flaws.iter().map(|flaw| document.problem(&flaw.key, flaw.message.clone(), &*flaw.help));
    document.refuse(problems).map_or_else(
        || Failure::Failed("the configuration was refused without a reason".to_owned()),
        Failure::from,
    )
}
