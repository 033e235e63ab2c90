//! Why a relation is not learnt.

use std::fmt;

/// Shortest time from which a relation is learnt, s.
pub const LEAST_TIME: f64 = 600.0;

/// Why a relation was not learnt.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ProcessRefusal {
    /// Data for so many seconds only, where it takes `least`.
    Short { seconds: f64, least: f64 },
    /// The signals do not determine it: nothing moves.
    Undetermined,
    /// The recording contradicts it at this time, s, with this much evidence, nats.
    Contradicted { at: f64, nats: f64 },
}

impl fmt::Display for ProcessRefusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Short { seconds, least } => write!(
                f,
                "{seconds:.0} s of usable data in monitored states, and it takes {least:.0} s"
            ),
            Self::Undetermined => f.write_str("its signals hardly move, and do not determine it"),
            Self::Contradicted { at, nats } => write!(
                f,
                "what is {at:.1} s after the first frame is not like the rest, by {nats:.0} nats: is there a \
                 fault in the recording?"
            ),
        }
    }
}

/// Refuses a relation that so many `samples` teach where that is less than `least` seconds of them.
pub(super) fn enough(samples: usize, sample_time: f64, least: f64) -> Result<(), ProcessRefusal> {
    let seconds = samples as f64 * sample_time;
    if seconds < least { Err(ProcessRefusal::Short { seconds, least }) } else { Ok(()) }
}
