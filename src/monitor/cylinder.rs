//! One cylinder: from what arrived in a cycle to what its detectors find.

mod agreement;
mod estimating;
mod findings;

use super::gate::Opening;
use super::implausible::Implausible;
use super::sink::Record;
use crate::compare::Comparator;
use crate::config::settings::Levels;
use crate::decode::Value;
use crate::estimate::{self, Estimate, VirtualSensor};
use crate::observe::observer::{Design, Innovation, Measurement, Observer, Restart};
use crate::sample::plausibility::{Limits, Moment, Plausibility};
use crate::sample::{Field, Inputs, Quality, Reading, Transducer};
use crate::sequential::{self, Dwell, DwellHistory, Moved, Sequential};
use crate::time::{Span, Timestamp};
use crate::verdict::{Bank, BankDesign, Residuals, Verdict};
use agreement::Agreement;

/// What one cylinder is monitored by.
#[derive(Clone, Debug)]
pub struct CylinderDesign {
    /// From 1.
    pub number: u8,
    /// Fields that a complete cycle has, by [`Field::bit`].
    pub required: u16,
    /// Fields for which a cycle is held open until its deadline: those required, and pressures where
    /// they are read, which never make a cycle incomplete.
    pub awaited: u16,
    /// C1 and C2; a cylinder without C2 never judges it.
    pub limits: [Limits; 2],
    pub counter_bits: [Option<u32>; 2],
    /// The command at which the cylinder rests, m/s.
    pub command_offset: f64,
    /// Cycles without a command until it is stale.
    pub command_stale: u32,
    /// The command moves the cylinder beyond this, m/s.
    pub moving_speed: f64,
    pub observers: [Design; 2],
    pub comparator: Comparator,
    pub bank: BankDesign,
    /// `None` where no calibration for it is configured.
    pub sequential: Option<sequential::Design>,
    pub estimate: estimate::Design,
    /// |R3| at which the machine itself trips, m.
    pub critical: f64,
    pub levels: Levels,
    /// Good readings for this long clear a plausibility warning.
    pub clear: Span,
}

/// The cycle in which a cylinder is evaluated.
#[derive(Clone, Copy, Debug)]
pub struct Evaluation {
    /// When it is evaluated: the last frame of the cycle, or its deadline.
    pub at: Timestamp,
    pub cycle: u64,
    pub opened: Timestamp,
    /// See [`Moment::live`].
    pub live: bool,
    pub gate: Opening,
    /// The rods stand on their mechanical stops.
    pub at_stop: bool,
}

/// Counts and extremes of one cylinder, for reports.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tally {
    /// Cycles evaluated, whether complete or not.
    pub cycles: u64,
    /// Of these, cycles that neither FDE1 nor FDE2 judged.
    pub gated: u64,
    /// Of these, cycles in which something configured did not arrive.
    pub incomplete: u64,
    /// Readings of C1 and C2 that did not pass the plausibility checks, missing ones not counted.
    pub implausible: [u64; 2],
    /// Largest |R1| and |R2| judged, and largest |R3|, m.
    pub worst: [Option<f64>; 3],
}

const TRANSDUCERS: [Transducer; 2] = [Transducer::C1, Transducer::C2];

/// The monitor of one cylinder.
#[derive(Clone, Debug)]
pub struct Cylinder {
    design: CylinderDesign,
    pub inputs: Inputs,
    /// Still to be evaluated in the open cycle.
    pub pending: bool,
    plausibility: [Plausibility; 2],
    implausible: [Implausible; 3],
    observers: [Observer; 2],
    bank: Bank,
    sequential: Option<Box<Sequential>>,
    agreement: Agreement,
    /// `None` where nobody wants its estimates.
    sensor: Option<Box<VirtualSensor>>,
    estimated: Option<Estimate>,
    was_critical: bool,
    command_missing: u32,
    moving: bool,
    judged: [bool; 2],
    tally: Tally,
}

impl Cylinder {
    pub fn new(design: CylinderDesign) -> Self {
        let plausibility =
            |i: usize| Plausibility::new(design.limits[i].clone(), design.counter_bits[i]);
        Self {
            inputs: Inputs::default(),
            pending: false,
            plausibility: [plausibility(0), plausibility(1)],
            implausible: std::array::from_fn(|_| Implausible::new(design.clear)),
            observers: design.observers.clone().map(Observer::new),
            bank: Bank::new(&design.bank),
            sequential: design.sequential.clone().map(|design| Box::new(Sequential::new(design))),
            agreement: Agreement::default(),
            sensor: None,
            estimated: None,
            was_critical: false,
            command_missing: 0,
            moving: false,
            judged: [false; 2],
            tally: Tally::default(),
            design,
        }
    }

    pub const fn tally(&self) -> &Tally {
        &self.tally
    }

    /// What was read on the stop in the newest cycle, once.
    pub fn take_dwell(&mut self) -> Option<(Dwell, Option<Moved>)> {
        self.sequential.as_mut()?.take_dwell()
    }

