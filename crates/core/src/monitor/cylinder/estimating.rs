//! Inputs of the virtual sensor in a cycle.

use super::{Cylinder, Evaluation};
use crate::alarm::Finding;
use crate::estimate::{Estimate, SensorInput, VirtualSensor};
use crate::monitor::gate::Opening;
use crate::observe::observer::Measurement;
use crate::verdict::Suspect;
use alloc::boxed::Box;

impl Cylinder {
    /// This cylinder with a virtual sensor.
    pub fn estimating(mut self) -> Self {
        self.sensor = Some(Box::new(VirtualSensor::new(self.design.estimate.clone())));
        self
    }

    /// The estimate of the newest cycle: `None` where none is made, `Some(None)` where the length
    /// is not known.
    #[inline]
    pub fn estimated(&self) -> Option<Option<&Estimate>> {
        self.sensor.as_ref().map(|_| self.estimated.as_ref())
    }

    /// Estimates the length, after everything that blames a transducer in this cycle has done so.
    pub(super) fn estimate(&mut self, now: Evaluation, good: [Option<Measurement>; 2]) {
        let found = if self.finds_anything() { self.findings() } else { Default::default() };
        let blames = |suspect| found.iter().flatten().any(|it: &Finding| it.suspect == suspect);
        let trusted = [!blames(Suspect::C1), !blames(Suspect::C2)];
        let live = self.command_missing < self.design.command_stale;
        let input = SensorInput {
            cycle: now.cycle,
            lengths: good.map(|reading| reading.map(|reading| reading.position)),
            velocity: good[1].and_then(|reading| reading.velocity),
            command: self.inputs.command_value(),
            follows: now.gate == Opening::Open && live,
            trusted,
            // Whoever is blamed is what the two differ by.
            undecided: blames(Suspect::Undecided) && trusted == [true; 2],
            process: blames(Suspect::Process),
        };
        self.estimated = self.sensor.as_mut().and_then(|sensor| sensor.step(&input));
    }
}
