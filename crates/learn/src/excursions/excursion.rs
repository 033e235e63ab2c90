//! One excursion: a stretch in which a reading is off, and comes back at an edge.

/// An excursion of one transducer, as it shows in the difference of both.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Excursion {
    /// Place of the first sample, counted in judged samples from 0.
    pub at: u64,
    /// Magnitude, m: the mean of its samples less one standard error, because the computation of limits
    /// adds the noise again.
    pub size: f64,
    /// Length, samples.
    pub length: u32,
    /// Direction of the difference: up with C1, or down with C2.
    pub positive: bool,
    /// Speed of the rod at its middle, m/s, not negative.
    pub speed: f64,
}

impl Excursion {
    /// Order by length, then by all else that does not depend on the order of files.
    pub(super) fn shorter_first(&self, other: &Self) -> std::cmp::Ordering {
        self.length
            .cmp(&other.length)
            .then(self.size.total_cmp(&other.size))
            .then(self.speed.total_cmp(&other.speed))
            .then(self.positive.cmp(&other.positive))
    }
}
