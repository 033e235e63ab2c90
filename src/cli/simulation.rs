//! A simulated machine as a source of frames.

use crate::bus::{Source, SourceError};
use crate::frame::Frame;
use crate::inject::Tally;
use crate::simulator::Simulator;

/// The frames of a simulated machine over a number of cycles, one by one.
pub struct Simulation {
    simulator: Simulator,
    /// Cycles that are not simulated yet.
    cycles: u64,
    /// Frames of the present cycle.
    frames: Vec<Frame>,
    given: usize,
}

impl Simulation {
    pub const fn new(simulator: Simulator, cycles: u64) -> Self {
        Self { simulator, cycles, frames: Vec::new(), given: 0 }
    }

    /// Tallies of all faults so far, in the order in which the faults were given.
    pub fn tallies(&self) -> &[Tally] {
        self.simulator.tallies()
    }
}

impl Source for Simulation {
    fn next_frame(&mut self) -> Result<Option<&Frame>, SourceError> {
        // A fault may lose every frame of a cycle.
        while self.given == self.frames.len() {
            if self.cycles == 0 {
                return Ok(None);
            }
            self.cycles -= 1;
            self.given = 0;
            self.frames.clear();
            let frames = &mut self.frames;
            self.simulator.step(&mut |frame| frames.push(frame.clone()));
        }
        self.given += 1;
        Ok(self.frames.get(self.given - 1))
    }
}
