//! Readings that are off for a sample or two, and what they leave in an observer.
//!
//! An observer follows each reading (5-4), a wild one, too, and is then off to the other side. Beside an observer whose
//! innovation exceeds its threshold, a copy goes on that no position corrects. If the readings come back, the observer goes on
//! from the copy; if they stay, it is a fault, and the observer has followed it as the thesis has it.

use super::Cylinder;
use crate::observe::observer::{Innovation, Measurement};
use crate::verdict::Residuals;

impl Cylinder {
    /// The innovations without the readings before that have turned out to be wild, and which of them are others now.
    #[cold]
    #[inline(never)]
    pub(super) fn without_wild(
        &mut self,
        mut innovations: [Option<Innovation>; 2],
        good: [Option<Measurement>; 2],
    ) -> ([Option<Innovation>; 2], [bool; 2]) {
        let mut resumed = [false; 2];
        for i in 0..2 {
            let Some((copy, reading)) = self.uncorrected[i].zip(good[i]) else { continue };
            if !self.bank.is_open(i) {
                self.uncorrected[i] = None;
            } else if !self.bank.stays(i, reading.position - copy.length()) {
                let own = self.observers[i].resume(copy, reading);
                (self.uncorrected[i], resumed[i]) = (None, true);
                // Or the quiet after it would confirm it.
                self.last.dismiss(i);
                if let Some(it) = &mut innovations[i] {
                    (it.estimate, it.residual) = (own.estimate, own.residual);
                }
            }
        }
        (innovations, resumed)
    }

    /// Goes on without a reading that was off by less than the threshold, where only what it has left in the observer exceeds
    /// that now. Returns what the copies show, m.
    pub(super) fn set_former_aside(
        &mut self,
        residuals: &mut Residuals,
        innovations: &mut [Option<Innovation>; 2],
        good: [Option<Measurement>; 2],
        resumed: [bool; 2],
    ) -> [Option<f64>; 2] {
        core::array::from_fn(|i| {
            let (reading, residual) = good[i].zip(residuals.r[i])?;
            if let Some(copy) = self.uncorrected[i] {
                return Some(reading.position - copy.length());
            }
            let former = self.bank.former_of_new(i, residual).filter(|_| !resumed[i])?;
            let (copy, left) = self.observers[i].without_former(former, residual);
            if left.abs() < self.design.bank.parameters.stays * residual.abs() {
                self.observers[i].take_over(copy);
                residuals.r[i] = Some(left);
                let estimate = reading.position - left;
                let innovation = innovations[i].iter_mut();
                innovation.for_each(|it| (it.estimate, it.residual) = (estimate, left));
            }
            None
        })
    }

    /// Begins, goes on with, or ends the copies after the residuals were judged.
    pub(super) fn keep_uncorrected(
        &mut self,
        innovations: &[Option<Innovation>; 2],
        good: [Option<Measurement>; 2],
    ) {
        for i in 0..2 {
            let velocity = good[i].and_then(|reading| reading.velocity);
            let observer = &self.observers[i];
            self.uncorrected[i] = match (self.uncorrected[i], innovations[i]) {
                _ if !self.bank.is_open(i) => None,
                (Some(copy), _) => Some(observer.go_on(copy, velocity)),
                (None, Some(it)) if self.bank.may_be_wild(i) => {
                    Some(observer.uncorrected(it.residual))
                }
                (None, _) => None,
            };
        }
    }
}
