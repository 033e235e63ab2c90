//! `tertius inject --from … --to …`: faults between two interfaces, live.

use super::Failure;
use crate::bus::socket::{Options, SocketPort};
use crate::bus::{Port, Unrestricted};
use crate::inject::Injector;
use crate::live::proxy::{self, Bench, Lane, LaneCounts, LaneLimits, Open, Proxy, Side};
use crate::text::counted;
use crate::time::Span;
use nix::net::if_::if_nametoindex;
use nix::poll::{PollFd, PollFlags, PollTimeout, poll};
use signal_hook::consts::{SIGINT, SIGTERM};
use std::io;
use std::os::fd::AsFd;
use std::os::linux::net::SocketAddrExt;
use std::os::unix::net::{SocketAddr, UnixDatagram};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Most frames that wait: half a second of a full bus.
const WAITING: usize = 4096;

type Socket = Unrestricted<SocketPort>;

/// The two interfaces, and the duration.
#[derive(Debug)]
pub struct Ends {
    /// Interface whose frames get faults.
    pub from: String,
    /// Interface whose frames go back unchanged.
    pub to: String,
    /// Duration; `None`: until a signal comes.
    pub lasts: Option<Duration>,
    /// Age at which a frame is dropped.
    pub max_age: Duration,
}

/// Runs the proxy until it is told to stop, and reports what became of the frames. Returns the
/// injector with its tallies.
///
/// # Errors
/// Both are the same interface, or one cannot be used even when it is there.
pub fn run(ends: &Ends, injector: Injector) -> Result<Injector, Failure> {
    ends.refuse_one_interface()?;
    let (mut from, mut to) = (Interface::new(&ends.from), Interface::new(&ends.to));
    // What a user has to put right is told at once; what may pass is waited for.
    for interface in [&mut from, &mut to] {
        if let Err(Refusal { reason, may_pass: false }) = interface.open() {
            return Err(Failure::Wrong(reason));
        }
    }
    let age = Span::from_seconds(ends.max_age.as_secs_f64());
    let mut proxy = Proxy::new(injector, LaneLimits { waiting: WAITING, age });
    let mut sides = [Side::new(from.opener()), Side::new(to.opener())];
    let mut host = Host::new(ends)
        .map_err(|error| Failure::Failed(format!("signals cannot be caught: {error}")))?;
    proxy::run(&mut proxy, &mut sides, &mut host);
    report(&ends.from, &ends.to, proxy.there(), sides[0].overrun());
    report(&ends.to, &ends.from, proxy.back(), sides[1].overrun());
    Ok(proxy.injector().clone())
}

impl Ends {
    /// A length of time on the command line.
    pub fn parse_seconds(text: &str) -> Result<Duration, String> {
        let seconds = text.parse().ok().filter(|seconds| *seconds > 0.0 && *seconds <= 3.2e9);
        seconds.map(Duration::from_secs_f64).ok_or_else(|| "expected seconds, such as 60".into())
    }

    fn refuse_one_interface(&self) -> Result<(), Failure> {
        let Self { from, to, .. } = self;
        if from == to {
            return Err(Failure::Wrong(format!(
                "--from and --to are both {from}; a proxy needs two interfaces, else it would hear \
                 its own frames"
            )));
        }
        // One that is not there yet is looked at again when it is opened.
        match (if_nametoindex(from.as_str()), if_nametoindex(to.as_str())) {
            (Ok(one), Ok(other)) if one == other => Err(Failure::Wrong(format!(
                "{from} and {to} are two names of one interface (index {one}); a proxy needs two"
            ))),
            _ => Ok(()),
        }
    }
}

/// An interface by name.
struct Interface {
    name: String,
    claim: Option<UnixDatagram>,
}

/// Why an interface cannot be opened.
struct Refusal {
    reason: String,
    may_pass: bool,
}

impl Interface {
    fn new(name: &str) -> Self {
        Self { name: name.to_owned(), claim: None }
    }

    fn opener(mut self) -> Open<Socket> {
        Box::new(move || self.open().map_err(|refusal| refusal.reason))
    }

