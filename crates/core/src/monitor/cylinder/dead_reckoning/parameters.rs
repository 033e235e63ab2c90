//! What a departure from dead reckoning is judged by: every number of the family, with its unit and source.

/// Windows, each twice as long as the one before.
pub const WINDOWS: usize = 8;

/// Ticks of the longest one.
pub const LONGEST_WINDOW_TICKS: usize = 1 << (WINDOWS - 1);

/// Numbers of the comparison with dead reckoning.
#[derive(Clone, Debug, PartialEq)]
pub struct ReckoningParameters {
    /// Readings are compared so often, s, in windows of 1, 2, 4 … 128 times as long; 0.2 to 1.
    pub interval: f64,
    /// The usual error of a window is a mean over this time, s; some dozen times the longest window.
    pub memory: f64,
    /// The mean error is followed with this time constant, s; 60 to 300. While oil warmed, it went from 0.7 to −1 mm/s in 25
    /// minutes.
    pub bias: f64,
    /// Without a drive the model goes alone; its pressure has a time constant of 10 s by Table 4-1, and is used after so long, s.
    pub settling: f64,
    /// A window is judged once as many of its length were learnt, and a mean square of n counts as 1 + doubt/n of it. With 2 and
    /// 4 a sound transducer was named in 1 of 240 minutes: of two samples the deviation may come out a tenth. Of eight, 12
    /// times the deviation is exceeded in two of a million cases (Student).
    pub trials: f64,
    pub doubt: f64,
    /// An error of as many deviations is a fault; 6 or more. Healthy machines came to 4.4, and to 5.8 while a pump failed.
    pub deviations: f64,
    /// Part of the difference at which the machine trips, below which nothing is a fault; 0.1 to 0.5. A rod that was at rest has
    /// hardly any usual error.
    pub least: f64,
}

impl ReckoningParameters {
    /// The same for every machine.
    pub const DEFAULT: Self = Self {
        interval: 0.5,
        memory: 1800.0,
        bias: 120.0,
        settling: 40.0,
        trials: 8.0,
        doubt: 16.0,
        deviations: 7.0,
        least: 0.2,
    };
}
