//! Facts about a computer, before anything is judged.

use super::hearing::Hearing;
use crate::bus::Stamps;
use crate::bus::socket::LinkState;
use std::net::SocketAddr;
use std::path::PathBuf;
use tertius_config::settings::Realtime;
use tertius_core::frame::Id;
use tertius_core::time::Span;

/// All facts.
#[derive(Clone, Debug)]
pub struct Facts {
    pub wanted: Wanted,
    pub bus: Bus,
    /// The interfaces of the other buses, by [`Wanted::others`].
    pub others: Vec<InterfaceFacts>,
    pub host: Host,
}

/// Requirements of the configuration and its DBC.
#[derive(Clone, Debug)]
pub struct Wanted {
    pub config: PathBuf,
    /// Day of the newest recording that the calibration was learnt from, as `2026-03-14`.
    pub calibrated: Option<String>,
    /// Name of the DBC.
    pub dbc: String,
    /// Number of findings in the DBC.
    pub dbc_findings: usize,
    pub interface: String,
    /// Bit rate, bit/s.
    pub bit_rate: u32,
    /// Sample time Ts, s.
    pub sample_time: f64,
    /// CANopen node number of the gateway.
    pub node: u8,
    /// Identifiers that the gateway sends.
    pub own: Vec<Id>,
    /// That of its status.
    pub status: Id,
    pub messages: Vec<Message>,
    /// Interfaces of the other buses of a machine with several, and the messages on them.
    pub others: Vec<(String, Vec<Message>)>,
    pub realtime: Realtime,
    /// The files that the configuration is in.
    pub files: Vec<PathBuf>,
    /// What the gateway keeps, in words, and where.
    pub keeps: Vec<(&'static str, PathBuf)>,
}

impl Wanted {
    /// What is wanted of each of the other buses, on which the gateway sends nothing.
    pub fn of_others(&self) -> impl Iterator<Item = Self> {
        self.others.iter().map(|(interface, messages)| Self {
            interface: interface.clone(),
            messages: messages.clone(),
            own: Vec::new(),
            others: Vec::new(),
            ..self.clone()
        })
    }
}

/// A message that the monitor uses.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Message {
    pub id: Id,
    pub name: String,
    /// Length up to the last byte that is read, bytes.
    pub needs: usize,
    /// Whether it opens a cycle.
    pub sync: bool,
    /// Whether it carries a reading of a transducer.
    pub reading: bool,
    /// Whether it comes once in each cycle, or once for each page.
    pub cyclic: bool,
    /// Number of its pages that are read.
    pub pages: usize,
}

/// The bus.
#[derive(Clone, Debug)]
pub enum Bus {
    /// The embedded bus, `interface = "virtual"`.
    Embedded,
    Socket(Box<InterfaceFacts>),
}

/// A SocketCAN interface.
#[derive(Clone, Debug)]
pub struct InterfaceFacts {
    /// Why the kernel has no CAN sockets, if it has none.
    pub no_can: Option<String>,
    /// State of the interface in the kernel, or why it is not known.
    pub link: Result<LinkState, String>,
    /// Whether it is a CAN interface; `None` if not known.
    pub is_can: Option<bool>,
    /// Settings of a socket on it, or why there is no socket.
    pub port: Result<Receiving, String>,
    /// Kernel setting net.core.rmem_max, bytes.
    pub rmem_max: Option<u64>,
    /// Counts of the interface before and after listening; `None` if the kernel does not show them.
    pub counts: Option<[LinkCounts; 2]>,
    /// Whether the controller can stamp frames by itself; `None` if not known.
    pub hardware_stamps: Option<bool>,
    /// Frames heard; `None` if nobody listened.
    pub hearing: Option<Hearing>,
}

/// What the kernel has counted of an interface since it appeared.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LinkCounts {
    /// Frames received.
    pub frames: u64,
    /// Frames that the controller lost because nobody fetched them in time.
    pub overruns: u64,
    /// Frames that the kernel dropped ahead of all sockets.
    pub dropped: u64,
    /// Errors on the wire: of bits, stuffing, form and CRC.
    pub errors: u64,
}

impl LinkCounts {
    /// Frames that a computer lost which was too slow for them.
    pub const fn lost(&self) -> u64 {
        self.overruns.saturating_add(self.dropped)
    }

