//! The monitor of one cylinder: from the inputs of a cycle to the findings of its detectors.

mod allowing;
mod blanks;
mod checking;
mod dead_reckoning;
mod design;
mod detectors;
mod devices;
mod estimating;
mod findings;
mod judging;
mod last;
mod losing;
mod recording;
mod saved;
mod stopped;
mod tally;
mod tilted;
mod wild;

use super::gate::Opening;
use super::implausible::Implausible;
use crate::alarm::Approach;
use crate::blame::BlameMemory;
use crate::decode::Value;
use crate::estimate::{Estimate, VirtualSensor};
use crate::frame::Buses;
use crate::incident::Quantities;
use crate::observe::commands::CommandWatch;
use crate::observe::observer::{Innovation, Measurement, Observer, Restart, Uncorrected};
use crate::process::Process;
use crate::sample::motion::ReadingMotion;
use crate::sample::plausibility::Plausibility;
use crate::sample::{DeviceRole, Field, Inputs, Quality, Reading, Transducer};
use crate::sequential::{DwellHistory, Sequential};
use crate::time::Timestamp;
use crate::verdict::{Bank, Trigger};
use alloc::boxed::Box;
use blanks::Blanks;
pub use blanks::{Blank, NotJudged};
use dead_reckoning::DeadReckoning;
pub use dead_reckoning::WaySource;
pub use design::CylinderDesign;
use devices::Watches;
use last::LastOne;
pub use recording::Evaluated;
use stopped::{OnStop, StopDrift};
pub use tally::Tally;
use tilted::Tilted;

/// The cycle in which a cylinder is evaluated.
#[derive(Clone, Copy, Debug)]
pub struct Evaluation {
    /// Time of the evaluation: the last frame of the cycle, or its deadline.
    pub at: Timestamp,
    pub cycle: u64,
    pub opened: Timestamp,
    /// Buses that were heard, see [`crate::sample::plausibility::Moment::live`].
    pub heard: Buses,
    pub gate: Opening,
    /// Whether the rods stand on their mechanical stops.
    pub at_stop: bool,
}

/// Result of a transducer in a cycle.
#[derive(Clone, Copy, Debug, Default)]
struct Followed {
    good: Option<Measurement>,
    /// Whether its reading is not good, or a warning of its plausibility stands.
    is_odd: bool,
    innovation: Option<Innovation>,
    restart: Option<Restart>,
}

const TRANSDUCERS: [Transducer; 2] = [Transducer::C1, Transducer::C2];

/// The monitor of one cylinder.
#[derive(Clone, Debug)]
pub struct Cylinder {
    design: CylinderDesign,
    pub inputs: Inputs,
    /// Whether the cylinder is still to be evaluated in the open cycle.
    pub pending: bool,
    plausibility: [Plausibility; 2],
    motions: [ReadingMotion; 2],
    /// `None` without devices that tell of themselves.
    devices: Option<Box<Watches>>,
    implausible: [Implausible; 3],
    observers: [Observer; 2],
    commands: CommandWatch,
    /// Observers as if the newest readings had not corrected them, which may be wild.
    uncorrected: [Option<Uncorrected>; 2],
    bank: Bank,
    sequential: Option<Box<Sequential>>,
    /// `None` without tables of spool or pressures.
    process: Option<Box<Process>>,
    /// Whether the sums of the chambers' pressures are off in many cylinders.
    pub supply_is_odd: bool,
    blame: BlameMemory,
    last: LastOne,
    /// `None` where there are two transducers, and neither oil nor a drive were learnt.
    reckoning: Option<Box<DeadReckoning>>,
    /// What the deck's attitude finds of the only transducer.
    tilted: Option<Tilted>,
    /// `None` where the readings on the stop are not judged.
    on_stop: Option<Box<OnStop>>,
    /// What the stop finds of the only transducer.
    drifted: Option<StopDrift>,
    /// Virtual sensor; `None` where its estimates are not needed.
    sensor: Option<Box<VirtualSensor>>,
    estimated: Option<Estimate>,
    /// Trigger of the measured C1 − C2.
    critical: Trigger,
    /// How soon the measured C1 − C2 is critical.
    approach: Approach,
    /// C1 of the newest cycle, m, if it was good.
    length: Option<f64>,
    /// Newest measured C1 − C2, m.
    apart: f64,
    was_critical: bool,
    command_missing: u32,
    /// Whether no command came because its bus is silent.
    command_silent: bool,
    /// Way in one cycle of the newest command that moves the cylinder, m, signed; zero where it does not.
    way: f64,
    judged: [bool; 2],
    blanks: Blanks,
    /// Whether it was watched in the newest cycle, or any detector has a finding.
    is_busy: bool,
    /// Whether an incident of it is open.
    pub is_watched: bool,
    /// Quantities of the newest cycle in which it was watched, or found anything.
    quantities: Quantities,
    tally: Tally,
}

