//! How soon a limit is reached at the present rate: C1 − C2 at which the machine trips, or a supply that no longer carries
//! the load.

use super::Level;
use super::level::Levels;
use crate::state::{choice, state};
use crate::time;

/// What tells that a value runs towards its limit.
#[derive(Clone, Debug, PartialEq)]
pub struct ApproachParameters {
    /// Time over which values are averaged, s, above 0: less than a wave's tenth, so that 16 of them are a wave.
    pub block: f64,
    /// Part of the values' variance that a straight line has to explain, 0 to 1: of a step it explains three quarters at
    /// the most, of a wave less, of a steady drift nearly all.
    pub explained: f64,
}

impl ApproachParameters {
    pub const DEFAULT: Self = Self { block: 0.5, explained: 0.9 };
}

/// Blocks that are looked at: 8 s of them, the period of a long wave.
const BLOCKS: usize = 16;

/// How soon.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Urgency {
    /// Not soon, or nobody knows.
    #[default]
    None,
    /// Within [`Deadlines::soon`].
    Soon,
    /// Within [`Deadlines::at_once`].
    AtOnce,
}

choice! { Urgency { None, Soon, AtOnce } }

impl Urgency {
    /// Its level.
    pub const fn level(self, levels: &Levels) -> Level {
        match self {
            Self::None => Level::None,
            Self::Soon => levels.soon,
            Self::AtOnce => levels.at_once,
        }
    }
}

/// Times to a limit at which an alarm is of another level (Table 2-1), s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Deadlines {
    /// Orange: there is time to finish the operation.
    pub soon: f64,
    /// Red: there is time to shut down.
    pub at_once: f64,
}

impl Default for Deadlines {
    fn default() -> Self {
        Self { soon: 60.0, at_once: 5.0 }
    }
}

impl Deadlines {
    fn urgency(&self, left: Option<f64>) -> Urgency {
        match left {
            Some(left) if left < self.at_once => Urgency::AtOnce,
            Some(left) if left < self.soon => Urgency::Soon,
            _ => Urgency::None,
        }
    }
}

/// Follows a value that may run towards a limit.
#[derive(Clone, Debug)]
pub struct Approach {
    deadlines: Deadlines,
    /// Samples of a block, and its time, s.
    samples: u32,
    seconds: f64,
    sum: f64,
    count: u32,
    /// The newest means, of which the last one is the newest.
    means: [f64; BLOCKS],
    held: u32,
    urgency: Urgency,
    /// Blocks since it was so urgent.
    calm: u32,
}

state! {
    Approach { sum, count, means, held, urgency, calm }
    but { deadlines, samples, seconds }
    sound |it| it.count < it.samples
}

impl Approach {
    /// Of a value that is sampled every `sample_time`, s.
    pub fn new(deadlines: Deadlines, sample_time: f64) -> Self {
        let samples = time::cycles(ApproachParameters::DEFAULT.block, sample_time).max(1);
        Self {
            deadlines,
            samples,
            seconds: f64::from(samples) * sample_time,
            sum: 0.0,
            count: 0,
            means: [0.0; BLOCKS],
            held: 0,
            urgency: Urgency::None,
            calm: 0,
        }
    }

    /// How soon the limit is reached. It is less urgent only once it was for as long as is looked back.
    pub const fn urgency(&self) -> Urgency {
        self.urgency
    }

    /// Forgets the values, after a time of which nothing is known; what was urgent is so until more is known.
    pub fn interrupt(&mut self) {
        (self.sum, self.count, self.held) = (0.0, 0, 0);
    }

    /// Takes a value that is `limit` at most, and at least its negative; returns whether the urgency is another one now.
    #[inline]
    pub fn push(&mut self, value: f64, limit: f64) -> bool {
        self.sum += value;
        self.count += 1;
        self.count >= self.samples && self.close(limit)
    }

    #[cold]
    fn close(&mut self, limit: f64) -> bool {
        let mean = self.sum / f64::from(self.samples);
        (self.sum, self.count) = (0.0, 0);
        if !mean.is_finite() {
            self.held = 0;
            return false;
        }
        self.means.rotate_left(1);
        self.means[BLOCKS - 1] = mean;
        self.held = self.held.saturating_add(1).min(BLOCKS as u32);
        let urgency = self.deadlines.urgency(self.left(limit));
        let before = self.urgency;
        self.calm = if urgency >= before { 0 } else { self.calm.saturating_add(1) };
        if urgency > before || self.calm >= BLOCKS as u32 {
            (self.urgency, self.calm) = (urgency, 0);
        }
        self.urgency != before
    }

    /// Time until the value is at ± `limit`, s; `None` where it does not run there in a straight line.
    fn left(&self, limit: f64) -> Option<f64> {
        if (self.held as usize) < BLOCKS {
            return None;
        }
        let count = BLOCKS as f64;
        let mean = self.means.iter().sum::<f64>() / count;
        let (mut mixed, mut squares, mut times) = (0.0, 0.0, 0.0);
        for (i, value) in self.means.iter().enumerate() {
            let (t, beside) = (i as f64 - 0.5 * (count - 1.0), value - mean);
            mixed += t * beside;
            squares += beside * beside;
            times += t * t;
        }
        let slope = mixed / times;
        let now = mean + 0.5 * count * slope;
        let is_line = slope * mixed >= ApproachParameters::DEFAULT.explained * squares;
        let runs_away = slope * now > 0.0;
        let blocks = (limit - now.abs()).max(0.0) / slope.abs();
        (is_line && runs_away).then_some(blocks * self.seconds)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CYCLE: f64 = 0.02;

    /// When a difference of this course, mm at a time in s, becomes urgent up to 50 mm.
    fn told(course: impl Fn(f64) -> f64, seconds: f64) -> Vec<(f64, Urgency)> {
        let (mut approach, mut told) = (Approach::new(Deadlines::default(), CYCLE), Vec::new());
        for k in 0..(seconds / CYCLE) as u32 {
            let t = CYCLE * f64::from(k);
            if approach.push(course(t), 50.0) {
                told.push((t, approach.urgency()));
            }
        }
        told
    }

    /// 0.5 mm/s: at 20 mm it is a minute to the trip, at 47.5 mm five seconds.
    #[test]
    fn a_drift_is_urgent_by_the_time_that_is_left() {
        for sign in [1.0, -1.0] {
            let noise = |t: f64| 0.1 * libm::sin(700.0 * t);
            let told = told(|t| sign * 0.5 * t + noise(t), 100.0);
            let [(soon, Urgency::Soon), (at_once, Urgency::AtOnce)] = told[..] else {
                panic!("{told:?}")
            };
            assert!((39.0..42.0).contains(&soon) && (95.0..96.0).contains(&at_once), "{told:?}");
        }
    }

    #[test]
    fn what_stands_swings_or_steps_runs_nowhere_and_what_comes_back_is_no_longer_urgent() {
        let wave =
            |period: f64| move |t: f64| 20.0 * libm::sin(core::f64::consts::TAU / period * t);
        assert_eq!(told(|_| 49.0, 60.0), []);
        assert_eq!(told(|t| if t < 20.0 { 0.0 } else { 40.0 }, 60.0), []);
        for period in [4.0, 6.0, 8.0, 10.0] {
            assert_eq!(told(wave(period), 120.0), [], "{period}");
        }
        let back = told(|t| if t < 30.0 { t } else { 0.0 }, 60.0);
        assert!(
            matches!(back[..], [(_, Urgency::Soon), (t, Urgency::None)] if t > 37.0),
            "{back:?}"
        );
    }
}
