//! The monitor of one cylinder: from the inputs of a cycle to the findings of its detectors.

mod account;
mod blanks;
mod command;
mod cycle;
mod dead_reckoning;
mod design;
mod devices;
mod estimating;
mod fde;
mod findings;
mod judging;
mod last;
mod losing;
mod readings;
mod recording;
mod stopped;
mod tally;
mod tilted;
mod trip;

use crate::blame::BlameMemory;
use crate::decode::Value;
use crate::incident::Quantities;
use crate::observe::observer::{Measurement, Restart};
use crate::process::Process;
use crate::sample::{Awaited, DeviceRole, Field, Inputs, Transducer};
use crate::sequential::{DwellHistory, Sequential};
use crate::state::state;
use account::Account;
use alloc::boxed::Box;
pub use blanks::{Blank, NotJudged};
use command::CommandState;
pub use cycle::{Cycle, Evaluation};
use dead_reckoning::DeadReckoning;
pub use dead_reckoning::{ReckoningParameters, WaySource};
pub use design::CylinderDesign;
use estimating::EstimatedLength;
use fde::Fde;
use last::LastOne;
pub use last::LastParameters;
use readings::{CheckContext, Readings};
use stopped::OnStop;
pub use tally::Tally;
use tilted::Tilted;
use trip::Trip;

const TRANSDUCERS: [Transducer; 2] = Transducer::ALL;

/// The monitor of one cylinder.
#[derive(Clone, Debug)]
pub struct Cylinder {
    design: CylinderDesign,
    pub inputs: Inputs,
    /// Whether the cylinder is still to be evaluated in the open cycle.
    pub pending: bool,
    awaited: Awaited,
    pub(super) readings: Readings,
    command: CommandState,
    fde: Fde,
    /// The machine's own rule.
    trip: Trip,
    sequential: Option<Box<Sequential>>,
    /// `None` without tables of spool or pressures.
    process: Option<Box<Process>>,
    /// Whether the sums of the chambers' pressures are off in many cylinders.
    pub supply_is_odd: bool,
    /// `None` where the readings on the stop are not judged.
    on_stop: Option<Box<OnStop>>,
    /// What the deck's attitude finds of the only transducer.
    tilted: Option<Tilted>,
    last: LastOne,
    /// `None` where there are two transducers, and neither oil nor a drive were learnt.
    reckoning: Option<Box<DeadReckoning>>,
    blame: BlameMemory,
    /// `None` where no estimates are needed.
    estimated: Option<Box<EstimatedLength>>,
    /// C1 of the newest cycle, m, if it was good.
    length: Option<f64>,
    account: Account,
    /// Whether it was watched in the newest cycle, or any detector has a finding.
    is_busy: bool,
    /// Whether an incident of it is open.
    pub is_watched: bool,
    /// Quantities of the newest cycle in which it was watched, or found anything.
    quantities: Quantities,
}

state! {
    Cylinder {
        inputs, pending, awaited, readings, command, fde, trip, supply_is_odd, tilted, last, blame, length, account, is_busy, is_watched,
        quantities,
    }
    parts { sequential, process, on_stop, reckoning, estimated }
    but { design }
}

impl Cylinder {
    pub fn new(design: CylinderDesign) -> Self {
        let mut cylinder = Self {
            inputs: Inputs::default(),
            pending: false,
            awaited: Awaited::new(design.required, design.awaited),
            readings: Readings::new(&design),
            command: CommandState::new(&design),
            fde: Fde::new(&design),
            trip: Trip::new(&design),
            sequential: design.sequential.clone().map(|design| Box::new(Sequential::new(design))),
            process: design.process.clone().map(|design| Box::new(Process::new(design))),
            supply_is_odd: false,
            on_stop: OnStop::of(design.sequential.is_some(), design.has(Transducer::C2)),
            tilted: None,
            last: LastOne::default(),
            reckoning: DeadReckoning::of(&design).map(Box::new),
            blame: BlameMemory::new(
                design.coincidence,
                design.coincidence_cycles,
                design.bank.sample_time,
            ),
            estimated: None,
            length: None,
            account: Account::default(),
            is_busy: false,
            is_watched: false,
            quantities: Quantities::default(),
            design,
        };
        cylinder.restore(&DwellHistory::default());
        cylinder
    }

