//! The detectors that a cylinder has where its configuration has tables for them.

use super::Cylinder;
use crate::process::Process;
use crate::sequential::Sequential;

impl Cylinder {
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
}
