//! Everything that the page shows at a glance, at one time.

use super::cell::{Gauge, State};
use super::health::HealthReport;
use super::lamp::Lamp;
use super::stops::Drifting;
use super::{Cylinder, EVIDENCE, NO_STATE, OpenIncident, Telemetry, trend};
use serde::Serialize;
use std::sync::atomic::Ordering;
use std::time::Duration;
use tertius_config::MachineNames;
use tertius_core::alarm::status::Health;
use tertius_core::sample::Transducer;
use tertius_core::time::Timestamp;

/// State of the gateway and of the machine.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Overview {
    /// The system's time, s.
    pub time: f64,
    #[serde(flatten)]
    pub health: HealthReport,
    /// The platform's state: its name, or its number where the DBC has no names.
    pub platform: Option<String>,
    pub cylinders: Vec<CylinderOverview>,
}

/// State of one cylinder.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CylinderOverview {
    /// Counted from 1.
    pub number: usize,
    /// What people call it, if the configuration says so.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Those of C1 and C2.
    pub transducers: [TransducerOverview; 2],
    /// Largest |R1|, |R2| and |R3| in the newest bin of the trend and cycle; `null` without evidence.
    pub residuals_mm: [Option<f64>; 3],
    /// Estimated length of the virtual third sensor.
    pub estimate_m: Option<f64>,
    /// Its standard deviation.
    pub sigma_mm: Option<f64>,
    /// Number of readings on the stops that are kept.
    pub dwells: Option<f64>,
}

/// State of one transducer.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TransducerOverview {
    /// Its tag, if the configuration has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    pub lamp: Lamp,
    /// Words for it, with the reason where there is one.
    pub words: String,
    /// Drift by the readings on the stops, mm a month, whether or not it is beyond chance.
    pub drift_mm_per_month: Option<f64>,
    /// Its standard error, mm a month.
    pub error_mm_per_month: Option<f64>,
    /// Months until maintenance is due: expected, earliest, latest; only where the stops name the transducer.
    pub months_left: [Option<f64>; 3],
}

impl Telemetry {
    /// The overview at the uptime `now` and the system's time `time`.
    pub fn overview(&self, now: Duration, time: Timestamp) -> Overview {
        let health = self.health(now);
        let evidence = self.has_evidence(now);
        let facts = self.facts();
        let view = |numbered| self.cylinder(numbered, evidence, &health, &facts.names);
        let cylinders = (1..).zip(self.cylinders()).map(view).collect();
        let platform = Some(self.platform.load(Ordering::Relaxed)).filter(|_| evidence);
        let platform = platform.filter(|number| *number != NO_STATE).map(|it| self.platform(it));
        Overview { time: time.as_seconds(), platform, cylinders, health }
    }

    /// Name of the platform's state of that number.
    fn platform(&self, number: i64) -> String {
        let facts = self.facts();
        let named = facts.platform_states.iter().find(|(it, _)| *it == number);
        named.map_or_else(|| number.to_string(), |(_, name)| name.clone())
    }

    fn cylinder(
        &self,
        (number, cylinder): (usize, &Cylinder),
        evidence: bool,
        health: &HealthReport,
        names: &MachineNames,
    ) -> CylinderOverview {
        let now = |gauge: &Gauge| gauge.get().filter(|_| evidence);
        let second = known(State::get(&cylinder.transducers[1]), evidence);
        let is_alone = second == Health::NotFitted;
        let transducer = |which: usize| {
            let state = known(State::get(&cylinder.transducers[which]), evidence);
            let check = cylinder.check(which).filter(|_| evidence);
            let is =
                |it: &Drifting| it.cylinder == number && it.transducer == Transducer::NAMES[which];
            let drifts = health.drifting.iter().any(is);
            let lamp = Lamp::new(state, check.is_some(), drifts);
            let reading = &cylinder.stop.readings[which];
            let tag = names.of_transducer(number, Transducer::ALL[which]);
            TransducerOverview {
                name: tag.map(str::to_owned),
                lamp,
                words: words(lamp, (number, Transducer::NAMES[which]), is_alone, check, health),
                drift_mm_per_month: reading.drift.get().map(|drift| drift * 1e3),
                error_mm_per_month: reading.error.get().map(|error| error * 1e3),
                months_left: reading.left.each_ref().map(Gauge::get),
            }
        };
        CylinderOverview {
            number,
            name: names.of_cylinder(number).map(str::to_owned),
            transducers: [transducer(0), transducer(1)],
            residuals_mm: cylinder
                .lately()
                .map(|size| size.filter(|_| evidence).map(|it| it * 1e3)),
            estimate_m: now(&cylinder.estimate),
            sigma_mm: now(&cylinder.sigma).map(|sigma| sigma * 1e3),
            dwells: cylinder.stop.dwells.get(),
        }
    }
}

