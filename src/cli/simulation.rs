//! A simulated machine as a source of frames.

use crate::bus::{Source, SourceError};
use crate::controller::State;
use crate::frame::Frame;
use crate::inject::Tally;
use crate::simulator::Simulator;
use std::collections::VecDeque;

/// The frames of a simulated machine over a number of cycles, one by one.
pub struct Simulation {
    simulator: Simulator,
    /// Cycles that are not simulated yet.
    cycles: u64,
    /// Frames of the present cycle.
    frames: Vec<Frame>,
    given: usize,
    /// Cycles at which a state is asked for, the first ones first.
    requests: VecDeque<(u64, State)>,
    cycle: u64,
}

impl Simulation {
    pub fn new(simulator: Simulator, cycles: u64) -> Self {
        let (frames, requests) = (Vec::new(), VecDeque::new());
        Self { simulator, cycles, frames, given: 0, requests, cycle: 0 }
    }

    /// The same, which asks the platform for states at these cycles, given in order.
    pub fn asked_for(self, requests: Vec<(u64, State)>) -> Self {
        Self { requests: requests.into(), ..self }
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
            while let Some((_, state)) = self.requests.pop_front_if(|(at, _)| *at <= self.cycle) {
                self.simulator.request(state);
            }
            self.cycle += 1;
            self.given = 0;
            self.frames.clear();
            let frames = &mut self.frames;
            self.simulator.step(&mut |frame| frames.push(frame.clone()));
        }
        self.given += 1;
        Ok(self.frames.get(self.given - 1))
    }
}
