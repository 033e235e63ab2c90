//! In which platform states FDE1 and FDE2 judge.

use crate::time::{Span, Timestamp};

/// Follows the platform's state.
#[derive(Clone, Debug)]
pub struct Gate {
    /// Absent: always open.
    monitored: Option<Vec<i64>>,
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
    /// A gate that opens in the `monitored` states; a state older than `timeout` is not known.
    pub fn new(monitored: Option<Vec<i64>>, timeout: Span) -> Self {
        Self { monitored, timeout, state: None }
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

    /// Forgets the state, after a jump in time.
    pub fn reset(&mut self) {
        self.state = None;
    }
}
