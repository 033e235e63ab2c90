//! The algorithm of a cylinder at a glance: what is done in a cycle, and in which order.

use super::account::Account;
use super::readings::CheckContext;
use super::{Cycle, Cylinder};
use crate::observe::observer::{Measurement, Restart};
use crate::sample::{DeviceRole, Transducer};

impl Cylinder {
    /// Evaluates the cycle; its inputs must be cleared afterwards. `restarted` is called for
    /// observers that restart.
    pub fn evaluate(&mut self, cycle: &mut Cycle, restarted: impl FnMut(Transducer, Restart)) {
        self.pending = false;
        self.awaited.take(self.inputs.got());
        self.read(cycle);
        self.observe(cycle, restarted);
        self.detect(cycle);
        self.follow_standing();
        let finds = self.judge_last(cycle);
        if self.estimated.is_some() {
            self.estimate(cycle);
        }
        self.account(cycle, finds);
    }

    /// Takes the inputs of a cycle: which readings are good, and how the command moves the rod.
    #[inline(always)]
    fn read(&mut self, cycle: &mut Cycle) {
        let now = cycle.now;
        cycle.command = self.inputs.command_value().map(|u| u - self.design.command_offset);
        cycle.readings = Transducer::ALL.map(|t| self.inputs.reading(t, self.design.required));
        self.readings.take(&now, &self.design, &cycle.readings);
        self.check::<0>(cycle);
        self.check::<1>(cycle);
        self.length = cycle.length();
        let is_heard = now.heard.has(self.design.buses[DeviceRole::Valve as usize]);
        let quality = self.command.follow(cycle.command, is_heard, &self.design);
        self.readings.check_command(quality, now.at);
        cycle.is_odd |= self.readings.is_implausible(DeviceRole::Valve as usize);
    }

    /// Checks the reading of transducer `I`, see [`super::fde::Fde::observe`].
    #[inline(always)]
    fn check<const I: usize>(&mut self, cycle: &mut Cycle) {
        if !self.has(Transducer::ALL[I]) {
            // The only reading that is left is supervised in every cycle.
            cycle.is_odd = true;
            return;
        }
        let (is_plain, is_all) = self.readings.take_plain(I, &cycle.readings);
        let is_good = is_all || self.check_odd(I, is_plain, cycle);
        let reading = cycle.readings[I].as_ref().filter(|_| is_good);
        cycle.good[I] = reading
            .map(|reading| Measurement { position: reading.position, velocity: reading.velocity });
    }

    /// Checks a reading that is not plain, or of which a warning stands; returns whether it is good.
    #[inline(never)]
    fn check_odd(&mut self, i: usize, is_plain: bool, cycle: &mut Cycle) -> bool {
        let context = CheckContext {
            now: cycle.now,
            design: &self.design,
            inputs: &self.inputs,
            way: self.command.way,
            been: self.last.been(),
            sequential: self.sequential.as_deref(),
            bank: &self.fde.bank,
            blame: &self.blame,
        };
        let is_good = self.readings.judge(i, is_plain, &cycle.readings, &context).is_good();
        self.account.tally.implausible[i] += u64::from(cycle.readings[i].is_some() && !is_good);
        cycle.is_odd |= !is_good || self.readings.is_implausible(i);
        is_good
    }

    /// Steps the observers, and compares C1 with the corrected C2.
    #[inline(always)]
    fn observe(&mut self, cycle: &mut Cycle, mut restarted: impl FnMut(Transducer, Restart)) {
        if self.has(Transducer::C1)
            && let Some(reason) = self.fde.observe::<0>(cycle)
        {
            restarted(Transducer::C1, reason);
        }
        if self.has(Transducer::C2)
            && let Some(reason) = self.fde.observe::<1>(cycle)
        {
            restarted(Transducer::C2, reason);
        }
        let [c1, c2] = cycle.lengths();
        cycle.difference = c1.zip(c2).map(|(c1, c2)| self.design.comparator.residual(c1, c2));
    }

    /// Lets each detector judge the cycle, in the order in which one needs what another has found.
    #[inline(always)]
    fn detect(&mut self, cycle: &mut Cycle) {
        self.rest(cycle);
        if self.sequential.is_some() {
            self.judge_sequentially(cycle);
        }
        self.judge_residuals(cycle);
        self.command.watch.take(cycle.command);
        self.judge_measured(cycle);
        if self.sequential.is_some() {
            self.judge_beside_sequential(cycle);
        }
        if self.process.is_some() {
            self.judge_process(cycle);
            self.reckon_by_oil(cycle);
        }
    }

    /// Takes the readings of a cycle, on the stop or not.
    #[inline]
    fn rest(&mut self, cycle: &Cycle) {
        match &mut self.on_stop {
            Some(on_stop) if cycle.now.at_stop => {
                on_stop.stand(cycle, self.design.has(Transducer::C2));
            }
            Some(on_stop) => on_stop.leave(),
            None => {}
        }
    }

    /// Counts what was judged, and keeps what an incident is compared with.
    #[inline(always)]
    fn account(&mut self, cycle: &Cycle, finds: bool) {
        let complete = self.is_complete();
        let Account { judged, blanks, tally } = &mut self.account;
        tally.count(&cycle.residuals, judged.contains(&true), complete);
        if !blanks.goes_on(*judged) {
            self.note_blank(cycle);
        }
        self.is_busy = self.is_watched | finds | self.has_drifted();
        if self.is_busy {
            self.note_quantities(&cycle.residuals);
        }
    }
}
