//! A configuration with its DBC, ready to be monitored.

use super::Failure;
use crate::bus::{Interfaces, SeveralInterfaces};
use crate::config::design::{self, Flaw};
#[cfg(feature = "cli")]
use crate::config::settings::bus_of;
use crate::config::units::Converted;
use crate::config::{self, Document, Loaded, Overrides, Settings, Sheet};
use crate::dbc::{self, Database};
use crate::frame::BusNumber;
use crate::monitor::MonitorDesign;
#[cfg(feature = "cli")]
use crate::report::RecordedPace;
use crate::time::Span;
use std::path::{Path, PathBuf};

/// Configuration of the simulated machine for the monitor; built in with its DBC, so that a
/// demonstration needs only the program.
const SIMULATED: &str = include_str!("../../config/e-type-simulated.toml");
const DBC: &[u8] = include_bytes!("../../dbc/e-type.dbc");

/// The same machine with CANopen devices; its corrections are those of the other.
const CANOPEN: &str = include_str!("../../config/e-type-canopen.toml");
const CANOPEN_DBC: &[u8] = include_bytes!("../../dbc/e-type-canopen.dbc");
const SHEETS: [(&str, &[u8]); 2] = [
    ("../dbc/encoder.eds", include_bytes!("../../dbc/encoder.eds")),
    ("../dbc/valve.eds", include_bytes!("../../dbc/valve.eds")),
];

/// Makes a design for a machine.
pub type Designer = fn(&Settings, &Database) -> Result<MonitorDesign, Vec<Flaw>>;

/// A machine, as loaded from a configuration file.
#[derive(Debug)]
pub struct Machine {
    pub loaded: Loaded,
    pub database: Database,
    /// Signals that are read in another unit than the DBC gives them.
    pub converted: Vec<Converted>,
    pub design: MonitorDesign,
}

impl Machine {
    /// Loads the configuration `path` with `overrides` in force, and its DBC.
    ///
    /// # Errors
    /// Every error in either.
    pub fn load(path: &Path, overrides: &Overrides) -> Result<Self, Failure> {
        Self::new(config::load_with(path, overrides)?, design::judging)
    }

    /// Loads a machine whose configuration is looked at, and which need not be commissioned yet.
    ///
    /// # Errors
    /// See [`Self::load`], except for a default model of another sample time.
    pub fn load_checking(path: &Path, overrides: &Overrides) -> Result<Self, Failure> {
        Self::new(config::load_with(path, overrides)?, design::checking)
    }

    /// Loads a machine for a command that judges nothing: model and tables may be of another sample
    /// time.
    ///
    /// # Errors
    /// See [`Self::load`], except for sample times.
    pub fn load_unjudging(path: &Path, overrides: &Overrides) -> Result<Self, Failure> {
        Self::new(config::load_with(path, overrides)?, design::unjudging)
    }

    /// Loads a machine for a command that learns from a recording: the design also reads the
    /// pressures, and tables that are to be replaced may be of another sample time.
    ///
    /// # Errors
    /// See [`Self::load_unjudging`]; also pressures that cannot be used.
    pub fn load_surveying(path: &Path, overrides: &Overrides) -> Result<Self, Failure> {
        Self::new(config::load_with(path, overrides)?, design::surveying)
    }

    /// The machine of the configuration `text` for the file `path`, without overrides.
    ///
    /// # Errors
    /// See [`Self::load`].
    pub fn of_text(path: &Path, text: &str, design: Designer) -> Result<Self, Failure> {
        Self::new(config::load_text(path, text)?, design)
    }

    /// The built-in machine of `config/e-type-simulated.toml`.
    ///
    /// # Errors
    /// Only a program that was built wrongly has errors.
    pub fn simulated() -> Result<Self, Failure> {
        Self::built_in("e-type-simulated.toml", SIMULATED, ("e-type.dbc", DBC), Vec::new())
    }

    /// The same machine with the CANopen devices of `config/e-type-canopen.toml`.
    ///
    /// # Errors
    /// Only a program that was built wrongly has errors.
    pub fn simulated_canopen() -> Result<Self, Failure> {
        let corrections = SIMULATED.find("[[cylinder]]").map_or("", |at| &SIMULATED[at..]);
        let sheet = |(name, text): (&str, &[u8])| Sheet {
            name: name.to_owned(),
            path: PathBuf::from(name),
            text: text.to_vec(),
        };
        let (text, sheets) = (format!("{CANOPEN}\n{corrections}"), SHEETS.map(sheet).into());
        let dbc = ("e-type-canopen.dbc", CANOPEN_DBC);
        Self::built_in("e-type-canopen.toml", &text, dbc, sheets)
    }

