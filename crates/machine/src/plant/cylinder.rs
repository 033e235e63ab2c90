//! One cylinder with its valve and its load.

use super::PASCAL;
use super::ailment::Wear;
use super::friction::Friction;
use super::identified::{self, IdentifiedFlow};
use super::parameters::{Chambers, Parameters};
use super::valve::Valve;

/// State of a cylinder (3-14), and the spool, which lags its command.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CylinderState {
    /// Length l, m; 0 in the middle of the stroke.
    pub length: f64,
    /// Velocity l̇, m/s; exactly 0 while the piston sticks.
    pub speed: f64,
    /// Load pressure P_L = P_bot − α P_rod (3-4), bar.
    pub pressure: f64,
    /// Position of the main spool, −1 to 1.
    pub spool: f64,
    /// P_bot + P_rod − P_S, bar; 0 with ideal chambers.
    pub imbalance: f64,
}

/// Inputs of a cylinder over a sub-step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drive {
    /// Commanded spool position, −1 to 1.
    pub spool: f64,
    /// Mass carried, as a part of the usual mass.
    pub load: f64,
    /// Acceleration of the frame along the cylinder, gravity included, m/s².
    pub acceleration: f64,
    /// Supply pressure, bar.
    pub supply: f64,
    /// What differs from the tables.
    pub wear: Wear,
}

/// Parameters of (3-15) for one cylinder.
#[derive(Clone, Debug, PartialEq)]
pub struct Cylinder {
    valve: Valve,
    /// What passes the valve, where it was identified.
    identified: Option<IdentifiedFlow>,
    friction: Friction,
    /// Piston area A_p as force per pressure, N/bar.
    force_per_bar: f64,
    /// Areas A_p and a_p, m².
    areas: [f64; 2],
    area_ratio: f64,
    /// Stiffness k, N/m.
    stiffness: f64,
    /// Mass, kg.
    mass: f64,
    /// α of (3-8), bar/m.
    stiffening: f64,
    /// β of (3-8), 1/s.
    leakage: f64,
    ends: [f64; 2],
    sub_step: f64,
    /// Part of the spool's error that remains after half a sub-step.
    spool_decay: f64,
    chambers: Option<Chambers>,
}

impl Cylinder {
    /// The cylinder with this index, from 0.
    pub fn new(parameters: &Parameters, index: usize, sub_step: f64) -> Self {
        let table = &parameters.cylinder;
        let spread = &parameters.spread;
        let factors = [spread.extend[index], spread.retract[index]];
        let own = parameters.identified.iter().find(|it| usize::from(it.number) == index + 1);
        let identified = own.and_then(|it| it.flow.clone());
        let stribeck = own.and_then(|it| it.friction.as_ref());
        Self {
            valve: Valve::new(&parameters.valve, factors, parameters.supply.pressure),
            friction: stribeck
                .map_or(parameters.friction, |it| identified::friction(it, table.piston_area)),
            force_per_bar: table.piston_area * PASCAL,
            areas: [table.piston_area, table.piston_area * table.area_ratio],
            area_ratio: table.area_ratio,
            stiffness: table.stiffness,
            mass: table.load_mass,
            stiffening: identified.as_ref().map_or(table.pressure_rise, |it| it.stiffening),
            leakage: identified.as_ref().map_or(table.leakage, |it| it.leakage),
            identified,
            ends: table.ends,
            sub_step,
            spool_decay: (-0.5 * sub_step / parameters.valve.lag).exp(),
            chambers: parameters.chambers,
        }
    }

    /// The valve of the tables, whether or not another one was identified.
    pub fn valve(&self) -> &Valve {
        &self.valve
    }

    pub fn friction(&self) -> &Friction {
        &self.friction
    }

    /// The load pressure, bar, at which the piston needs no friction to stand still at `length`.
    pub fn balance(&self, length: f64, load: f64, acceleration: f64) -> f64 {
        (self.stiffness * length + self.mass * load * acceleration) / self.force_per_bar
    }

    /// The speed at which a piston without friction settles when it carries its load with the spool
    /// at `spool`, m/s: flow less leakage.
    pub fn settled_speed(&self, spool: f64, pressure: f64, supply: f64) -> f64 {
        self.passed(spool, pressure, supply) - self.leakage / self.stiffening * pressure
    }

