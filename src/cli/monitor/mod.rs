//! `tertius monitor`: a machine in a terminal, from its bus or from a running gateway.

mod bus;
mod gateway;
mod news;
mod picture;
mod stream;
mod terminal;
mod trust;
mod view;
mod viewer;

use super::Failure;
use super::overriding::SetOptions;
use bus::BusSource;
use clap::Args;
pub use gateway::GatewaySource;
use news::NewsSource;
use std::path::PathBuf;
use std::sync::mpsc::sync_channel;
use std::time::Instant;
use viewer::Viewer;

/// Most news that wait to be shown: those of some seconds, should the terminal not take its output.
const WAITING: usize = 16;

/// Shows the machine in a terminal: lamps, residuals against their limits, incidents. It listens to the bus, or reads
/// the page of a running gateway, and sends nothing to the bus.
#[derive(Args, Debug)]
#[command(override_usage = "tertius monitor <URL>
       tertius monitor --config <FILE> [--interface <NAME>]")]
#[command(after_help = "Examples:
  tertius monitor http://127.0.0.1:9481
  tertius monitor https://box:9481 --ca page.crt --token-file token
  tertius monitor --config config/e-type.toml --interface can0

Keys: up and down select a cylinder, s sorts, space freezes, enter zooms, ? helps, q quits.
NO_COLOR=1 shows no colours.")]
pub struct Monitor {
    /// Address of the page of a running gateway
    #[arg(value_name = "URL", required_unless_present = "config", conflicts_with = "config")]
    url: Option<String>,
    /// The machine's configuration, to listen to its bus with a monitor of its own
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    #[command(flatten)]
    set: SetOptions,
    /// Over https, trusts the certificates in this file (PEM), and no others: the gateway's own, or that of who
    /// certified it [default: those that this computer trusts]
    #[arg(long, value_name = "FILE", conflicts_with = "config")]
    ca: Option<PathBuf>,
    /// The file with the token that a gateway asks for from other computers [default: the environment's TERTIUS_TOKEN]
    #[arg(long, value_name = "FILE", conflicts_with = "config")]
    token_file: Option<PathBuf>,
    /// Listens to this interface [default: that of the configuration]
    #[arg(long, value_name = "NAME", requires = "config")]
    interface: Option<String>,
}

impl Monitor {
    /// Runs the command.
    ///
    /// # Errors
    /// A wrong call or configuration, or a terminal that cannot be drawn on. A gateway that does not answer
    /// and an interface that is missing are no errors: it waits for them.
    pub fn run(self) -> Result<(), Failure> {
        terminal::check()?;
        let mut source: Box<dyn NewsSource> = match (self.url, self.config) {
            (Some(_), _) if self.set.are_given() => {
                let message =
                    "--set is for --config: at a URL the gateway has its own configuration";
                return Err(Failure::Wrong(message.to_owned()));
            }
            (Some(url), _) => {
                let token = trust::token(self.token_file.as_deref())?;
                Box::new(GatewaySource::new(&url, self.ca.as_deref(), token)?)
            }
            (None, Some(config)) => {
                Box::new(BusSource::new(&config, &self.set.overrides()?, self.interface)?)
            }
            (None, None) => return Err(Failure::Wrong("give a URL or --config".to_owned())),
        };
        let (start, viewer) = (Instant::now(), Viewer::new(source.name()));
        let (told, news) = sync_channel(WAITING);
        let watch = move || source.watch(&mut |news| told.send((Instant::now(), news)).is_ok());
        // It ends with the program, or once nobody listens.
        std::thread::Builder::new()
            .name("watch".to_owned())
            .spawn(watch)
            .map_err(|error| Failure::Failed(format!("no thread can be started: {error}")))?;
        terminal::show(viewer, news, start)
    }
}
