//! The dwells of one cylinder so far: which transducer has moved, and where it is going.

use super::dwell::Dwell;
use super::trend::Trend;
use thiserror::Error;

/// Dwells that are kept: beyond that every other of the older half is let go, so that the span of
/// time stays.
pub const MOST: usize = 512;

/// At most so many of the first dwells are what later ones are compared with.
const ANCHORS: usize = 10;

/// Fewer are no history.
pub const LEAST: usize = 3;

/// A reading repeats to no better than this, m.
pub(super) const REPEATABILITY: f64 = 5e-5;

/// No cylinder is as long as this, m.
const LONGEST: f64 = 1000.0;

/// So many deviations are a move.
const DEVIATIONS: f64 = 5.0;

/// What both have moved alike is the stop or the temperature: within this part.
const ALIKE: f64 = 0.5;

/// Dwells in the order of time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DwellHistory {
    dwells: Vec<Dwell>,
    /// So many of the first are anchors: those before anything had moved.
    anchors: usize,
}

/// Why dwells are no history.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum Flaw {
    #[error("at most {MOST} dwells")]
    TooMany,
    #[error("no more anchors than dwells, and at most {ANCHORS}")]
    Anchors,
    #[error("readings within {LONGEST} m")]
    Reading,
    #[error("each dwell later than the one before")]
    Order,
}

/// What a dwell says of the two readings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moved {
    /// By how much each reads more than in its first dwells, m.
    pub by: [f64; 2],
    /// What it takes to have moved, m.
    pub least: [f64; 2],
}

/// Whom a dwell blames.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Blame {
    Neither,
    C1,
    C2,
    /// They have moved, and not alike.
    Both,
    /// They have moved alike: the stop, or the temperature.
    Stop,
}

impl Moved {
    pub fn blame(&self) -> Blame {
        let [one, two] = [0, 1].map(|i| self.by[i].abs() > self.least[i]);
        match (one, two) {
            (false, false) => Blame::Neither,
            (true, false) => Blame::C1,
            (false, true) => Blame::C2,
            (true, true) => {
                let [one, two] = self.by;
                let alike = (one - two).abs() < ALIKE * one.abs().max(two.abs());
                if alike { Blame::Stop } else { Blame::Both }
            }
        }
    }
}

impl DwellHistory {
    pub fn dwells(&self) -> &[Dwell] {
        &self.dwells
    }

    /// How many of the first are anchors.
    pub fn anchor_count(&self) -> usize {
        self.anchors
    }

    /// The history of `dwells`, of which the first `anchors` are anchors, as it was kept.
    ///
    /// # Errors
    /// If no history can be so.
    pub fn restore(dwells: Vec<Dwell>, anchors: usize) -> Result<Self, Flaw> {
        if dwells.len() > MOST {
            Err(Flaw::TooMany)
        } else if anchors > dwells.len().min(ANCHORS) {
            Err(Flaw::Anchors)
        } else if !dwells.iter().all(is_sound) {
            Err(Flaw::Reading)
        } else if !dwells.is_sorted_by(|one, next| one.at < next.at) {
            Err(Flaw::Order)
        } else {
            Ok(Self { dwells, anchors })
        }
    }

    /// Takes a dwell, and says how the readings have moved since the first ones; `None` while there
    /// is no history. A dwell that is not newer than the newest is judged and not kept: the clock
    /// was set back, or it is the same one again.
    pub fn add(&mut self, dwell: Dwell) -> Option<Moved> {
        if !is_sound(&dwell) {
            return None;
        }
        let moved = self.compare(&dwell);
        if self.dwells.last().is_some_and(|newest| newest.at >= dwell.at) {
            return moved;
        }
        let healthy = moved.is_none_or(|moved| moved.blame() == Blame::Neither);
        if healthy && self.anchors == self.dwells.len() && self.anchors < ANCHORS {
            self.anchors += 1;
        }
        self.dwells.push(dwell);
        if self.dwells.len() > MOST {
            self.thin();
        }
        moved
    }

    fn anchors(&self) -> &[Dwell] {
        &self.dwells[..self.anchors]
    }

    fn compare(&self, dwell: &Dwell) -> Option<Moved> {
        let anchors = self.anchors();
        if anchors.len() < LEAST {
            return None;
        }
        let (mut by, mut least) = ([0.0; 2], [0.0; 2]);
        for i in 0..2 {
            let middle = median(anchors.iter().map(|anchor| anchor.readings[i]));
            let spread = median(anchors.iter().map(|anchor| (anchor.readings[i] - middle).abs()));
            by[i] = dwell.readings[i] - middle;
            // Of a normal distribution the median magnitude is 0.6745 deviations.
            least[i] = DEVIATIONS * (spread / 0.6745).max(REPEATABILITY);
        }
        Some(Moved { by, least })
    }

    /// The anchors stay, and the newer half.
    fn thin(&mut self) {
        let middle = self.dwells.len() / 2;
        let mut place = 0;
        self.dwells.retain(|_| {
            place += 1;
            place <= ANCHORS || place > middle || place % 2 == 0
        });
    }

    /// The trend of C1 (`which` 0) or C2 (1); `None` with fewer than three dwells.
    pub fn trend(&self, which: usize) -> Option<Trend> {
        let reference = median(self.anchors().iter().map(|anchor| anchor.readings[which]));
        Trend::through(&self.dwells, which, reference)
    }
}

fn is_sound(dwell: &Dwell) -> bool {
    dwell.readings.iter().all(|reading| reading.abs() <= LONGEST)
}

