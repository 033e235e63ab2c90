//! Losses: times of which nothing is known, of a cylinder or of what one bus carries of it.

use super::Cylinder;
use crate::frame::BusNumber;
use crate::observe::observer::Restart;
use crate::time::Timestamp;

impl Cylinder {
    /// Restarts what was learnt of the motion after a time jump or lost frames, of which `last` is the time before;
    /// findings stand.
    pub fn interrupt(&mut self, reason: Restart, last: Timestamp) {
        self.readings.interrupt([true; 3]);
        self.command.interrupt();
        self.fde.interrupt([true; 2], reason);
        self.fde.bank.interrupt();
        self.interrupt_joint();
        self.account.interrupt(last);
        self.pending = false;
        self.inputs.clear();
    }

    /// Restarts what was learnt of the motion by what `bus` carries, since frames of it may be missing. What the other
    /// buses carry goes on, and findings stand.
    pub fn lose(&mut self, bus: BusNumber) {
        let lost = self.design.buses.map(|own| own == bus);
        if lost == [false; 3] {
            return;
        }
        let [c1, c2, command] = lost;
        self.readings.interrupt(lost);
        if command {
            self.command.interrupt();
        }
        let unfollowed = [c1 || command, c2 || command];
        self.fde.interrupt(unfollowed, Restart::Interruption);
        self.fde.bank.interrupt_of(unfollowed);
        self.interrupt_joint();
    }

    /// Restarts what needs both transducers, or the command.
    fn interrupt_joint(&mut self) {
        if let Some(sequential) = &mut self.sequential {
            sequential.interrupt();
        }
        if let Some(on_stop) = &mut self.on_stop {
            on_stop.interrupt();
        }
        if let Some(process) = &mut self.process {
            process.interrupt();
        }
        if let Some(estimated) = &mut self.estimated {
            estimated.interrupt();
        }
        if let Some(reckoning) = &mut self.reckoning {
            reckoning.pause();
        }
        self.trip.interrupt();
        self.blame.interrupt();
        self.last.interrupt();
    }
}
