//! The hydraulic power unit with its accumulator, which turns "250 bar" into Figure 3-7.

use super::parameters::SupplyTable;

/// The supply that all cylinders share.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Supply {
    pressure: f64,
    set_point: f64,
    pump_gain: f64,
    pump_flow: f64,
    /// Gas pressure times gas volume, bar m³: constant, as the gas keeps its temperature.
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

    /// Supply pressure, bar.
    pub fn pressure(&self) -> f64 {
        self.pressure
    }

    /// Takes out `flow`, m³/s, for `time` seconds. The pump gives more the further the pressure is
    /// below its set point, up to its limit. `lost` are the parts of its flow and of its set point that are
    /// missing. The accumulator gives
    /// the rest while its gas expands: Ṗ = P²/(P V)₀ · (Q_pump − Q).
    pub fn step(&mut self, flow: f64, lost: [f64; 2], time: f64) {
        let set_point = (1.0 - lost[1]) * self.set_point;
        let whole = (self.pump_gain * (set_point - self.pressure)).clamp(0.0, self.pump_flow);
        let pump = (1.0 - lost[0]) * whole;
        let rise = self.pressure * self.pressure / self.gas * (pump - flow);
        self.pressure = (self.pressure + rise * time).max(1.0);
    }
}
