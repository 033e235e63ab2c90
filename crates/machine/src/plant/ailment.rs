//! Faults of a cylinder, its valve and its supply: what is wrong with the machine and not with a transducer.

/// A fault of the machine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Ailment {
    /// Oil passes the piston: `rate` is added to β of (3-8), 1/s.
    Leakage { rate: f64 },
    /// Worn edges: near its middle the valve loses `speed`, m/s of the piston, at a load pressure of 24 bar.
    ValveLeakage { speed: f64 },
    /// The spool stays until its command is further away than `band`, part of its stroke.
    Sticking { band: f64 },
    /// The ports open later by `size` on either side, part of the spool's stroke.
    DeadBand { size: f64 },
    /// The spool stands beside its command by `size`, part of its stroke, and says so.
    SpoolOffset { size: f64 },
    /// The spool passes oil as if it stood further out by `size`, part of its stroke.
    NullShift { size: f64 },
    /// The pump's set point falls by `part`, 0 to 1, for all cylinders.
    SupplyLoss { part: f64 },
    /// All friction is `factor` times the usual.
    Friction { factor: f64 },
    /// The command reaches the valve late by so many cycles, at most [`MOST_LATE`].
    LateCommand { cycles: usize },
    /// The valve does 1 + `gain` times its command.
    WrongCommand { gain: f64 },
}

impl Ailment {
    /// Its name in the text of a fault.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Leakage { .. } => "leakage",
            Self::ValveLeakage { .. } => "valve_leakage",
            Self::Sticking { .. } => "sticking",
            Self::DeadBand { .. } => "dead_band",
            Self::SpoolOffset { .. } => "spool_offset",
            Self::NullShift { .. } => "null_shift",
            Self::SupplyLoss { .. } => "supply_loss",
            Self::Friction { .. } => "friction",
            Self::LateCommand { .. } => "late_command",
            Self::WrongCommand { .. } => "wrong_command",
        }
    }

    /// Its size, in the unit of its key.
    pub const fn size(self) -> f64 {
        match self {
            Self::Leakage { rate } => rate,
            Self::ValveLeakage { speed } => speed,
            Self::Sticking { band } => band,
            Self::DeadBand { size } | Self::SpoolOffset { size } | Self::NullShift { size } => size,
            Self::SupplyLoss { part } => part,
            Self::Friction { factor } => factor,
            Self::LateCommand { cycles } => cycles as f64,
            Self::WrongCommand { gain } => gain,
        }
    }
}

/// The most cycles by which a command is late.
pub const MOST_LATE: usize = 15;

/// Load pressure, bar, for which the size of a valve's leakage is given.
const LEAKAGE_PRESSURE: f64 = 24.0;
/// Position of the spool, part of its stroke, from which its edges no longer leak.
const EDGES: f64 = 0.04;

/// What differs in a cylinder from its tables, over a sub-step; nothing by default.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Wear {
    /// Added to β of (3-8), 1/s.
    pub leakage: f64,
    /// Speed that the valve's edges lose in its middle at 24 bar, m/s.
    pub valve_leakage: f64,
    /// Added to the overlap, part of the spool's stroke.
    pub dead_band: f64,
    /// Added to the factor 1 of the overlap.
    pub overlap: f64,
    /// Added to the spool's position for the flow, part of its stroke.
    pub null: f64,
    /// Added to the factor 1 of all friction, and once more of viscous friction.
    pub friction: f64,
    pub viscosity: f64,
    /// Added to the factor 1 of the flow.
    pub flow: f64,
}

impl Wear {
    /// Adds what `ailment` does to a cylinder; faults of command, spool and supply do nothing here.
    pub fn add(&mut self, ailment: Ailment) {
        match ailment {
            Ailment::Leakage { rate } => self.leakage += rate,
            Ailment::ValveLeakage { speed } => self.valve_leakage += speed,
            Ailment::DeadBand { size } => self.dead_band += size,
            Ailment::NullShift { size } => self.null += size,
            Ailment::Friction { factor } => self.friction += factor - 1.0,
            Ailment::Sticking { .. }
            | Ailment::SpoolOffset { .. }
            | Ailment::SupplyLoss { .. }
            | Ailment::LateCommand { .. }
            | Ailment::WrongCommand { .. } => {}
        }
    }

    /// Where the spool of a sound valve with this `overlap` would stand to pass what this one passes at `spool`.
    pub(super) fn effective(&self, spool: f64, overlap: f64) -> f64 {
        let moved = spool + self.null;
        let beyond = (moved.abs() - self.dead_band).max(0.0);
        let edge = overlap * (1.0 + self.overlap);
        let size = match self.overlap {
            // To the last bit what it was before an overlap could wander.
            0.0 => beyond,
            _ if beyond < edge => beyond / edge * overlap,
            _ => beyond - edge + overlap,
        };
        size.copysign(moved)
    }

    /// What the valve's edges lose at `spool` and the load pressure `pressure`, bar: m/s of the piston.
    pub(super) fn lost(&self, spool: f64, pressure: f64) -> f64 {
        let near = (1.0 - (spool + self.null).abs() / EDGES).max(0.0);
        self.valve_leakage * near * near * pressure / LEAKAGE_PRESSURE
    }
}
