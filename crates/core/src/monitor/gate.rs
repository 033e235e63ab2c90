//! Platform states in which FDE1 and FDE2 judge, and in which the rods stand on their stops.

use crate::state::{state, whole};
use crate::time::{Span, Timestamp};
use alloc::vec::Vec;

/// Follows the platform's state.
#[derive(Clone, Debug)]
pub struct Gate {
    /// Numbers of the monitored states; absent: the gate is always open.
    monitored: Option<Vec<i64>>,
    stops: Vec<i64>,
    timeout: Span,
    state: Option<Seen>,
}

state! {
    Gate { state }
    but { monitored, stops, timeout }
}

/// Newest state of the platform, with its meaning, which is looked up once and not in each cycle of
/// each cylinder.
#[derive(Clone, Copy, Debug)]
struct Seen {
    at: Timestamp,
    number: i64,
    monitored: bool,
    at_stop: bool,
}

whole! { Seen { at, number, monitored, at_stop } }

/// Opening of the gate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Opening {
    Open,
    /// The platform is in a state that is not monitored.
    Closed,
    /// The platform's state is not known, or no longer.
    Unknown,
}

impl Gate {
    /// A gate that opens in the `monitored` states, of a machine whose rods stand on their
    /// mechanical stops in those of `stops`; a state older than `timeout` is unknown.
    pub fn new(monitored: Option<Vec<i64>>, stops: Vec<i64>, timeout: Span) -> Self {
        Self { monitored, stops, timeout, state: None }
    }

    /// Takes a platform state from the bus.
    pub fn state(&mut self, at: Timestamp, state: i64) {
        let monitored = self.monitored.as_ref().is_none_or(|states| states.contains(&state));
        let at_stop = self.stops.contains(&state);
        self.state = Some(Seen { at, number: state, monitored, at_stop });
    }

    /// Whether it is open at `at`, and whether the rods stand on their stops.
    #[inline]
    pub fn look(&self, at: Timestamp) -> (Opening, bool) {
        let seen = self.known(at);
        let opening = match seen {
            _ if self.monitored.is_none() => Opening::Open,
            Some(seen) if seen.monitored => Opening::Open,
            Some(_) => Opening::Closed,
            None => Opening::Unknown,
        };
        (opening, seen.is_some_and(|seen| seen.at_stop))
    }

    /// Number of the present state.
    pub fn number(&self, at: Timestamp) -> Option<i64> {
        Some(self.known(at)?.number)
    }

    /// The state, if it is not too old at `at`.
    #[inline]
    fn known(&self, at: Timestamp) -> Option<&Seen> {
        self.state.as_ref().filter(|seen| at.since(seen.at) <= self.timeout)
    }

    /// Forgets the state, after a jump in time.
    pub fn reset(&mut self) {
        self.state = None;
    }
}
