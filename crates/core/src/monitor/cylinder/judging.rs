//! Inputs of the detectors of a cylinder in a cycle.

use super::{Cylinder, Evaluation, Implausible, TRANSDUCERS};
use crate::blame::Agreement;
use crate::blame::agreement::{PairState, is_alone};
use crate::blame::standing::ReadingState;
use crate::monitor::gate::Opening;
use crate::observe::observer::{Innovation, Measurement};
use crate::process::{ProcessCoverage, ProcessInput};
use crate::sample::{Quality, Reading};
use crate::sequential::{self, Sequential};
use crate::time::Timestamp;
use crate::verdict::{Residuals, Testimony, Verdict};

impl Cylinder {
    /// The part of [`Cylinder::evaluate`] that is not compiled again with a sink in another crate. Returns the residuals, and
    /// the innovations that they are from: those of a wild reading are replaced.
    #[inline(always)]
    pub(super) fn judge(
        &mut self,
        now: Evaluation,
        mut innovations: [Option<Innovation>; 2],
        good: [Option<Measurement>; 2],
        difference: Option<f64>,
    ) -> ([Option<Innovation>; 2], Residuals) {
        // Without a command the model predicts nothing, so its residual is no evidence.
        // Nor does it for a valve that does not work.
        let open = now.gate == Opening::Open
            && self.command_missing < self.design.command_stale
            && !self.command_silent
            && !self.has_idle_valve();
        let mut resumed = [false; 2];
        if self.bank.is_exceeded() {
            (innovations, resumed) = self.without_wild(innovations, good);
        }
        let judged = innovations
            .map(|innovation| innovation.filter(|i| open && i.settled).map(|i| i.residual));
        self.judged = judged.map(|residual| residual.is_some());
        if !self.design.observes {
            // Then the sequential detector alone is evidence that either is healthy.
            self.judged = [self.sequential.as_ref().is_some_and(|it| it.unknown().is_none()); 2];
        }
        // After a loss it is no evidence either way.
        let whole = |i: usize| judged[i].filter(|_| innovations[i].is_some_and(|i| i.whole));
        let mut residuals = Residuals { r: [whole(0), whole(1), difference] };
        if self.commands.is_beyond() {
            self.keep_lonely(&mut residuals, judged);
        }
        if !self.bank.take_calm(&residuals) {
            (innovations, residuals) =
                self.judge_exceeded(now, (innovations, residuals), good, resumed);
        }
        (innovations, residuals)
    }

    /// Judges residuals of which one exceeds its threshold, or did so lately.
    #[inline(never)]
    fn judge_exceeded(
        &mut self,
        now: Evaluation,
        (mut innovations, mut residuals): ([Option<Innovation>; 2], Residuals),
        good: [Option<Measurement>; 2],
        resumed: [bool; 2],
    ) -> ([Option<Innovation>; 2], Residuals) {
        let aside = self.set_former_aside(&mut residuals, &mut innovations, good, resumed);
        let jump = self.sequential.as_deref().and_then(Sequential::jump);
        self.bank.judge(now.at, &residuals, aside, self.length, jump);
        if self.bank.any_found() || self.blame.pattern.is_any() {
            self.blame.pattern.follow(now.at, &self.bank.raised());
        }
        self.keep_uncorrected(&innovations, good);
        (innovations, residuals)
    }

    /// After a command that the thresholds were not made for, only what one observer alone sees is a fault. One that
    /// started meanwhile does not have what the other one has from before, and proves nothing. What exceeded its threshold
    /// before that command is no error of it: a controller answers a step of both readings by 25 mm within a cycle.
    #[cold]
    fn keep_lonely(&self, residuals: &mut Residuals, mut judged: [Option<f64>; 2]) {
        if !self.observers.iter().all(|it| self.commands.is_shared_by(it.followed())) {
            judged = [None; 2];
        }
        let high = self.design.bank.observer.high;
        for (i, residual) in residuals.r.iter_mut().take(judged.len()).enumerate() {
            let has_begun = self.bank.is_open(i);
            *residual =
                residual.filter(|it| it.abs() <= high || has_begun || is_alone(*it, judged[1 - i]));
        }
    }

    /// Judges the machine's own rule, "difference too big" (thesis, section 1-1), on the readings
    /// as measured: it knows neither a nor b of (5-20), nor that a reading is frozen. The machine
    /// replaces a reading without a signal, or an impossible one, by the other, and then has
    /// nothing to compare.
    #[inline(always)]
    pub(super) fn judge_measured(&mut self, at: Timestamp, readings: &[Option<Reading>; 2]) {
        let measured = |i: usize| {
            let taken = matches!(self.plausibility[i].quality(), Quality::Good | Quality::Frozen);
            readings[i].as_ref().filter(|_| taken).map(|reading| reading.position)
        };
        let apart = measured(0).zip(measured(1)).map(|(c1, c2)| c1 - c2);
        self.apart = apart.unwrap_or(self.apart);
        self.critical.judge(at, apart);
        if let Some(apart) = apart {
            self.approach.push(apart, self.design.critical);
        }
        // It has tripped: that is over when the two agree again.
        let differ = self.bank.verdicts()[2] == Verdict::Faulty;
        self.was_critical = self.critical.raised().is_some() || (self.was_critical && differ);
    }

