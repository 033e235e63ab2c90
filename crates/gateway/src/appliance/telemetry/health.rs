//! The health report of the HTTP endpoint, from the telemetry and the present time.

use super::stops::Drifting;
use super::{EVIDENCE, OpenIncident, Telemetry};
use serde::Serialize;
use std::sync::atomic::Ordering;
use std::time::Duration;
use tertius_core::alarm::Level;
use tertius_core::alarm::status::{Health, Mode};
use tertius_core::error_frame::ControllerState;
use tertius_report::report::alignment;

/// Overall condition, best first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Condition {
    /// Everything is judged, and there are no findings.
    Ok,
    /// There is no evidence either way.
    Unknown,
    /// Warnings stand, or something that should be judged cannot be.
    Degraded,
    /// The gateway does not do its work.
    Down,
}

/// The health report.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct HealthReport {
    pub status: Condition,
    /// Reason, for people.
    pub reason: String,
    /// Identity of the configuration, and of the calibration in it.
    pub configuration: String,
    pub calibration: Option<String>,
    /// Mode, as in Fd_Status.
    pub mode: Option<&'static str>,
    /// State of the bus, `open` or `closed`.
    pub bus: &'static str,
    /// State of the controller in the kernel, where there is one.
    pub controller: Option<&'static str>,
    pub level: &'static str,
    pub warnings_standing: u32,
    /// Incidents that are not closed, the worst first.
    pub incidents: Vec<OpenIncident>,
    /// Time since the last turn of the data path, s; `null` if there was none.
    pub seconds_since_turn: Option<f64>,
    /// Time since the last frame of the machine, s; `null` if there was none since the bus was
    /// opened.
    pub seconds_since_frame: Option<f64>,
    /// Transducers whose readings on the stops drift more than chance explains with this number of
    /// dwells.
    pub drifting: Vec<Drifting>,
}

impl HealthReport {
    /// Whether the gateway does its work, whatever it finds.
    pub fn is_serving(&self) -> bool {
        self.status != Condition::Down
    }
}

impl Telemetry {
    /// The health at the uptime `now`.
    pub fn health(&self, now: Duration) -> HealthReport {
        let (status, reason) = self.judge(now);
        let mode = self.mode.get().filter(|_| self.lives(now));
        let facts = self.facts();
        HealthReport {
            status,
            reason,
            configuration: facts.identity.clone(),
            calibration: facts.calibration.clone(),
            mode: mode.and_then(|mode| name(&Mode::NAMES, mode)),
            bus: if self.is_open() { "open" } else { "closed" },
            controller: self
                .link
                .state
                .get()
                .and_then(|state| name(&ControllerState::NAMES, state)),
            level: name(&Level::NAMES, self.level.load(Ordering::Relaxed)).unwrap_or("none"),
            incidents: self.incidents(now),
            warnings_standing: self.standing.load(Ordering::Relaxed),
            seconds_since_turn: self.since_turn(now).map(|time| time.as_secs_f64()),
            seconds_since_frame: self.since_frame(now).map(|time| time.as_secs_f64()),
            drifting: self.drifting(),
        }
    }

    fn judge(&self, now: Duration) -> (Condition, String) {
        if let Some(reason) = self.standstill(now) {
            return (Condition::Down, reason);
        }
        let standing = self.standing.load(Ordering::Relaxed);
        let mode = self.mode.get();
        if standing > 0 {
            if let Some(reason) = self.unaligned(now) {
                return (Condition::Unknown, reason);
            }
            return (Condition::Degraded, self.trouble(standing, now));
        }
        if let Some(reason) = self.silence(now) {
            return (Condition::Unknown, reason);
        }
        let (condition, reason) = match mode {
            Some(mode) if mode == Mode::Monitoring as u8 => match self.all_healthy() {
                true => return (Condition::Ok, self.calm()),
                false => (Condition::Unknown, "not every transducer is known to be healthy"),
            },
            Some(mode) if mode == Mode::Degraded as u8 => {
                (Condition::Degraded, "something that should be judged cannot be")
            }
            Some(mode) if mode == Mode::Gated as u8 => {
                (Condition::Unknown, "in this state of the platform FDE1 and FDE2 do not judge")
            }
            _ => (Condition::Unknown, "not everything has been judged yet"),
        };
        (condition, reason.to_owned())
    }

    /// That nothing is wrong, as far as the configuration lets it be judged.
    fn calm(&self) -> String {
        match self.facts().switched_off {
            None => "everything is judged, and no warning stands".to_owned(),
            Some(off) => format!("no warning stands; switched off by the configuration: {off}"),
        }
    }

    /// That no warning stands but of differences that nobody has calibrated, if so: those are of no incident.
    fn unaligned(&self, now: Duration) -> Option<String> {
        let of = self.facts().not_calibrated.clone();
        let doubt = alignment::doubt(&of).filter(|_| self.incidents(now).is_empty());
        doubt.map(|_| format!("{}; C1 and C2 have differed from the start", alignment::RUN))
    }

    /// What is wrong with the machine, where `standing` warnings stand.
    fn trouble(&self, standing: u32, now: Duration) -> String {
        if let [worst, others @ ..] = &self.incidents(now)[..] {
            return match others.len() {
                0 => worst.summary.clone(),
                more => format!("{}; and {more} more", worst.summary),
            };
        }
        let level = name(&Level::NAMES, self.level.load(Ordering::Relaxed)).unwrap_or("none");
        match standing {
            1 => format!("a warning of level {level} stands"),
            _ => format!("{standing} warnings stand, the highest of level {level}"),
        }
    }

    /// Why the gateway does not do its work, if so.
    fn standstill(&self, now: Duration) -> Option<String> {
        if !self.is_open() {
            return Some("the interface is not open; the log says why".to_owned());
        }
        match self.since_turn(now) {
            None => Some("the data path has not started".to_owned()),
            Some(time) if time > EVIDENCE => {
                Some(format!("the data path has not turned for {:.1} s", time.as_secs_f64()))
            }
            Some(_) => None,
        }
    }

    /// Why nothing is known of the machine, if the bus is quiet.
    fn silence(&self, now: Duration) -> Option<String> {
        match self.since_frame(now) {
            None => Some("no frame of the machine yet".to_owned()),
            Some(time) if time > EVIDENCE => {
                Some(format!("no frame of the machine for {:.1} s", time.as_secs_f64()))
            }
            Some(_) => None,
        }
    }

    /// Whether each cylinder has a healthy transducer, and no transducer is suspect or faulty.
    fn all_healthy(&self) -> bool {
        let healthy = Some(Health::Healthy as u8);
        let neither = [Some(Health::Unknown as u8), Some(Health::NotFitted as u8)];
        let cylinders = self.cylinders();
        let sound = |cylinder: &super::Cylinder| {
            let states = cylinder.transducers.each_ref().map(super::cell::State::get);
            states.contains(&healthy)
                && states.iter().all(|state| *state == healthy || neither.contains(state))
        };
        !cylinders.is_empty() && cylinders.iter().all(sound)
    }
}

fn name(names: &[&'static str], number: u8) -> Option<&'static str> {
    names.get(usize::from(number)).copied()
}
