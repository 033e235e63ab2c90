//! `tertius run`: the live gateway.

use super::Failure;
use super::doctor;
use super::gateway::{gateway, identifiers};
use super::machine::Machine;
use super::overriding::SetOptions;
use super::stage::Stage;
use super::tls::tls_files;
use super::virtual_bus::{self, PlayOptions};
use crate::appliance::flight::FlightPlan;
use crate::appliance::history::{HistoryFile, Kept};
use crate::appliance::http::{DeskPlan, LoginLimits};
use crate::appliance::logging::{self, LogFormat};
use crate::appliance::outputs::OutputPlan;
use crate::appliance::realtime;
use crate::appliance::store::StorePlan;
use crate::appliance::surroundings::{Appliance, Keeping, PreparedGateway, SitePlan};
use crate::appliance::telemetry::MachineFacts;
use crate::bus::socket::{ControllerState, LinkState, Options, SocketPort};
use crate::bus::{Identifiers, Port, Recording};
use crate::config::Overrides;
use crate::config::settings::Settings;
use crate::frame::BusNumber;
use crate::live::several::SeveralOpener;
use crate::live::supervisor::{self, Opener};
use crate::time::Span;
use clap::Args;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

/// Monitors a machine on its CAN bus, until it is told to stop (SIGTERM). SIGHUP reads the
/// configuration again.
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  tertius run --config config/e-type.toml
  tertius run --config virtual.toml --play field.log.zst --speed 10 --record sent.log")]
pub struct Run {
    /// The machine's configuration
    #[arg(long, value_name = "FILE")]
    config: PathBuf,
    #[command(flatten)]
    set: SetOptions,
    /// Format of the log: text or json on standard error, or journal for fields in systemd's
    /// journal
    #[arg(long, value_enum, default_value_t = LogFormat::Text)]
    log: LogFormat,
    #[command(flatten)]
    play: PlayOptions,
}

impl Run {
    /// Runs the command.
    ///
    /// # Errors
    /// A wrong call or configuration. A missing interface is not an error: the gateway
    /// waits for it.
    pub fn run(self) -> Result<(), Failure> {
        // Who asks for a reload while the configuration is read for the first time must not end it.
        _ = signal_hook::flag::register(signal_hook::consts::SIGHUP, Arc::default());
        let overrides = self.set.overrides()?;
        let stage = self.play.stage(&self.config, &overrides)?;
        let prepared = prepare(&self.config, &overrides, stage.as_ref())?;
        let PreparedGateway { mut gateway, opener, site, interface, realtime, facts, keeping } =
            prepared;
        // Its worker writes what is left when it goes.
        let _worker = logging::start(self.log)?;
        let (config, player) = (self.config.clone(), stage.clone());
        let again = move || {
            let prepared = prepare(&config, &overrides, player.as_ref());
            prepared.map_err(|failure| failure.to_string())
        };
        let mut appliance = Appliance::new(Box::new(again))
            .map_err(|error| Failure::Failed(format!("signals cannot be caught: {error}")))?;
        let title = facts.configuration.clone();
        appliance.describe(facts);
        appliance.starting(&title, site, interface.as_deref());
        appliance.restore(&mut gateway, keeping);
        if let Some(stage) = &stage {
            stage.stop_at_end(appliance.stopper());
        }
        realtime::apply(realtime);
        let gateway = supervisor::run(gateway, opener, &mut appliance);
        appliance.stopped(&gateway);
        stage.map_or(Ok(()), |stage| stage.finish())
    }
}

/// What is monitored by the configuration of `machine`.
pub fn facts(machine: &Machine) -> MachineFacts {
    let fingerprints = machine.loaded.fingerprints();
    MachineFacts {
        name: machine.loaded.settings.machine.name.clone(),
        names: machine.loaded.settings.names(),
        configuration: machine.loaded.title(),
        identity: fingerprints.configuration.to_string(),
        calibration: fingerprints.calibration.map(|it| it.to_string()),
        calibration_recorded: fingerprints.recorded,
        has_model: machine.loaded.has_model(),
        switched_off: machine.loaded.settings.switched_off(),
        not_calibrated: machine.loaded.settings.unaligned(),
        limits_m: machine.design.cylinders.iter().map(|cylinder| cylinder.limits()).collect(),
        platform_states: machine.platform_states(),
    }
}

