//! Which transducer a displacement belongs to that has outlasted healthy excursions: read at its onset, up to a second ago.

use super::Sequential;
use crate::sequential::alarm::{Alarm, Cause, decide};
use crate::sequential::excursions::{AlarmWindow, Beginning, find};
use crate::verdict::{Fault, Suspect, Testimony};

impl Sequential {
    /// Compares the readings at the onset of a new `alarm` that has no suspect yet.
    pub(super) fn locate(&self, alarm: &mut Alarm) {
        let (Some(limits), Some(pair)) = (&self.design.excursions, &self.pair) else { return };
        let p = &self.design.parameters.onset;
        let age = alarm.age as usize;
        // The size may change for as long as samples are added to it, however long ago the onset was.
        let is_over = age > p.after && age + alarm.back > p.compared;
        let is_new = alarm.cause == Cause::Mean && !is_over && !alarm.of_timing;
        if !is_new || alarm.suspect != Suspect::Undecided || alarm.fault == Fault::Noise {
            return;
        }
        let window = AlarmWindow {
            width: alarm.back,
            age,
            longest: limits.longest.into(),
            deviation: self.design.deviation,
            sample_time: self.design.sample_time,
            followed: self.design.parameters.pair.followed,
        };
        let newest = self.history.all.in_order();
        let newest = &newest[..self.history.all.held()];
        let Some(onset) = find(newest, &window, p) else { return };
        let enough = match onset.beginning {
            Beginning::Step => p.decided,
            Beginning::Ramp => p.decided_of_a_ramp,
        };
        if let Some(evidence) = pair.compare_at(&onset, newest, window.deviation, p) {
            decide(alarm, Testimony::Innovations, Some(evidence), enough);
        }
    }
}