impl Cylinder {
    /// Largest |R1|, |R2| and |R3| in the newest bin of the trend and in the newest cycle, m; `None` where the
    /// newest cycle has none.
    fn lately(&self) -> [Option<f64>; 3] {
        let [_, _, ranges @ .., _, _] = self.trend.newest().map_or(trend::EMPTY, |bin| bin.ranges);
        std::array::from_fn(|i| {
            // Not-a-number loses against any number.
            let [least, largest] = ranges[i].map(|value| f64::from(value.abs()));
            self.residuals[i].get().map(|size| size.max(least).max(largest))
        })
    }
}

/// The state of that number; unknown without `evidence`, which what is not fitted does not need.
pub(super) fn known(state: Option<u8>, evidence: bool) -> Health {
    let is = |health: &Health| Some(*health as u8) == state;
    let known = Health::ALL.into_iter().find(is);
    known.filter(|health| evidence || *health == Health::NotFitted).unwrap_or_default()
}

/// Words for the lamp of a transducer of the cylinder, with their reason.
fn words(
    lamp: Lamp,
    (cylinder, transducer): (usize, &str),
    is_alone: bool,
    check: Option<&'static str>,
    health: &HealthReport,
) -> String {
    let incident = |suspects: &[&str]| {
        let mut incidents = health.incidents.iter();
        let of = |it: &&OpenIncident| it.concerns(cylinder) && suspects.contains(&it.suspect);
        incidents.find(of).map(|it| it.kind)
    };
    let in_common = || {
        let mut incidents = health.incidents.iter();
        incidents.find(|it| it.cylinder.is_none() && it.concerns(cylinder)).map(|it| it.kind)
    };
    let reason = match lamp {
        Lamp::Failure => incident(&[transducer]).or_else(in_common).unwrap_or_default(),
        // The evidence of an incident may name one when the newest warning names neither.
        Lamp::OutOfSpecification => match incident(&[transducer]) {
            Some(kind) => kind,
            None if is_alone => "it may be this one, or the cylinder",
            None if incident(&["undecided"]).is_some() => "it may be this one or the other",
            None if incident(&["c1", "c2"]).is_some() => {
                "the other one is suspected; this one is not cleared yet"
            }
            None => "",
        },
        Lamp::MaintenanceRequired => "its readings on the stops drift",
        Lamp::CheckFunction => check.unwrap_or_default(),
        Lamp::Good | Lamp::NotFitted => "",
        Lamp::Unknown => match health.mode {
            _ if health.seconds_since_frame.is_none_or(|time| time > EVIDENCE.as_secs_f64()) => {
                "no frames"
            }
            Some("gated") => "not judged in this state of the platform",
            Some("starting") => "not judged yet",
            _ => "no evidence",
        },
    };
    let separator = if reason.is_empty() { "" } else { ": " };
    format!("{}{separator}{reason}", lamp.words())
}

#[cfg(test)]
mod tests {
    use super::super::clock::SystemClock;
    use super::*;

    #[test]
    fn what_is_not_fitted_is_so_without_evidence_and_has_no_reason() {
        let telemetry = Telemetry::new(&SystemClock::new());
        let health = telemetry.health(Duration::ZERO);
        for evidence in [false, true] {
            assert_eq!(known(Some(Health::NotFitted as u8), evidence), Health::NotFitted);
        }
        assert_eq!(known(Some(Health::Healthy as u8), false), Health::Unknown);
        assert_eq!(known(Some(Health::Healthy as u8), true), Health::Healthy);
        assert_eq!(words(Lamp::NotFitted, (2, "c2"), true, None, &health), "not fitted");
        let alone = words(Lamp::OutOfSpecification, (2, "c1"), true, None, &health);
        assert_eq!(alone, "out of specification: it may be this one, or the cylinder");
    }

    /// What is said of C1 and C2 of cylinder 2 when both have this lamp, while an incident blames `suspect`.
    fn said(lamp: Lamp, suspect: &'static str) -> [String; 2] {
        let telemetry = Telemetry::new(&SystemClock::new());
        let mut health = telemetry.health(Duration::ZERO);
        health.incidents = vec![OpenIncident {
            number: 1,
            cylinder: Some(2),
            cylinders: Vec::new(),
            suspect,
            level: "yellow",
            fault: "abrupt",
            kind: "step",
            ..OpenIncident::default()
        }];
        Transducer::NAMES.map(|transducer| words(lamp, (2, transducer), false, None, &health))
    }

    #[test]
    fn whom_an_incident_suspects_has_its_kind_and_the_other_is_not_cleared() {
        let [c1, c2] = said(Lamp::OutOfSpecification, "c1");
        assert_eq!(c1, "out of specification: step");
        assert!(c2.ends_with("the other one is suspected; this one is not cleared yet"), "{c2}");
        let open = said(Lamp::OutOfSpecification, "undecided");
        assert!(open.iter().all(|it| it.ends_with("it may be this one or the other")), "{open:?}");
        assert_eq!(said(Lamp::Good, "c1")[1], "good");
        let of_process = said(Lamp::OutOfSpecification, "process");
        assert_eq!(of_process, ["out of specification", "out of specification"]);
    }
}