    /// What was counted since `before`.
    pub const fn since(&self, before: &Self) -> Self {
        Self {
            frames: self.frames.saturating_sub(before.frames),
            overruns: self.overruns.saturating_sub(before.overruns),
            dropped: self.dropped.saturating_sub(before.dropped),
            errors: self.errors.saturating_sub(before.errors),
        }
    }
}

/// Settings of a socket that the kernel has granted.
#[derive(Clone, Debug, PartialEq)]
pub struct Receiving {
    /// Receive buffer, bytes as the kernel counts them.
    pub buffer: u64,
    /// Time in which a full bus fills the buffer, s.
    pub lasts: f64,
    /// Source of the frames' time stamps, as seen while listening.
    pub stamps: Stamps,
}

/// The computer itself.
#[derive(Clone, Debug)]
pub struct Host {
    pub rights: Rights,
    pub clock: ClockFacts,
    pub service: Service,
    /// The disks on which the gateway keeps something, each once.
    pub disks: Vec<DiskFacts>,
    pub ages: Ages,
    /// Address at which the gateway serves HTTP, and why it could not, if so; `None` if HTTP is
    /// off.
    pub http: Option<(SocketAddr, Option<String>)>,
    /// Wrong tokens and lockouts of the running gateway, or why they are not known; `None` if none is running, or HTTP is off.
    pub logins: Option<Result<Logins, String>>,
}

/// Failed logins of a gateway since it was started.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Logins {
    /// Wrong tokens.
    pub failures: u64,
    /// Times that an address was locked out.
    pub lockouts: u64,
}

/// Rights of a process: the gateway of this configuration that is running, or else this process.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Rights {
    /// Process id of the running gateway.
    pub gateway: Option<u32>,
    /// Whether it has CAP_NET_ADMIN.
    pub net_admin: bool,
    /// Whether it has CAP_SYS_NICE.
    pub sys_nice: bool,
    /// Whether it has CAP_IPC_LOCK.
    pub ipc_lock: bool,
    /// Limit RLIMIT_RTPRIO; `None` if unlimited.
    pub priority: Option<u64>,
    /// Limit RLIMIT_MEMLOCK, bytes; `None` if unlimited.
    pub locked_memory: Option<u64>,
}

/// The system's clock.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ClockFacts {
    /// Whether it is synchronised; `None` if this could not be determined.
    pub synchronised: Option<bool>,
    /// Step of the clock against one that nobody sets.
    pub step: Span,
    /// Time in which the step was observed, s.
    pub watched: f64,
    /// What chrony follows, where it runs.
    pub source: Option<ClockSource>,
}

/// What the clock is synchronised with.
#[derive(Clone, Debug, PartialEq)]
pub struct ClockSource {
    /// Address, or the name of a reference clock.
    pub name: String,
    /// Number of computers between it and a reference clock.
    pub stratum: u8,
    /// Most by which the clock may be wrong, s.
    pub bound: f64,
}

/// A disk on which the gateway keeps something.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DiskFacts {
    /// What is kept there, in words.
    pub keeps: Vec<&'static str>,
    /// The nearest folder that exists.
    pub folder: PathBuf,
    /// Bytes that are free for the gateway, and those of the whole file system.
    pub free: u64,
    pub size: u64,
    pub is_read_only: bool,
    /// Bytes that were written since the computer started, per day; `None` if not known.
    pub written_per_day: Option<f64>,
    pub wear: Option<Wear>,
}

/// How far a flash memory is used up, as it says by itself (eMMC, JESD84-B51).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Wear {
    /// Life used up: n stands for at most n tenths, 11 for more than was promised.
    pub tenths: u8,
    /// State of the blocks in reserve: 1 normal, 2 four fifths are used, 3 urgent.
    pub reserve: u8,
}

/// How old things are.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Ages {
    /// Time since this program was installed.
    pub program: Option<Span>,
    /// Time since the configuration or its DBC was changed.
    pub configuration: Option<Span>,
    /// Time since the running gateway was started.
    pub gateway: Option<Span>,
    /// Whether the running gateway's program has been replaced since.
    pub is_replaced: bool,
}

/// The service manager's settings for the gateway.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Service {
    /// Whether the computer was started with systemd.
    pub systemd: bool,
    /// Path of the gateway's unit.
    pub unit: Option<String>,
    /// WatchdogSec of the unit.
    pub watchdog: Option<String>,
}
