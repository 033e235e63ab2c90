//! What becomes of an alarm: when it is over, what it is and whose.

use crate::time::Decay;

/// The numbers by which alarms rise, are looked at and end. What one takes from samples, be they innovations or
/// residuals, is as many of them below 50 Hz as at 50 Hz ([`crate::time::samples`]).
#[derive(Clone, Debug, PartialEq)]
pub struct AlarmParameters {
    /// The mean of a minute beyond this is a fault, whatever the baseline has followed, m; 3e-4 to 1e-3.
    pub slow: f64,
    /// A slow alarm is over below this, m; less than `slow`.
    pub slow_over: f64,
    /// The level at which an alarm ends, as a part of that at which it rises; 0 to 1.
    pub calm: f64,
    /// A clearing alarm is looked at over at least so many samples: fewer are calm by chance.
    pub least_watched: usize,
    /// When after an alarm it is looked at again, s: a few samples do not tell what it is, ten do mostly.
    pub looks: [f64; 7],
    /// So long after an alarm all cylinders mostly know whether they are sampled otherwise, and whose a
    /// noise is can be told, s; the shorter one of [`super::SamplingParameters::times`].
    pub noise_told: f64,
    /// A noise has a root mean square of more than so many healthy deviations; 1 or more.
    pub notable: f64,
    /// Evidence that decides whose a noise is, nats; 3 to 10. At e⁵ to one a blame is wrong once in 150.
    pub decided: f64,
    /// The same by what the oil or the deck's attitude says of a displacement, which is asked anew all the time; 6 to 12.
    pub decided_by_the_rod: f64,
}

impl AlarmParameters {
    pub const DEFAULT: Self = Self {
        slow: 6e-4,
        slow_over: 4e-4,
        calm: 0.5,
        least_watched: 48,
        looks: [0.2, 0.32, 0.5, 1.0, 2.0, 4.0, 8.0],
        noise_told: 0.5,
        notable: 1.1,
        decided: 5.0,
        decided_by_the_rod: 8.0,
    };
}

/// The numbers by which step, ramp and noise are told apart ([`crate::sequential::kind`]).
#[derive(Clone, Debug, PartialEq)]
pub struct KindParameters {
    /// Of all samples, in motion or not, so many are held, s; up to 100 Hz. As many below 50 Hz as there.
    pub newest: f64,
    /// Innovations, and residuals at rest, are looked at as far back as this, s; up to `newest`. As many
    /// below 50 Hz as there.
    pub looked_at: f64,
    /// What a ramp must explain more than a step, nats: one sample alone fits both.
    pub ramp_advantage: f64,
    /// Of fewer samples a ramp cannot be told.
    pub shortest_ramp: usize,
    /// The square of the mean by the mean square below which it is noise, and about no step; 0 to 1, …
    pub noisy: f64,
    /// … and above which it is no noise; `noisy` to 1. Of ten draws of (5-17) one or two in a hundred are
    /// so alike.
    pub steady: f64,
    /// The mean square of the changes by the variance above which it is noise; 0 to 2, that of white
    /// noise (von Neumann).
    pub wild: f64,
}

impl KindParameters {
    pub const DEFAULT: Self = Self {
        newest: 1.28,
        looked_at: 1.0,
        ramp_advantage: 1.0,
        shortest_ramp: 12,
        noisy: 0.3,
        steady: 0.6,
        wild: 1.0,
    };
}

/// The numbers by which it is told whose step, ramp or noise it is ([`crate::sequential::pair`]).
#[derive(Clone, Debug, PartialEq)]
pub struct PairParameters {
    /// Standard deviations of what moves the rod, and its velocity's error, in `process_time`: m, m/s and
    /// m/s². They grow with the root of the time, as a random walk does.
    pub process: [f64; 3],
    /// s.
    pub process_time: f64,
    /// What of the slope of the velocity's error is left.
    pub slope_left: Decay,
    /// The filter has followed for a while after so long, s; up to 100 Hz. As many samples below 50 Hz as
    /// there.
    pub followed_for: f64,
    /// What a nat against a noise of both is worth; 1 or more, for two faults at once are the less likely.
    pub against_both: f64,
    /// So many nats a step must be better than a ramp, or a ramp than a step, to be taken for one instead,
    /// and to be compared as one: a slow drift is nobody's.
    pub clearly: f64,
    /// Evidence that decides whose a step or a ramp is, nats; 3 to 10.
    pub decided: f64,
    /// The same where it is not known how the errors of the command go on, and each counts as if it were
    /// independent of those before: that proves too much.
    pub decided_of_any: f64,
    /// Evidence with which a step's side stays told where a drift explains a little more later, nats; more than
    /// `decided_of_any`.
    pub certain: f64,
    /// So long after an alarm a side can be told, s: then the filter has followed a step, and in the closed
    /// loop the machine has, too. As many samples below 50 Hz as there.
    pub latest: f64,
    /// Alarms of longer windows, s, come too late. As many samples below 50 Hz as there.
    pub located: f64,
    /// A slower drift is followed by the filter, and in the closed loop by the machine, m/s.
    pub followed: f64,
}

impl PairParameters {
    pub const DEFAULT: Self = Self {
        process: [6e-5, 2e-4, 3e-3],
        process_time: 0.02,
        slope_left: Decay { left: 0.9, after: 0.02 },
        followed_for: 1.28,
        against_both: 2.0,
        clearly: 3.0,
        decided: 4.0,
        decided_of_any: 5.0,
        certain: 12.0,
        latest: 0.5,
        located: 0.48,
        followed: 5e-3,
    };

    /// Variances of what a cycle of `sample_time` seconds adds, of each state.
    pub fn process_of(&self, sample_time: f64) -> [f64; 3] {
        let grown = libm::sqrt(sample_time / self.process_time);
        self.process.map(|deviation| (deviation * grown) * (deviation * grown))
    }
}

/// The numbers by which a gain that is off is told ([`crate::sequential::scale`]).
#[derive(Clone, Debug, PartialEq)]
pub struct ScaleParameters {
    /// So often it is looked at whether a fault is a gain, s.
    pub every: f64,
    /// Residuals of so long after an alarm are taken, s: what time alone explains is a parabola for no
    /// longer.
    pub longest: f64,
    /// Neighbouring residuals say the same, s: the valves' dither, a fluctuation and a quantised reading
    /// last for a fraction of a second, and the samples of so long are one.
    pub alike: f64,
    /// Evidence for a gain that tells, nats: a chance of e⁻¹⁰ for each fault, of which there are few …
    pub evident: f64,
    /// … and time leaves this many times as much unexplained.
    pub clearly: f64,
    /// A larger gain is no gain: a frozen reading has −1.
    pub largest: f64,
}

impl ScaleParameters {
    pub const DEFAULT: Self =
        Self { every: 0.4, longest: 60.0, alike: 0.5, evident: 10.0, clearly: 4.0, largest: 0.1 };
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A walk of a second is the same in 10, 50 or 100 steps.
    #[test]
    fn a_random_walk_is_one_of_time() {
        let of = |rate: f64| PairParameters::DEFAULT.process_of(1.0 / rate);
        assert_eq!(
            of(50.0),
            PairParameters::DEFAULT.process.map(|deviation| deviation * deviation)
        );
        for rate in [10.0, 100.0] {
            for (here, usual) in of(rate).into_iter().zip(of(50.0)) {
                assert!((rate * here / (50.0 * usual) - 1.0).abs() < 1e-12, "{rate} Hz");
            }
        }
    }
}
