//! Logs warnings and incidents.

use crate::live::outbox::OutboxLimits;
use tertius_config::MachineNames;
use tertius_core::alarm::status::MAX_CYLINDERS;
use tertius_core::alarm::{State, Warning};
use tertius_core::incident::{Incident, MOST_AT_ONCE, Progress};
use tertius_core::verdict::Fault;
use tertius_report::story;
use tracing::{debug, info, warn};

/// Most warnings that wait: as many as wait to be sent. Further ones are logged at once.
const WAITING: usize = OutboxLimits::WAITING;

/// Most incidents that wait: as many as can be open at once.
const INCIDENTS_WAITING: usize = MOST_AT_ONCE * MAX_CYLINDERS;

/// Keeps the warnings of a turn until their frames have been sent, since the bus comes first.
/// Writing a log line takes longer than everything that the monitor does with a frame, and wakes
/// another thread.
#[derive(Debug)]
pub(super) struct WarningLog {
    waiting: Vec<Warning>,
    incidents: Vec<Incident>,
    /// How cylinders and transducers are called.
    names: MachineNames,
}

impl WarningLog {
    pub(super) fn new() -> Self {
        Self {
            waiting: Vec::with_capacity(WAITING),
            incidents: Vec::with_capacity(INCIDENTS_WAITING),
            names: MachineNames::default(),
        }
    }

    /// Calls cylinders and transducers so from now on.
    pub(super) fn call(&mut self, names: &MachineNames) {
        self.write();
        self.names.clone_from(names);
    }

    /// How cylinders and transducers are called.
    pub(super) const fn names(&self) -> &MachineNames {
        &self.names
    }

    pub(super) fn take(&mut self, warning: &Warning) {
        if self.waiting.len() == WAITING {
            self.write();
        }
        self.waiting.push(*warning);
    }

    pub(super) fn queue_incident(&mut self, incident: &Incident) {
        if self.incidents.len() == INCIDENTS_WAITING {
            self.write();
        }
        self.incidents.push(*incident);
    }

    /// Logs the warnings that wait, and then the incidents that they belong to.
    pub(super) fn write(&mut self) {
        let names = &self.names;
        self.waiting.drain(..).for_each(|warning| write(&warning, names));
        self.incidents.drain(..).for_each(|incident| log_incident(&incident, names));
    }
}

fn write(warning: &Warning, names: &MachineNames) {
    let finding = &warning.finding;
    let said = said(warning);
    let residual = finding.residual.map(|residual| residual * 1e3);
    let gain = finding.gain().map(|gain| gain * 100.0);
    let device = finding.device.map(|device| device.to_string());
    let suspect =
        story::transducer(finding.suspect).and_then(|it| names.of_transducer(warning.cylinder, it));
    macro_rules! log {
        ($level:ident) => {
            $level!(
                cylinder = warning.cylinder,
                name = names.of_cylinder(warning.cylinder),
                detector = warning.detector.name(),
                fault = finding.fault.name(),
                suspect = finding.suspect.name(),
                suspect_name = suspect,
                by = finding.rule.name(),
                level = finding.level.name(),
                residual_mm = residual,
                gain_percent = gain,
                device = device.as_deref(),
                timestamp = %warning.timestamp,
                "{said}"
            )
        };
    }
    if finding.fault == Fault::NotCalibrated {
        // It was logged at the start that there is no calibration.
        return log!(debug);
    }
    match warning.state {
        State::Cleared => log!(info),
        State::Raised | State::Changed => log!(warn),
    }
}

/// The warning in a line: `FDE3 raised: cylinder 3, suspect C2 (by frozen-partner)`.
fn said(warning: &Warning) -> String {
    let Warning { detector, state, cylinder, finding, .. } = warning;
    let (detector, state) = (detector.label(), state.name());
    let suspect = story::suspect_word(finding.suspect);
    let rule = finding.rule.name();
    format!("{detector} {state}: cylinder {cylinder}, suspect {suspect} (by {rule})")
}

fn log_incident(incident: &Incident, names: &MachineNames) {
    let (line, state) = (story::line(incident, names), incident.progress.name());
    let (number, cylinder) = (incident.number, incident.scope.cylinder());
    let (suspect, level) = (incident.suspect.name(), incident.level.name());
    macro_rules! log {
        ($level:ident, $more:expr) => {
            $level!(
                incident = number,
                cylinder,
                suspect,
                level,
                timestamp = %incident.timestamp,
                "incident {state}: {line}; {}",
                $more
            )
        };
    }
    match incident.progress {
        Progress::Closed => log!(info, story::ending(incident)),
        Progress::Opened | Progress::Revised | Progress::Standing => {
            log!(warn, story::evidence(incident));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tertius_core::alarm::{Detector, Finding, Level};
    use tertius_core::blame::Rule;
    use tertius_core::time::Timestamp;
    use tertius_core::verdict::Suspect;

    #[test]
    fn a_storm_is_logged_and_not_kept() {
        let finding = Finding {
            fault: Fault::Abrupt,
            suspect: Suspect::C1,
            rule: Rule::OneObserver,
            level: Level::Yellow,
            residual: None,
            threshold: None,
            evidence: None,
            device: None,
        };
        let warning = Warning {
            timestamp: Timestamp::default(),
            cylinder: 1,
            detector: Detector::Fde1,
            place: 0,
            state: State::Raised,
            finding,
        };
        let mut log = WarningLog::new();
        (0..WAITING).for_each(|_| log.take(&warning));
        assert_eq!(log.waiting.len(), WAITING, "all of a turn wait");
        log.take(&warning);
        assert_eq!(log.waiting.len(), 1, "what waited was logged to make room");
        assert_eq!(log.waiting.capacity(), WAITING);
        log.write();
        assert!(log.waiting.is_empty());
    }
}
