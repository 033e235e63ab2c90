//! What all cylinders together know of when C1 and C2 are sampled.

use super::cylinder::Cylinder;
use super::{Monitor, Notice, Sink};
use crate::sequential::Sequential;
use crate::time::Timestamp;

/// Cycles from one look to the next.
const EVERY: u64 = 5;

impl Monitor {
    /// The sequential detectors of the cylinders that have one, with their numbers.
    pub fn sequential(&self) -> impl Iterator<Item = (u8, &Sequential)> {
        self.cylinders.iter().filter_map(Cylinder::sequential)
    }

    /// Lets the sequential detectors allow for what most of them see, and tells where that has changed.
    pub(super) fn follow_sampling(&mut self, at: Timestamp, sink: &mut impl Sink) {
        if !self.clock.number().is_multiple_of(EVERY) {
            return;
        }
        let Self { cylinders, sampling, .. } = self;
        let said = cylinders.iter().filter_map(Cylinder::sequential);
        let said = said.filter_map(|(_, detector)| detector.said());
        let (apart, told) = sampling.judge(said).unwrap_or_default();
        cylinders.iter_mut().for_each(|cylinder| cylinder.allow(&apart));
        if let Some(changed) = told {
            sink.notice(&Notice::Timing { at, apart: changed.then_some(apart) });
        }
    }
}
