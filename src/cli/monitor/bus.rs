//! A bus, listened to by a monitor of our own.

use super::news::{News, NewsSource};
use crate::appliance::history::HistoryFile;
use crate::appliance::link_watch::LinkWatch;
use crate::appliance::telemetry::clock::SystemClock;
use crate::appliance::telemetry::feed::{PERIOD, TrendFeed};
use crate::appliance::telemetry::{MachineFacts, Recorder};
use crate::bus::{Identifiers, ListeningPort, embedded};
use crate::cli::Failure;
use crate::cli::machine::Machine;
use crate::cli::{gateway, run};
use crate::config::Overrides;
use crate::estimate::Estimate;
use crate::frame::BusNumber;
use crate::incident::Incident;
use crate::live::gateway::Journal;
use crate::live::listener::ListeningMonitor;
use crate::monitor::{Monitor, Notice, Record};
use crate::sequential::{Archive, DriftLimits, Dwell};
use crate::time::Span;
use serde::Serialize;
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Longest wait for frames.
const PATIENCE: Duration = Duration::from_millis(20);

/// Pause before an interface that could not be opened is tried again.
const PAUSE: Duration = Duration::from_secs(1);

/// A CAN interface, to which a monitor listens.
pub struct BusSource {
    interface: String,
    identifiers: Identifiers,
    listener: ListeningMonitor,
    facts: MachineFacts,
    ear: Ear,
    /// What the gateway has kept of the stops, which is only read.
    archive: Archive,
    limits: DriftLimits,
}

impl BusSource {
    /// A monitor of the configuration `path` with `overrides` that listens to `interface`, or to that of the configuration.
    ///
    /// # Errors
    /// A wrong configuration, or one of the embedded bus, on which nobody else can listen.
    pub fn new(
        path: &Path,
        overrides: &Overrides,
        interface: Option<String>,
    ) -> Result<Self, Failure> {
        let machine = Machine::load(path, overrides)?;
        let settings = &machine.loaded.settings;
        let interface = interface.unwrap_or_else(|| settings.bus.interface.clone());
        if interface == embedded::NAME {
            return Err(Failure::Wrong(format!(
                "bus.interface is {interface:?}, the bus inside another process, to which nobody else can listen; \
                 watch the gateway that runs on it instead: tertius monitor http://127.0.0.1:9481, or give a \
                 CAN interface (--interface can0)"
            )));
        }
        machine.refuse_several(
            "`tertius monitor` on a bus",
            "watch the gateway's page instead: tertius monitor http://127.0.0.1:9481",
        )?;
        let (name, cylinders) = (settings.machine.name.clone(), settings.machine.cylinders);
        let file = machine.loaded.history_path.clone().map(HistoryFile::new);
        // It is another process's file: one that cannot be read is as good as none.
        let kept = file.and_then(|file| file.read(&name, cylinders).ok().flatten());
        let archive = kept.unwrap_or_else(|| Archive::new(&name, cylinders));
        let (identifiers, facts) =
            (gateway::identifiers(&machine, BusNumber::First), run::facts(&machine));
        let guard = Span::from_seconds(settings.gateway.guard);
        let limits = settings.drift_limits();
        let mut listener = ListeningMonitor::new(Monitor::new(machine.design), guard);
        listener.restore(&archive);
        let recorder = Recorder::new(Arc::new(SystemClock::new()));
        recorder.telemetry().describe(facts.clone());
        recorder.telemetry().stops(&archive, limits);
        Ok(Self {
            interface,
            identifiers: Identifiers::Only(identifiers),
            listener,
            facts,
            ear: Ear { recorder, dwelt: false },
            archive,
            limits,
        })
    }

    /// Listens to `port` until it is lost; `Ok` if nobody wants to be told any more.
    fn listen(
        &mut self,
        port: &mut ListeningPort,
        send: &mut dyn FnMut(News) -> bool,
    ) -> Result<(), String> {
        let mut feed = TrendFeed::default();
        let mut due = Instant::now();
        self.ear.recorder.opened();
        loop {
            let turned = self.listener.turn(port, PATIENCE, &mut self.ear);
            self.ear.recorder.listened(self.listener.monitor(), port.counts());
            if let Err(error) = turned {
                self.listener.lose(&mut self.ear);
                self.ear.recorder.lost();
                return Err(error.to_string());
            }
            if std::mem::take(&mut self.ear.dwelt) {
                self.listener.monitor().save(&mut self.archive);
                self.ear.recorder.telemetry().stops(&self.archive, self.limits);
            }
            if Instant::now() >= due {
                due = Instant::now() + PERIOD;
                if !self.send(&mut feed, send) {
                    return Ok(());
                }
            }
        }
    }

    /// Sends the present state, in the form of the gateway's page.
    fn send(&self, feed: &mut TrendFeed, send: &mut dyn FnMut(News) -> bool) -> bool {
        let (telemetry, clock) = (self.ear.recorder.telemetry(), self.ear.recorder.clock());
        let overview = telemetry.overview(clock.uptime(), clock.system());
        let bins = feed.newest(telemetry);
        said("overview", &overview).is_none_or(&mut *send) && said("bins", &bins).is_none_or(send)
    }
}

impl NewsSource for BusSource {
    fn name(&self) -> String {
        self.interface.clone()
    }

    fn watch(&mut self, send: &mut dyn FnMut(News) -> bool) {
        let telemetry = Arc::clone(self.ear.recorder.telemetry());
        let links = LinkWatch::start(move |link| match link {
            Some(link) => telemetry.link(link),
            None => telemetry.link_unknown(),
        });
        // Without it the state of the controller is not shown.
        _ = links.as_ref().map(|links| links.name(&self.interface));
        if !said("machine", &self.facts).is_none_or(&mut *send) {
            return;
        }
        loop {
            let opened = run::open(&self.interface, &self.identifiers).map(ListeningPort::new);
            let reason = match opened {
                Ok(mut port) => match self.listen(&mut port, send) {
                    Ok(()) => return,
                    Err(reason) => reason,
                },
                Err(reason) => reason,
            };
            if !send(News::Lost(reason)) {
                return;
            }
            std::thread::sleep(PAUSE);
        }
    }
}

/// `value` as the page's event `name` tells it.
fn said(name: &str, value: &impl Serialize) -> Option<News> {
    // What this program writes it can read.
    News::event(name, &serde_json::to_string(value).ok()?).ok().flatten()
}

/// Passes what the monitor says to the telemetry.
struct Ear {
    recorder: Recorder,
    /// Whether a rod was read on its stop.
    dwelt: bool,
}

impl Journal for Ear {
    fn record(&mut self, record: &Record) {
        self.recorder.record(record);
    }

    fn incident(&mut self, incident: &Incident) {
        self.recorder.incident(incident);
    }

    fn estimate(&mut self, cylinder: u8, estimate: Option<&Estimate>) {
        self.recorder.estimate(cylinder, estimate);
    }

    fn dwell(&mut self, _: u8, _: &Dwell) {
        self.dwelt = true;
    }

    fn notice(&mut self, notice: &Notice) {
        self.recorder.notice(notice);
    }
}
