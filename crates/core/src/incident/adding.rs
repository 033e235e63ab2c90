//! What a warning adds to its incident.

use super::fusing::OBSERVERS;
use super::{Excursion, Incident, Outset, Part, Progress, QUANTITIES, Quantities, Scope};
use crate::alarm::detector::PLACES;
use crate::alarm::{Finding, Level, State, Warning};
use crate::time::Timestamp;
use crate::verdict::{Fault, Suspect, Testimony};

impl Incident {
    /// An incident that begins with `warning`, which it does not yet include.
    pub(super) fn new(warning: &Warning, elsewhere: [bool; 3], limits: [f64; QUANTITIES]) -> Self {
        Self {
            number: 0,
            scope: Scope::Cylinder(warning.cylinder),
            progress: Progress::Opened,
            timestamp: warning.timestamp,
            begin: warning.timestamp,
            onset: warning.timestamp,
            end: None,
            suspect: Suspect::Undecided,
            named: None,
            fault: Fault::Unclassified,
            gain: None,
            size: None,
            parted: None,
            level: Level::None,
            parts: [None; PLACES],
            peaks: [None; QUANTITIES],
            now: [None; QUANTITIES],
            outset: Outset { elsewhere, ..Outset::default() },
            limits,
        }
    }

    pub(super) fn raise(&mut self, warning: &Warning) {
        let (raised, finding) = (warning.timestamp, warning.finding);
        let part = self.parts[warning.place].get_or_insert(Part {
            raised,
            raises: 0,
            stands: true,
            finding,
            has_cleared: false,
        });
        part.raises = part.raises.saturating_add(1);
        part.stands = true;
        part.take(&finding);
        self.level = self.level.max(finding.level);
        self.fuse(raised);
    }

    pub(super) fn revise(&mut self, warning: &Warning) {
        let Some(part) = &mut self.parts[warning.place] else { return };
        if warning.state == State::Cleared {
            (part.stands, part.has_cleared) = (false, true);
            return;
        }
        part.take(&warning.finding);
        self.level = self.level.max(warning.finding.level);
        self.fuse(warning.timestamp);
    }

    /// Takes that the warning at a place has turned out at `at` to be about another fault. Returns its part if it was raised for
    /// that fault alone; otherwise the part stays. The level stays in either case, since it was reported.
    pub(super) fn give_up(&mut self, place: usize, at: Timestamp) -> Option<Part> {
        let part = self.parts[place].as_mut()?;
        part.stands = false;
        let given = if part.raises == 1 { self.parts[place].take() } else { None };
        self.fuse(at);
        given
    }

    /// Takes the residual by which an observer's detector was raised before it was known to be of this incident.
    pub(super) fn reach_by(&mut self, warning: &Warning) {
        let quantity = OBSERVERS.iter().position(|place| *place as usize == warning.place);
        if let (Some(quantity), Some(residual)) = (quantity, warning.finding.residual) {
            let mut quantities = Quantities::default();
            quantities[quantity] = Some(residual);
            self.reach(warning.timestamp, &quantities);
        }
    }

    pub(super) fn reach(&mut self, opened: Timestamp, quantities: &Quantities) {
        for (peak, value) in self.peaks.iter_mut().zip(quantities) {
            let Some(value) = *value else { continue };
            if peak.is_none_or(|peak| value.abs() > peak.value.abs()) {
                *peak = Some(Excursion { value, at: opened });
            }
        }
    }
}

impl Part {
    /// Takes what its detector says now.
    fn take(&mut self, finding: &Finding) {
        let Finding { fault, suspect, rule, evidence, device, .. } = *finding;
        let own = &mut self.finding;
        if !self.has_cleared {
            (own.fault, own.suspect, own.rule) = (fault, suspect, rule);
            own.evidence = evidence.or(own.evidence);
            own.device = device.or(own.device);
            if evidence.is_some_and(|it| it.by == Some(Testimony::Way)) {
                // The innovation by which the observer rose before is another quantity.
                (own.residual, own.threshold) = (finding.residual, finding.threshold);
            }
            return;
        }
        if own.suspect == Suspect::Undecided {
            (own.suspect, own.rule) = (suspect, rule);
            if let (Some(own), Some(new)) = (&mut own.evidence, evidence) {
                (own.location, own.by) = (new.location, new.by);
            }
        }
        if own.fault == Fault::Unclassified && own.gain().is_none() {
            own.fault = fault;
        }
    }
}
