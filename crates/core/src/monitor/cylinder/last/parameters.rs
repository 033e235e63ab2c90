//! What the last transducer of a cylinder is judged by: every number of the family, with its unit and source.

/// Numbers by which a displacement of it is told from wild samples, noise and another motion.
#[derive(Clone, Debug, PartialEq)]
pub struct LastParameters {
    /// A displacement has to stay for so long, s; 0.04 to 1. A transducer that fluctuates is now and then off for 0.2 s
    /// (Figure 5-9), and by twice as much where one fluctuation follows the other.
    pub confirmed: f64,
    /// Part of it that has to be there in the next cycle, and by which C1 − C2 and dead reckoning have to show it, too; 0.3 to
    /// 0.7.
    pub stays: f64,
    /// Part of it that an innovation against it takes back, 0.5 to 1; that of an observer which overshoots comes at once.
    pub returned: f64,
    /// Number of 64 innovations beyond its limit from which on they are noise and not wild samples; 8 to 64. Noise of 2 σ has about 25. A wild
    /// sample has three: where one in a hundred is wild, as many meet about once in a thousand hours.
    pub noise: u32,
    /// The mean square of its innovations while it was not the last one is over this time, s.
    pub memory: f64,
    /// The most that an innovation counts as in that mean, in δ_h: a fault is not usual.
    pub counted: f64,
    /// Standard deviations of the innovations in health that are well above them, 6 to 12: a model that fits badly exceeds
    /// its threshold now and then.
    pub well_above: f64,
    /// Part of that from which on the transducer is named, although the displacement is not yet latched; 0.5 to 1.
    pub named: f64,
    /// A rod that moves no farther than this beyond where it has been, m, is not on a stop; by half of the way that it has been
    /// it may do so, unless it comes near an end of its stroke: each high wave goes farther than the one before.
    pub near: f64,
    /// Part of the stroke at either end in which a stop may hold the rod.
    pub stop: f64,
    /// Factor on the largest usual command from which on a command is another motion; 1 or more. In a sea the largest one so far is
    /// exceeded again and again.
    pub further: f64,
    /// Settling times without a finding after which it is known where the rod moves.
    pub known: u32,
}

impl LastParameters {
    /// The same for every machine. They were chosen on simulated machines.
    pub const DEFAULT: Self = Self {
        confirmed: 0.3,
        stays: 0.5,
        returned: 0.6,
        noise: 22,
        memory: 60.0,
        counted: 4.0,
        well_above: 8.0,
        named: 0.8,
        near: 0.1,
        stop: 0.1,
        further: 1.5,
        known: 10,
    };
}
