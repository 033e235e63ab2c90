//! What all cylinders together show of the sampling of C1 and C2.

use super::cylinder::Cylinder;
use super::{Monitor, Notice, Sink};
use crate::alarm::status::MAX_CYLINDERS;
use crate::sequential::{Sampling, Sequential};
use crate::time::Timestamp;

/// Interval of the checks, cycles.
const EVERY: u64 = 5;

const _: () = assert!(MAX_CYLINDERS <= Sampling::MOST_CYLINDERS);

impl Monitor {
    /// Sequential detectors, with the numbers of their cylinders.
    pub fn sequential(&self) -> impl Iterator<Item = (u8, &Sequential)> {
        self.cylinders.iter().filter_map(Cylinder::sequential)
    }

    /// Makes the sequential detectors allow for the sampling that most of them see, and reports
    /// changes.
    pub(super) fn follow_sampling(&mut self, at: Timestamp, sink: &mut impl Sink) {
        if !self.clock.number().is_multiple_of(EVERY) {
            return;
        }
        let Self { cylinders, sampling, .. } = self;
        let said = cylinders.iter().filter_map(Cylinder::sequential);
        let said = said.filter_map(|(_, detector)| detector.said());
        let (apart, told) = sampling.judge(said).unwrap_or_default();
        let detectors = cylinders.iter_mut().filter_map(Cylinder::sequential_mut);
        detectors.for_each(|detector| detector.allow(&apart));
        ask(cylinders);
        if let Some(changed) = told {
            sink.notice(&Notice::Timing { at, apart: changed.then_some(apart) });
        }
    }
}

/// Asks the other cylinders, for each with an alarm that blames nobody, whether the sampling may be
/// the cause.
fn ask(cylinders: &mut [Cylinder]) {
    for index in 0..cylinders.len() {
        let Some(claim) = cylinders[index].sequential().and_then(|(_, it)| it.claim()) else {
            continue;
        };
        let others = cylinders.iter().enumerate().filter(|(other, _)| *other != index);
        let others = others.filter_map(|(_, cylinder)| cylinder.sequential());
        let evidence = others.filter_map(|(_, detector)| detector.evidence(&claim));
        let may_be_timing = !claim.is_contradicted(evidence);
        if let Some(detector) = cylinders[index].sequential_mut() {
            detector.hear(may_be_timing);
        }
    }
}
