//! In which platform states FDE1 and FDE2 judge, and in which the rods stand on their stops.

use crate::time::{Span, Timestamp};

/// Follows the platform's state.
#[derive(Clone, Debug)]
pub struct Gate {
    /// Absent: always open.
    monitored: Option<Vec<i64>>,
    stops: Vec<i64>,
    timeout: Span,
    state: Option<(i64, Timestamp)>,
}

/// Where the gate stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Opening {
    Open,
    /// The platform is in a state that is not monitored.
    Closed,
    /// The platform's state is not known, or not any more.
    Unknown,
}

impl Gate {
    /// A gate that opens in the `monitored` states, of a machine whose rods stand on their mechanical
    /// stops in those of `stops`; a state older than `timeout` is not known.
    pub fn new(monitored: Option<Vec<i64>>, stops: Vec<i64>, timeout: Span) -> Self {
        Self { monitored, stops, timeout, state: None }
    }

    /// Takes the platform's state as it was on the bus.
    pub fn state(&mut self, at: Timestamp, state: i64) {
        self.state = Some((state, at));
    }

    pub fn opening(&self, at: Timestamp) -> Opening {
        let Some(monitored) = &self.monitored else { return Opening::Open };
        match self.state {
            Some((_, since)) if at.since(since) > self.timeout => Opening::Unknown,
            Some((state, _)) if monitored.contains(&state) => Opening::Open,
            Some(_) => Opening::Closed,
            None => Opening::Unknown,
        }
    }

    /// The state in which the rods stand on their stops, if it is one of these.
    pub fn stop(&self, at: Timestamp) -> Option<i64> {
        let (state, since) = self.state?;
        (at.since(since) <= self.timeout && self.stops.contains(&state)).then_some(state)
    }

    /// Forgets the state, after a jump in time.
    pub fn reset(&mut self) {
        self.state = None;
    }
}
