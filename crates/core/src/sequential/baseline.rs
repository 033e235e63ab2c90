//! The baseline of a healthy residual: its slow changes, mainly with the temperature.

use super::parameters::ResidualParameters;
use crate::state::{state, whole};
use crate::time::{self, Timestamp};

/// A slow mean of the residual, which weights uncertain samples less, and its own uncertainty.
#[derive(Clone, Debug)]
pub struct Baseline {
    parameters: &'static ResidualParameters,
    /// Weight of one sample.
    gain: f64,
    begin: f64,
    clip: f64,
    /// Number of samples, weighted by their certainty.
    seen: f64,
    value: f64,
    doubt: f64,
}

state! {
    Baseline { seen, value, doubt }
    but { parameters, gain, begin, clip }
}

impl Baseline {
    /// A baseline for samples every `sample_time` seconds with a healthy standard deviation
    /// `deviation`, m.
    pub fn new(parameters: &'static ResidualParameters, sample_time: f64, deviation: f64) -> Self {
        let cycles = parameters.cycles(sample_time);
        Self {
            parameters,
            gain: cycles.baseline_gain,
            begin: cycles.baseline_begin,
            clip: parameters.baseline_clip * deviation,
            seen: 0.0,
            value: 0.0,
            doubt: 0.0,
        }
    }

    pub fn reset(&mut self) {
        (self.seen, self.value, self.doubt) = (0.0, 0.0, 0.0);
    }

    /// Uncertainty of the baseline, m, from that of the samples it has followed.
    pub const fn doubt(&self) -> f64 {
        self.doubt
    }

    /// The baseline, m, once it has begun.
    pub fn value(&self) -> Option<f64> {
        (self.seen >= self.begin).then_some(self.value)
    }

    /// Follows a residual with the uncertainty `doubt`, m.
    pub fn follow(&mut self, residual: f64, doubt: f64) {
        let ResidualParameters { half_taught, wild, .. } = *self.parameters;
        let halves = doubt / half_taught;
        let share = 1.0 / (1.0 + halves * halves);
        let off = residual - self.value;
        if self.seen < self.begin {
            self.seen += share;
            self.value += share * off.clamp(-wild, wild) / self.seen;
            self.doubt += share * (doubt - self.doubt) / self.seen;
        } else {
            let clip = self.clip + doubt;
            self.value += self.gain * share * off.clamp(-clip, clip);
            self.doubt += self.gain * share * (doubt - self.doubt);
        }
    }
}

/// Whether a loss of readings was long enough to forget a baseline. One cycle in a few seconds is
/// not; otherwise a bus that loses some would never have a baseline.
#[derive(Clone, Copy, Debug, Default)]
pub struct Loss {
    newest: Option<Timestamp>,
    lost: bool,
}

whole! { Loss { newest, lost } }

impl Loss {
    /// Notes that readings are missing from here on.
    pub const fn begin(&mut self) {
        self.lost = true;
    }

    /// Takes the time of a reading; returns `true` if it is the first one after a long loss, or the
    /// clock has been set.
    pub fn is_long(&mut self, at: Timestamp) -> bool {
        let newest = self.newest.replace(at);
        let short = ResidualParameters::DEFAULT.short_loss;
        let passed = |newest: Timestamp| at.since(newest).as_seconds();
        core::mem::take(&mut self.lost)
            && newest.is_some_and(|newest| !(0.0..=short).contains(&passed(newest)))
    }
}

/// One-second means in a [`Slow`]: the minute of it.
const MEANS: usize = 60;

/// The mean of the residual itself over the newest minute of evidence, which shows drifts that the
/// baseline follows.
#[derive(Clone, Debug)]
pub struct Slow {
    /// No residual counts as more, m.
    wild: f64,
    second: u32,
    means: [f64; MEANS],
    held: usize,
    next: usize,
    /// Mean of `means`, once they cover a minute.
    mean: Option<f64>,
    sum: f64,
    count: u32,
}

state! {
    Slow { means, held, next, mean, sum, count }
    but { wild, second }
    sound |it| it.next < MEANS && it.held <= MEANS && it.count < it.second
}

impl Slow {
    pub fn new(parameters: &ResidualParameters, sample_time: f64) -> Self {
        let (wild, second) = (parameters.wild, time::cycles(1.0, sample_time).max(1));
        Self { wild, second, means: [0.0; MEANS], held: 0, next: 0, mean: None, sum: 0.0, count: 0 }
    }

