//! The monitor of one cylinder: from the inputs of a cycle to the findings of its detectors.

mod account;
mod accounting;
mod attitude;
mod blanks;
mod command;
mod cycle;
mod dead_reckoning;
mod design;
mod devices;
mod estimated;
mod estimating;
mod evaluating;
mod fde;
mod findings;
mod judging;
mod last;
mod losing;
mod readings;
mod reckoning;
mod recording;
mod stopped;
mod tally;
mod tilted;
mod trip;

use crate::blame::BlameMemory;
use crate::decode::Value;
use crate::incident::Quantities;
use crate::process::Process;
use crate::sample::{Awaited, Field, Inputs, Transducer};
use crate::sequential::{Dwell, DwellHistory, Sequential};
use crate::state::state;
use account::Account;
use alloc::boxed::Box;
pub use blanks::{Blank, NotJudged};
use command::CommandState;
pub use cycle::{Cycle, Evaluation};
use dead_reckoning::DeadReckoning;
pub use dead_reckoning::{ReckoningParameters, WaySource};
pub use design::CylinderDesign;
use estimated::EstimatedLength;
use fde::Fde;
use last::LastOne;
pub use last::LastParameters;
use readings::Readings;
use stopped::OnStop;
pub use tally::Tally;
use tilted::Tilted;
use trip::Trip;

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
        Self {
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
            on_stop: OnStop::of(&design),
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
        }
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

    /// Reading on the stop in the newest cycle, returned once.
    pub fn take_dwell(&mut self) -> Option<Dwell> {
        self.on_stop.as_mut()?.take_dwell()
    }

    /// Cylinder number and readings on the stop so far, if they are kept.
    pub fn dwells(&self) -> Option<(u8, &DwellHistory)> {
        Some((self.design.number, self.on_stop.as_ref()?.history()))
    }

    /// Restores the dwells of an earlier monitor, if the cylinder keeps any.
    pub fn restore(&mut self, dwells: &DwellHistory) {
        if let Some(on_stop) = &mut self.on_stop {
            on_stop.restore(dwells, &self.design);
        }
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
        Transducer::ALL.into_iter().all(|t| !self.has(t) || self.account.judged[t as usize])
    }

    /// Opens a cycle.
    #[inline]
    pub fn open(&mut self) {
        self.pending = true;
        let kept = self.awaited.turn(self.inputs.got());
        self.inputs.clear_except(kept);
    }
}