    /// Its number and its sequential detector, if it has one.
    pub fn sequential(&self) -> Option<(u8, &Sequential)> {
        Some((self.design.number, self.sequential.as_deref()?))
    }

    /// Goes on with the dwells of an earlier monitor, if it has a detector that reads them.
    pub fn inherit(&mut self, dwells: &DwellHistory) {
        if let Some(sequential) = &mut self.sequential {
            sequential.inherit(dwells.clone());
        }
    }

    /// Times that an alive counter of C1 and C2 jumped.
    pub fn counter_jumps(&self) -> [u64; 2] {
        [self.plausibility[0].counter_jumps(), self.plausibility[1].counter_jumps()]
    }

    /// Puts a decoded value into its place; `false` if it is not a finite number there.
    pub fn put(&mut self, field: Field, value: Value) -> bool {
        let inputs = &mut self.inputs;
        match field {
            Field::Position(transducer) => {
                inputs.position(transducer, value.physical, value.raw.as_i64());
                true
            }
            Field::Velocity(transducer) => inputs.velocity(transducer, value.physical),
            Field::Status(transducer) => {
                inputs.status(transducer, bits(value));
                true
            }
            Field::Counter(transducer) => {
                inputs.counter(transducer, bits(value));
                true
            }
            Field::Command => inputs.command(value.physical),
            Field::Pressure(pressure) => inputs.pressure(pressure, value.physical),
            Field::Spool => inputs.spool(value.physical),
        }
    }

    /// Nothing is waited for any more in this cycle.
    #[inline]
    pub const fn is_done(&self) -> bool {
        self.inputs.got() & self.design.awaited == self.design.awaited
    }

    /// Everything that is monitored has arrived.
    #[inline]
    pub const fn is_complete(&self) -> bool {
        self.inputs.got() & self.design.required == self.design.required
    }

    pub const fn has(&self, transducer: Transducer) -> bool {
        self.design.required & Field::Position(transducer).bit() != 0
    }

    /// Every configured transducer was judged by its observer in the newest cycle.
    pub fn judges(&self) -> bool {
        TRANSDUCERS.into_iter().all(|t| !self.has(t) || self.judged[t as usize])
    }

    /// Evaluates the cycle. `restarted` hears of observers that start anew.
    pub fn evaluate(
        &mut self,
        now: Evaluation,
        mut restarted: impl FnMut(Transducer, Restart),
    ) -> Record {
        self.pending = false;
        let command = self.inputs.command_value().map(|u| u - self.design.command_offset);
        let moment = Moment {
            cycle: now.cycle,
            live: now.live,
            moving: self.moving && now.gate == Opening::Open,
            other: None,
        };
        let readings = TRANSDUCERS.map(|t| self.inputs.reading(t, self.design.required).copied());
        let mut good = [None; 2];
        let mut innovations = [None; 2];
        for (i, transducer) in TRANSDUCERS.into_iter().enumerate() {
            if !self.has(transducer) {
                continue;
            }
            let moment = Moment { other: self.relied_on(1 - i, &readings), ..moment };
            good[i] = self.check(i, readings[i].as_ref(), moment, now.at);
            let measurement = good[i].map(|reading| Measurement {
                position: reading.position,
                velocity: reading.velocity,
            });
            let (innovation, restart) = self.observers[i].step(measurement, command);
            innovations[i] = innovation;
            if let Some(reason) = restart {
                restarted(transducer, reason);
            }
        }
        self.follow_command(command, now);
        let difference = good[0]
            .zip(good[1])
            .map(|(c1, c2)| self.design.comparator.residual(c1.position, c2.position));
        let residuals = self.judge(now, innovations, difference);
        self.judge_sequentially(now, good, &residuals);
        self.estimate(now, good);
        self.count(&residuals);
        let record = self.record(now, readings, innovations, difference);
        self.inputs.clear();
        record
    }

    /// Time jumped or frames were lost: what was learnt of motion is void, what was found stands.
    pub fn interrupt(&mut self, reason: Restart) {
        self.observers.iter_mut().for_each(|observer| observer.stop(reason));
        self.plausibility.iter_mut().for_each(Plausibility::reset);
        self.bank.interrupt();
        if let Some(sequential) = &mut self.sequential {
            sequential.interrupt();
        }
        if let Some(sensor) = &mut self.sensor {
            sensor.interrupt();
        }
        self.implausible.iter_mut().for_each(|implausible| implausible.trigger.interrupt());
        self.judged = [false; 2];
        self.moving = false;
        self.pending = false;
        self.inputs.clear();
    }

    /// What a transducer reads, if it was sound when it was last judged.
    fn relied_on(&self, i: usize, readings: &[Option<Reading>; 2]) -> Option<f64> {
        let sound = self.plausibility[i].quality().is_good();
        readings[i].as_ref().filter(|_| sound).map(|reading| reading.position)
    }

