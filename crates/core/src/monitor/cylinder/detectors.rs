//! The detectors that a cylinder has where its configuration has tables for them.

use super::Cylinder;
use crate::compare::Comparator;
use crate::process::Process;
use crate::sequential::{Dwell, DwellHistory, Judgement, Sequential};
use crate::time::Timestamp;

impl Cylinder {
    /// Reading on the stop in the newest cycle, returned once.
    pub fn take_dwell(&mut self) -> Option<Dwell> {
        self.sequential.as_mut()?.take_dwell()
    }

    /// Takes the judgement of this cylinder from the dwells of the machine up to `at`.
    pub fn judge_stop(&mut self, at: Timestamp, judgement: &Judgement) {
        if let Some(sequential) = &mut self.sequential {
            sequential.judge_stop(at, judgement);
            self.is_busy |= self.finds_anything();
        }
    }

    /// Cylinder number and sequential detector, if it has one.
    pub fn sequential(&self) -> Option<(u8, &Sequential)> {
        Some((self.design.number, self.sequential.as_deref()?))
    }

    /// Process detector, if the cylinder has one.
    pub fn process(&self) -> Option<&Process> {
        self.process.as_deref()
    }

    /// The same, to be told of the machine's supply.
    pub(in crate::monitor) fn process_mut(&mut self) -> Option<&mut Process> {
        self.process.as_deref_mut()
    }

    /// Restores the dwells of an earlier monitor, if the cylinder has a detector that reads them.
    pub fn restore(&mut self, dwells: &DwellHistory) {
        if let Some(sequential) = &mut self.sequential {
            let Comparator { gain, offset } = self.design.comparator;
            sequential.restore(dwells.clone(), [gain, offset]);
        }
    }
}