/// A gateway for the configuration `path` with `overrides`, and an opener of its interface, or of the embedded bus
/// of `stage`.
fn prepare(
    path: &Path,
    overrides: &Overrides,
    stage: Option<&Stage<Recording>>,
) -> Result<PreparedGateway, Failure> {
    let machine = Machine::load(path, overrides)?;
    let settings = &machine.loaded.settings;
    refuse_what_is_not_built(settings)?;
    let name = settings.bus.interface.clone();
    let (opener, interface): (Box<dyn Opener>, _) = match virtual_bus::wanted(stage, &name)? {
        Some(stage) => (stage.opener(received(&machine, BusNumber::First)), None),
        None => (opener(&machine), Some(name)),
    };
    let realtime = settings.realtime;
    let history = Kept {
        machine: settings.machine.name.clone(),
        cylinders: settings.machine.cylinders,
        limits: settings.drift_limits(),
        file: machine.loaded.history_path.clone().map(HistoryFile::new),
    };
    let facts = facts(&machine);
    let (store, flight) =
        (store_plan(&machine), FlightPlan::new(path, &machine.loaded, &machine.design));
    let site = SitePlan {
        listen: settings.http.address(),
        tls: tls_files(path, &machine),
        desk: DeskPlan {
            token: settings.http.token.as_ref().and_then(|digest| digest.parse().ok()),
            logins: LoginLimits {
                failures: settings.http.login_failures,
                lockout: Duration::from_secs_f64(settings.http.lockout),
            },
            recordings: flight.as_ref().map(|flight| flight.folder.clone()),
            patient: Some(doctor::wanted(&machine, path)),
        },
        outputs: OutputPlan::new(path, &machine.loaded),
    };
    let keeping = Keeping { history, store, flight };
    Ok(PreparedGateway {
        gateway: gateway(machine),
        opener,
        site,
        interface,
        realtime,
        facts,
        keeping,
    })
}

/// Refuses settings of what this program was built without.
fn refuse_what_is_not_built(settings: &Settings) -> Result<(), Failure> {
    not_built(settings).map_or(Ok(()), |what| Err(Failure::Wrong(what)))
}

/// What is set, but what this program was built without, and what to do.
pub fn not_built(settings: &Settings) -> Option<String> {
    (!cfg!(feature = "opcua") && settings.opcua.address().is_some()).then(|| {
        format!(
            "`opcua.listen` is {:?}, but this program was built without OPC UA; build it with the feature: cargo \
             install --locked --path . --features opcua; or set opcua.listen = \"off\"",
            settings.opcua.listen
        )
    })
}

/// The event store of a machine, if it has one.
fn store_plan(machine: &Machine) -> Option<StorePlan> {
    let settings = &machine.loaded.settings;
    Some(StorePlan {
        path: machine.loaded.store_path.clone()?,
        size: u64::from(settings.store.size) * 1_000_000,
        days: settings.store.days,
        machine: settings.machine.name.clone(),
        names: settings.names(),
        configuration: machine.loaded.fingerprints().configuration.to_string(),
        sample_time: settings.machine.sample_time,
    })
}

/// What the gateway of a machine receives on `bus`.
fn received(machine: &Machine, bus: BusNumber) -> Identifiers {
    if machine.loaded.settings.recorder.records_all() {
        // The monitor ignores the frames of others.
        Identifiers::All
    } else {
        Identifiers::Only(identifiers(machine, bus))
    }
}

/// The opener of the interfaces of a machine.
pub fn opener(machine: &Machine) -> Box<dyn Opener> {
    let settings = &machine.loaded.settings;
    let interfaces = settings.bus.interfaces().map(|(bus, name)| {
        (bus, Interface { name: name.to_owned(), identifiers: received(machine, bus) })
    });
    let interfaces: Vec<(BusNumber, Interface)> = interfaces.collect();
    match interfaces.as_slice() {
        [(_, only)] => Box::new(only.clone()),
        _ => {
            let boxed = |(bus, it): &(BusNumber, Interface)| -> (BusNumber, Box<dyn Opener>) {
                (*bus, Box::new(it.clone()))
            };
            let openers = move || interfaces.iter().map(boxed).collect();
            Box::new(SeveralOpener::new(openers, Span::from_seconds(settings.gateway.guard)))
        }
    }
}

/// A SocketCAN interface by name.
#[derive(Clone, Debug)]
struct Interface {
    name: String,
    identifiers: Identifiers,
}

impl Opener for Interface {
    fn open(&mut self) -> Result<Box<dyn Port>, String> {
        Ok(Box::new(open(&self.name, &self.identifiers)?))
    }
}

/// The interface `name`, which receives `identifiers`.
///
/// # Errors
/// It is not there or not up, or its controller takes no part in the bus.
pub fn open(name: &str, identifiers: &Identifiers) -> Result<SocketPort, String> {
    let identifiers = identifiers.clone();
    let options = Options { identifiers, few_under_way: true, ..Options::default() };
    let port = SocketPort::open(name, &options).map_err(|error| error.to_string())?;
    // Error frames tell of what befalls the controller from now on, not of what has before.
    match LinkState::read(name).ok().and_then(|link| link.state) {
        Some(ControllerState::BusOff) => Err(format!(
            "the controller of {name} is bus-off: it receives and sends nothing until it is restarted"
        )),
        _ => Ok(port),
    }
}