    fn built_in(
        name: &str,
        text: &str,
        (dbc, dbc_text): (&str, &[u8]),
        sheets: Vec<Sheet>,
    ) -> Result<Self, Failure> {
        let (settings, document): (Settings, Document) =
            config::parse(&format!("config/{name}"), text)?;
        let dbc_path = PathBuf::from(format!("dbc/{dbc}"));
        let dbc_text = dbc_text.to_vec();
        let (history_path, store_path) = (None, None);
        let loaded =
            Loaded { settings, document, dbc_path, dbc_text, sheets, history_path, store_path };
        Self::new(loaded, design::judging)
    }

    /// Interfaces of a recording whose frames are read: `asked`, if given, or else the
    /// configuration's. For a machine with several buses, `asked` has the form `first=vcan0,second=vcan1`.
    ///
    /// # Errors
    /// `asked` has not the form that this machine needs.
    pub fn interfaces(&self, asked: Option<&str>) -> Result<Interfaces, Failure> {
        let bus = &self.loaded.settings.bus;
        let disorder = Span::from_seconds(self.loaded.settings.gateway.guard);
        let several = |buses| Interfaces::Several(SeveralInterfaces { buses, disorder });
        let configured = bus.interfaces().map(|(bus, name)| (bus, name.to_owned()));
        match asked {
            None if bus.is_several() => Ok(several(configured.collect())),
            Some(asked) if bus.is_several() => Ok(several(mapped(configured.collect(), asked)?)),
            Some(name) => Ok(Interfaces::Only(name.to_owned())),
            None => Ok(Interfaces::One(bus.interface.clone())),
        }
    }

    /// Refuses a machine with several buses, for what knows one: `what`, and what to do instead.
    ///
    /// # Errors
    /// The machine has several buses.
    pub fn refuse_several(&self, what: &str, instead: &str) -> Result<(), Failure> {
        if !self.loaded.settings.bus.is_several() {
            return Ok(());
        }
        let name = self.loaded.document.name();
        Err(Failure::Wrong(format!(
            "{name} has several buses ([bus.second]), and {what} knows only one; {instead}"
        )))
    }

    fn new(loaded: Loaded, design: Designer) -> Result<Self, Failure> {
        let text = dbc::text::from_bytes(&loaded.dbc_text);
        let mut database = Database::parse(&text).map_err(|error| {
            refusal(
                &loaded,
                &[Flaw {
                    key: "bus.dbc".to_owned(),
                    message: format!("{}: {error}", loaded.dbc_path.display()),
                    help: "correct the DBC".to_owned(),
                }],
            )
        })?;
        config::devices::connect(&loaded.settings, &loaded.sheets, &mut database)
            .map_err(|flaws| refusal(&loaded, &flaws))?;
        let converted = config::units::convert(&loaded.settings, &mut database);
        let design =
            design(&loaded.settings, &database).map_err(|flaws| refusal(&loaded, &flaws))?;
        Ok(Self { loaded, database, converted, design })
    }

    /// The files of the machine that a command must not overwrite, `config` among them.
    pub fn files<'a>(&'a self, config: &'a Path) -> impl Iterator<Item = &'a Path> {
        let history = self.loaded.history_path.as_deref();
        let store = self.loaded.store_path.as_deref();
        let sheets = self.loaded.sheets.iter().map(|sheet| sheet.path.as_path());
        let kept = history.into_iter().chain(store);
        [config, self.loaded.dbc_path.as_path()].into_iter().chain(sheets).chain(kept)
    }
}

/// What a recording is compared with.
#[cfg(feature = "cli")]
impl Machine {
    /// Times the cycles of a recording.
    pub fn pace(&self) -> RecordedPace {
        let settings = &self.loaded.settings;
        RecordedPace::new(
            &self.design,
            settings.machine.sample_time,
            settings.signals.sync.as_deref(),
        )
    }

    /// Numbers and names of the platform's states, as far as the DBC names them.
    pub fn platform_states(&self) -> Vec<(i64, String)> {
        let signal = self.loaded.settings.signals.state.as_deref();
        let found = signal.and_then(bus_of).and_then(|(_, name)| self.database.signal(name).ok());
        found.map_or_else(Vec::new, |(_, signal)| signal.values.clone())
    }
}

/// The interfaces of several buses, with those that `asked` names instead of the `configured` ones.
fn mapped(
    mut configured: Vec<(BusNumber, String)>,
    asked: &str,
) -> Result<Vec<(BusNumber, String)>, Failure> {
    for part in asked.split(',') {
        let named = part.split_once('=').and_then(|(bus, name)| {
            let wanted = bus.trim();
            let own = configured.iter_mut().find(|(bus, _)| bus.to_string() == wanted)?;
            Some((own, name.trim()))
        });
        let Some((own, name)) = named.filter(|(_, name)| !name.is_empty()) else {
            let buses: Vec<String> =
                configured.iter().map(|(bus, name)| format!("{bus}={name}")).collect();
            return Err(Failure::Wrong(format!(
                "--interface {asked}: found {part:?}, expected a bus of the configuration and its interface in the \
                 recording, such as {}",
                buses.join(",")
            )));
        };
        own.1 = name.to_owned();
    }
    Ok(configured)
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
