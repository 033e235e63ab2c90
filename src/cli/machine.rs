//! A configuration with its DBC, ready to be monitored.

use super::Failure;
use crate::bus::Interfaces;
use crate::config::design::{self, Flaw};
use crate::config::{self, Document, Loaded, Settings};
use crate::dbc::{self, Database};
use crate::monitor::MonitorDesign;
use std::path::{Path, PathBuf};

/// The simulated machine for the monitor, and its DBC; built in, so that a demonstration needs
/// nothing but the program.
const SIMULATED: &str = include_str!("../../config/e-type-simulated.toml");
const DBC: &[u8] = include_bytes!("../../dbc/e-type.dbc");

/// Makes a design for a machine.
pub type Designer = fn(&Settings, &Database) -> Result<MonitorDesign, Vec<Flaw>>;

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
        Self::new(config::load(path)?, design::judging)
    }

    /// The same for who judges nothing with it: model and tables may be of another sample time.
    ///
    /// # Errors
    /// As [`Self::load`], but for sample times.
    pub fn load_unjudging(path: &Path) -> Result<Self, Failure> {
        Self::new(config::load(path)?, design::unjudging)
    }

    /// The same for who learns from a recording: the design reads the pressures, too, and what is to be
    /// learnt anew may be of another sample time.
    ///
    /// # Errors
    /// As [`Self::load_unjudging`], and pressures that cannot be used.
    pub fn load_surveying(path: &Path) -> Result<Self, Failure> {
        Self::new(config::load(path)?, design::surveying)
    }

    /// The machine of the configuration `text`, which is to be in the file `path`.
    ///
    /// # Errors
    /// As [`Self::load`].
    pub fn of_text(path: &Path, text: &str, design: Designer) -> Result<Self, Failure> {
        Self::new(config::load_text(path, text)?, design)
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
        let loaded = Loaded { settings, document, dbc_path, dbc_text, history_path: None };
        Self::new(loaded, design::judging)
    }

    /// Whose frames of a recording are read: of the interface `asked` for, else of the configuration's.
    pub fn interfaces(&self, asked: Option<&str>) -> Interfaces {
        match asked {
            Some(name) => Interfaces::Only(name.to_owned()),
            None => Interfaces::One(self.loaded.settings.bus.interface.clone()),
        }
    }

    fn new(loaded: Loaded, design: Designer) -> Result<Self, Failure> {
        let text = dbc::text::from_bytes(&loaded.dbc_text);
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
        let design =
            design(&loaded.settings, &database).map_err(|flaws| refusal(&loaded, &flaws))?;
        Ok(Self { loaded, database, design })
    }

    /// The files of the machine that a command must not write over, `config` among them.
    pub fn files<'a>(&'a self, config: &'a Path) -> impl Iterator<Item = &'a Path> {
        let history = self.loaded.history_path.as_deref();
        [config, self.loaded.dbc_path.as_path()].into_iter().chain(history)
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
