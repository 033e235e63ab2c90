//! The parts into which the stream of a cylinder's difference is divided.

use super::excursion::Excursion;

/// What a part of the stream is. Every sample is handed out once, as `Core` or `Off`, in order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Segment {
    /// A sample of no candidate, and not beside one: noise. Residual, m, and velocity, m/s.
    Core { residual: f64, velocity: f64 },
    /// A sample of a candidate, or beside one. Residual, m, and velocity, m/s.
    Off { residual: f64, velocity: f64 },
    /// A stretch in which one or two samples are off; `samples` is how many are.
    Wild { samples: u32 },
    /// An excursion.
    Excursion(Excursion),
    /// Two excursions that overlap, one of each transducer, in the order of their beginnings.
    Overlap([Excursion; 2]),
    /// An excursion of unknown length, since the stream begins or ends within it.
    Cut { positive: bool },
    /// A candidate of more samples than `LONGEST_CANDIDATE`: no excursion.
    Overlong { samples: u64 },
    /// A candidate in which nothing counts, as where a profile is off in one place.
    Unexplained { samples: u32 },
}
