//! Dwells: where the rods stand on their mechanical stop, a transducer's reading repeats from dwell
//! to dwell, and the one that moved is the one that drifted.

use super::stops::StopParameters;
use crate::state::{state, whole};
use crate::time::{Span, Timestamp};

/// Fewer are no history.
pub const LEAST_DWELLS: usize = 3;

const P: &StopParameters = &StopParameters::DEFAULT;

/// What C1 reads on the stop, and C2 where the cylinder has one, m; or by how much they have moved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StopReadings {
    pub c1: f64,
    pub c2: Option<f64>,
}

whole! { StopReadings { c1, c2 } }

impl StopReadings {
    /// Readings of a cylinder with two transducers.
    pub const fn both([c1, c2]: [f64; 2]) -> Self {
        Self { c1, c2: Some(c2) }
    }

    /// The reading of the only transducer.
    pub const fn single(c1: f64) -> Self {
        Self { c1, c2: None }
    }

    /// Those of C1 and C2.
    pub const fn each(self) -> [Option<f64>; 2] {
        [Some(self.c1), self.c2]
    }

    /// C1 − C2; `None` where there is no C2.
    pub fn apart(self) -> Option<f64> {
        self.c2.map(|c2| self.c1 - c2)
    }

    /// The mean of both, or what C1 alone reads.
    pub fn mean(self) -> f64 {
        self.c2.map_or(self.c1, |c2| 0.5 * (self.c1 + c2))
    }

    /// These and `other` in one, by what `one` makes of two readings of a transducer.
    pub(super) fn with(self, other: Self, one: impl Fn(f64, f64) -> f64) -> Self {
        let c2 = self.c2.zip(other.c2).map(|(c2, other)| one(c2, other));
        Self { c1: one(self.c1, other.c1), c2 }
    }

    /// These less what is `common` to both.
    pub(super) fn less(self, common: f64) -> Self {
        self.with(self, |reading, _| reading - common)
    }

    /// The mix of these and a `share` of `new`.
    pub(super) fn mixed(self, new: Self, share: f64) -> Self {
        self.with(new, |old, new| old + share * (new - old))
    }

    /// Whether none of them is further than `far` from that of `other`.
    fn is_near(self, other: Self, far: f64) -> bool {
        let apart = self.with(other, |one, other| (one - other).abs());
        apart.each().into_iter().flatten().all(|it| it <= far)
    }
}

/// Readings of one dwell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dwell {
    /// Time of the readings.
    pub at: Timestamp,
    /// Means of the readings, m.
    pub readings: StopReadings,
}

whole! { Dwell { at, readings } }

/// Waits for a rod to rest on its stop, and reads it once each time.
#[derive(Clone, Debug)]
pub struct Dwelling {
    rest: Span,
    /// Time since which the readings have stayed near the first of them, and these, m.
    since: Option<(Timestamp, StopReadings)>,
    sums: StopReadings,
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
            sums: StopReadings::single(0.0),
            count: 0,
            read: false,
        }
    }
}

impl Dwelling {
    /// Takes that the platform is in no state in which the rods stand on their stops.
    #[inline]
    pub fn leave(&mut self) {
        // Nearly always there is nothing to forget.
        if self.since.is_some() {
            *self = Self::default();
        }
    }

    /// Takes the readings of a cycle in a state in which the rods stand on their stops, `None` where one is missing.
    /// Returns each dwell once.
    pub fn step(&mut self, at: Timestamp, readings: Option<StopReadings>) -> Option<Dwell> {
        let readings = readings?;
        let since = match self.since.filter(|(_, first)| readings.is_near(*first, P.still)) {
            Some((since, _)) => since,
            None => {
                self.since = Some((at, readings));
                (self.sums, self.count) = (readings.with(readings, |_, _| 0.0), 0);
                at
            }
        };
        if self.read {
            return None;
        }
        self.sums = self.sums.with(readings, |sum, reading| sum + reading);
        self.count += 1;
        if at.since(since) < self.rest {
            return None;
        }
        self.read = true;
        let count = f64::from(self.count);
        Some(Dwell { at, readings: self.sums.with(self.sums, |sum, _| sum / count) })
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
            let readings = StopReadings::both([length, length + 2e-3]);
            dwells.extend(dwelling.step(at(k), Some(readings)));
        }
        let [dwell] = dwells[..] else { panic!("{dwells:?}") };
        assert!((249..252).contains(&(dwell.at.as_nanos() / 20_000_000)), "{dwell:?}");
        let StopReadings { c1, c2: Some(c2) } = dwell.readings else { panic!("{dwell:?}") };
        assert!((c1 + 1.4).abs() < 2e-5 && (c2 + 1.398).abs() < 2e-5, "{dwell:?}");
        // After another state it is another dwell.
        dwelling.leave();
        let stands = Some(StopReadings::both([-1.4; 2]));
        let again = (1001..1300).filter_map(|k| dwelling.step(at(k), stands));
        assert_eq!(again.count(), 1);
    }

    #[test]
    fn the_only_transducer_is_read_by_itself() {
        let mut dwelling = Dwelling::default();
        let length = |k: i64| -1.4 + 1e-4 * f64::from(u8::from(k % 2 == 0));
        let step = |k| dwelling.step(at(k), Some(StopReadings::single(length(k))));
        let dwells: Vec<Dwell> = (0..1000).filter_map(step).collect();
        let [Dwell { readings, .. }] = dwells[..] else { panic!("{dwells:?}") };
        assert!((readings.c1 + 1.39995).abs() < 1e-6 && readings.c2.is_none(), "{readings:?}");
    }

    #[test]
    fn a_rod_that_moves_is_not_at_its_stop() {
        moves(|length| [length, -1.4]);
        moves(|length| [-1.4, length]);
    }

    fn moves(readings: impl Fn(f64) -> [f64; 2]) {
        let mut dwelling = Dwelling::default();
        for k in 0..2000 {
            let length = 0.2 * (k as f64 * 0.01).sin();
            let readings = StopReadings::both(readings(length));
            assert_eq!(dwelling.step(at(k), Some(readings)), None, "{k}");
        }
    }
}
