//! Telemetry of the live gateway: numbers that its data path stores and that others read.
//!
//! [`Recorder`] belongs to the data path. It does nothing for a frame, and a few relaxed stores for
//! a cycle and a turn: no lock, no allocation, and no system call except reading a clock. It writes
//! to [`Telemetry`], which everyone may read at any time: [`exposition`] for Prometheus, [`health`]
//! for load balancers, [`overview`] and [`trend`] for people, [`snapshot`] for controllers, [`points`]
//! for protocols that name each value.

mod cell;
pub mod clock;
pub mod exposition;
pub mod feed;
mod flight;
pub mod health;
mod incidents;
pub mod lamp;
pub mod overview;
mod peers;
pub mod points;
mod recorder;
pub mod snapshot;
mod stops;
mod totals;
pub mod trend;

use crate::bus::socket::{ControllerState, LinkState};
use cell::{Gauge, Histogram, State, Total};
use clock::Clock;
use incidents::Incidents;
pub use incidents::{OpenIncident, OpenSlot, OpenWorst};
use peers::Peers;
pub use recorder::Recorder;
use serde::Serialize;
use std::sync::atomic::{AtomicBool, AtomicI64, AtomicU8, AtomicU32, AtomicU64, Ordering};
use std::sync::{Arc, PoisonError, RwLock};
use std::time::Duration;
use stops::Stop;
use tertius_config::MachineNames;
use tertius_core::alarm::Level;
use tertius_core::alarm::status::{Health, MAX_CYLINDERS, Mode, Status};
use tertius_core::incident::{QUANTITIES, Quantity};
use tertius_core::sample::dispute::Doubt;
use tertius_core::time::Timestamp;
use totals::Totals;
use trend::Trend;

/// Time without a frame of the machine after which nothing is known of its transducers, and without
/// a turn of the data path after which nothing is known at all.
pub const EVIDENCE: Duration = Duration::from_secs(1);

/// Bounds of |R1|, |R2| and |R3|, m. The thresholds of the thesis, 0.75, 1 and 1.5 mm, are among
/// them.
const RESIDUAL_BOUNDS: [f64; 13] =
    [1e-5, 2.5e-5, 5e-5, 1e-4, 2.5e-4, 5e-4, 7.5e-4, 1e-3, 1.5e-3, 2.5e-3, 5e-3, 1e-2, 5e-2];

/// Bounds of the time from the time stamp of a frame to the hand-over of its warning, s.
const LATENCY_BOUNDS: [f64; 16] = [
    1e-5, 2.5e-5, 5e-5, 1e-4, 2.5e-4, 5e-4, 1e-3, 2.5e-3, 5e-3, 1e-2, 2.5e-2, 5e-2, 0.1, 0.25, 0.5,
    1.0,
];

/// Number of detectors in [`tertius_core::alarm::Detector::ALL`].
const DETECTORS: usize = tertius_core::alarm::Detector::ALL.len();

/// In place of the number of a platform's state.
const NO_STATE: i64 = i64::MIN;

/// Telemetry of one cylinder.
#[derive(Debug)]
struct Cylinder {
    /// Newest |R1|, |R2| and |R3|, m.
    residuals: [Gauge; 3],
    /// Newest |C1 − C2| as measured, m.
    measured: Gauge,
    sizes: [Histogram; 3],
    raised: [Total; DETECTORS],
    /// State ([`Health`]) of C1 and C2.
    transducers: [State; 2],
    /// Whether the device of C1 and of C2 said that it is not operational.
    idle: [AtomicBool; 2],
    /// What frames of C1 and of C2 lack of their configuration ([`Doubt`]).
    lacking: [State; 2],
    /// Estimated length and its standard deviation, m.
    estimate: Gauge,
    sigma: Gauge,
    trend: Trend,
    stop: Stop,
    incidents: Incidents,
}

