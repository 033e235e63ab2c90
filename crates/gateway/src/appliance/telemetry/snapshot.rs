//! The state of the machine in numbers, at one time, for programs that know no words.

use super::cell::{Gauge, State};
use super::health::Condition;
use super::incidents::OpenSlot;
use super::lamp::Lamp;
use super::overview::known;
use super::stops::Drifting;
use super::{Cylinder, DETECTORS, NO_STATE, Telemetry};
use std::sync::atomic::Ordering;
use std::time::Duration;
use tertius_core::alarm::status::Health;
use tertius_core::sample::Transducer;

/// State of the gateway and of the machine. What is not known is `None`, or unknown.
#[derive(Clone, Debug)]
pub struct Snapshot {
    /// Time since the gateway's start.
    pub uptime: Duration,
    pub condition: Condition,
    /// Number of the mode in Fd_Status.
    pub mode: Option<u8>,
    /// Number of the highest level in Fd_Status.
    pub level: u8,
    pub warnings_standing: u32,
    /// Number of incidents that are open.
    pub incidents: usize,
    /// Number of the platform's state.
    pub platform: Option<i64>,
    /// Cycles since the gateway's start.
    pub cycles: u64,
    /// Time since the last frame of the machine.
    pub since_frame: Option<Duration>,
    /// Whether the machine is heard now, so that anything can be known of its transducers.
    pub has_evidence: bool,
    /// Identities of the configuration and of the calibration in it.
    pub identity: Option<u32>,
    pub calibration: Option<u32>,
    /// Open incidents of the machine.
    pub shared: Vec<OpenSlot>,
    pub cylinders: Vec<CylinderSnapshot>,
}

/// State of one cylinder.
#[derive(Clone, Debug)]
pub struct CylinderSnapshot {
    /// State of C1 and of C2.
    pub transducers: [Health; 2],
    pub lamps: [Lamp; 2],
    /// |R1|, |R2| and |R3| of the newest cycle, m.
    pub residuals: [Option<f64>; 3],
    /// Estimated length and its standard deviation, m.
    pub estimate: Option<f64>,
    pub sigma: Option<f64>,
    /// The worst of its open incidents and of those of the machine that concern it.
    pub incident: Option<OpenSlot>,
    /// Its own open incidents.
    pub open: Vec<OpenSlot>,
    /// Warnings raised since the gateway's start, by the detectors' order.
    pub raised: [u64; DETECTORS],
}

impl Snapshot {
    /// The state of a machine with so many cylinders of which nothing is known.
    pub fn unknown(cylinders: usize) -> Self {
        let cylinder = CylinderSnapshot {
            transducers: Default::default(),
            lamps: [Lamp::Unknown; 2],
            residuals: [None; 3],
            estimate: None,
            sigma: None,
            incident: None,
            open: Vec::new(),
            raised: Default::default(),
        };
        Self {
            uptime: Duration::ZERO,
            condition: Condition::Unknown,
            mode: None,
            level: 0,
            warnings_standing: 0,
            incidents: 0,
            platform: None,
            cycles: 0,
            since_frame: None,
            has_evidence: false,
            identity: None,
            calibration: None,
            shared: Vec::new(),
            cylinders: vec![cylinder; cylinders],
        }
    }
}

impl Telemetry {
    /// The state at the uptime `now`.
    pub fn snapshot(&self, now: Duration) -> Snapshot {
        let health = self.health(now);
        let evidence = self.has_evidence(now);
        let facts = self.facts();
        let platform = Some(self.platform.load(Ordering::Relaxed)).filter(|_| evidence);
        let shared: Vec<OpenSlot> = self.shared.slots().collect();
        let of = |(number, cylinder): (usize, &Cylinder)| {
            let drifts = |which: usize| {
                let name = Transducer::NAMES[which];
                let is = |it: &Drifting| it.cylinder == number && it.transducer == name;
                health.drifting.iter().any(is)
            };
            let own = cylinder.snapshot(evidence, [drifts(0), drifts(1)]);
            let concerned = shared.iter().filter(|it| it.cylinders.has(number)).copied();
            let worst = own.incident.into_iter().chain(concerned);
            CylinderSnapshot { incident: worst.max_by_key(|it| (it.level, it.number)), ..own }
        };
        Snapshot {
            uptime: now,
            condition: health.status,
            mode: self.mode.get().filter(|_| self.lives(now)),
            level: self.level.load(Ordering::Relaxed),
            warnings_standing: health.warnings_standing,
            incidents: health.incidents.len(),
            platform: platform.filter(|number| *number != NO_STATE),
            cycles: self.totals.cycles.get(),
            since_frame: self.since_frame(now),
            has_evidence: evidence,
            identity: u32::from_str_radix(&facts.identity, 16).ok(),
            calibration: facts.calibration.as_ref().and_then(|it| u32::from_str_radix(it, 16).ok()),
            cylinders: (1..).zip(self.cylinders()).map(of).collect(),
            shared,
        }
    }
}

impl Cylinder {
    fn snapshot(&self, evidence: bool, drifts: [bool; 2]) -> CylinderSnapshot {
        let now = |gauge: &Gauge| gauge.get().filter(|_| evidence);
        let transducers = self.transducers.each_ref();
        let transducers = transducers.map(|it| known(State::get(it), evidence));
        let lamp = |which: usize| {
            let check = evidence && self.check(which).is_some();
            Lamp::new(transducers[which], check, drifts[which])
        };
        let open: Vec<OpenSlot> = self.incidents.slots().collect();
        CylinderSnapshot {
            transducers,
            lamps: [lamp(0), lamp(1)],
            residuals: self.residuals.each_ref().map(now),
            estimate: now(&self.estimate),
            sigma: now(&self.sigma),
            incident: open.iter().copied().max_by_key(|it| (it.level, it.number)),
            open,
            raised: self.raised.each_ref().map(super::cell::Total::get),
        }
    }
}

impl Condition {
    /// Its number for programs: 0 is good, and only that.
    pub const fn number(self) -> u16 {
        match self {
            Self::Ok => 0,
            Self::Unknown => 1,
            Self::Degraded => 2,
            Self::Down => 3,
        }
    }
}
