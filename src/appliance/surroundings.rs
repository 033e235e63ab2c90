//! The surroundings of the live gateway: signals, the log, the service manager.

use super::activity::Activity;
use super::flight::{FlightPlan, FlightRecorder};
use super::history::{Keeper, Kept};
use super::link_watch::LinkWatch;
use super::quota::Quota;
use super::site::Site;
use super::telemetry::Recorder;
use super::telemetry::clock::SystemClock;
use super::warning_log::WarningLog;
use super::watchdog::{Watchdog, tell};
use crate::alarm::{OwnFrame, Warning};
use crate::bus::Port;
use crate::canopen::node::{NmtCommand, NmtEvent};
use crate::config::settings::Realtime;
use crate::error_frame::ControllerState;
use crate::failure::Failure;
use crate::frame::Frame;
use crate::incident::Incident;
use crate::live::gateway::{Gateway, Journal};
use crate::live::health::BusHealth;
use crate::live::supervisor::{Opener, Request, Surroundings};
use crate::monitor::{Notice, Record};
use crate::report::{device, jsonl::restart_name};
use crate::sample::device::{DeviceNews, DeviceState};
use crate::sequential::{Apart, Dwell};
use crate::time::Timestamp;
use sd_notify::NotifyState;
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM, SIGUSR1};
use signal_hook::flag;
use std::io;
use std::net::SocketAddr;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};
use tracing::{info, warn};

/// Interval at which a wait checks for signals.
const SLICE: Duration = Duration::from_millis(50);

/// Everything that is prepared from a configuration.
pub struct PreparedGateway {
    pub gateway: Gateway,
    /// Opens the interface.
    pub opener: Box<dyn Opener>,
    /// Name of the interface; `None` for the embedded bus.
    pub interface: Option<String>,
    /// Address of the HTTP server.
    pub listen: Option<SocketAddr>,
    /// Real-time settings, used only at the gateway's start.
    pub realtime: Realtime,
    /// State that outlives the gateway.
    pub kept: Kept,
    /// What is recorded of incidents; `None` for nothing.
    pub flight: Option<FlightPlan>,
}

type Prepare = Box<dyn FnMut() -> Result<PreparedGateway, Failure>>;

/// The surroundings of the gateway on a computer.
pub struct Appliance {
    stop: Arc<AtomicBool>,
    reload: Arc<AtomicBool>,
    prepare: Prepare,
    watchdog: Watchdog,
    activity: Activity,
    recorder: Recorder,
    warnings: WarningLog,
    site: Site,
    links: Option<LinkWatch>,
    quota: Quota,
    keeper: Keeper,
    flight: FlightRecorder,
}

impl Appliance {
    /// Catches the signals; `prepare` reads the configuration again.
    ///
    /// # Errors A signal cannot be caught.
    pub fn new(prepare: Prepare) -> io::Result<Self> {
        let (stop, reload) = (Arc::new(AtomicBool::new(false)), Arc::new(AtomicBool::new(false)));
        for signal in [SIGTERM, SIGINT] {
            flag::register(signal, Arc::clone(&stop))?;
        }
        flag::register(SIGHUP, Arc::clone(&reload))?;
        let (watchdog, activity) = (Watchdog::new(), Activity::new());
        let recorder = Recorder::new(Arc::new(SystemClock::new()));
        let telemetry = Arc::clone(recorder.telemetry());
        let links = LinkWatch::start(move |link| match link {
            Some(link) => telemetry.link(link),
            None => telemetry.link_unknown(),
        });
        // Without it the error frames still tell of the controller.
        let links = links.ok();
        let (warnings, site, quota) =
            (WarningLog::new(), Site::default(), Quota::new(Instant::now()));
        let keeper = Keeper::new(recorder.telemetry());
        let flight = FlightRecorder::new(recorder.telemetry());
        flag::register(SIGUSR1, flight.demand())?;
        Ok(Self {
            stop,
            reload,
            prepare,
            watchdog,
            activity,
            recorder,
            warnings,
            site,
            links,
            quota,
            keeper,
            flight,
        })
    }

    /// A flag that, when set, stops the gateway as SIGTERM does.
    pub fn stopper(&self) -> Arc<AtomicBool> {
        Arc::clone(&self.stop)
    }

    /// Logs the start of the gateway with the configuration `config`, on its interface, and starts
    /// HTTP on `listen`.
    pub fn starting(&mut self, config: &Path, listen: Option<SocketAddr>, interface: Option<&str>) {
        info!(config = %config.display(), version = env!("CARGO_PKG_VERSION"), "starting");
        self.site.listen(listen, &self.recorder);
        self.watch(interface);
        tell(&[NotifyState::Ready, NotifyState::Status("waiting for the interface")]);
    }

    fn watch(&self, interface: Option<&str>) {
        if let (Some(links), Some(interface)) = (&self.links, interface) {
            links.name(interface);
        }
    }

    /// Restores in `gateway` what was kept, and records it by `flight`.
    pub fn restore(&mut self, gateway: &mut Gateway, kept: Kept, flight: Option<FlightPlan>) {
        gateway.restore(self.keeper.open(kept, None));
        self.flight.follow(flight, gateway.monitor());
    }

    /// Finishes after `gateway` has stopped.
    pub fn stopped(&mut self, gateway: &Gateway) {
        tell(&[NotifyState::Stopping]);
        self.keeper.finish(gateway.monitor());
        self.flight.finish();
        info!("stopped");
    }
}

impl Journal for Appliance {
    fn frame(&mut self, frame: &Frame) {
        self.flight.frame(frame);
    }

    fn record(&mut self, record: &Record) {
        self.recorder.record(record);
    }

    fn warning(&mut self, warning: &Warning) {
        self.recorder.warning(warning);
        self.warnings.take(warning);
    }