    pub fn reset(&mut self) {
        (self.held, self.next, self.mean) = (0, 0, None);
        (self.sum, self.count) = (0.0, 0);
    }

    pub fn push(&mut self, residual: f64) {
        self.sum += residual.clamp(-self.wild, self.wild);
        self.count += 1;
        if self.count == self.second {
            self.means[self.next] = self.sum / f64::from(self.count);
            self.next = (self.next + 1) % MEANS;
            self.held = (self.held + 1).min(MEANS);
            let mean = || self.means.iter().sum::<f64>() / MEANS as f64;
            self.mean = (self.held == MEANS).then(mean);
            (self.sum, self.count) = (0.0, 0);
        }
    }

    /// Mean over a minute, m; `None` before there is a minute of evidence.
    pub const fn mean(&self) -> Option<f64> {
        self.mean
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const P: &ResidualParameters = &ResidualParameters::DEFAULT;

    #[test]
    fn it_begins_with_a_mean_and_then_follows_slowly() {
        let mut baseline = Baseline::new(P, 0.02, 1e-4);
        for k in 0..250 {
            assert_eq!(baseline.value(), None);
            baseline.follow(if k % 2 == 0 { 1e-3 } else { 3e-3 }, 0.0);
        }
        assert!((baseline.value().unwrap() - 2e-3).abs() < 1e-12);
        // A jump of a metre moves it by three deviations a minute at the most.
        (0..3000).for_each(|_| baseline.follow(1.0, 0.0));
        assert!((baseline.value().unwrap() - 2.3e-3).abs() < 1e-9 && baseline.doubt() == 0.0);
    }

    /// The residual of a place with an uncertainty of 0.2 mm, and an error of that size.
    #[test]
    fn what_is_doubtful_teaches_little_and_leaves_its_doubt() {
        let mut baseline = Baseline::new(P, 0.02, 1e-4);
        let begun = (0..2000).position(|_| {
            baseline.follow(2e-4, 2e-4);
            baseline.value().is_some()
        });
        // Five times as many as of what is known.
        assert!(begun.is_some_and(|samples| (1245..1255).contains(&samples)), "{begun:?}");
        assert!((baseline.doubt() - 2e-4).abs() < 1e-12, "{baseline:?}");
        (0..6000).for_each(|_| baseline.follow(0.0, 0.0));
        assert!(baseline.value().unwrap() < 3e-5 && baseline.doubt() < 3e-5, "{baseline:?}");
        (0..150).for_each(|_| baseline.follow(2e-4, 2e-4));
        assert!(baseline.value().unwrap() < 3e-5, "{baseline:?}");
    }

    #[test]
    fn neither_follows_a_wild_sample() {
        let (mut baseline, mut slow) = (Baseline::new(P, 0.02, 1e-4), Slow::new(P, 0.02));
        for k in 0..3000 {
            let residual = if k % 200 == 100 { 0.5 } else { 0.0 };
            baseline.follow(residual, 0.0);
            slow.push(residual);
            assert!(baseline.value().is_none_or(|value| value < 2e-5), "{k}: {baseline:?}");
        }
        assert!(slow.mean().is_some_and(|mean| mean < 2e-5), "{slow:?}");
    }

    #[test]
    fn a_short_loss_is_none_and_a_set_clock_is_a_long_one() {
        let at = |seconds: f64| Timestamp::from_nanos((seconds * 1e9) as i64);
        let mut loss = Loss::default();
        assert!(!loss.is_long(at(0.0)) && !loss.is_long(at(5.0)), "nobody lost anything");
        for (seconds, expected) in [(5.04, false), (6.04, false), (7.1, true), (3.0, true)] {
            loss.begin();
            assert_eq!(loss.is_long(at(seconds)), expected, "{seconds}");
        }
        assert!(!loss.is_long(at(9.0)), "it was told once");
    }

    #[test]
    fn the_slow_mean_is_that_of_a_minute() {
        let mut slow = Slow::new(P, 0.02);
        (0..3000).for_each(|_| slow.push(1e-3));
        (0..2999).for_each(|k| slow.push(1e-7 * f64::from(k)));
        let expected = (1e-3 * 50.0 + 1e-7 * (0..2950).sum::<i32>() as f64) / 3000.0;
        assert!(slow.mean().is_some_and(|mean| (mean - expected).abs() < 1e-15));
        slow.reset();
        assert_eq!(slow.mean(), None);
    }
}
