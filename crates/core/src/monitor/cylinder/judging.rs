//! What each detector of a cylinder is given in a cycle.

use super::{Cycle, Cylinder};
use crate::blame::Agreement;
use crate::blame::agreement::PairState;
use crate::blame::standing::ReadingState;
use crate::process::{ProcessCoverage, ProcessInput};
use crate::sample::Transducer;
use crate::sequential::{self, Judgement, Sequential};
use crate::time::Timestamp;
use crate::verdict::{Residuals, Testimony, Verdict};

impl Cylinder {
    /// The part of [`Cylinder::evaluate`] that is not compiled again with a sink in another crate.
    #[inline(always)]
    pub(super) fn judge_residuals(&mut self, cycle: &mut Cycle) {
        // Without a command the model predicts nothing, so its residual is no evidence.
        // Nor does it for a valve that does not work.
        let open =
            cycle.is_monitored() && self.command.is_known() && !self.readings.has_idle_valve();
        let mut resumed = [false; 2];
        if self.fde.bank.is_exceeded() {
            resumed = self.fde.resume_without_wild(cycle);
            // Or the quiet after it would confirm it.
            (0..2).filter(|i| resumed[*i]).for_each(|i| self.last.dismiss(i));
        }
        let innovations = cycle.innovations;
        let judged = innovations
            .map(|innovation| innovation.filter(|i| open && i.settled).map(|i| i.residual));
        self.account.judged = judged.map(|residual| residual.is_some());
        if !self.design.observes {
            // Then the sequential detector alone is evidence that either is healthy.
            self.account.judged =
                [self.sequential.as_ref().is_some_and(|it| it.unknown().is_none()); 2];
        }
        // After a loss it is no evidence either way.
        let whole = |i: usize| judged[i].filter(|_| innovations[i].is_some_and(|i| i.whole));
        cycle.residuals = Residuals { r: [whole(0), whole(1), cycle.difference] };
        if self.command.watch.is_beyond() {
            self.fde.keep_lonely(cycle, &self.command.watch, judged);
        }
        if !self.fde.bank.take_calm(&cycle.residuals) {
            self.judge_exceeded(cycle, resumed);
        }
    }

    /// Judges residuals of which one exceeds its threshold, or did so lately.
    #[inline(never)]
    fn judge_exceeded(&mut self, cycle: &mut Cycle, resumed: [bool; 2]) {
        let jump = self.sequential.as_deref().and_then(Sequential::jump);
        self.fde.judge_exceeded(cycle, resumed, jump);
        if self.fde.bank.any_found() || self.blame.pattern.is_any() {
            self.blame.pattern.follow(cycle.now.at, &self.fde.bank.raised());
        }
    }

    /// Judges the machine's own rule.
    #[inline(always)]
    pub(super) fn judge_measured(&mut self, cycle: &Cycle) {
        let [c1, c2] = self.readings.measured(&cycle.readings);
        let differ = self.fde.bank.verdicts()[2] == Verdict::Faulty;
        self.trip.judge(cycle.now.at, c1.zip(c2).map(|(c1, c2)| c1 - c2), differ);
    }

    /// Follows which reading stands still, or is missing, while a detector is raised.
    #[inline]
    pub(super) fn follow_standing(&mut self) {
        let sequential = self.sequential.as_ref().is_some_and(|it| it.alarm().is_some());
        if self.fde.bank.any_found() || sequential {
            self.take_standing(sequential);
        } else {
            // Nearly always nothing is raised.
            self.blame.standing.rest();
        }
    }

    #[cold]
    fn take_standing(&mut self, sequential: bool) {
        let [fde1, fde2, fde3] = self.fde.bank.verdicts().map(|verdict| verdict == Verdict::Faulty);
        let raised = [fde1, fde2, fde3, sequential];
        let standing = core::array::from_fn(|i| ReadingState {
            known: self.readings.implausible[i]
                .raised()
                .then_some(self.readings.implausible[i].fault),
            alone: self.readings.plausibility[i].stands_alone(),
            idle: self.readings.plausibility[i].idle(),
        });
        self.blame.standing.follow(raised, standing);
    }

    #[inline(never)]
    pub(super) fn judge_process(&mut self, cycle: &Cycle) {
        let mut good = cycle.good;
        let (is_doubted, asked) = self.doubts();
        // The controller does not follow a transducer that was out before and gives no reading.
        let is_without = self.last.alone(&self.design).is_some_and(|i| good[1 - i].is_none());
        let held = is_doubted && !is_without;
        if self.fde.bank.is_exceeded() {
            // A spike of 4 mm is a way that no oil explains.
            good = [0, 1].map(|i| good[i].filter(|_| !self.fde.bank.is_open(i)));
        }
        let is_lost =
            Transducer::ALL.into_iter().any(|t| self.has(t) && good[t as usize].is_none());
        let is_gain = asked && self.sequential.as_deref().is_some_and(Sequential::is_gain);
        let Some(process) = &mut self.process else { return };
        let monitored = cycle.is_monitored();
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
            at: cycle.now.opened,
        });
        if let (Some(nats), Some(sequential)) = (side, &mut self.sequential) {
            sequential.take_evidence(Testimony::Flow, nats);
        }
        if monitored {
            let coverage = self
                .account
                .tally
                .process
                .get_or_insert_with(|| ProcessCoverage::new(process.knows()));
            coverage.count(process.judged());
        }
    }

    #[inline(never)]
    pub(super) fn judge_sequentially(&mut self, cycle: &Cycle) {
        let Some(sequential) = &mut self.sequential else { return };
        sequential.step(&sequential::Input {
            lengths: cycle.lengths(),
            velocity: cycle.good[1].and_then(|reading| reading.velocity),
            // As it was sent: the drive has a constant of its own.
            command: self.inputs.command_value(),
            monitored: cycle.is_monitored(),
            at: cycle.now.opened,
        });
        self.account.tally.sequential.get_or_insert_default().count(sequential.unknown());
    }

    /// Judges what needs the verdicts of this cycle, and is there where a sequential detector is.
    #[inline(never)]
    pub(super) fn judge_beside_sequential(&mut self, cycle: &Cycle) {
        self.judge_agreement(&cycle.residuals);
        self.reckon_by_drive(cycle);
    }

    /// Whether C1 and C2 agree with each other while an observer disagrees with one of them.
    #[inline]
    fn judge_agreement(&mut self, residuals: &Residuals) {
        let Some(sequential) = &self.sequential else { return };
        let [fde1, fde2, _] = self.fde.bank.verdicts();
        let [r1, r2, _] = residuals.r;
        let raised = [fde1, fde2].map(|verdict| verdict == Verdict::Faulty);
        if raised == [false; 2] && !self.fde.bank.is_exceeded() {
            // Nearly always neither observer disagrees.
            self.blame.agreement = Agreement::default();
        } else {
            let readings = PairState {
                apart: sequential.apart(),
                contradicted: sequential.alarm().is_some(),
                parted: sequential.is_displaced(),
            };
            let exceeded = [0, 1].map(|i| self.fde.bank.is_open(i));
            self.blame.agreement.judge(raised, exceeded, [r1, r2], readings);
        }
    }
    /// Takes the judgement of this cylinder from the dwells of the machine up to `at`.
    pub fn judge_stop(&mut self, at: Timestamp, judgement: &Judgement) {
        match (&mut self.sequential, &mut self.on_stop) {
            (Some(sequential), _) => sequential.judge_stop(at, judgement),
            (None, Some(on_stop)) => on_stop.judge(at, judgement),
            (None, None) => {}
        }
        self.is_busy |= self.has_findings();
    }
}
