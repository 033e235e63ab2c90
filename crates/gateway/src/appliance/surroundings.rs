//! The surroundings of the live gateway: signals, the log, the service manager.

use super::activity::Activity;
use super::flight::{FlightPlan, FlightRecorder};
use super::history::{Keeper, Kept};
use super::link_watch::LinkWatch;
use super::notice_log;
use super::quota::Quota;
use super::site::Site;
pub use super::site::SitePlan;
use super::store::{Cause, Clerk, EventKind, StorePlan};
use super::telemetry::clock::SystemClock;
use super::telemetry::{MachineFacts, Recorder};
use super::warning_log::WarningLog;
use super::watchdog::{Watchdog, notify};
use crate::bus::Port;
use crate::live::gateway::{Gateway, Journal};
use crate::live::health::BusHealth;
use crate::live::supervisor::{Opener, Request, Surroundings};
use sd_notify::NotifyState;
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM, SIGUSR1};
use signal_hook::flag;
use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};
use tertius_canopen::node::{NmtCommand, NmtEvent};
use tertius_config::settings::Realtime;
use tertius_core::alarm::{OwnFrame, Warning};
use tertius_core::error_frame::ControllerState;
use tertius_core::estimate::Estimate;
use tertius_core::frame::Frame;
use tertius_core::incident::Incident;
use tertius_core::monitor::{Monitor, Notice, Record};
use tertius_core::sequential::Dwell;
use tertius_core::time::Timestamp;
use tertius_report::report::alignment;
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
    /// What is monitored, for people.
    pub facts: MachineFacts,
    /// The HTTP server.
    pub site: SitePlan,
    /// Real-time settings, used only at the gateway's start.
    pub realtime: Realtime,
    pub keeping: Keeping,
}

/// What is kept of what a gateway finds.
pub struct Keeping {
    /// The history of the stops.
    pub history: Kept,
    /// Event store; `None`: no events are kept.
    pub store: Option<StorePlan>,
    /// Recordings of incidents; `None`: nothing is recorded.
    pub flight: Option<FlightPlan>,
}

/// Reads the configuration; where it is refused, it says why.
type Prepare = Box<dyn FnMut() -> Result<PreparedGateway, String>>;

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
    clerk: Clerk,
    flight: FlightRecorder,
}

