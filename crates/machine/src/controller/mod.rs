//! The machine's own controller: Figure 2-3 for each cylinder, and the PLC's platform states.
//!
//! ```text
//! motion sensor ─ reference ─→ l_ref, l̇_ref ─→ control speed u ─ look-up table ─→ spool
//!                                     C1, l̇, P_L ──↑
//! ```
//!
//! For each cylinder it can take another [`Measurement`] than C1, and [`Supervision`] watches both.
//! It replaces the real controller in simulations. Nothing in the monitor uses it, and it switches
//! nothing itself: the platform goes to the state that is requested.

mod limit;
mod lookup;
mod measuring;
mod plc;
mod reference;
mod supervision;

pub use limit::soft;
pub use lookup::LookUp;
pub use measuring::{Heard, Measurement};
pub use plc::{Phase, Plc, State};
pub use reference::Reference;
pub use supervision::Supervision;

use crate::hexapod::{Hexapod, LEGS, Pose, PoseRate};
use serde::Deserialize;

/// Gains and times of the controller.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ControllerTable {
    /// Gain of the position feedback, 1/s.
    pub position: f64,
    /// Gain of the velocity feedback, 1.
    pub velocity: f64,
    /// Gain of the feedback of fast changes of the load pressure, m/s per bar.
    pub pressure: f64,
    /// Time constant above which a change of the load pressure is the load's and is not fed back,
    /// s.
    pub pressure_time: f64,
    /// Limit of the control speed, m/s.
    pub speed_limit: f64,
    /// Limit of the reference, the workspace, m.
    pub stroke_limit: f64,
    /// Time from Sync until a new command reaches the valve, s.
    pub latency: f64,
    /// Spool position of the safe state, set by the valve's springs: −10 % (section 2-2-1).
    pub safe_spool: f64,
    /// Control speed that keeps settled cylinders retracted, m/s.
    pub settled_speed: f64,
    /// Time from one platform state to the next, s.
    pub transition: f64,
    /// Least time that the platform stays in a state, s.
    pub dwell: f64,
}

/// What the controller measures in a cycle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Readings {
    /// Length of each cylinder by its [`Measurement`], m.
    pub lengths: [f64; LEGS],
    /// Velocity of each cylinder, m/s.
    pub speeds: [f64; LEGS],
    /// P_L of each cylinder, bar.
    pub pressures: [f64; LEGS],
    /// Pose of the vessel, by the motion sensor.
    pub pose: Pose,
    /// PoseRate of the vessel's pose, by the motion sensor.
    pub rate: PoseRate,
}

/// What the controller commands for a cycle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Commands {
    /// Control speed u = l̇_ctrl of each cylinder, m/s.
    pub speeds: [f64; LEGS],
    /// Spool positions, −1 to 1.
    pub spools: [f64; LEGS],
}

/// The controller of six cylinders.
#[derive(Clone, Debug)]
pub struct Controller {
    table: ControllerTable,
    hexapod: Hexapod,
    look_ups: [LookUp; LEGS],
    plc: Plc,
    retracted: f64,
    /// Slow part of the load pressures, bar; `None` before the first reading.
    loads: Option<[f64; LEGS]>,
    /// Part of a difference that the slow part follows in one sample.
    follow: f64,
}

impl Controller {
    /// A controller that is in `state`; `retracted` is the cylinders' shortest stroke, m.
    pub fn new(
        table: &ControllerTable,
        hexapod: Hexapod,
        look_ups: [LookUp; LEGS],
        retracted: f64,
        sample_time: f64,
        state: State,
    ) -> Self {
        Self {
            table: *table,
            hexapod,
            look_ups,
            plc: Plc::new(state, table.transition, table.dwell, sample_time),
            retracted,
            loads: None,
            follow: -(-sample_time / table.pressure_time).exp_m1(),
        }
    }

    /// Requests `state`; the platform passes through those in between.
    pub fn request(&mut self, state: State) {
        self.plc.request(state);
    }

    /// The state that the PLC reports.
    pub fn state(&self) -> State {
        self.plc.state()
    }

    /// Reference lengths and velocities of the engaged state for this motion of the vessel.
    pub fn engaged(&self, pose: &Pose, rate: &PoseRate) -> Reference {
        Reference::engaged(&self.hexapod, pose, rate, self.table.stroke_limit)
    }

    /// Runs one cycle: the commands that follow from `readings`.
    pub fn step(&mut self, readings: &Readings) -> Commands {
        let changes = self.pressure_changes(&readings.pressures);
        let phase = self.plc.step();
        match phase {
            Phase::At(State::Safe) => {
                return Commands { speeds: [0.0; LEGS], spools: [self.table.safe_spool; LEGS] };
            }
            Phase::At(State::Settled) => {
                return self.through_look_up([self.table.settled_speed; LEGS]);
            }
            Phase::At(_) | Phase::Between { .. } => {}
        }
        let reference = self.reference(phase, readings);
        let limit = self.table.speed_limit;
        self.through_look_up(std::array::from_fn(|leg| {
            let speed = reference.speeds[leg]
                + self.table.position * (reference.lengths[leg] - readings.lengths[leg])
                + self.table.velocity * (reference.speeds[leg] - readings.speeds[leg])
                - self.table.pressure * changes[leg];
            speed.clamp(-limit, limit)
        }))
    }

    fn reference(&self, phase: Phase, readings: &Readings) -> Reference {
        let of = |state: State| match state {
            State::Safe | State::Settled => Reference::still(self.retracted),
            State::Neutral => Reference::still(0.0),
            State::Engaged => self.engaged(&readings.pose, &readings.rate),
        };
        match phase {
            Phase::At(state) => of(state),
            Phase::Between { from, to, progress, rate } => {
                Reference::between(&of(from), &of(to), progress, rate)
            }
        }
    }

    /// The spool positions that the look-up tables have for control speeds, m/s.
    pub fn spools(&self, speeds: &[f64; LEGS]) -> [f64; LEGS] {
        std::array::from_fn(|leg| self.look_ups[leg].spool(speeds[leg]))
    }

    fn through_look_up(&self, speeds: [f64; LEGS]) -> Commands {
        Commands { speeds, spools: self.spools(&speeds) }
    }

    /// Load pressures without their slow part, which is the load.
    fn pressure_changes(&mut self, pressures: &[f64; LEGS]) -> [f64; LEGS] {
        let loads = self.loads.get_or_insert(*pressures);
        std::array::from_fn(|leg| {
            let change = pressures[leg] - loads[leg];
            loads[leg] += self.follow * change;
            change
        })
    }
}
