//! Logs warnings.

use crate::alarm::{State, Warning};
use crate::live::outbox::OutboxLimits;
use tracing::{info, warn};

/// Most warnings that wait: as many as wait to be sent. Further ones are logged at once.
const WAITING: usize = OutboxLimits::WAITING;

/// Keeps the warnings of a turn until their frames have been sent, since the bus comes first.
/// Writing a log line takes longer than everything that the monitor does with a frame, and wakes
/// another thread.
#[derive(Debug)]
pub(super) struct WarningLog {
    waiting: Vec<Warning>,
}

impl WarningLog {
    pub(super) fn new() -> Self {
        Self { waiting: Vec::with_capacity(WAITING) }
    }

    pub(super) fn take(&mut self, warning: &Warning) {
        if self.waiting.len() == WAITING {
            self.write();
        }
        self.waiting.push(*warning);
    }

    /// Logs the warnings that wait.
    pub(super) fn write(&mut self) {
        self.waiting.drain(..).for_each(|warning| write(&warning));
    }
}

fn write(warning: &Warning) {
    let finding = &warning.finding;
    let state = warning.state.name();
    let residual = finding.residual.map(|residual| residual * 1e3);
    let gain = finding.gain().map(|gain| gain * 100.0);
    let device = finding.device.map(|device| device.to_string());
    macro_rules! tell {
        ($say:ident) => {
            $say!(
                cylinder = warning.cylinder,
                detector = warning.detector.name(),
                fault = finding.fault.name(),
                suspect = finding.suspect.name(),
                level = finding.level.name(),
                residual_mm = residual,
                gain_percent = gain,
                device = device.as_deref(),
                timestamp = %warning.timestamp,
                "{state}"
            )
        };
    }
    match warning.state {
        State::Cleared => tell!(info),
        State::Raised | State::Changed => tell!(warn),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::alarm::{Detector, Finding, Level};
    use crate::time::Timestamp;
    use crate::verdict::{Fault, Suspect};

    #[test]
    fn a_storm_is_logged_and_not_kept() {
        let finding = Finding {
            fault: Fault::Abrupt,
            suspect: Suspect::C1,
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
