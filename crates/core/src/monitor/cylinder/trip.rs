//! The machine's own rule, "difference too big" (thesis, section 1-1), on the readings as measured: it knows neither a
//! nor b of (5-20), nor that a reading is frozen.

use super::CylinderDesign;
use crate::alarm::{Approach, Urgency};
use crate::state::state;
use crate::time::Timestamp;
use crate::verdict::Trigger;

/// Whether the machine trips, and how soon.
#[derive(Clone, Debug)]
pub(super) struct Trip {
    /// |C1 − C2| beyond which it does, m.
    limit: f64,
    trigger: Trigger,
    approach: Approach,
    /// Newest measured C1 − C2, m.
    apart: f64,
    has_tripped: bool,
}

state! {
    Trip { trigger, approach, apart, has_tripped }
    but { limit }
}

impl Trip {
    pub fn new(design: &CylinderDesign) -> Self {
        Self {
            limit: design.critical,
            trigger: design.trip(),
            approach: Approach::new(design.deadlines, design.bank.sample_time),
            apart: 0.0,
            has_tripped: false,
        }
    }

    /// Takes the measured C1 − C2, m; `None` where the machine has nothing to compare. Once it has tripped, that
    /// lasts while `differ` holds: while FDE3 finds a difference.
    #[inline(always)]
    pub fn judge(&mut self, at: Timestamp, apart: Option<f64>, differ: bool) {
        self.apart = apart.unwrap_or(self.apart);
        self.trigger.judge(at, apart);
        if let Some(apart) = apart {
            self.approach.push(apart, self.limit);
        }
        self.has_tripped = self.trigger.raised().is_some() || (self.has_tripped && differ);
    }

    /// The measured difference, m, if the machine has tripped.
    #[inline]
    pub fn beyond(&self) -> Option<f64> {
        self.has_tripped.then_some(self.apart)
    }

    pub fn urgency(&self) -> Urgency {
        self.approach.urgency()
    }

    /// Forgets what was under way, after a time of which nothing is known.
    pub fn interrupt(&mut self) {
        self.trigger.interrupt();
        self.approach.interrupt();
    }
}
