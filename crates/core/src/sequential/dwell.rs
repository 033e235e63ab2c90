//! Dwells: where the rods stand on their mechanical stop, a transducer's reading repeats from dwell
//! to dwell, and the one that moved is the one that drifted.

use super::stops::StopParameters;
use crate::state::{state, whole};
use crate::time::{Span, Timestamp};

const P: &StopParameters = &StopParameters::DEFAULT;

/// Readings of one dwell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dwell {
    /// Time of the readings.
    pub at: Timestamp,
    /// Means of C1 and C2, m.
    pub readings: [f64; 2],
}

whole! { Dwell { at, readings } }

/// Waits for a rod to rest on its stop, and reads it once each time.
#[derive(Clone, Debug)]
pub struct Dwelling {
    rest: Span,
    /// Time since which the readings have stayed near the first of them, and these, m.
    since: Option<(Timestamp, [f64; 2])>,
    sums: [f64; 2],
    count: u32,
    read: bool,
}

state! {
    Dwelling { since, sums, count, read }
    but { rest }
    sound |it| it.count < u32::MAX / 2
}

impl Default for Dwelling {
    fn default() -> Self {
        Self {
            rest: Span::from_seconds(P.rest),
            since: None,
            sums: [0.0; 2],
            count: 0,
            read: false,
        }
    }
}

impl Dwelling {
    /// Takes the readings of a cycle, m; `at_stop`: the platform is in a state in which the rods
    /// stand on their stops. Returns each dwell once.
    #[inline]
    pub fn step(
        &mut self,
        at: Timestamp,
        at_stop: bool,
        lengths: [Option<f64>; 2],
    ) -> Option<Dwell> {
        if !at_stop {
            // Nearly always there is nothing to forget.
            if self.since.is_some() {
                *self = Self::default();
            }
            return None;
        }
        let readings = match lengths {
            [Some(c1), Some(c2)] => [c1, c2],
            _ => return None,
        };
        let near = |first: &[f64; 2]| {
            first.iter().zip(readings).all(|(first, now)| (now - first).abs() <= P.still)
        };
        let since = match self.since.filter(|(_, first)| near(first)) {
            Some((since, _)) => since,
            None => {
                self.since = Some((at, readings));
                (self.sums, self.count) = ([0.0; 2], 0);
                at
            }
        };
        if self.read {
            return None;
        }
        self.sums = [self.sums[0] + readings[0], self.sums[1] + readings[1]];
        self.count += 1;
        if at.since(since) < self.rest {
            return None;
        }
        self.read = true;
        let count = f64::from(self.count);
        Some(Dwell { at, readings: self.sums.map(|sum| sum / count) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(cycle: i64) -> Timestamp {
        Timestamp::from_nanos(cycle * 20_000_000)
    }

    #[test]
    fn a_dwell_is_read_once_when_the_rod_has_come_to_rest() {
        let mut dwelling = Dwelling::default();
        let mut dwells = Vec::new();
        for k in 0..1000 {
            // It comes down until cycle 100.
            let length = -1.4 + 1e-3 * (100 - k).max(0) as f64;
            dwells.extend(dwelling.step(at(k), true, [Some(length), Some(length + 2e-3)]));
        }
        let [dwell] = dwells[..] else { panic!("{dwells:?}") };
        assert!((249..252).contains(&(dwell.at.as_nanos() / 20_000_000)), "{dwell:?}");
        assert!((dwell.readings[0] + 1.4).abs() < 2e-5, "{dwell:?}");
        assert!((dwell.readings[1] + 1.398).abs() < 2e-5, "{dwell:?}");
        // After another state it is another dwell.
        dwelling.step(at(1000), false, [None; 2]);
        let again = (1001..1300).filter_map(|k| dwelling.step(at(k), true, [Some(-1.4); 2]));
        assert_eq!(again.count(), 1);
    }

    #[test]
    fn a_rod_that_moves_is_not_at_its_stop() {
        let mut dwelling = Dwelling::default();
        for k in 0..2000 {
            let length = 0.2 * (k as f64 * 0.01).sin();
            assert_eq!(dwelling.step(at(k), true, [Some(length); 2]), None, "{k}");
        }
    }
}