    pub const fn tally(&self) -> &Tally {
        &self.account.tally
    }

    /// Cylinder number and sequential detector, if it has one.
    pub fn sequential(&self) -> Option<(u8, &Sequential)> {
        Some((self.design.number, self.sequential.as_deref()?))
    }

    /// The same, to allow for what all cylinders show of their sampling.
    pub(super) fn sequential_mut(&mut self) -> Option<&mut Sequential> {
        self.sequential.as_deref_mut()
    }

    /// Process detector, if the cylinder has one.
    pub fn process(&self) -> Option<&Process> {
        self.process.as_deref()
    }

    /// The same, to take what was found of the machine's supply.
    pub(super) fn process_mut(&mut self) -> Option<&mut Process> {
        self.process.as_deref_mut()
    }

    pub fn count_anew(&mut self) {
        self.account.count_anew();
    }

    /// Whether there may be anything to tell of the newest cycle: a finding, or an incident that is open.
    #[inline]
    pub const fn is_busy(&self) -> bool {
        self.is_busy
    }

    /// Stores a decoded value in its place; returns `false` if it is not a finite number there.
    pub fn put(&mut self, field: Field, value: Value) -> bool {
        let inputs = &mut self.inputs;
        match field {
            Field::Position(transducer) => {
                inputs.position(transducer, value.physical, value.raw.as_i64());
                true
            }
            Field::Velocity(transducer) => inputs.velocity(transducer, value.physical),
            Field::Status(transducer) => {
                // Without a status that it should have, a reading is not known to be good.
                let status = value.raw.bits();
                status.into_iter().for_each(|status| inputs.status(transducer, status));
                status.is_some()
            }
            Field::Counter(transducer) => {
                inputs.counted(transducer);
                true
            }
            Field::Command => inputs.command(value.physical),
            Field::Pressure(pressure) => inputs.pressure(pressure, value.physical),
            Field::Spool => inputs.spool(value.physical),
        }
    }

    /// Whether nothing more is awaited in this cycle.
    #[inline]
    pub const fn is_done(&self) -> bool {
        self.awaited.is_done(self.inputs.got())
    }

    /// Whether everything that is monitored has arrived.
    #[inline]
    pub const fn is_complete(&self) -> bool {
        self.inputs.got() & self.design.required == self.design.required
    }

    pub const fn has(&self, transducer: Transducer) -> bool {
        self.design.has(transducer)
    }

    /// Whether every configured transducer was judged by its observer in the newest cycle.
    pub fn judges(&self) -> bool {
        TRANSDUCERS.into_iter().all(|t| !self.has(t) || self.account.judged[t as usize])
    }

    /// Opens a cycle.
    #[inline]
    pub fn open(&mut self) {
        self.pending = true;
        let kept = self.awaited.turn(self.inputs.got());
        self.inputs.clear_except(kept);
    }

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
        cycle.readings = TRANSDUCERS.map(|t| self.inputs.reading(t, self.design.required));
        self.readings.take(&now, &self.design, &cycle.readings);
        self.check::<0>(cycle);
        self.check::<1>(cycle);
        self.length = cycle.length();
        let is_heard = now.heard.has(self.design.buses[DeviceRole::Valve as usize]);
        let quality = self.command.follow(cycle.command, is_heard, &self.design);
        self.readings.check_command(quality, now.at);
        cycle.is_odd |= self.readings.is_implausible(DeviceRole::Valve as usize);
    }

    /// Checks the reading of transducer `I`, see [`Fde::observe`].
    #[inline(always)]
    fn check<const I: usize>(&mut self, cycle: &mut Cycle) {
        if !self.has(TRANSDUCERS[I]) {
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