    /// P_bot and P_rod, bar. A valve whose ports match the areas loses the same pressure on both
    /// sides: P_bot + P_rod = P_S, with (3-4).
    pub fn chamber_pressures(&self, state: &CylinderState, supply: f64) -> [f64; 2] {
        let sum = supply + state.imbalance;
        let rod = ((sum - state.pressure) / (1.0 + self.area_ratio)).clamp(0.0, supply);
        [sum - rod, rod]
    }

    /// Advances by one sub-step and returns the oil taken from the supply, m³/s.
    pub fn step(&self, state: &mut CylinderState, drive: &Drive) -> f64 {
        let mass = self.mass * drive.load;
        let (weight, mobility) = (mass * drive.acceleration, 1.0 / mass);
        let before = *state;
        let friction = self.friction.worn(&drive.wear);
        let push = |length: f64, pressure: f64| {
            self.force_per_bar * pressure - self.stiffness * length - weight
        };
        let force = push(before.length, before.pressure);
        let sticks = before.speed == 0.0 && friction.holds(force);
        let direction = if before.speed == 0.0 { force } else { before.speed };
        // Dry friction keeps its direction for the sub-step.
        let acceleration = |direction: f64, speed: f64, force: f64| {
            let dry = friction.dry((speed * direction.signum()).max(0.0));
            (force - friction.viscous * speed - dry.copysign(direction)) * mobility
        };
        let half = 0.5 * self.sub_step;
        let spool = drive.spool + (before.spool - drive.spool) * self.spool_decay;
        state.spool = drive.spool + (spool - drive.spool) * self.spool_decay;

        let flow = self.flow(before.spool, before.pressure, drive);
        let middle = CylinderState {
            length: before.length + half * before.speed,
            speed: if sticks {
                0.0
            } else {
                before.speed + half * acceleration(direction, before.speed, force)
            },
            pressure: before.pressure + half * self.pressure_rise(&before, flow, drive),
            spool,
            imbalance: before.imbalance,
        };
        let flow = self.flow(spool, middle.pressure, drive);
        let pressure = before.pressure + self.sub_step * self.pressure_rise(&middle, flow, drive);
        // Below, the oil of one chamber boils; above, its relief valve opens.
        state.pressure = pressure.clamp(-self.area_ratio * drive.supply, drive.supply);
        if !sticks {
            let force = push(middle.length, middle.pressure);
            state.length = before.length + self.sub_step * middle.speed;
            let change = self.sub_step * acceleration(direction, middle.speed, force);
            state.speed = before.speed + change;
            if state.speed * direction < 0.0 {
                // It came to rest on the way: there it stays, or goes back for what is left.
                let left = self.sub_step * state.speed / change;
                let back = -direction;
                let start = acceleration(back, 0.0, force);
                let goes = !friction.holds(force) && start * back > 0.0;
                state.speed = if goes { left * start } else { 0.0 };
            }
            self.stop_at_ends(state);
        }
        if let Some(it) = self.chambers {
            let target = it.leakage * state.pressure + it.mismatch * state.speed;
            state.imbalance += (target - state.imbalance) * (self.sub_step / it.time).min(1.0);
        }
        if flow >= 0.0 { self.areas[0] * flow } else { -self.areas[1] * flow }
    }

    /// Flow through the sound valve (3-7), m/s of the piston, at load and supply pressure, bar.
    pub fn passed(&self, spool: f64, load: f64, supply: f64) -> f64 {
        match &self.identified {
            Some(it) => it.valve.speed(spool, load, supply),
            None => self.valve.flow(spool, load, supply),
        }
    }

    /// Flow through the valve as it is worn (3-7), m/s of the piston.
    fn flow(&self, spool: f64, pressure: f64, drive: &Drive) -> f64 {
        let wear = &drive.wear;
        let flow = self.passed(wear.effective(spool, self.valve.overlap()), pressure, drive.supply);
        (1.0 + wear.flow) * flow - wear.lost(spool, pressure)
    }

    /// Rate of change of the load pressure (3-8), bar/s.
    fn pressure_rise(&self, state: &CylinderState, flow: f64, drive: &Drive) -> f64 {
        let leakage = self.leakage + drive.wear.leakage;
        self.stiffening * (flow - state.speed) - leakage * state.pressure
    }

    /// Stops the piston at the cylinder's end without a rebound.
    fn stop_at_ends(&self, state: &mut CylinderState) {
        let [low, high] = self.ends;
        if state.length <= low {
            (state.length, state.speed) = (low, state.speed.max(0.0));
        } else if state.length >= high {
            (state.length, state.speed) = (high, state.speed.min(0.0));
        }
    }
}
