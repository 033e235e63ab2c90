//! Six cylinders and the supply that they share, from sample to sample.

use super::CYLINDERS;
use super::ailment::Wear;
use super::cylinder::{Cylinder, CylinderState, Drive};
use super::parameters::Parameters;
use super::supply::Supply;

/// Inputs of the plant over one sample.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Inputs {
    /// Commanded spool positions, −1 to 1.
    pub spools: [f64; CYLINDERS],
    /// Masses that the cylinders carry now, as parts of their usual load.
    pub loads: [f64; CYLINDERS],
    /// Acceleration of the frame along each cylinder, gravity included, m/s².
    pub accelerations: [f64; CYLINDERS],
    /// Part of the pump's flow that is missing, 0 to 1.
    pub pump_lost: f64,
    /// Part by which the pump's set point is lower, 0 to 1.
    pub supply_lost: f64,
    /// What differs in each cylinder from its tables.
    pub wear: [Wear; CYLINDERS],
}

/// Six cylinders and their supply.
#[derive(Clone, Debug, PartialEq)]
pub struct Plant {
    cylinders: [Cylinder; CYLINDERS],
    supply: Supply,
    states: [CylinderState; CYLINDERS],
    sub_step: f64,
}

impl Plant {
    /// A plant that is integrated in sub-steps of `sub_step` seconds, at rest with all strokes
    /// `length`, m.
    pub fn new(parameters: &Parameters, sub_step: f64, length: f64) -> Self {
        let state = CylinderState { length, ..CylinderState::default() };
        Self {
            cylinders: std::array::from_fn(|index| Cylinder::new(parameters, index, sub_step)),
            supply: Supply::new(&parameters.supply),
            states: [state; CYLINDERS],
            sub_step,
        }
    }

    pub fn states(&self) -> &[CylinderState; CYLINDERS] {
        &self.states
    }

    /// States of the cylinders, to be set for a start in the middle of a motion.
    pub fn states_mut(&mut self) -> &mut [CylinderState; CYLINDERS] {
        &mut self.states
    }

    pub fn cylinders(&self) -> &[Cylinder; CYLINDERS] {
        &self.cylinders
    }

    /// Supply pressure, bar.
    pub fn supply_pressure(&self) -> f64 {
        self.supply.pressure()
    }

    /// P_bot and P_rod, bar, as pressure transducers would measure them.
    pub fn chamber_pressures(&self, index: usize) -> [f64; 2] {
        self.cylinders[index].chamber_pressures(&self.states[index], self.supply.pressure())
    }

    /// Advances by `steps` sub-steps under constant inputs.
    pub fn run(&mut self, inputs: &Inputs, steps: u32) {
        for _ in 0..steps {
            let supply = self.supply.pressure();
            let mut flow = 0.0;
            for (index, cylinder) in self.cylinders.iter().enumerate() {
                let drive = Drive {
                    spool: inputs.spools[index],
                    load: inputs.loads[index],
                    acceleration: inputs.accelerations[index],
                    supply,
                    wear: inputs.wear[index],
                };
                flow += cylinder.step(&mut self.states[index], &drive);
            }
            self.supply.step(flow, [inputs.pump_lost, inputs.supply_lost], self.sub_step);
        }
    }
}
