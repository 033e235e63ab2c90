//! What the attitude of the deck is judged by: every number of the family, with its unit and source.

/// All of them. Those without a source were chosen on simulated machines (docs/HEXAPOD.md).
#[derive(Clone, Debug, PartialEq)]
pub struct TiltParameters {
    /// Time between two comparisons, s: what a sensor is off by lasts for longer.
    pub every: f64,
    /// Time constant of the mean that is judged, s: what is longer comes late for a fast drift.
    pub mean: f64,
    /// Time constant of what is healthy, s.
    pub healthy: f64,
    /// Time at work after which a mean is one of healthy comparisons, s: some time constants of it.
    pub settled: f64,
    /// Time without a comparison after which the mean begins anew, s.
    pub gap: f64,
    /// A sensor that repeats itself for so long is frozen, s. A deck that its cylinders hold level hardly moves, but
    /// its sensor has noise.
    pub frozen: f64,
    /// For how many measured means the sensor's own accuracy counts, and the most that are remembered.
    pub remembered: [u32; 2],
    /// No mean teaches more than one that is off by so many standard deviations.
    pub odd: f64,
    /// How far the sensor's error walks in the root of a second, rad.
    pub walk: f64,
    /// What the geometry may be wrong by, as a part of the tilt that a displacement makes.
    pub geometry: f64,
    /// Nothing is said where no explanation is nearer than so many standard deviations.
    pub beside: f64,
    /// Of single transducers: means that were measured before a tilt can depart from the usual one. At one in two
    /// seconds, they are some swells.
    pub taught: u32,
    /// From how many standard deviations on a tilt has departed, and nothing is learnt from it.
    pub departed: f64,
    /// By how many nats a leg has to explain it better than every other one, as in `decided_by_the_rod` of the sequential
    /// detectors.
    pub apart: f64,
    /// Time for which the same leg has to explain it, and for which the tilt has to be the usual one again, s.
    pub confirmed: f64,
    /// Time after which a departure that no leg explains is the machine's new usual tilt, s.
    pub undecided: f64,
}

impl TiltParameters {
    pub const DEFAULT: Self = Self {
        every: 0.1,
        mean: 2.0,
        healthy: 60.0,
        settled: 15.0,
        gap: 5.0,
        frozen: 2.0,
        remembered: [4, 150],
        odd: 4.0,
        walk: 3e-6,
        geometry: 0.05,
        beside: 4.0,
        taught: 30,
        departed: 3.0,
        apart: 8.0,
        confirmed: 1.0,
        undecided: 600.0,
    };
}