    fn incident(&mut self, incident: &Incident) {
        self.recorder.incident(incident);
        self.warnings.tell(incident);
        self.flight.incident(incident);
    }

    fn dwell(&mut self, _: u8, _: &Dwell) {
        self.keeper.dwelt();
    }

    fn notice(&mut self, notice: &Notice) {
        self.warnings.write();
        let Some(withheld) = self.quota.ask(Instant::now()) else { return };
        if withheld > 0 {
            info!(lines = withheld, "more of what follows was left out");
        }
        match *notice {
            Notice::Gap { length, .. } => {
                info!(seconds = length.as_seconds(), "cycles again after none");
            }
            Notice::TimeJump { by, .. } => {
                warn!(seconds = by.as_seconds(), "time stamps jumped, everything restarts");
            }
            Notice::Interruption { .. } => {
                warn!("the bus was lost, everything restarts");
            }
            Notice::Restart { cylinder, detector, reason, .. } => {
                let (detector, reason) = (detector.name(), restart_name(reason));
                info!(cylinder, detector, reason, "observer restarts");
            }
            Notice::Timing { apart: Some(Apart { mean, spread, .. }), .. } => {
                warn!(skew = mean, jitter = spread, "C1 and C2 are not sampled together");
            }
            Notice::Timing { apart: None, .. } => {
                info!("C1 and C2 are sampled as they were calibrated again");
            }
            Notice::Device { cylinder, role, node, news, .. } => {
                let what = device::news(news);
                let device = role.name();
                match news {
                    DeviceNews::State(DeviceState::Operational) => {
                        info!(cylinder, device, node, "the device {what}");
                    }
                    _ => warn!(cylinder, device, node, "the device {what}"),
                }
            }
        }
    }

    fn bus(&mut self, health: &BusHealth) {
        let state = health.state.map_or("active again", ControllerState::name);
        let [transmit_errors, receive_errors] = health.counters.unwrap_or_default();
        match health.state {
            Some(ControllerState::BusOff) => warn!(
                "the controller is bus-off: it receives and sends nothing until it is restarted, \
                 by \
                 itself if restart-ms is set, else by `ip link set INTERFACE type can restart`"
            ),
            Some(ControllerState::Warning | ControllerState::Passive) => {
                warn!(transmit_errors, receive_errors, "the controller is {state}");
            }
            _ => info!(transmit_errors, receive_errors, "the controller is {state}"),
        }
    }

    fn nmt(&mut self, event: &NmtEvent) {
        self.warnings.write();
        let Some(withheld) = self.quota.ask(Instant::now()) else { return };
        if withheld > 0 {
            info!(lines = withheld, "more of what follows was left out");
        }
        let (command, state) = (event.command.name(), event.state.name());
        let to = if event.everyone { "all nodes" } else { "this node" };
        match event.command {
            NmtCommand::Stop | NmtCommand::EnterPreOperational => warn!(
                command,
                to,
                state,
                "an NMT master has silenced the gateway's PDOs; monitoring goes on. NMT frames do \
                 not say who sent them"
            ),
            _ => info!(command, to, state, "an NMT master commands"),
        }
    }

    fn sent(&mut self, frame: &OwnFrame, at: Timestamp) {
        self.recorder.sent(frame);
        self.flight.sent(frame, at);
    }
}

impl Surroundings for Appliance {
    fn request(&mut self) -> Request {
        if self.stop.load(Ordering::Relaxed) {
            Request::Stop
        } else if self.reload.swap(false, Ordering::Relaxed) {
            Request::Reload
        } else {
            Request::GoOn
        }
    }

    fn wait(&mut self, time: Duration) {
        let end = Instant::now() + time;
        while !(self.stop.load(Ordering::Relaxed) || self.reload.load(Ordering::Relaxed)) {
            // Waiting for an interface is what the data path does then: it is alive.
            self.watchdog.feed();
            let left = end.saturating_duration_since(Instant::now());
            if left.is_zero() {
                break;
            }
            std::thread::sleep(left.min(SLICE));
        }
    }

    fn opened(&mut self, port: &dyn Port) {
        self.recorder.opened();
        let description = port.description();
        info!("open: {description}");
        tell(&[NotifyState::Status(&description)]);
    }

    fn lost(&mut self, reason: &str) {
        warn!("no bus: {reason}; trying again");
        tell(&[NotifyState::Status(reason)]);
    }

    fn not_told(&mut self, reason: &str) {
        warn!("the bus was not told that the gateway stops: {reason}");
    }

    fn closed(&mut self, gateway: &Gateway, port: &dyn Port) {
        self.warnings.write();
        self.recorder.closed(gateway, port);
    }

    fn turned(&mut self, gateway: &Gateway, port: &dyn Port) {
        self.warnings.write();
        self.watchdog.feed();
        self.recorder.turned(gateway, port);
        self.keeper.turned(gateway.monitor());
        self.flight.turned(gateway);
        self.activity.look(gateway, port);
    }

    fn reload(&mut self, before: &Gateway) -> Option<(Gateway, Box<dyn Opener>)> {
        match (self.prepare)() {
            Ok(prepared) => {
                let PreparedGateway {
                    mut gateway, opener, interface, listen, kept, flight, ..
                } = prepared;
                gateway.restore(self.keeper.open(kept, Some(before.monitor())));
                self.flight.follow(flight, gateway.monitor());
                info!("the configuration was read again; judging restarts");
                self.recorder.reloaded();
                self.site.listen(listen, &self.recorder);
                self.watch(interface.as_deref());
                Some((gateway, opener))
            }
            Err(failure) => {
                self.recorder.refused();
                warn!("the new configuration is refused, the old one stays in force: {failure}");
                None
            }
        }
    }
}
