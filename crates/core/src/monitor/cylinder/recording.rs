//! Records of a cylinder's cycle.

use super::{Cycle, Cylinder};
use crate::incident::Quantities;
use crate::monitor::sink::Record;
use crate::observe::observer::Innovation;
use crate::sample::plausibility::Plausibility;
use crate::verdict::Residuals;

impl Cylinder {
    /// What an incident is compared with in the newest cycle: what the detectors judged, and beyond the
    /// machine's own limit the measured difference. Only for a cylinder that is watched or finds anything.
    pub const fn quantities(&self) -> &Quantities {
        &self.quantities
    }

    #[cold]
    pub(super) fn note_quantities(&mut self, residuals: &Residuals) {
        let mut shown = residuals.r;
        // What raised an FDE in this cycle may have been larger a sample before.
        for (shown, found) in shown.iter_mut().zip(self.fde.bank.detections()) {
            *shown = shown.map(|it| found.map_or(it, |found| found.residual));
        }
        let [r1, r2, r3] = shown;
        self.quantities = [r1, r2, r3, self.trip.beyond()];
    }

    /// The record of the newest cycle, available until its inputs are cleared.
    pub fn record(&self, cycle: &Cycle) -> Record {
        let Cycle { now, readings, innovations, difference, .. } = *cycle;
        let [c1, c2] = readings.map(|reading| reading.map(|reading| reading.position));
        let residual = |i: usize| innovations[i].map(|innovation: Innovation| innovation.residual);
        Record {
            timestamp: now.opened,
            cycle: now.cycle,
            cylinder: self.design.number,
            c1,
            c2,
            velocities: readings.map(|reading| reading?.velocity),
            qualities: self.readings.plausibility.each_ref().map(Plausibility::quality),
            pressures: self.inputs.pressures(),
            supply: self.inputs.supply_value(),
            spool: self.inputs.spool_value(),
            c2_corrected: c2.map(|c2| self.design.comparator.corrected(c2)),
            command: self.inputs.command_value(),
            estimates: innovations.map(|innovation| innovation.map(|i| i.estimate)),
            residuals: [residual(0), residual(1), difference],
            judged: self.account.judged,
            gated: !self.account.judged.contains(&true),
            monitored: cycle.is_monitored(),
        }
    }
}