impl Cylinder {
    pub fn new(design: CylinderDesign) -> Self {
        let plausibility = |i: usize| Plausibility::new(design.limits[i].clone());
        let mut cylinder = Self {
            inputs: Inputs::default(),
            pending: false,
            plausibility: [plausibility(0), plausibility(1)],
            motions: [ReadingMotion::default(); 2],
            devices: devices::watches(&design.devices),
            implausible: core::array::from_fn(|_| Implausible::new(design.clear)),
            observers: design.observers.clone().map(Observer::new),
            commands: CommandWatch::new(design.commands, design.observers[0].settle),
            uncorrected: [None; 2],
            bank: Bank::new(&design.judging_bank()),
            sequential: design.sequential.clone().map(|design| Box::new(Sequential::new(design))),
            process: design.process.clone().map(|design| Box::new(Process::new(design))),
            supply_is_odd: false,
            blame: BlameMemory::new(
                design.coincidence,
                design.coincidence_cycles,
                design.bank.sample_time,
            ),
            last: LastOne::default(),
            reckoning: DeadReckoning::of(&design).map(Box::new),
            tilted: None,
            on_stop: OnStop::of(design.sequential.is_some(), design.has(Transducer::C2)),
            drifted: None,
            sensor: None,
            estimated: None,
            critical: design.trip(),
            approach: Approach::new(design.deadlines, design.bank.sample_time),
            length: None,
            apart: 0.0,
            was_critical: false,
            command_missing: 0,
            command_silent: false,
            way: 0.0,
            judged: [false; 2],
            blanks: Blanks::default(),
            is_busy: false,
            is_watched: false,
            quantities: Quantities::default(),
            tally: Tally::default(),
            design,
        };
        cylinder.restore(&DwellHistory::default());
        cylinder
    }

    pub const fn tally(&self) -> &Tally {
        &self.tally
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
        self.inputs.got() & self.design.awaited == self.design.awaited
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
        TRANSDUCERS.into_iter().all(|t| !self.has(t) || self.judged[t as usize])
    }

    /// Evaluates the cycle; its inputs must be cleared afterwards. `restarted` is called for
    /// observers that restart.
    pub fn evaluate(
        &mut self,
        now: Evaluation,
        mut restarted: impl FnMut(Transducer, Restart),
    ) -> Evaluated {
        self.pending = false;
        let command = self.inputs.command_value().map(|u| u - self.design.command_offset);
        let readings = TRANSDUCERS.map(|t| self.inputs.reading(t, self.design.required));
        if self.speaks() {
            self.step_devices(now.heard, &readings);
        }
        for (motion, reading) in self.motions.iter_mut().zip(&readings) {
            motion.follow(reading.as_ref().map(|reading| reading.position));
        }
        let c1 = self.follow::<0>(&readings, command, now);
        let c2 = self.follow::<1>(&readings, command, now);
        for (transducer, followed) in TRANSDUCERS.into_iter().zip([&c1, &c2]) {
            if let Some(reason) = followed.restart {
                restarted(transducer, reason);
            }
        }
        let (good, innovations) = ([c1.good, c2.good], [c1.innovation, c2.innovation]);
        self.length = good[0].map(|reading| reading.position);
        self.follow_command(command, now);
        let difference = good[0]
            .zip(good[1])
            .map(|(c1, c2)| self.design.comparator.residual(c1.position, c2.position));
        self.rest(now, good);
        if self.sequential.is_some() {
            self.judge_sequentially(now, good);
        }
        let (innovations, residuals) = self.judge(now, innovations, good, difference);
        self.commands.take(command);
        self.judge_measured(now.at, &readings);
        if self.sequential.is_some() {
            self.judge_beside_sequential(now.opened, &residuals, good);
        }
        if self.process.is_some() {
            self.judge_process(now, good);
            self.reckon_by_oil(now.opened, good);
        }
        self.follow_standing();
        let is_odd = c1.is_odd | c2.is_odd | self.implausible[DeviceRole::Valve as usize].raised();
        let finds = self.judge_last(is_odd, now, &residuals, good, command);
        if self.sensor.is_some() {
            self.estimate(now, good, &residuals);
        }
        let complete = self.is_complete();
        self.tally.count(&residuals, self.judged.contains(&true), complete);
        if !self.blanks.goes_on(self.judged) {
            self.note_blank(now);
        }
        self.is_busy = self.is_watched | finds | self.drifted.is_some();
        if self.is_busy {
            self.note_quantities(&residuals);
        }
        Evaluated { readings, innovations, difference }
    }

    /// Judges the reading of the transducer of index `I` and steps its observer. The index is a
    /// constant because as a variable it would cost an address computation for everything that
    /// exists twice.
    #[inline(always)]
    fn follow<const I: usize>(
        &mut self,
        readings: &[Option<Reading>; 2],
        command: Option<f64>,
        now: Evaluation,
    ) -> Followed {
        if !self.has(TRANSDUCERS[I]) {
            // The only reading that is left is supervised in every cycle.
            return Followed { is_odd: true, ..Followed::default() };
        }
        let reading = readings[I].as_ref();
        let (is_good, is_odd) = self.check(I, readings, now);
        let good = reading
            .filter(|_| is_good)
            .map(|reading| Measurement { position: reading.position, velocity: reading.velocity });
        let (innovation, restart) = self.observers[I].step(good, command);
        Followed { good, is_odd, innovation, restart }
    }

    fn follow_command(&mut self, command: Option<f64>, now: Evaluation) {
        let heard = now.heard.has(self.design.buses[DeviceRole::Valve as usize]);
        match command {
            Some(u) => {
                self.command_missing = 0;
                let moves = u.abs() > self.design.moving_speed;
                self.way = if moves { u * self.design.bank.sample_time } else { 0.0 };
            }
            None => {
                let aged = u32::from(heard);
                self.command_missing = self.command_missing.saturating_add(aged);
            }
        }
        self.command_silent = command.is_none() && !heard;
        let stale = self.command_missing >= self.design.command_stale;
        let quality = match (command, stale) {
            (Some(_), _) => Quality::Good,
            (None, true) => Quality::Stale,
            (None, false) => Quality::Missing,
        };
        if !quality.is_good()
            || self.implausible[DeviceRole::Valve as usize].raised()
            || self.speaks()
        {
            self.doubt_command(quality, now.at);
        }
    }
}