    fn open(&mut self) -> Result<Socket, Refusal> {
        self.claim = None;
        let port = Socket::open(&self.name, &Options::default())
            .map_err(|error| Refusal { reason: error.to_string(), may_pass: error.may_pass() })?;
        self.claim = Some(
            claim(port.index())
                .map_err(|error| Refusal { reason: self.explain(&error), may_pass: false })?,
        );
        Ok(port)
    }

    fn explain(&self, error: &io::Error) -> String {
        let name = &self.name;
        if error.kind() == io::ErrorKind::AddrInUse {
            return format!(
                "another `tertius inject` uses the interface {name}: two on one interface would \
                 forward each other's frames endlessly; end it, or give all faults to one"
            );
        }
        format!("the interface {name} cannot be claimed for this proxy: {error}")
    }
}

/// Claims the interface of that index for one proxy, so that several cannot form a ring. Like the
/// index, the name belongs to the network namespace; it becomes free when the process ends.
fn claim(index: u32) -> io::Result<UnixDatagram> {
    let address = SocketAddr::from_abstract_name(format!("tertius inject {index}"))?;
    UnixDatagram::bind_addr(&address)
}

/// The computer that the proxy runs on.
struct Host<'a> {
    ends: &'a Ends,
    stop: Arc<AtomicBool>,
    started: Instant,
}

impl<'a> Host<'a> {
    fn new(ends: &'a Ends) -> io::Result<Self> {
        let stop = Arc::new(AtomicBool::new(false));
        for signal in [SIGTERM, SIGINT] {
            signal_hook::flag::register(signal, Arc::clone(&stop))?;
        }
        Ok(Self { ends, stop, started: Instant::now() })
    }

    fn name(&self, side: usize) -> &str {
        if side == 0 { &self.ends.from } else { &self.ends.to }
    }
}

impl Bench<Socket> for Host<'_> {
    fn now(&mut self) -> Duration {
        self.started.elapsed()
    }

    fn is_over(&mut self) -> bool {
        self.stop.load(Ordering::Relaxed)
            || self.ends.lasts.is_some_and(|lasts| self.started.elapsed() >= lasts)
    }

    fn wait(&mut self, ports: [Option<&Socket>; 2], longest: Duration) {
        let left = self.ends.lasts.map(|lasts| lasts.saturating_sub(self.started.elapsed()));
        let longest = left.map_or(longest, |left| left.min(longest));
        let mut watched = Vec::with_capacity(ports.len());
        let ports = ports.into_iter().flatten();
        watched.extend(ports.map(|port| PollFd::new(port.as_fd(), PollFlags::POLLIN)));
        // Rounded up: a wait of nothing would go round and round for the rest of a millisecond.
        let longest = PollTimeout::try_from(longest + Duration::from_micros(999));
        // A signal ends it early, and whatever is wrong with a socket its port will say.
        _ = poll(&mut watched, longest.unwrap_or(PollTimeout::MAX));
    }

    fn opened(&mut self, side: usize, port: &Socket) {
        let what = if side == 0 { "from" } else { "to" };
        tell!("{what} {}", port.description());
    }

    fn lost(&mut self, side: usize, reason: &str) {
        tell!("no {}: {reason}; trying again", self.name(side));
    }
}

/// Reports the counts of the frames from `from` to `to` that are not zero.
fn report(from: &str, to: &str, lane: &Lane, overrun: u64) {
    let LaneCounts { received, sent, changed, .. } = *lane.counts();
    let frames = counted(received, "frame");
    tell!("{from} to {to}: {frames} received, {sent} sent, {changed} changed");
    let counts = lane.counts();
    let waiting = lane.waiting() as u64;
    let refused = lane.rejection().unwrap_or_default();
    for (count, fate) in [
        (counts.lost, "lost to a fault".to_owned()),
        (counts.too_old, "dropped as too old: longer than --max-age on their way".to_owned()),
        (counts.crowded_out, format!("dropped as too many waited for {to}")),
        (counts.away, "dropped while an interface was away".to_owned()),
        (counts.rejected, format!("refused by {to}: {refused}")),
        (waiting, format!("still waiting for {to} at the end")),
        (counts.error_frames, format!("error frames of {from}, which are not forwarded")),
        (overrun, format!("never received: the receive queue of {from} was full")),
    ] {
        if count > 0 {
            tell!("  {count} {fate}");
        }
    }
}
