//! Values in the frames of a cycle.

use super::machine::Sample;
use crate::controller::{Commands, State};
use crate::inject::Unrounded;
use crate::transducer::Grid;

/// Source of a signal's value; `usize` is the cylinder, from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// Counter that rises by one in each cycle, with as many bits as the signal has.
    Counter,
    /// Status 0: nothing to report.
    Status,
    /// Length by transducer 0 (C1) or 1 (C2) of a cylinder.
    Length(usize, usize),
    Speed(usize, usize),
    Command(usize),
    Spool(usize),
    Bottom(usize),
    Rod(usize),
    /// Load pressure P_L (3-4).
    LoadPressure(usize),
    /// Surge, sway, or heave.
    Translation(usize),
    /// Roll, pitch, or yaw.
    Attitude(usize),
    /// Roll or pitch of the deck.
    Top(usize),
    State,
    Supply,
}

/// What the numbers on a machine's bus stand for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scales {
    /// Grid that the transducers round to.
    pub grid: Grid,
    /// A spool's signal at full stroke.
    pub spool_full: f64,
    /// Numbers of the platform's states, in the order of [`State`].
    pub states: [f64; 4],
}

/// The values of one cycle, in the units of the bus.
#[derive(Clone, Debug)]
pub struct Values {
    scales: Scales,
    sample: Sample,
    commands: Commands,
    state: f64,
    pub cycle: u64,
}

impl Values {
    pub fn new(scales: Scales) -> Self {
        let (sample, commands) = (Sample::default(), Commands::default());
        Self { scales, sample, commands, state: 0.0, cycle: 0 }
    }

    /// The value of a transducer before it was rounded.
    pub fn unrounded(&self, origin: Origin) -> Option<Unrounded> {
        let Origin::Length(cylinder, which) = origin else { return None };
        let length = self.sample.transducers[cylinder][which].unrounded;
        Some(Unrounded { length, grid: self.scales.grid })
    }

    pub fn sampled(&mut self, sample: &Sample, state: State, cycle: u64) {
        self.sample = *sample;
        self.state = self.scales.states[state as usize];
        self.cycle = cycle;
    }

    pub fn commanded(&mut self, commands: &Commands) {
        self.commands = *commands;
    }

    /// The value of a signal that is not a counter.
    pub fn of(&self, origin: Origin) -> f64 {
        match origin {
            Origin::Counter | Origin::Status => 0.0,
            Origin::Length(cylinder, which) => self.sample.transducers[cylinder][which].length,
            Origin::Speed(cylinder, which) => self.sample.transducers[cylinder][which].speed,
            Origin::Command(cylinder) => self.commands.speeds[cylinder],
            Origin::Spool(cylinder) => self.scales.spool_full * self.sample.spools[cylinder],
            Origin::Bottom(cylinder) => self.sample.chambers[cylinder][0],
            Origin::Rod(cylinder) => self.sample.chambers[cylinder][1],
            Origin::LoadPressure(cylinder) => self.sample.load_pressures[cylinder],
            Origin::Translation(axis) => self.sample.motion.pose.translation[axis],
            Origin::Attitude(axis) => self.sample.motion.pose.attitude[axis],
            Origin::Top(axis) => self.sample.top[axis],
            Origin::State => self.state,
            Origin::Supply => self.sample.supply,
        }
    }
}