impl Cylinder {
    fn new() -> Self {
        Self {
            residuals: Default::default(),
            measured: Gauge::default(),
            sizes: std::array::from_fn(|_| Histogram::new(&RESIDUAL_BOUNDS)),
            raised: Default::default(),
            transducers: Default::default(),
            idle: Default::default(),
            lacking: Default::default(),
            estimate: Gauge::default(),
            sigma: Gauge::default(),
            trend: Trend::default(),
            stop: Stop::default(),
            incidents: Incidents::default(),
        }
    }

    /// Why somebody has to look at what the transducer sends, whatever its readings are.
    fn check(&self, which: usize) -> Option<&'static str> {
        if self.idle[which].load(Ordering::Relaxed) {
            return Some("its device is not operational");
        }
        let lacks = |doubt: Doubt| self.lacking[which].get() == Some(doubt as u8);
        if lacks(Doubt::TooShort) {
            return Some("its frames are too short for the configuration");
        }
        lacks(Doubt::Uncounted).then_some("the alive counter of its frames does not count")
    }

    /// Absolute values of the quantities in the newest cycle, m.
    fn quantities(&self) -> [Option<f64>; QUANTITIES] {
        let [r1, r2, r3] = self.residuals.each_ref().map(Gauge::get);
        [r1, r2, r3, self.measured.get()]
    }
}

/// State of the interface as last reported by the kernel; absent on a bus without one.
#[derive(Debug, Default)]
struct Link {
    /// Whether the interface is up: 0 or 1.
    up: Gauge,
    /// State of the controller ([`ControllerState`]).
    state: State,
    transmit_errors: Gauge,
    receive_errors: Gauge,
}

/// What a gateway monitors: facts of its configuration.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct MachineFacts {
    /// Name of the machine.
    pub name: String,
    /// How its cylinders and transducers are called.
    #[serde(skip_serializing_if = "MachineNames::is_empty")]
    pub names: MachineNames,
    /// File of the configuration.
    pub configuration: String,
    /// Identity of the configuration with its DBC ([`tertius_config::Fingerprints`]).
    pub identity: String,
    /// Identity of the calibration; `None` where no cylinder has one.
    pub calibration: Option<String>,
    /// The day (UTC) on which the newest recording ended that it was learnt from, if the configuration says it.
    pub calibration_recorded: Option<String>,
    /// Whether the configuration has a model of the machine.
    pub has_model: bool,
    /// Detectors that the configuration switches off, in words.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub switched_off: Option<&'static str>,
    /// Cylinders with a C2 that no calibration has compared with their C1.
    pub not_calibrated: Vec<u8>,
    /// Of each cylinder, limits of R1, R2, R3 and of the measured difference, m; infinite, and `null` in JSON, where
    /// there is no such quantity.
    pub limits_m: Vec<[f64; QUANTITIES]>,
    /// Numbers and names of the platform's states.
    pub platform_states: Vec<(i64, String)>,
}

/// All telemetry of a running gateway.
#[derive(Debug)]
pub struct Telemetry {
    /// The system's time at the start.
    started: Timestamp,
    totals: Totals,
    cylinders: [Cylinder; MAX_CYLINDERS],
    /// The incidents of the machine.
    shared: Incidents,
    /// Number of cylinders that the machine has.
    used: AtomicU8,
    /// Whether a port is open.
    open: AtomicBool,
    /// Mode ([`tertius_core::alarm::status::Mode`]).
    mode: State,
    /// Highest level ([`tertius_core::alarm::Level`]).
    level: AtomicU8,
    standing: AtomicU32,
    /// Number of the platform's state; [`NO_STATE`] means that it is not known.
    platform: AtomicI64,
    latency: Histogram,
    /// Uptime at the last turn, ns, plus one; zero means never.
    turned: AtomicU64,
    /// Uptime at the last frame of the machine, ns, plus one; zero means never.
    heard: AtomicU64,
    link: Link,
    /// What is monitored; written at the start and by a reload.
    facts: RwLock<Arc<MachineFacts>>,
    /// Size of the event store, bytes.
    store_size: Gauge,
    peers: Peers,
}

