//! What a virtual sensor goes by, beside what is configured.

use crate::time::{self, Decay};

/// The numbers of the virtual sensor, the same for every machine. None is from the thesis, which has no
/// such sensor: each is reasoned, and docs/EVALUATION.md has the errors of the estimates that come of them.
#[derive(Clone, Debug, PartialEq)]
pub struct EstimateParameters {
    /// What is measured (innovations, differences and errors of predictions) is a mean over so long, s;
    /// a minute or more. Five minutes: a load or a temperature changes more slowly, and 15 000 squares at
    /// 50 Hz make a mean square known to one per cent.
    pub memory: f64,
    /// One innovation counts as no more than this in that, as its square by the expected one; beyond 10.
    /// One of ten deviations is no noise.
    pub wild: f64,
    /// What of the largest difference is left while somebody is suspected: of a second.
    pub difference_left: Decay,
    /// A reserve is sent so often, s; so old to twice as old is what the estimate goes on from where blame
    /// leaves nobody. A second, as findings come within one of the fault (docs/EVALUATION.md).
    pub reserve: f64,
    /// A difference whose suspect is not known and that stood for longer than this, s, is not explained by what the other
    /// transducer is blamed for later; longer than it takes to find a frozen reading, whose difference comes first.
    pub disputed: f64,
    /// A mean square error of n trials counts as 1 + this/n of it; 1 to 10. An error of a single trial
    /// tells little of the next.
    pub doubt: f64,
    /// No rod is faster, m/s; above what the machine's cylinders reach. A length that is not followed for a
    /// cycle may have gone so far.
    pub fastest: f64,
    /// The largest error of the last transducer that its supervision does not find is this many deviations of the estimate; 2
    /// to 4. A user takes an estimate for wrong beyond three. Without it a step of 1.25 mm made 232 of 240 estimates valid and
    /// wrong.
    pub unseen: f64,
    /// Standard deviations of the usual difference by which the two halves of a step's time may be apart, and by which a
    /// difference may scatter within a half; 2 to 5. What fluctuates now and then stays below, a drift that matters within
    /// minutes does not.
    pub still: f64,
    /// Standard deviations of what is not known of a fitted drive: of its velocity's error, m/s, and of
    /// the slope of that, m/s². Several times what fitted drives are off by.
    pub drive_unknown: [f64; 2],
    /// The same of a load pressure, bar: they lie within some hundred.
    pub pressure_unknown: f64,
}

impl EstimateParameters {
    pub const DEFAULT: Self = Self {
        memory: 300.0,
        wild: 100.0,
        difference_left: Decay { left: 0.37, after: 1.0 },
        reserve: 1.0,
        disputed: 10.0,
        doubt: 4.0,
        fastest: 1.5,
        unseen: 3.0,
        still: 3.0,
        drive_unknown: [0.05, 0.1],
        pressure_unknown: 100.0,
    };

    /// The counts for a machine with this `sample_time`, s.
    pub fn cycles(&self, sample_time: f64) -> EstimateCycles {
        let at_least_one = |seconds: f64| time::cycles(seconds, sample_time).max(1);
        EstimateCycles {
            memory: at_least_one(self.memory),
            reserve: at_least_one(self.reserve),
            disputed: at_least_one(self.disputed),
            difference_left: self.difference_left.per_cycle(sample_time),
        }
    }
}

impl Default for EstimateParameters {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// The times of [`EstimateParameters`] in cycles of one machine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EstimateCycles {
    pub memory: u32,
    pub reserve: u32,
    pub disputed: u32,
    /// What is left after one cycle.
    pub difference_left: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_cycles_of_the_machine() {
        let of = |rate: f64| EstimateParameters::DEFAULT.cycles(1.0 / rate);
        let counts = |cycles: EstimateCycles| (cycles.memory, cycles.reserve);
        assert_eq!(counts(of(50.0)), (15_000, 50));
        assert_eq!(counts(of(10.0)), (3_000, 10));
        assert_eq!(counts(of(100.0)), (30_000, 100));
        // A second, however it is divided.
        let second = of(10.0).difference_left.powi(10);
        assert!((second - 0.37).abs() < 1e-12 && of(100.0).difference_left > 0.99);
    }
}
