//! What is known of a box before anything is judged.

use super::hearing::Hearing;
use crate::bus::Stamps;
use crate::bus::socket::LinkState;
use crate::config::settings::Realtime;
use crate::frame::Id;
use crate::time::Span;
use std::net::SocketAddr;
use std::path::PathBuf;

/// All that is known.
#[derive(Clone, Debug)]
pub struct Facts {
    pub wanted: Wanted,
    pub bus: Bus,
    pub host: Host,
}

/// What the configuration and its DBC ask for.
#[derive(Clone, Debug)]
pub struct Wanted {
    pub config: PathBuf,
    /// The DBC's name.
    pub dbc: String,
    /// How much in the DBC is worth a look.
    pub dbc_findings: usize,
    pub interface: String,
    /// bit/s.
    pub bit_rate: u32,
    /// Ts, s.
    pub sample_time: f64,
    /// The gateway's own.
    pub node: u8,
    /// The identifiers that the gateway sends; its status is the first.
    pub own: [Id; 3],
    pub messages: Vec<Message>,
    pub realtime: Realtime,
}

/// A message that the monitor listens to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Message {
    pub id: Id,
    pub name: String,
    /// Bytes up to the last that is read.
    pub needs: usize,
    /// It opens a cycle.
    pub sync: bool,
    /// It carries a reading of a transducer.
    pub reading: bool,
    /// It comes once each cycle, or once for each page.
    pub cyclic: bool,
    /// How many pages of it are read.
    pub pages: usize,
}

/// What there is of a bus.
#[derive(Clone, Debug)]
pub enum Bus {
    /// `interface = "virtual"`.
    Embedded,
    Socket(Box<Interface>),
}

/// A SocketCAN interface.
#[derive(Clone, Debug)]
pub struct Interface {
    /// Why the kernel has no CAN sockets, if it has none.
    pub no_can: Option<String>,
    /// What the kernel knows of it; else why nothing.
    pub link: Result<LinkState, String>,
    /// Whether it is a CAN interface; `None` if that is not known.
    pub is_can: Option<bool>,
    /// What a socket on it got; else why there is none.
    pub port: Result<Receiving, String>,
    /// net.core.rmem_max, bytes.
    pub rmem_max: Option<u64>,
    /// `None` if nobody listened.
    pub hearing: Option<Hearing>,
}

/// What a socket got of what it asked for.
#[derive(Clone, Debug, PartialEq)]
pub struct Receiving {
    /// Room for frames not yet received, bytes as the kernel counts them.
    pub buffer: u64,
    /// How long a full bus takes to fill it, s.
    pub lasts: f64,
    /// Whose clock stamps the frames, after what was heard.
    pub stamps: Stamps,
}

/// The box itself.
#[derive(Clone, Debug)]
pub struct Host {
    pub rights: Rights,
    pub clock: Clock,
    pub service: Service,
    /// Where the gateway serves HTTP, and why it could not, if so; `None` if it is off.
    pub http: Option<(SocketAddr, Option<String>)>,
}

/// What a process may do: the gateway of this configuration that runs here, else this one.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Rights {
    /// The running gateway's process.
    pub gateway: Option<u32>,
    /// CAP_NET_ADMIN.
    pub net_admin: bool,
    /// CAP_SYS_NICE.
    pub sys_nice: bool,
    /// CAP_IPC_LOCK.
    pub ipc_lock: bool,
    /// RLIMIT_RTPRIO; `None` if it has none.
    pub priority: Option<u64>,
    /// RLIMIT_MEMLOCK, bytes; `None` if it has none.
    pub locked_memory: Option<u64>,
}

/// The system's clock.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Clock {
    /// Whether something keeps it right; `None` if that could not be found out.
    pub synchronised: Option<bool>,
    /// By how much it went ahead of a clock that nobody sets …
    pub step: Span,
    /// … in this time, s.
    pub watched: f64,
}

/// What starts the gateway, and again.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Service {
    /// Whether the box was started with systemd.
    pub systemd: bool,
    /// Where the gateway's unit is.
    pub unit: Option<String>,
    /// What the unit says of WatchdogSec.
    pub watchdog: Option<String>,
}