    fn check(
        &mut self,
        i: usize,
        reading: Option<&Reading>,
        moment: Moment,
        at: Timestamp,
    ) -> Option<Reading> {
        let checks = &mut self.plausibility[i];
        let quality = checks.judge(reading, moment);
        let beyond = reading.map_or(0.0, |reading| checks.beyond(reading.position));
        self.implausible[i].judge(at, quality, beyond);
        let seen = !matches!(quality, Quality::Missing | Quality::Stale);
        self.tally.implausible[i] += u64::from(seen && !quality.is_good());
        reading.filter(|_| quality.is_good()).copied()
    }

    fn follow_command(&mut self, command: Option<f64>, now: Evaluation) {
        match command {
            Some(u) => {
                self.command_missing = 0;
                self.moving = u.abs() > self.design.moving_speed;
            }
            None => {
                let aged = u32::from(now.live);
                self.command_missing = self.command_missing.saturating_add(aged);
            }
        }
        let stale = self.command_missing >= self.design.command_stale;
        let quality = match (command, stale) {
            (Some(_), _) => Quality::Good,
            (None, true) => Quality::Stale,
            (None, false) => Quality::Missing,
        };
        self.implausible[2].judge(now.at, quality, 0.0);
    }

    fn judge(
        &mut self,
        now: Evaluation,
        innovations: [Option<Innovation>; 2],
        difference: Option<f64>,
    ) -> Residuals {
        // Without a command the model predicts nothing, so its residual is no evidence.
        let open = now.gate == Opening::Open && self.command_missing < self.design.command_stale;
        let judged = innovations
            .map(|innovation| innovation.filter(|i| open && i.settled).map(|i| i.residual));
        self.judged = judged.map(|residual| residual.is_some());
        let residuals = Residuals { r: [judged[0], judged[1], difference] };
        self.bank.judge(now.at, &residuals);
        let critical = difference.is_some_and(|r3| r3.abs() >= self.design.critical);
        let raised = self.bank.verdicts()[2] == Verdict::Faulty;
        self.was_critical = raised && (self.was_critical || critical);
        residuals
    }

    fn judge_sequentially(
        &mut self,
        now: Evaluation,
        good: [Option<Reading>; 2],
        residuals: &Residuals,
    ) {
        let Some(sequential) = &mut self.sequential else { return };
        let [c1, c2] = good;
        sequential.step(&sequential::Input {
            lengths: [c1.map(|reading| reading.position), c2.map(|reading| reading.position)],
            velocity: c2.and_then(|reading| reading.velocity),
            // As it was sent: the drive has a constant of its own.
            command: self.inputs.command_value(),
            monitored: now.gate == Opening::Open,
            at: now.opened,
            at_stop: now.at_stop,
        });
        let [fde1, fde2, _] = self.bank.verdicts();
        let [r1, r2, _] = residuals.r;
        let raised = [fde1, fde2].map(|verdict| verdict == Verdict::Faulty);
        let alarm = sequential.alarm().is_some();
        self.agreement.judge(raised, [r1, r2], sequential.apart(), alarm);
    }

    fn count(&mut self, residuals: &Residuals) {
        let incomplete = u64::from(!self.is_complete());
        let tally = &mut self.tally;
        tally.cycles += 1;
        tally.gated += u64::from(!self.judged.contains(&true));
        tally.incomplete += incomplete;
        for (worst, residual) in tally.worst.iter_mut().zip(residuals.r) {
            if let Some(magnitude) = residual.map(f64::abs) {
                *worst = Some(worst.map_or(magnitude, |w| w.max(magnitude)));
            }
        }
    }

    fn record(
        &self,
        now: Evaluation,
        readings: [Option<Reading>; 2],
        innovations: [Option<Innovation>; 2],
        difference: Option<f64>,
    ) -> Record {
        let [c1, c2] = readings.map(|reading| reading.map(|reading| reading.position));
        let residual = |i: usize| innovations[i].map(|innovation: Innovation| innovation.residual);
        Record {
            timestamp: now.opened,
            cycle: now.cycle,
            cylinder: self.design.number,
            c1,
            c2,
            velocities: readings.map(|reading| reading?.velocity),
            qualities: self.plausibility.each_ref().map(Plausibility::quality),
            pressures: self.inputs.pressures(),
            supply: self.inputs.supply_value(),
            spool: self.inputs.spool_value(),
            c2_corrected: c2.map(|c2| self.design.comparator.corrected(c2)),
            command: self.inputs.command_value(),
            estimates: innovations.map(|innovation| innovation.map(|i| i.estimate)),
            residuals: [residual(0), residual(1), difference],
            judged: self.judged,
            gated: !self.judged.contains(&true),
            monitored: now.gate == Opening::Open,
        }
    }
}

/// The raw bits of an integer signal; a float has none, and its whole part is taken.
fn bits(value: Value) -> u64 {
    value.raw.as_i128().map_or(value.raw.as_f64() as u64, |raw| raw as u64)
}
