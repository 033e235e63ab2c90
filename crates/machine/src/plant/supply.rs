//! The hydraulic power unit with its accumulator, which turns "250 bar" into Figure 3-7.

use super::parameters::SupplyTable;

/// The supply that all cylinders share.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Supply {
    pressure: f64,
    /// Flow of the pump, m³/s, where it lags.
    pumped: f64,
    set_point: f64,
    pump_gain: f64,
    pump_flow: f64,
    pump_lag: f64,
    /// Volume of the gas at the set point, m³.
    volume: f64,
    exponent: f64,
}

impl Supply {
    /// A supply at its set point.
    pub fn new(table: &SupplyTable) -> Self {
        Self {
            pressure: table.pressure,
            pumped: 0.0,
            set_point: table.pressure,
            pump_gain: table.pump_gain,
            pump_flow: table.pump_flow,
            pump_lag: table.pump_lag,
            volume: table.gas_volume,
            exponent: table.exponent,
        }
    }

    /// Supply pressure, bar.
    pub fn pressure(&self) -> f64 {
        self.pressure
    }

    /// Takes out `flow`, m³/s, for `time` seconds. The pump gives more the further the pressure is
    /// below its set point, up to its limit. `lost` are the parts of its flow and of its set point that are
    /// missing. The accumulator gives the rest while its gas expands.
    pub fn step(&mut self, flow: f64, lost: [f64; 2], time: f64) {
        let set_point = (1.0 - lost[1]) * self.set_point;
        let whole = (self.pump_gain * (set_point - self.pressure)).clamp(0.0, self.pump_flow);
        let pump = (1.0 - lost[0]) * whole;
        let pump = if self.pump_lag > 0.0 { self.follow(pump, time) } else { pump };
        let rise = self.stiffness() * (pump - flow);
        self.pressure = (self.pressure + rise * time).max(1.0);
    }

    /// The pump's flow on its way to `pump`, m³/s.
    fn follow(&mut self, pump: f64, time: f64) -> f64 {
        self.pumped += (pump - self.pumped) * (time / self.pump_lag).min(1.0);
        self.pumped
    }

    /// dP/dV of the oil in the accumulator, bar/m³: n P/V, with P Vⁿ as at the set point.
    fn stiffness(&self) -> f64 {
        if self.exponent == 1.0 {
            return self.pressure * self.pressure / (self.set_point * self.volume);
        }
        let volume = self.volume * (self.set_point / self.pressure).powf(1.0 / self.exponent);
        self.exponent * self.pressure / volume
    }
}
