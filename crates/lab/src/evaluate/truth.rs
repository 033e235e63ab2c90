//! What the lengths of the simulated rods are, for comparison with the estimates of the same cycle.

use tertius_core::time::{Span, Timestamp};
use tertius_machine::plant::CYLINDERS;
use tertius_machine::simulator::Simulator;

/// An estimate is wrong when it is off by more of its own standard deviations than this.
pub(super) const WRONG: f64 = 3.0;

/// True lengths of the newest two cycles: a cycle that lacks something is reported during the next.
#[derive(Clone, Debug)]
pub(super) struct Truth {
    half: Span,
    newest: [(Timestamp, [f64; CYLINDERS]); 2],
}

impl Truth {
    /// Before the first cycle of `simulator`; `sample_time` in s.
    pub fn new(simulator: &Simulator, sample_time: f64) -> Self {
        let half = Span::from_seconds(0.5 * sample_time);
        Self { half, newest: [(simulator.opening(), [0.0; CYLINDERS]); 2] }
    }

    /// Takes the lengths of the cycle that `simulator` is about to simulate, as a noiseless C1 would read them. C1's own
    /// calibration error is unknown to anyone on the bus.
    pub fn note(&mut self, simulator: &Simulator) {
        let lengths = std::array::from_fn(|leg| simulator.machine().calibrated(leg));
        self.newest = [self.newest[1], (simulator.opening(), lengths)];
    }

    /// The opening of the cycle reported `at` that time, and the length of a cylinder in it, counted from 1, m.
    pub fn of(&self, at: Timestamp, cylinder: u8) -> Option<(Timestamp, f64)> {
        let of_cycle = |(opening, _): &&(Timestamp, _)| {
            at.since(*opening).as_nanos().abs() < self.half.as_nanos()
        };
        let (opening, lengths) = self.newest.iter().find(of_cycle)?;
        Some((*opening, lengths[usize::from(cylinder) - 1]))
    }
}
