//! A configuration with its DBC, ready to be monitored.

use super::Failure;
use crate::bus::Interfaces;
use crate::config::design::{self, Flaw};
use crate::config::{self, Document, Loaded, Settings};
use crate::dbc::{self, Database};
use crate::monitor::MonitorDesign;
use std::path::{Path, PathBuf};

/// Configuration of the simulated machine for the monitor; built in with its DBC, so that a
/// demonstration needs only the program.
const SIMULATED: &str = include_str!("../../config/e-type-simulated.toml");
const DBC: &[u8] = include_bytes!("../../dbc/e-type.dbc");

/// Makes a design for a machine.
pub type Designer = fn(&Settings, &Database) -> Result<MonitorDesign, Vec<Flaw>>;

/// A machine, as loaded from a configuration file.
#[derive(Debug)]
pub struct Machine {
    pub loaded: Loaded,
    pub database: Database,
    pub design: MonitorDesign,
}

impl Machine {
    /// Loads the configuration `path` and its DBC.
    ///
    /// # Errors Every error in either.
    pub fn load(path: &Path) -> Result<Self, Failure> {
        Self::new(config::load(path)?, design::judging)
    }

    /// Loads a machine for a command that judges nothing: model and tables may be of another sample
    /// time.
    ///
    /// # Errors See [`Self::load`], except for sample times.
    pub fn load_unjudging(path: &Path) -> Result<Self, Failure> {
        Self::new(config::load(path)?, design::unjudging)
    }

    /// Loads a machine for a command that learns from a recording: the design also reads the
    /// pressures, and tables that are to be replaced may be of another sample time.
    ///
    /// # Errors See [`Self::load_unjudging`]; also pressures that cannot be used.
    pub fn load_surveying(path: &Path) -> Result<Self, Failure> {
        Self::new(config::load(path)?, design::surveying)
    }

    /// The machine of the configuration `text` for the file `path`.
    ///
    /// # Errors See [`Self::load`].
    pub fn of_text(path: &Path, text: &str, design: Designer) -> Result<Self, Failure> {
        Self::new(config::load_text(path, text)?, design)
    }

    /// The built-in machine of `config/e-type-simulated.toml`.
    ///
    /// # Errors Only a program that was built wrongly has errors.
    pub fn simulated() -> Result<Self, Failure> {
        let (settings, document): (Settings, Document) =
            config::parse("config/e-type-simulated.toml", SIMULATED)?;
        let dbc_path = PathBuf::from("dbc/e-type.dbc");
        let dbc_text = DBC.to_vec();
        let loaded = Loaded {
            settings,
            document,
            dbc_path,
            dbc_text,
            sheets: Vec::new(),
            history_path: None,
        };
        Self::new(loaded, design::judging)
    }

    /// Interfaces of a recording whose frames are read: `asked`, if given, or else the
    /// configuration's.
    pub fn interfaces(&self, asked: Option<&str>) -> Interfaces {
        match asked {
            Some(name) => Interfaces::Only(name.to_owned()),
            None => Interfaces::One(self.loaded.settings.bus.interface.clone()),
        }
    }

    fn new(loaded: Loaded, design: Designer) -> Result<Self, Failure> {
        let text = dbc::text::from_bytes(&loaded.dbc_text);
        let mut database = Database::parse(&text).map_err(|error| {
            refusal(
                &loaded,
                &[Flaw {
                    key: "bus.dbc".to_owned(),
                    message: format!("{}: {error}", loaded.dbc_path.display()),
                    help: "correct the DBC; `tertius check` lists what is wrong with it".to_owned(),
                }],
            )
        })?;
        config::devices::connect(&loaded.settings, &loaded.sheets, &mut database)
            .map_err(|flaws| refusal(&loaded, &flaws))?;
        let design =
            design(&loaded.settings, &database).map_err(|flaws| refusal(&loaded, &flaws))?;
        Ok(Self { loaded, database, design })
    }

    /// The files of the machine that a command must not overwrite, `config` among them.
    pub fn files<'a>(&'a self, config: &'a Path) -> impl Iterator<Item = &'a Path> {
        let history = self.loaded.history_path.as_deref();
        let sheets = self.loaded.sheets.iter().map(|sheet| sheet.path.as_path());
        [config, self.loaded.dbc_path.as_path()].into_iter().chain(sheets).chain(history)
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
