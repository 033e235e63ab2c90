//! Incidents and warnings for the tests of the store.

use tertius_core::alarm::detector::{PLACES, WarningPlace};
use tertius_core::alarm::{Detector, Finding, Level, State, Warning};
use tertius_core::blame::Rule;
use tertius_core::incident::{Ending, Excursion, Incident, Naming, Outset, Part, Progress, Scope};
use tertius_core::time::{Span, Timestamp};
use tertius_core::verdict::{Fault, Suspect};

pub(super) const BEGIN: Timestamp = Timestamp::from_nanos(1_700_000_000_000_000_000);

/// A finding of a step.
fn finding() -> Finding {
    Finding {
        fault: Fault::Abrupt,
        suspect: Suspect::C1,
        rule: Rule::OneObserver,
        level: Level::Yellow,
        residual: Some(1.2e-3),
        threshold: Some(1e-3),
        evidence: None,
        device: None,
    }
}

pub(super) fn warning() -> Warning {
    Warning {
        timestamp: BEGIN,
        cylinder: 1,
        detector: Detector::Fde1,
        place: WarningPlace::Fde1 as usize,
        state: State::Raised,
        finding: finding(),
    }
}

/// The incident of that number, as it opens; it begins `number` seconds after [`BEGIN`].
pub(super) fn incident(number: u32) -> Incident {
    let begin = BEGIN.after(Span::from_seconds(f64::from(number)));
    let mut parts = [None; PLACES];
    parts[WarningPlace::Fde1 as usize] = Some(Part {
        raised: begin,
        raises: 1,
        stands: true,
        finding: finding(),
        has_cleared: false,
    });
    let peak = Excursion { value: 1.2e-3, at: begin };
    Incident {
        number,
        scope: Scope::Cylinder(1 + (number % 6) as u8),
        progress: Progress::Opened,
        timestamp: begin,
        begin,
        onset: begin,
        end: None,
        suspect: Suspect::C1,
        named: Some(Naming { at: begin, by_its_end: false }),
        fault: Fault::Abrupt,
        gain: None,
        size: Some(1.21e-3),
        parted: None,
        level: Level::Yellow,
        parts,
        peaks: [Some(peak), None, None, None],
        now: [Some(1.2e-3), None, None, None],
        outset: Outset { judged: [true, false, false], elsewhere: [false; 3] },
        limits: [1e-3, 1e-3, 1.5e-3, 0.05],
    }
}

/// The same, closed after five seconds.
pub(super) fn closed(number: u32) -> Incident {
    let open = incident(number);
    let end = open.begin.after(Span::from_seconds(5.0));
    let progress = Progress::Closed;
    Incident { progress, timestamp: end, end: Some((end, Ending::Returned)), ..open }
}