impl Telemetry {
    /// Telemetry of a gateway that starts now, by `clock`.
    pub fn new(clock: &dyn Clock) -> Self {
        Self {
            started: clock.system(),
            totals: Totals::default(),
            cylinders: std::array::from_fn(|_| Cylinder::new()),
            shared: Incidents::default(),
            used: AtomicU8::new(0),
            open: AtomicBool::new(false),
            mode: State::default(),
            level: AtomicU8::new(0),
            standing: AtomicU32::new(0),
            platform: AtomicI64::new(NO_STATE),
            latency: Histogram::new(&LATENCY_BOUNDS),
            turned: AtomicU64::new(0),
            heard: AtomicU64::new(0),
            link: Link::default(),
            facts: RwLock::default(),
            store_size: Gauge::default(),
            peers: Peers::default(),
        }
    }

    /// Takes what is monitored from now on.
    pub fn describe(&self, facts: MachineFacts) {
        *self.facts.write().unwrap_or_else(PoisonError::into_inner) = Arc::new(facts);
    }

    /// What is monitored.
    pub fn facts(&self) -> Arc<MachineFacts> {
        self.facts.read().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// The trend of the cylinder `number` (from 1); `None` where the machine has no such cylinder.
    pub fn trend(&self, number: usize) -> Option<&Trend> {
        Some(&self.cylinders().get(number.checked_sub(1)?)?.trend)
    }

    /// Takes the state of the interface from the kernel.
    pub fn link(&self, link: &LinkState) {
        self.link.up.set(Some(f64::from(u8::from(link.up))));
        self.link.state.set(link.state.map(controller_number));
        self.link.transmit_errors.set(link.transmit_errors.map(f64::from));
        self.link.receive_errors.set(link.receive_errors.map(f64::from));
    }

    /// Notes that the interface is gone, or that the kernel cannot be asked.
    pub fn link_unknown(&self) {
        self.link.up.set(None);
        self.link.state.set(None);
        self.link.transmit_errors.set(None);
        self.link.receive_errors.set(None);
    }

    /// Notes that the event store has written so many notes, and that it lost so many before.
    pub fn store_written(&self, written: u64, lost: u64) {
        self.totals.store_written.add(written);
        self.totals.store_lost.add(lost);
    }

    /// Notes that the event store could not be written.
    pub fn store_failed(&self) {
        self.totals.store_failures.add(1);
    }

    /// Notes that somebody gave a wrong token, and whether the address was locked out for it.
    pub fn login_failed(&self, is_out: bool) {
        self.totals.login_failures.add(1);
        self.totals.login_lockouts.add(u64::from(is_out));
    }

    /// Wrong tokens so far, and lockouts.
    pub fn logins(&self) -> [u64; 2] {
        [&self.totals.login_failures, &self.totals.login_lockouts].map(Total::get)
    }

    /// Takes the size of the event store, bytes; `None` if it is not open.
    pub fn store_size(&self, size: Option<u64>) {
        self.store_size.set(size.map(|size| size as f64));
    }

    fn cylinders(&self) -> &[Cylinder] {
        let used = usize::from(self.used.load(Ordering::Relaxed));
        &self.cylinders[..used.min(MAX_CYLINDERS)]
    }

    /// Absolute value of the quantity of that name of the cylinder `number` (from 1) in the newest cycle, m; `None` where it
    /// is not known at the uptime `now`.
    pub fn newest(&self, number: usize, quantity: &str, now: Duration) -> Option<f64> {
        let cylinder = self.cylinders().get(number.checked_sub(1)?)?;
        let place = Quantity::ALL.into_iter().position(|it| it.name() == quantity)?;
        cylinder.quantities()[place].filter(|_| self.has_evidence(now))
    }

    /// The incidents that are not closed, the worst first, at the uptime `now`.
    fn incidents(&self, now: Duration) -> Vec<OpenIncident> {
        let evidence = self.has_evidence(now);
        let facts = self.facts();
        let names = &facts.names;
        let open = (1..).zip(self.cylinders()).flat_map(|(number, cylinder)| {
            let quantities = cylinder.quantities().map(|value| value.filter(|_| evidence));
            cylinder.incidents.open(number, quantities, names)
        });
        let shared = self.shared.open(0, [None; QUANTITIES], names);
        let mut open: Vec<OpenIncident> = open.chain(shared).collect();
        let level = |it: &OpenIncident| Level::NAMES.iter().position(|name| *name == it.level);
        open.sort_by_key(|it| (std::cmp::Reverse(level(it)), it.number));
        open
    }

    /// Whether the monitor is in `mode`.
    pub fn is_in(&self, mode: Mode) -> bool {
        self.mode.get() == Some(mode as u8)
    }

    fn is_open(&self) -> bool {
        self.open.load(Ordering::Relaxed)
    }

    /// Time since the last turn of the data path, at the uptime `now`.
    fn since_turn(&self, now: Duration) -> Option<Duration> {
        since(&self.turned, now)
    }

    /// Time since the last frame of the machine, at the uptime `now`.
    fn since_frame(&self, now: Duration) -> Option<Duration> {
        since(&self.heard, now)
    }

    /// Whether the data path does its work: a port is open and is being served.
    fn lives(&self, now: Duration) -> bool {
        self.is_open() && self.since_turn(now).is_some_and(|time| time <= EVIDENCE)
    }

    /// Whether there is evidence by which the machine can be judged now.
    fn has_evidence(&self, now: Duration) -> bool {
        self.lives(now) && self.since_frame(now).is_some_and(|time| time <= EVIDENCE)
    }

    fn publish(&self, status: &Status, lacking: [[Option<Doubt>; 2]; MAX_CYLINDERS]) {
        for (cylinder, pair) in self.cylinders.iter().zip(&status.transducers) {
            for (transducer, health) in cylinder.transducers.iter().zip(pair) {
                transducer.set(Some(*health as u8));
            }
        }
        for (cylinder, pair) in self.cylinders.iter().zip(lacking) {
            for (place, doubt) in cylinder.lacking.iter().zip(pair) {
                place.set(doubt.map(|it| it as u8));
            }
        }
        self.mode.set(Some(status.mode as u8));
        self.level.store(status.level as u8, Ordering::Relaxed);
        self.standing.store(status.active_warnings, Ordering::Relaxed);
    }

    /// Marks everything about the machine as unknown; findings stand.
    fn forget_evidence(&self) {
        for cylinder in &self.cylinders {
            cylinder.residuals.iter().for_each(|residual| residual.set(None));
            cylinder.measured.set(None);
            let transducers = cylinder.transducers.iter();
            let fitted = transducers.filter(|it| it.get() != Some(Health::NotFitted as u8));
            fitted.for_each(|transducer| transducer.set(Some(Health::Unknown as u8)));
        }
        self.mode.set(None);
        self.heard.store(0, Ordering::Relaxed);
    }
}

fn mark(place: &AtomicU64, uptime: Duration) {
    let nanos = u64::try_from(uptime.as_nanos()).unwrap_or(u64::MAX);
    place.store(nanos.saturating_add(1), Ordering::Relaxed);
}

fn since(place: &AtomicU64, now: Duration) -> Option<Duration> {
    let nanos = place.load(Ordering::Relaxed).checked_sub(1)?;
    Some(now.saturating_sub(Duration::from_nanos(nanos)))
}

/// Number of a state in the order of [`exposition`]'s names.
const fn controller_number(state: ControllerState) -> u8 {
    match state {
        ControllerState::ErrorActive => 0,
        ControllerState::Warning => 1,
        ControllerState::Passive => 2,
        ControllerState::BusOff => 3,
        ControllerState::Stopped => 4,
        ControllerState::Sleeping => 5,
    }
}
