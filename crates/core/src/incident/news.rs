//! When an incident is reported again.
//!
//! Whom to suspect, what it is and its level are news at once. That it has grown, or that a further detector agrees, is
//! news after [`IncidentParameters::pause`], so that a person sees no size of minutes ago and a log does not fill with a drift.

use super::{Incident, IncidentParameters, Progress};
use crate::alarm::Level;
use crate::alarm::detector::PLACES;
use crate::state::whole;
use crate::time::Span;
use crate::verdict::{Fault, Suspect};

const P: &IncidentParameters = &IncidentParameters::DEFAULT;

/// What was reported of an incident.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Reported {
    suspect: Suspect,
    fault: Fault,
    has_gain: bool,
    has_size: bool,
    level: Level,
    raised: [bool; PLACES],
    /// Largest value in terms of its limit.
    share: f64,
}

whole! { Reported { suspect, fault, has_gain, has_size, level, raised, share } }

impl Reported {
    pub fn of(incident: &Incident) -> Self {
        let Incident { suspect, fault, gain, level, parts, .. } = incident;
        Self {
            suspect: *suspect,
            fault: *fault,
            has_gain: gain.is_some(),
            has_size: parts.iter().flatten().any(|part| part.finding.size().is_some()),
            level: *level,
            raised: parts.map(|part| part.is_some()),
            share: incident.severity().1,
        }
    }

    /// Whether it says something else than `before`, whatever its size.
    fn differs(&self, before: &Self) -> bool {
        Self { raised: before.raised, share: before.share, ..*self } != *before
    }

    /// Whether it says more than `before`.
    fn is_more(&self, before: &Self) -> bool {
        self.raised != before.raised || self.share > P.growth * before.share.max(P.small)
    }
    /// What is new of the incident, of which `before` was reported `since` then; `None` if nothing is.
    pub fn progress(&self, before: Option<&Self>, since: Span) -> Option<Progress> {
        let Some(before) = before else { return Some(Progress::Opened) };
        // A clock that was set back does not keep it waiting.
        let is_due = !(Span::ZERO..Span::from_seconds(P.pause)).contains(&since);
        let is_news = self.differs(before) || is_due && self.is_more(before);
        is_news.then_some(Progress::Revised)
    }
}
