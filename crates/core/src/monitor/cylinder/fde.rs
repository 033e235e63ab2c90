//! FDE1, FDE2 and FDE3: observers on C1 and C2, and the thresholds of R1, R2 and R3 (thesis, chapter 5).
//!
//! An observer follows each reading (5-4), wild ones too. After one it is off in the other direction. Beside an observer whose
//! innovation exceeds its threshold, a copy goes on that no position corrects. If the readings come back, the observer goes on
//! from the copy; if they stay, it is a fault, and the observer has followed it as the thesis has it.

use super::{Cycle, CylinderDesign};
use crate::blame::agreement::is_alone;
use crate::observe::commands::CommandWatch;
use crate::observe::observer::{Innovation, Observer, Restart, Uncorrected};
use crate::state::state;
use crate::verdict::{Bank, Jump};

/// The detectors of the residuals.
#[derive(Clone, Debug)]
pub(super) struct Fde {
    pub observers: [Observer; 2],
    /// Observers as if the newest readings had not corrected them, which may be wild.
    uncorrected: [Option<Uncorrected>; 2],
    pub bank: Bank,
    /// Part of a residual that remains where it is not a wild sample's.
    stays: f64,
    /// Threshold of R1 and R2, m.
    high: f64,
}

state! {
    Fde { observers, uncorrected, bank }
    but { stays, high }
}

impl Fde {
    pub fn new(design: &CylinderDesign) -> Self {
        Self {
            observers: design.observers.clone().map(Observer::new),
            uncorrected: [None; 2],
            bank: Bank::new(&design.judging_bank()),
            stays: design.bank.parameters.stays,
            high: design.bank.observer.high,
        }
    }

    /// Steps the observer of transducer `I` with the reading of a cycle. The index is a constant because as a variable it would
    /// cost an address computation for everything that exists twice.
    #[inline(always)]
    pub fn observe<const I: usize>(&mut self, cycle: &mut Cycle) -> Option<Restart> {
        let (innovation, restart) = self.observers[I].step(cycle.good[I], cycle.command);
        cycle.innovations[I] = innovation;
        restart
    }

    /// Goes on without readings that have turned out to be wild; returns of which transducers.
    #[cold]
    #[inline(never)]
    pub fn resume_without_wild(&mut self, cycle: &mut Cycle) -> [bool; 2] {
        core::array::from_fn(|i| {
            let Some((copy, reading)) = self.uncorrected[i].zip(cycle.good[i]) else {
                return false;
            };
            if !self.bank.is_open(i) {
                self.uncorrected[i] = None;
            } else if !self.bank.stays(i, reading.position - copy.length()) {
                let own = self.observers[i].resume(copy, reading);
                self.uncorrected[i] = None;
                if let Some(it) = &mut cycle.innovations[i] {
                    (it.estimate, it.residual) = (own.estimate, own.residual);
                }
                return true;
            }
            false
        })
    }

    /// After a command that the thresholds were not made for, only what one observer alone sees is a fault. One that
    /// started meanwhile does not have what the other one has from before, and proves nothing. What exceeded its threshold
    /// before that command is no error of it: a controller answers a step of both readings by 25 mm within a cycle.
    #[cold]
    pub fn keep_lonely(
        &self,
        cycle: &mut Cycle,
        commands: &CommandWatch,
        mut judged: [Option<f64>; 2],
    ) {
        if !self.observers.iter().all(|it| commands.is_shared_by(it.followed())) {
            judged = [None; 2];
        }
        for (i, residual) in cycle.residuals.r.iter_mut().take(judged.len()).enumerate() {
            let has_begun = self.bank.is_open(i);
            *residual = residual
                .filter(|it| it.abs() <= self.high || has_begun || is_alone(*it, judged[1 - i]));
        }
    }

    /// Judges residuals of which one exceeds its threshold, or did so lately. `resumed` is of [`Self::resume_without_wild`].
    #[inline(never)]
    pub fn judge_exceeded(&mut self, cycle: &mut Cycle, resumed: [bool; 2], jump: Option<Jump>) {
        let aside = self.set_former_aside(cycle, resumed);
        self.bank.judge(cycle.now.at, &cycle.residuals, aside, cycle.length(), jump);
        self.keep_uncorrected(cycle);
    }

    /// Goes on without a reading that was off by less than the threshold, where only what it has left in the observer exceeds
    /// that now. Returns what the copies show, m.
    fn set_former_aside(&mut self, cycle: &mut Cycle, resumed: [bool; 2]) -> [Option<f64>; 2] {
        core::array::from_fn(|i| {
            let (reading, residual) = cycle.good[i].zip(cycle.residuals.r[i])?;
            if let Some(copy) = self.uncorrected[i] {
                return Some(reading.position - copy.length());
            }
            let former = self.bank.former_of_new(i, residual).filter(|_| !resumed[i])?;
            let (copy, left) = self.observers[i].without_former(former, residual);
            if left.abs() < self.stays * residual.abs() {
                self.observers[i].take_over(copy);
                cycle.residuals.r[i] = Some(left);
                let estimate = reading.position - left;
                let innovation = cycle.innovations[i].iter_mut();
                innovation.for_each(|it| (it.estimate, it.residual) = (estimate, left));
            }
            None
        })
    }

    /// Begins, goes on with, or ends the copies after the residuals were judged.
    fn keep_uncorrected(&mut self, cycle: &Cycle) {
        for i in 0..2 {
            let velocity = cycle.good[i].and_then(|reading| reading.velocity);
            let observer = &self.observers[i];
            self.uncorrected[i] = match (self.uncorrected[i], cycle.innovations[i]) {
                _ if !self.bank.is_open(i) => None,
                (Some(copy), _) => Some(observer.go_on(copy, velocity)),
                (None, Some(Innovation { residual, .. })) if self.bank.may_be_wild(i) => {
                    Some(observer.uncorrected(residual))
                }
                (None, _) => None,
            };
        }
    }

    /// Restarts the observers of what was `lost`, and what their residuals had begun.
    pub fn interrupt(&mut self, lost: [bool; 2], reason: Restart) {
        let observers = self.observers.iter_mut().zip(lost).filter(|(_, lost)| *lost);
        observers.for_each(|(observer, _)| observer.stop(reason));
        self.uncorrected = [None; 2];
    }
}