/// The middle of at most [`ANCHORS`] values.
fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut sorted = [f64::INFINITY; ANCHORS];
    let mut count = 0;
    for (place, value) in sorted.iter_mut().zip(values) {
        *place = value;
        count += 1;
    }
    sorted.sort_unstable_by(f64::total_cmp);
    match count {
        0 => 0.0,
        n if n % 2 == 1 => sorted[n / 2],
        n => 0.5 * (sorted[n / 2 - 1] + sorted[n / 2]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::time::Timestamp;

    fn day(day: f64) -> Timestamp {
        Timestamp::from_nanos((day * 86_400e9) as i64)
    }

    /// Twenty dwells a tenth of a millimetre apart, one a day.
    fn history(drift: impl Fn(f64) -> [f64; 2]) -> DwellHistory {
        let mut history = DwellHistory::default();
        for k in 0..20 {
            let scatter = 1e-4 * (f64::from(k * 7 % 5) / 4.0 - 0.5);
            let [one, two] = drift(f64::from(k));
            let readings = [-1.4 + scatter + one, -1.39 - scatter + two];
            history.add(Dwell { at: day(f64::from(k)), readings });
        }
        history
    }

    fn next(history: &mut DwellHistory, by: [f64; 2]) -> Blame {
        let readings = [-1.4 + by[0], -1.39 + by[1]];
        history.add(Dwell { at: day(30.0), readings }).expect("there is a history").blame()
    }

    #[test]
    fn the_one_that_moved_is_blamed() {
        let healthy = history(|_| [0.0; 2]);
        for (by, blame) in [
            ([1e-4, -1e-4], Blame::Neither),
            ([1e-3, 0.0], Blame::C1),
            ([1e-4, -1e-3], Blame::C2),
            ([1e-3, 1.2e-3], Blame::Stop),
            ([1e-3, -1e-3], Blame::Both),
        ] {
            assert_eq!(next(&mut healthy.clone(), by), blame, "{by:?}");
        }
    }

    #[test]
    fn a_slow_drift_is_not_taken_for_the_new_normal() {
        let mut drifting = history(|day| [5e-5 * day, 0.0]);
        assert_eq!(next(&mut drifting, [1.5e-3, 0.0]), Blame::C1);
        let [one, two] = [0, 1].map(|i| drifting.trend(i).expect("there is a history"));
        let expected = 5e-5 * 30.4375;
        assert!((one.per_month - expected).abs() < 0.05 * expected, "{one:?}");
        assert!(two.per_month.abs() < 3.0 * two.error, "{two:?}");
        let left = one.until(0.05).expect("it goes there");
        assert!((left.expected - (0.05 - one.moved) / expected).abs() < 2.0, "{left:?}");
        assert_eq!(two.until(0.05), None);
    }

    #[test]
    fn without_a_history_nothing_is_said() {
        let mut history = DwellHistory::default();
        for k in 0..3 {
            let dwell = Dwell { at: day(f64::from(k)), readings: [0.0; 2] };
            assert_eq!(history.add(dwell), None);
        }
        assert_eq!(history.dwells().len(), 3);
    }

    #[test]
    fn a_clock_that_was_set_back_hides_no_move() {
        let mut history = history(|_| [0.0; 2]);
        let before = history.clone();
        let old = Dwell { at: day(1.0), readings: [-1.4, -1.389] };
        assert_eq!(history.add(old).map(|moved| moved.blame()), Some(Blame::C2));
        assert_eq!(history, before, "it is not kept");
    }

    #[test]
    fn what_is_no_history_is_not_restored() {
        let dwells = |readings: &[f64]| {
            let dwell = |(k, reading): (usize, &f64)| Dwell {
                at: day(k as f64),
                readings: [*reading, -*reading],
            };
            readings.iter().enumerate().map(dwell).collect::<Vec<_>>()
        };
        let kept = history(|_| [0.0; 2]);
        let again = DwellHistory::restore(kept.dwells().to_vec(), kept.anchor_count());
        assert_eq!(again, Ok(kept));
        let restore = DwellHistory::restore;
        assert_eq!(restore(dwells(&[1.0; MOST + 1]), 3), Err(Flaw::TooMany));
        assert_eq!(restore(dwells(&[1.0; 2]), 3), Err(Flaw::Anchors));
        assert_eq!(restore(dwells(&[1.0; 20]), ANCHORS + 1), Err(Flaw::Anchors));
        for wrong in [f64::NAN, f64::INFINITY, -1e4] {
            assert_eq!(restore(dwells(&[1.0, wrong]), 1), Err(Flaw::Reading), "{wrong}");
        }
        let mut twice = dwells(&[1.0; 4]);
        twice[2].at = twice[1].at;
        assert_eq!(restore(twice, 3), Err(Flaw::Order));
    }

    #[test]
    fn a_history_of_years_keeps_its_beginning_and_its_end() {
        let mut history = DwellHistory::default();
        for k in 0..20_000 {
            history.add(Dwell { at: day(f64::from(k)), readings: [1e-3 * f64::from(k), 0.0] });
        }
        let dwells = history.dwells();
        assert!(dwells.len() <= MOST && dwells.len() > MOST / 2, "{}", dwells.len());
        assert_eq!(dwells[..3].iter().map(|d| d.at).collect::<Vec<_>>(), [0.0, 1.0, 2.0].map(day));
        assert_eq!(dwells[dwells.len() - 1].at, day(19_999.0));
        assert!(dwells.is_sorted_by_key(|dwell| dwell.at));
    }
}
