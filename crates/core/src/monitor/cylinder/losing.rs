//! Losses: times of which nothing is known, of a cylinder or of what one bus carries of it.

use super::{Cylinder, TRANSDUCERS};
use crate::frame::BusNumber;
use crate::observe::observer::Restart;
use crate::sample::DeviceRole;
use crate::sample::plausibility::Plausibility;
use crate::time::Timestamp;

impl Cylinder {
    /// Restarts what was learnt of the motion after a time jump or lost frames, of which `last` is the time before;
    /// findings stand.
    pub fn interrupt(&mut self, reason: Restart, last: Timestamp) {
        self.observers.iter_mut().for_each(|observer| observer.stop(reason));
        self.commands.reset();
        self.plausibility.iter_mut().for_each(Plausibility::reset);
        self.bank.interrupt();
        self.interrupt_joint();
        self.implausible.iter_mut().for_each(|implausible| implausible.trigger.interrupt());
        self.judged = [false; 2];
        self.blanks.interrupt(last, self.tally.cycles);
        self.motions = Default::default();
        self.interrupt_devices([true; 3]);
        self.way = 0.0;
        self.pending = false;
        self.inputs.clear();
    }

    /// Restarts what was learnt of the motion by what `bus` carries, since frames of it may be missing. What the other
    /// buses carry goes on, and findings stand.
    pub fn lose(&mut self, bus: BusNumber) {
        let [c1, c2, command] = self.design.buses.map(|own| own == bus);
        if !(c1 || c2 || command) {
            return;
        }
        for (i, lost) in TRANSDUCERS.into_iter().zip([c1, c2]).map(|(t, lost)| (t as usize, lost)) {
            if lost {
                self.plausibility[i].reset();
                self.motions[i] = Default::default();
                self.implausible[i].trigger.interrupt();
            }
            if lost || command {
                self.observers[i].stop(Restart::Interruption);
            }
        }
        if command {
            self.way = 0.0;
            self.commands.reset();
            self.implausible[DeviceRole::Valve as usize].trigger.interrupt();
        }
        self.bank.interrupt_of([c1 || command, c2 || command]);
        self.interrupt_joint();
        self.interrupt_devices([c1, c2, command]);
    }

    /// Restarts what needs both transducers, or the command.
    fn interrupt_joint(&mut self) {
        self.uncorrected = [None; 2];
        if let Some(sequential) = &mut self.sequential {
            sequential.interrupt();
        }
        if let Some(on_stop) = &mut self.on_stop {
            on_stop.interrupt();
        }
        if let Some(process) = &mut self.process {
            process.interrupt();
        }
        if let Some(sensor) = &mut self.sensor {
            sensor.interrupt();
        }
        if let Some(reckoning) = &mut self.reckoning {
            reckoning.pause();
        }
        self.critical.interrupt();
        self.approach.interrupt();
        self.blame.interrupt();
        self.last.interrupt();
    }
}
