//! What a process detector forgets, and when.

use super::Process;
use crate::process::Relation;

impl Process {
    pub(super) fn forget(&mut self) {
        self.forget_cycles();
        self.forget_flow();
        self.forget_friction();
    }

    pub(super) fn forget_cycles(&mut self) {
        self.of_spool.clear();
        self.of_chambers.clear();
        self.trace.clear();
    }

    pub(super) fn forget_flow(&mut self) {
        if let Some(flow) = &mut self.flow {
            flow.forget();
        }
    }

    pub(super) fn forget_friction(&mut self) {
        if let Some(friction) = &mut self.friction {
            friction.forget();
        }
    }

    /// Forgets what long windows still have of a fault that is over: it would raise its alarm again.
    pub(super) fn forget_ended(&mut self, which: Relation) {
        match (which, &mut self.flow, &mut self.friction) {
            (Relation::Flow, Some(flow), _) => flow.forget_evidence(),
            (Relation::Friction, _, Some(friction)) => friction.forget_evidence(),
            _ => {}
        }
    }
}
