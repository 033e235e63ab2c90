//! Collects the facts. Listens and reads; sends and changes nothing.

mod ages;
mod clock;
mod computer;
mod disks;

use super::facts::{
    Bus, Facts, Host, InterfaceFacts, LinkCounts, Receiving, Rights, Service, Wanted,
};
use super::hearing::Hearing;
use super::kernel;
use super::load::Rates;
use super::process::gateway_config;
use crate::bus::socket::{LinkState, OpenError, Options, SocketPort};
use crate::bus::{Identifiers, Port, embedded};
use computer::said_by;
use std::fs;
use std::net::{SocketAddr, TcpListener};
use std::path::Path;
use std::time::{Duration, Instant, SystemTime};

/// ARPHRD_CAN of linux/if_arp.h.
const CAN: &str = "280";

/// Longest wait for a frame, so that listening ends in time.
const PATIENCE: Duration = Duration::from_millis(20);

/// Directories in which systemd looks for units, in its order.
const UNITS: [&str; 4] = [
    "/etc/systemd/system",
    "/run/systemd/system",
    "/usr/local/lib/systemd/system",
    "/usr/lib/systemd/system",
];

const UNIT: &str = "tertius.service";

/// Gathers all facts, after listening on the bus for that long, if there is one. The gateway is not asked for anything.
pub fn gather(wanted: Wanted, http: Option<SocketAddr>, listen: Duration) -> Facts {
    let (monotonic, system) = (Instant::now(), SystemTime::now());
    let rights = rights(&wanted.config);
    let bus = match wanted.interface == embedded::NAME {
        true => Bus::Embedded,
        false => Bus::Socket(Box::new(interface(&wanted, listen))),
    };
    let others = wanted.of_others().map(|wanted| interface(&wanted, listen)).collect();
    let clock = clock::read(monotonic, system);
    let http = http.map(|address| (address, TcpListener::bind(address).err()));
    let http = http.map(|(address, error)| (address, error.map(|error| error.to_string())));
    let (disks, ages) = (disks::of(&wanted.keeps), ages::of(&wanted.files, rights.gateway));
    let host = Host { rights, clock, service: service(), disks, ages, http, logins: None };
    Facts { wanted, bus, others, host }
}

fn interface(wanted: &Wanted, listen: Duration) -> InterfaceFacts {
    let name = &wanted.interface;
    let link = LinkState::read(name);
    let kind = fs::read_to_string(format!("/sys/class/net/{name}/type")).ok();
    let mut found = InterfaceFacts {
        no_can: None,
        is_can: kind.map(|kind| kind.trim() == CAN),
        port: Err(String::new()),
        rmem_max: fs::read_to_string("/proc/sys/net/core/rmem_max")
            .ok()
            .and_then(|text| text.trim().parse().ok()),
        counts: None,
        hardware_stamps: said_by("ethtool", &["-T", name])
            .and_then(|text| kernel::stamps_by_itself(&text)),
        hearing: None,
        link: link.map_err(|error| error.to_string()),
    };
    let before = counts(name);
    let options = Options { identifiers: Identifiers::All, ..Options::default() };
    match SocketPort::open(name, &options) {
        Ok(mut port) => {
            found.hearing = (!listen.is_zero()).then(|| {
                let rates = rates(wanted, found.link.as_ref().ok());
                let mut hearing = Hearing::new(rates, wanted.status);
                listen_to(&mut port, listen, &mut hearing);
                hearing
            });
            found.port = Ok(Receiving {
                buffer: port.receive_buffer() as u64,
                lasts: port.buffer_lasts(),
                stamps: port.stamps(),
            });
        }
        Err(error) => {
            if let OpenError::NoCan { error } = &error {
                found.no_can = Some(error.to_string());
            }
            found.port = Err(error.to_string());
        }
    }
    found.counts = before.zip(counts(name)).map(|(before, after)| [before, after]);
    found
}

fn counts(interface: &str) -> Option<LinkCounts> {
    let folder = Path::new("/sys/class/net").join(interface).join("statistics");
    LinkCounts::read(|name| fs::read_to_string(folder.join(name)).ok())
}

fn rates(wanted: &Wanted, link: Option<&LinkState>) -> Rates {
    let nominal = link.and_then(|link| link.bit_rate).unwrap_or(wanted.bit_rate);
    let data = link.and_then(|link| link.data_bit_rate).unwrap_or(nominal);
    Rates { nominal: f64::from(nominal), data: f64::from(data) }
}

fn listen_to(port: &mut dyn Port, listen: Duration, hearing: &mut Hearing) {
    let started = Instant::now();
    while started.elapsed() < listen {
        if let Err(error) = port.receive(PATIENCE, &mut |frame| hearing.take(frame)) {
            hearing.ended = Some(error.to_string());
            break;
        }
    }
    hearing.seconds = started.elapsed().as_secs_f64();
    hearing.dropped = port.counts().dropped;
}

/// Rights of the gateway of this configuration, if /proc shows one, or else of this process.
fn rights(config: &Path) -> Rights {
    let of = |process: &str| -> Option<Rights> {
        let read = |file| fs::read_to_string(format!("/proc/{process}/{file}"));
        Some(Rights::read(&read("status").ok()?, &read("limits").ok()?))
    };
    let gateway = gateway(config);
    let rights = gateway.and_then(|process| of(&process.to_string())).or_else(|| of("self"));
    Rights { gateway, ..rights.unwrap_or_default() }
}

fn gateway(config: &Path) -> Option<u32> {
    let config = fs::canonicalize(config).ok()?;
    let processes = fs::read_dir("/proc").ok()?;
    processes.flatten().find_map(|entry| {
        let process = entry.file_name().to_str()?.parse().ok()?;
        let cmdline = fs::read(entry.path().join("cmdline")).ok()?;
        // Relative to where it runs; a service's path is none.
        let folder = fs::read_link(entry.path().join("cwd")).unwrap_or_default();
        let its = fs::canonicalize(folder.join(gateway_config(&cmdline)?)).ok()?;
        (its == config).then_some(process)
    })
}

fn service() -> Service {
    let unit = UNITS.iter().map(|folder| Path::new(folder).join(UNIT)).find(|path| path.exists());
    let mut texts: Vec<String> = unit.iter().flat_map(fs::read_to_string).collect();
    for folder in UNITS.iter().rev() {
        let drop_ins = fs::read_dir(Path::new(folder).join(format!("{UNIT}.d")));
        let mut paths: Vec<_> =
            drop_ins.into_iter().flatten().flatten().map(|entry| entry.path()).collect();
        paths.sort();
        texts.extend(paths.iter().flat_map(fs::read_to_string));
    }
    let watchdog = texts.iter().flat_map(|text| text.lines()).rev();
    Service {
        systemd: Path::new("/run/systemd/system").exists(),
        unit: unit.map(|path| path.display().to_string()),
        watchdog: { watchdog }
            .find_map(|line| line.trim().strip_prefix("WatchdogSec="))
            .map(|time| time.trim().to_owned()),
    }
}
