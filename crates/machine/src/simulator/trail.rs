//! The last sub-steps of the plant, for valves that do not sample at the Sync.

use crate::plant::{CYLINDERS, CylinderState, Inputs, Plant};
use std::collections::VecDeque;

/// States of the cylinders and the supply pressure, bar, at the end of a sub-step.
type Snapshot = ([CylinderState; CYLINDERS], f64);

/// The states since the oldest sampling of a valve.
#[derive(Clone, Debug)]
pub struct Trail {
    /// Newest first; one is enough where all valves sample at the Sync.
    snapshots: VecDeque<Snapshot>,
    sub_step: f64,
    length: usize,
}

impl Trail {
    /// A trail for valves that sample at most `age` seconds before the Sync.
    pub fn new(age: f64, sub_step: f64) -> Self {
        let length = if age > 0.0 { (age / sub_step).ceil() as usize + 1 } else { 0 };
        Self { snapshots: VecDeque::with_capacity(length + 1), sub_step, length }
    }

    /// Advances the plant and remembers its way.
    pub fn run(&mut self, plant: &mut Plant, inputs: &Inputs, steps: u32) {
        if self.length == 0 {
            return plant.run(inputs, steps);
        }
        for _ in 0..steps {
            plant.run(inputs, 1);
            self.snapshots.truncate(self.length.saturating_sub(1));
            self.snapshots.push_front((*plant.states(), plant.supply_pressure()));
        }
    }

    /// State of a cylinder and supply pressure `age` seconds ago; those of `plant` where nothing is remembered.
    pub fn at(&self, plant: &Plant, leg: usize, age: f64) -> (CylinderState, f64) {
        let now = (plant.states()[leg], plant.supply_pressure());
        let place = age / self.sub_step;
        let get =
            |back: usize| self.snapshots.get(back).map(|(states, supply)| (states[leg], *supply));
        let (Some(late), Some(early)) = (get(place as usize), get(place as usize + 1)) else {
            return get(place as usize).unwrap_or(now);
        };
        let mix = |late: f64, early: f64| late + place.fract() * (early - late);
        let state = CylinderState {
            length: mix(late.0.length, early.0.length),
            speed: mix(late.0.speed, early.0.speed),
            pressure: mix(late.0.pressure, early.0.pressure),
            spool: mix(late.0.spool, early.0.spool),
            imbalance: mix(late.0.imbalance, early.0.imbalance),
        };
        (state, mix(late.1, early.1))
    }
}
