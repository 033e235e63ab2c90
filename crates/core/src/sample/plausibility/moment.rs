//! What is known of a cycle beside the reading that is judged.

use crate::sample::motion::ReadingMotion;
use crate::state::choice;

/// Direction in which a command moves the cylinder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Push {
    Positive,
    Negative,
}

choice! { Push { Positive, Negative } }

impl Push {
    /// Direction of a command, m/s; `None` where it does not exceed `least`.
    pub fn of(command: f64, least: f64) -> Option<Self> {
        let push = if command > 0.0 { Self::Positive } else { Self::Negative };
        (command.abs() > least).then_some(push)
    }
}

/// The other transducer of the cylinder.
#[derive(Clone, Copy, Debug)]
pub struct Other {
    /// Position, m.
    pub position: f64,
    /// Whether it is in motion, see [`ReadingMotion::goes_on`].
    pub goes_on: bool,
}

impl Other {
    /// The other transducer at `position`, m, whose `motion` was followed up to it.
    #[cold]
    pub fn new(position: f64, motion: &ReadingMotion) -> Self {
        Self { position, goes_on: motion.goes_on() }
    }
}

/// Circumstances of a cycle beside the reading.
#[derive(Clone, Copy, Debug)]
pub struct Moment {
    /// Whether anything of the machine was on the bus in this cycle. In silence nothing ages: a
    /// quiet bus is not the fault of a transducer.
    pub live: bool,
    /// Direction in which the command since the last cycle moves the cylinder, in a platform state
    /// in which it follows; `None` if it does not move it.
    pub push: Option<Push>,
    /// Way of that command in one cycle, m, signed.
    pub way: f64,
    /// Lowest and highest length that the rod has had in health, m.
    pub been: [f64; 2],
    /// The other transducer in this cycle; `None` where it cannot be relied on.
    pub other: Option<Other>,
}