    /// Follows which reading stands still, or is missing, while a detector is raised.
    #[inline]
    pub(super) fn follow_standing(&mut self) {
        let sequential = self.sequential.as_ref().is_some_and(|it| it.alarm().is_some());
        if self.bank.any_found() || sequential {
            self.take_standing(sequential);
        } else {
            // Nearly always: nobody is blamed.
            self.blame.standing.rest();
        }
    }

    #[cold]
    fn take_standing(&mut self, sequential: bool) {
        let [fde1, fde2, fde3] = self.bank.verdicts().map(|verdict| verdict == Verdict::Faulty);
        let raised = [fde1, fde2, fde3, sequential];
        let standing = core::array::from_fn(|i| ReadingState {
            known: self.implausible[i].raised().then_some(self.implausible[i].fault),
            alone: self.plausibility[i].stands_alone(),
            idle: self.plausibility[i].idle(),
        });
        self.blame.standing.follow(raised, standing);
    }

    fn is_implausible(&self) -> bool {
        self.implausible[..2].iter().any(Implausible::raised)
    }

    /// Whether a transducer is under suspicion, and whether the readings have parted that are both plausible.
    #[inline]
    pub(super) fn doubts(&self) -> (bool, bool) {
        let difference = self.bank.any_found() && self.bank.difference_age().is_some();
        let (sequential, is_implausible) = (self.sequential.as_deref(), self.is_implausible());
        let is_doubted =
            difference || is_implausible || sequential.is_some_and(|it| it.alarm().is_some());
        (is_doubted, !is_implausible && sequential.is_some_and(Sequential::is_displaced))
    }

    #[inline(never)]
    pub(super) fn judge_process(&mut self, now: Evaluation, mut good: [Option<Measurement>; 2]) {
        let (is_doubted, asked) = self.doubts();
        // The controller does not follow a transducer that was out before and gives no reading.
        let is_without = self.alone().is_some_and(|i| good[1 - i].is_none());
        let held = is_doubted && !is_without;
        if self.bank.is_exceeded() {
            // A spike of 4 mm is a way that no oil explains.
            good = [0, 1].map(|i| good[i].filter(|_| !self.bank.is_open(i)));
        }
        let is_lost = TRANSDUCERS.into_iter().any(|t| self.has(t) && good[t as usize].is_none());
        let is_gain = asked && self.sequential.as_deref().is_some_and(Sequential::is_gain);
        let Some(process) = &mut self.process else { return };
        let monitored = now.gate == Opening::Open;
        let [bottom, rod, load] = self.inputs.pressures();
        let [c1, c2] = good.map(|reading| reading.map(|it| it.position));
        let c2 = c2.map(|c2| self.design.comparator.corrected(c2));
        let side = process.step(&ProcessInput {
            command: self.inputs.command_value(),
            spool: self.inputs.spool_value(),
            chambers: [bottom, rod],
            load,
            lengths: [c1, c2],
            supply: self.inputs.supply_value(),
            monitored,
            apart: self.sequential.as_deref().and_then(Sequential::residual),
            is_lost,
            held,
            asked,
            is_gain,
            at: now.opened,
        });
        if let (Some(nats), Some(sequential)) = (side, &mut self.sequential) {
            sequential.take_evidence(Testimony::Flow, nats);
        }
        if monitored {
            let coverage =
                self.tally.process.get_or_insert_with(|| ProcessCoverage::new(process.knows()));
            coverage.count(process.judged());
        }
    }

    #[inline(never)]
    pub(super) fn judge_sequentially(&mut self, now: Evaluation, good: [Option<Measurement>; 2]) {
        let Some(sequential) = &mut self.sequential else { return };
        let [c1, c2] = good;
        sequential.step(&sequential::Input {
            lengths: [c1.map(|reading| reading.position), c2.map(|reading| reading.position)],
            velocity: c2.and_then(|reading| reading.velocity),
            // As it was sent: the drive has a constant of its own.
            command: self.inputs.command_value(),
            monitored: now.gate == Opening::Open,
            at: now.opened,
        });
        self.tally.sequential.get_or_insert_default().count(sequential.unknown());
    }

    /// Judges what needs the verdicts of this cycle, and is there where a sequential detector is.
    #[inline(never)]
    pub(super) fn judge_beside_sequential(
        &mut self,
        at: Timestamp,
        residuals: &Residuals,
        good: [Option<Measurement>; 2],
    ) {
        self.judge_agreement(residuals);
        self.reckon_by_drive(at, good);
    }

    /// Whether C1 and C2 agree with each other while an observer disagrees with one of them.
    #[inline]
    fn judge_agreement(&mut self, residuals: &Residuals) {
        let Some(sequential) = &self.sequential else { return };
        let [fde1, fde2, _] = self.bank.verdicts();
        let [r1, r2, _] = residuals.r;
        let raised = [fde1, fde2].map(|verdict| verdict == Verdict::Faulty);
        if raised == [false; 2] && !self.bank.is_exceeded() {
            // Nearly always: nobody disagrees.
            self.blame.agreement = Agreement::default();
        } else {
            let readings = PairState {
                apart: sequential.apart(),
                contradicted: sequential.alarm().is_some(),
                parted: sequential.is_displaced(),
            };
            let exceeded = [0, 1].map(|i| self.bank.is_open(i));
            self.blame.agreement.judge(raised, exceeded, [r1, r2], readings);
        }
    }
}
