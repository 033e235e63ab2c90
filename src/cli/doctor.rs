//! `tertius doctor`: checks whether this computer suits the gateway.

use super::Failure;
use super::machine::Machine;
use super::monitor::GatewaySource;
use super::overriding::SetOptions;
use super::tls::tls_files;
use crate::appliance::doctor::facts::{Logins, Message, Wanted};
use crate::appliance::doctor::gather::gather;
use crate::appliance::doctor::{Finding, Verdict, examine};
use crate::appliance::flight::FlightPlan;
use crate::config::visible;
use crate::frame::BusNumber;
use clap::{Args, ValueEnum};
use console::style;
use serde::Serialize;
use std::io::Write;
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Checks this computer and its bus, and reports in one line each what suits the gateway and what
/// to do otherwise. It only listens: it sends and changes nothing. Exits with 1 if a check failed;
/// warnings are not failures.
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  tertius doctor --config config/e-type.toml
  tertius doctor --config config/e-type.toml --listen 10 --format json")]
pub struct Doctor {
    /// The machine's configuration
    #[arg(long, value_name = "FILE")]
    config: PathBuf,
    #[command(flatten)]
    set: SetOptions,
    /// Time to listen to the bus; 0 for not at all
    #[arg(long, value_name = "SECONDS", default_value = "2", value_parser = seconds)]
    listen: Duration,
    #[arg(long, value_enum, default_value_t = Format::Human)]
    format: Format,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Format {
    Human,
    Json,
}

/// Longest time of listening, s.
const LONGEST: f64 = 3600.0;

fn seconds(text: &str) -> Result<Duration, String> {
    let seconds: f64 = text.parse().map_err(|_| "not a number of seconds".to_owned())?;
    if !(0.0..=LONGEST).contains(&seconds) {
        return Err(format!("0 to {LONGEST} s"));
    }
    Ok(Duration::from_secs_f64(seconds))
}

/// Report for scripts.
#[derive(Serialize)]
struct Report<'a> {
    findings: &'a [Finding],
    warned: usize,
    failed: usize,
}

impl Doctor {
    /// Runs the command.
    ///
    /// # Errors
    /// A wrong configuration, or a check that failed.
    pub fn run(self) -> Result<(), Failure> {
        let machine = Machine::load(&self.config, &self.set.overrides()?)?;
        let wanted = wanted(&machine, &self.config);
        let mut facts = gather(wanted, machine.loaded.settings.http.address(), self.listen);
        if facts.host.rights.gateway.is_some() {
            facts.host.logins = logins(&machine, &self.config);
        }
        let findings = examine(&facts);
        let count = |verdict| findings.iter().filter(|finding| finding.verdict == verdict).count();
        let (warned, failed) = (count(Verdict::Warn), count(Verdict::Fail));
        let text = match self.format {
            Format::Human => findings.iter().map(|finding| line(finding) + "\n").collect(),
            Format::Json => {
                let report = Report { findings: &findings, warned, failed };
                let text = serde_json::to_string(&report);
                let text = text.map_err(|error| Failure::Failed(format!("the report: {error}")))?;
                visible(&text).into_owned() + "\n"
            }
        };
        // The colours are ours, and the rest is escaped below them.
        std::io::stdout()
            .write_all(text.as_bytes())
            .map_err(|error| Failure::writing("standard output", &error))?;
        match failed {
            0 => Ok(()),
            count => Err(Failure::Failed(format!("{count} of {} failed", findings.len()))),
        }
    }
}

/// What the doctor has to know of `machine`, whose configuration is the file `config`.
pub fn wanted(machine: &Machine, config: &Path) -> Wanted {
    let settings = &machine.loaded.settings;
    let others = settings.bus.interfaces().filter(|(bus, _)| *bus != BusNumber::First);
    Wanted {
        config: config.to_owned(),
        dbc: machine.loaded.dbc_path.display().to_string(),
        dbc_findings: machine.database.findings().len() + machine.database.findings_left_out(),
        interface: settings.bus.interface.clone(),
        bit_rate: settings.bus.bitrate,
        sample_time: settings.machine.sample_time,
        node: settings.gateway.node,
        own: settings.own_identifiers(),
        status: machine.design.encoder.status_id(),
        messages: messages(machine, BusNumber::First),
        others: others.map(|(bus, name)| (name.to_owned(), messages(machine, bus))).collect(),
        realtime: settings.realtime,
        files: machine.files(config).map(Path::to_owned).collect(),
        keeps: keeps(machine, config),
        calibrated: settings.calibration.recorded.clone(),
    }
}

/// The messages on `bus` that the monitor of `machine` uses.
fn messages(machine: &Machine, bus: BusNumber) -> Vec<Message> {
    let all = machine.design.subscriptions.all().iter().filter(|line| line.bus == bus);
    let messages = all.map(|line| {
        let message = machine.database.message_by_id(line.id);
        Message {
            id: line.id,
            name: message.map_or_else(|| line.id.to_string(), |message| message.name.clone()),
            needs: { line.signals.iter() }
                .map(|signal| signal.plan.needed_length())
                .max()
                .unwrap_or(0),
            sync: line.sync,
            reading: line.reading,
            cyclic: line.cyclic,
            pages: line.pages(),
        }
    });
    messages.collect()
}

/// Wrong tokens and lockouts of the gateway of `machine`, or why they are not known; `None` if it has no page to ask.
fn logins(machine: &Machine, config: &Path) -> Option<Result<Logins, String>> {
    let address = machine.loaded.settings.http.address().filter(|address| address.port() > 0)?;
    let host = match address.ip() {
        IpAddr::V4(it) if it.is_unspecified() => Ipv4Addr::LOCALHOST.into(),
        IpAddr::V6(it) if it.is_unspecified() => Ipv6Addr::LOCALHOST.into(),
        other => other,
    };
    let certificate = tls_files(config, machine).map(|files| files.certificate);
    let scheme = if certificate.is_some() { "https" } else { "http" };
    let url = format!("{scheme}://{}", SocketAddr::new(host, address.port()));
    let source = GatewaySource::new(&url, certificate.as_deref(), None);
    let metrics = source.map_err(|error| error.to_string()).and_then(|it| it.text("/metrics"));
    let logins = metrics.and_then(|text| {
        Logins::read(&text).ok_or_else(|| "it is of a version that does not count them".to_owned())
    });
    Some(logins.map_err(|reason| format!("{url}: {reason}")))
}

/// What the gateway of `machine` keeps, and where.
fn keeps(machine: &Machine, config: &Path) -> Vec<(&'static str, PathBuf)> {
    let loaded = &machine.loaded;
    let recordings = FlightPlan::new(config, loaded, &machine.design).map(|plan| plan.folder);
    let all = [
        ("the events", loaded.store_path.clone()),
        ("the history of the stops", loaded.history_path.clone()),
        ("the recordings", recordings),
    ];
    all.into_iter().filter_map(|(what, path)| Some((what, path?))).collect()
}

/// The finding in a line, its verdict in colour where the terminal has colours.
fn line(finding: &Finding) -> String {
    let text = visible(&finding.to_string()).into_owned();
    let (word, rest) = text.split_at(text.find(' ').unwrap_or(text.len()));
    match finding.verdict {
        Verdict::Ok => text,
        Verdict::Warn => format!("{}{rest}", style(word).yellow()),
        Verdict::Fail => format!("{}{rest}", style(word).red().bold()),
    }
}
