//! The hydraulic power unit with its accumulator: what makes Figure 3-7 of "250 bar".

use super::parameters::SupplyTable;

/// The supply that all cylinders share.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Supply {
    pressure: f64,
    set_point: f64,
    pump_gain: f64,
    pump_flow: f64,
    /// Gas pressure times gas volume, bar m³: constant, the gas keeps its temperature.
    gas: f64,
}

impl Supply {
    /// A supply at its set point.
    pub fn new(table: &SupplyTable) -> Self {
        Self {
            pressure: table.pressure,
            set_point: table.pressure,
            pump_gain: table.pump_gain,
            pump_flow: table.pump_flow,
            gas: table.pressure * table.gas_volume,
        }
    }

    /// bar.
    pub fn pressure(&self) -> f64 {
        self.pressure
    }

    /// `flow`, m³/s, is taken out for `time` seconds. The pump gives more the further the pressure
    /// is below its set point, up to its limit, less the part of it that is `lost`; the accumulator
    /// gives the rest, and its gas expands: Ṗ = P²/(P V)₀ · (Q_pump − Q).
    pub fn step(&mut self, flow: f64, lost: f64, time: f64) {
        let whole = (self.pump_gain * (self.set_point - self.pressure)).clamp(0.0, self.pump_flow);
        let pump = (1.0 - lost) * whole;
        let rise = self.pressure * self.pressure / self.gas * (pump - flow);
        self.pressure = (self.pressure + rise * time).max(1.0);
    }
}
