//! The numbers by which findings are blamed on a transducer or on the process.

use crate::time;

/// Numbers of the rules of blame. Times are in seconds. Below 50 Hz they are as many samples as at 50 Hz ([`time::samples`]).
#[derive(Clone, Debug, PartialEq)]
pub struct BlameParameters {
    /// A reading that has stood for so long when the other one leaves it may be that of a rod at rest, s; 0.04 to 0.2. Three
    /// samples: a rod that turns round stands for two of a coarse transducer.
    pub stood: f64,
    /// For so long the step away from it may be the begin of a motion, s; 0.06 to 0.3. Five samples: a rod that moves has by
    /// then also moved the coarser reading.
    pub awaited: f64,
    /// Part of the innovation from which the other observer also sees it where C1 and C2 agree; 0.1 to 0.5. Readings have noise
    /// of their own, and the innovation that first exceeds its threshold is larger than the other.
    pub seen: f64,
    /// The same where they do not agree; 0.6 to 0.9. Beside a fault of its own the error of the model is rarely as large.
    pub alike: f64,
    /// Part of the innovation below which C1 − C2 does not show it; 0.3 to 0.7. A fault of a reading appears in C1 − C2 no less
    /// than in the innovation.
    pub hidden: f64,
    /// Part of the innovation below which the other observer does not see it, either way; 0.3 to 0.7. An error of the model is in
    /// both.
    pub alone: f64,
}

impl BlameParameters {
    /// The same for every machine.
    pub const DEFAULT: Self =
        Self { stood: 0.06, awaited: 0.1, seen: 0.25, alike: 0.75, hidden: 0.5, alone: 0.5 };

    /// [`Self::stood`] and [`Self::awaited`] in samples of a machine with this `sample_time`, s.
    pub fn samples(&self, sample_time: f64) -> [u32; 2] {
        [self.stood, self.awaited].map(|seconds| time::samples(seconds, sample_time))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_stay_and_below_50_hz_samples_do() {
        let of = |rate: f64| BlameParameters::DEFAULT.samples(1.0 / rate);
        assert_eq!([of(10.0), of(50.0), of(100.0)], [[3, 5], [3, 5], [6, 10]]);
    }
}