impl Appliance {
    /// Catches the signals; `prepare` reads the configuration again.
    ///
    /// # Errors
    /// A signal cannot be caught.
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
        let (warnings, quota) = (WarningLog::new(), Quota::new(Instant::now()));
        let keeper = Keeper::new(recorder.telemetry());
        let clerk = Clerk::new(recorder.telemetry());
        let flight = FlightRecorder::new(recorder.telemetry());
        flag::register(SIGUSR1, flight.demand())?;
        let site = Site::new(clerk.handle(), flight.demand());
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
            clerk,
            flight,
        })
    }

    /// A flag that, when set, stops the gateway as SIGTERM does.
    pub fn stopper(&self) -> Arc<AtomicBool> {
        Arc::clone(&self.stop)
    }

    /// Takes what is monitored from now on.
    pub fn describe(&mut self, facts: MachineFacts) {
        if !facts.has_model {
            warn!(
                "the configuration has no [model]: R1 and R2 are judged by that of another machine (thesis, Table 4-1); \
                 `tertius commission` learns this machine's"
            );
        }
        if let Some(off) = facts.switched_off {
            warn!("switched off by the configuration: {off} (fde.enabled, comparator.enabled)");
        }
        if let Some(doubt) = alignment::doubt(&facts.not_calibrated) {
            warn!("{doubt}");
        }
        let (configuration, calibration) = (&*facts.identity, facts.calibration.as_deref());
        info!(configuration, calibration, "what is judged by");
        self.warnings.call(&facts.names);
        self.recorder.telemetry().describe(facts);
    }

    /// Logs the start of the gateway with the configuration `config`, on its interface, and starts
    /// HTTP by `site`.
    pub fn starting(&mut self, config: &str, site: SitePlan, interface: Option<&str>) {
        info!(config, version = env!("CARGO_PKG_VERSION"), "starting");
        self.site.listen(site, &self.recorder);
        self.watch(interface);
        notify(&[NotifyState::Ready, NotifyState::Status("waiting for the interface")]);
    }

    fn watch(&self, interface: Option<&str>) {
        if let (Some(links), Some(interface)) = (&self.links, interface) {
            links.name(interface);
        }
    }

    /// Restores in `gateway` what was kept, and keeps and records what it finds from now on.
    pub fn restore(&mut self, gateway: &mut Gateway, keeping: Keeping) {
        self.keep(gateway, keeping, None);
    }

    /// Keeps what `gateway` finds from now on, which follows on `before`, if on any.
    fn keep(&mut self, gateway: &mut Gateway, keeping: Keeping, before: Option<&Monitor>) {
        let Keeping { history, store, flight } = keeping;
        gateway.restore(self.keeper.open(history, before));
        let cause = if before.is_some() { Cause::Reload } else { Cause::Start };
        self.clerk.begin(store, cause, false);
        self.flight.follow(flight, gateway.monitor());
    }

    /// Finishes after `gateway` has stopped.
    pub fn stopped(&mut self, gateway: &Gateway) {
        notify(&[NotifyState::Stopping]);
        self.keeper.finish(gateway.monitor());
        self.clerk.finish();
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
        self.clerk.record(record);
    }

    fn warning(&mut self, warning: &Warning) {
        self.recorder.warning(warning);
        self.warnings.take(warning);
        self.clerk.warning(warning);
    }

    fn incident(&mut self, incident: &Incident) {
        self.recorder.incident(incident);
        self.warnings.queue_incident(incident);
        self.clerk.incident(incident);
        self.flight.incident(incident);
    }

    fn estimate(&mut self, cylinder: u8, estimate: Option<&Estimate>) {
        self.recorder.estimate(cylinder, estimate);
    }

    fn dwell(&mut self, cylinder: u8, dwell: &Dwell) {
        self.keeper.dwelt();
        self.clerk.dwell(cylinder, dwell);
    }

    fn notice(&mut self, notice: &Notice) {
        self.recorder.notice(notice);
        self.clerk.notice(notice);
        self.warnings.write();
        let Some(withheld) = self.quota.ask(Instant::now()) else { return };
        if withheld > 0 {
            info!(lines = withheld, "more of what follows was left out");
        }
        notice_log::write(notice, self.warnings.names());
    }

    fn bus(&mut self, health: &BusHealth) {
        let state = health.state.map_or("active again", ControllerState::name);
        let [transmit_errors, receive_errors] = health.counters.unwrap_or_default();
        self.clerk.event(EventKind::Controller, || format!("the controller is {state}"));
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
        self.clerk.event(EventKind::Nmt, || format!("NMT {command} to {to}: {state}"));
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
        self.clerk.event(EventKind::BusOpened, || description.clone());
        notify(&[NotifyState::Status(&description)]);
    }

    fn lost(&mut self, reason: &str) {
        warn!("no bus: {reason}; trying again");
        self.clerk.event(EventKind::BusLost, || reason.to_owned());
        self.clerk.turned();
        notify(&[NotifyState::Status(reason)]);
    }

    fn report_not_sent(&mut self, reason: &str) {
        warn!("the bus was not told that the gateway stops: {reason}");
    }

    fn closed(&mut self, gateway: &Gateway, port: &dyn Port) {
        self.warnings.write();
        self.recorder.closed(gateway, port);
        self.clerk.turned();
    }

    fn turned(&mut self, gateway: &Gateway, port: &dyn Port) {
        self.warnings.write();
        self.watchdog.feed();
        self.recorder.turned(gateway, port);
        self.keeper.turned(gateway.monitor());
        self.clerk.turned();
        self.flight.turned(gateway);
        self.activity.look(gateway, port);
    }

    fn reload(&mut self, before: &Gateway) -> Option<(Gateway, Box<dyn Opener>)> {
        match (self.prepare)() {
            Ok(prepared) => {
                let PreparedGateway {
                    mut gateway, opener, interface, site, facts, keeping, ..
                } = prepared;
                self.keep(&mut gateway, keeping, Some(before.monitor()));
                info!("the configuration was read again; judging restarts");
                self.recorder.reloaded();
                self.describe(facts);
                self.site.listen(site, &self.recorder);
                self.watch(interface.as_deref());
                Some((gateway, opener))
            }
            Err(refusal) => {
                self.recorder.refused();
                self.clerk.event(EventKind::Refused, || refusal.clone());
                warn!("the new configuration is refused, the old one stays in force: {refusal}");
                None
            }
        }
    }
}
