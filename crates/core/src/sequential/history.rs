//! History of the dwells of one cylinder.

use super::dwell::{Dwell, LEAST_DWELLS};
use super::stops::{Day, StopParameters};
use super::trend::Trend;
use crate::state::whole;
use crate::time::{Span, Timestamp};
use alloc::vec::Vec;
use thiserror::Error;

/// Dwells, or means of dwells, that are kept: beyond that older ones are put together, so that the span
/// of time stays.
pub const MOST_DWELLS: usize = 128;

/// A history that was kept by an earlier version may have so many.
pub const MOST_READ: usize = 512;

const P: &StopParameters = &StopParameters::DEFAULT;

/// No cylinder is as long as this, m.
const LONGEST: f64 = 1000.0;

const DAY: i64 = 86_400_000_000_000;

/// Seconds of a mean year.
const YEAR: f64 = 365.25 * 86_400.0;

/// Gauging of a cylinder's readings while its dwells were read.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Gauging {
    /// Resolution of the readings, m; 0 where not known, or finer than their noise.
    pub count: f64,
    /// Calibration a, dimensionless, and b, m, of (5-20); `None` where not known.
    pub corrected: Option<[f64; 2]>,
}

whole! { Gauging { count, corrected } }

/// Dwells in the order of time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DwellHistory {
    dwells: Vec<Dwell>,
    /// Number of dwells of which each is the mean.
    counts: Vec<u32>,
    gauging: Gauging,
}

whole! {
    DwellHistory { dwells, counts, gauging }
    sound |it| it.flaw().is_none()
}

/// Why dwells are not a valid history.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum Flaw {
    #[error("at most {MOST_READ} dwells")]
    TooMany,
    #[error("each the mean of one dwell at least")]
    Count,
    #[error("readings within {LONGEST} m")]
    Reading,
    #[error("readings of C2 in all of them, or in none")]
    Kind,
    #[error("each dwell later than the one before")]
    Order,
    #[error("a count and a calibration that are numbers")]
    Gauging,
}

impl DwellHistory {
    pub fn dwells(&self) -> &[Dwell] {
        &self.dwells
    }

    /// Number of dwells of which each of [`Self::dwells`] is the mean.
    pub fn counts(&self) -> &[u32] {
        &self.counts
    }

    pub const fn gauging(&self) -> &Gauging {
        &self.gauging
    }

    /// The history of `dwells`, each the mean of `counts`, as it was kept.
    ///
    /// # Errors
    /// The dwells are not a valid history.
    pub fn restore(dwells: Vec<Dwell>, counts: Vec<u32>, gauging: Gauging) -> Result<Self, Flaw> {
        let mut history = Self { dwells, counts, gauging };
        if let Some(flaw) = history.flaw() {
            return Err(flaw);
        }
        history.shorten();
        Ok(history)
    }

    /// Why this is not a valid history.
    fn flaw(&self) -> Option<Flaw> {
        let Self { dwells, counts, gauging: Gauging { count, corrected } } = self;
        let sound = count.is_finite() && *count >= 0.0;
        if dwells.len() > MOST_READ {
            Some(Flaw::TooMany)
        } else if counts.len() != dwells.len() || counts.contains(&0) {
            Some(Flaw::Count)
        } else if !dwells.iter().all(is_sound) {
            Some(Flaw::Reading)
        } else if !dwells.windows(2).all(|pair| is_alike(&pair[0], &pair[1])) {
            Some(Flaw::Kind)
        } else if !dwells.is_sorted_by(|one, next| one.at < next.at) {
            Some(Flaw::Order)
        } else if !sound || !corrected.iter().flatten().all(|number| number.is_finite()) {
            Some(Flaw::Gauging)
        } else {
            None
        }
    }

    /// Sets the `gauging` of further readings. If C2 is corrected differently than before, a
    /// transducer was replaced or adjusted, and the earlier dwells cannot be compared.
    pub fn gauge(&mut self, gauging: Gauging) {
        let newest = self.dwells.last().and_then(|newest| newest.readings.c2);
        if let Some((c2, (before, now))) = newest.zip(self.gauging.corrected.zip(gauging.corrected))
        {
            let corrected = |[gain, offset]: [f64; 2]| gain * c2 + offset;
            if (corrected(before) - corrected(now)).abs() > P.adjusted {
                *self = Self::default();
            }
        }
        self.gauging = gauging;
    }

    /// Takes that the cylinder has C1 alone: what it read beside a C2 stays comparable.
    pub fn keep_c1(&mut self) {
        self.dwells.iter_mut().for_each(|dwell| dwell.readings.c2 = None);
        self.gauging.corrected = None;
    }

    /// Takes a dwell, and returns whether it is a new one: the same one again is not kept. One that
    /// is older than the earlier dwells, or that comes years later, means that the clock was set:
    /// the earlier dwells are then moved to where they may have been by the new clock.
    pub fn add(&mut self, dwell: Dwell) -> bool {
        if !is_sound(&dwell) || self.knows(dwell.at) {
            return false;
        }
        if self.dwells.last().is_some_and(|newest| !is_alike(newest, &dwell)) {
            // C2 was fitted since: what C1 read without it tells nothing of their difference.
            (self.dwells, self.counts) = Default::default();
        }
        if !self.follow_clock(dwell.at) {
            return false;
        }
        self.dwells.push(dwell);
        self.counts.push(1);
        self.shorten();
        true
    }

    /// Whether the same dwell was read before, or it falls into a time of which only means are
    /// kept.
    fn knows(&self, at: Timestamp) -> bool {
        let place = self.dwells.partition_point(|dwell| dwell.at < at);
        let Some(next) = self.dwells.get(place) else { return false };
        let mean = |i: usize| self.counts[i] > 1;
        match place.checked_sub(1) {
            _ if next.at == at => true,
            Some(before) => mean(before) || mean(place),
            None => mean(place) && day(next.at) == day(at),
        }
    }

    /// Moves the earlier dwells to before `at`; returns `false` if there is no room.
    fn follow_clock(&mut self, at: Timestamp) -> bool {
        let Some(newest) = self.dwells.last().map(|dwell| dwell.at) else { return true };
        let usual = self.usual_interval();
        let idle = at.since(newest).as_seconds() > P.idle * YEAR;
        // Those that are later than `at` were stamped by the other clock; after years all were.
        let right = if idle { 0 } else { self.dwells.partition_point(|dwell| dwell.at < at) };
        let (_, wrong) = self.dwells.split_at(right);
        let Some(first) = wrong.first().map(|dwell| dwell.at) else { return true };
        let by = at.since(newest).as_nanos().saturating_sub(usual.as_nanos());
        let move_by = |stamp: Timestamp| stamp.after(Span::from_nanos(by));
        let before = right.checked_sub(1).map(|i| self.dwells[i].at);
        match before.filter(|before| move_by(first) <= *before) {
            None => self.dwells[right..].iter_mut().for_each(|it| it.at = move_by(it.at)),
            Some(before) => {
                let step = at.since(before).as_nanos() / (self.dwells.len() - right + 1) as i64;
                if step == 0 {
                    return false;
                }
                for (place, dwell) in (1..).zip(&mut self.dwells[right..]) {
                    dwell.at = before.after(Span::from_nanos(place * step));
                }
            }
        }
        true
    }

    /// Median of the newest intervals; a day where there are none.
    fn usual_interval(&self) -> Span {
        let intervals = self.dwells.windows(2).rev().take(P.intervals);
        let mut intervals: Vec<i64> =
            intervals.map(|pair| pair[1].at.since(pair[0].at).as_nanos()).collect();
        intervals.sort_unstable();
        Span::from_nanos(intervals.get(intervals.len() / 2).copied().unwrap_or(DAY))
    }

    /// Merges surplus dwells: those of one day, the oldest first; where there is one a day left,
    /// pairs of days of the older half, except the first three.
    fn shorten(&mut self) {
        while self.dwells.len() > MOST_DWELLS {
            let same = |pair: &[Dwell]| day(pair[0].at) == day(pair[1].at);
            match self.dwells.windows(2).position(same) {
                Some(place) => self.merge(place),
                None => {
                    let middle = self.dwells.len() / 2;
                    (LEAST_DWELLS..middle - 1).rev().step_by(2).for_each(|place| self.merge(place));
                }
            }
        }
    }

    /// Merges the dwell at `place` with the next one.
    fn merge(&mut self, place: usize) {
        let (next, more) = (self.dwells.remove(place + 1), self.counts.remove(place + 1));
        let count = self.counts[place].saturating_add(more);
        let share = f64::from(more) / f64::from(count);
        let one = &mut self.dwells[place];
        one.at = one.at.after(Span::from_seconds(share * next.at.since(one.at).as_seconds()));
        one.readings = one.readings.mixed(next.readings, share);
        self.counts[place] = count;
    }

    /// Readings of each day.
    pub fn days(&self) -> Vec<Day> {
        let mut days = Vec::with_capacity(self.dwells.len());
        for (dwell, count) in self.dwells.iter().zip(&self.counts) {
            let at = dwell.at.as_nanos() as f64 * 1e-9 / YEAR;
            let (number, readings, dwells) = (day(dwell.at), dwell.readings, *count);
            super::stops::put(&mut days, Day { number, at, readings, dwells });
        }
        days
    }

    /// The trend of C1 (`which` 0) or C2 (1); `None` with fewer than three dwells.
    pub fn trend(&self, which: usize) -> Option<Trend> {
        Trend::through(&self.dwells, which)
    }
}

const fn day(at: Timestamp) -> i64 {
    at.as_nanos().div_euclid(DAY)
}

fn is_sound(dwell: &Dwell) -> bool {
    dwell.readings.each().into_iter().flatten().all(|reading| reading.abs() <= LONGEST)
}

/// Whether both are of the same transducers.
const fn is_alike(one: &Dwell, other: &Dwell) -> bool {
    one.readings.c2.is_some() == other.readings.c2.is_some()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sequential::dwell::StopReadings;

    fn at(day: f64) -> Timestamp {
        Timestamp::from_nanos((day * DAY as f64) as i64)
    }

    fn dwell(day: f64) -> Dwell {
        Dwell { at: at(day), readings: StopReadings::both([1e-3 * day, -1.4]) }
    }

    fn history(days: impl IntoIterator<Item = f64>) -> DwellHistory {
        let mut history = DwellHistory::default();
        days.into_iter().for_each(|day| assert!(history.add(dwell(day)), "{day}"));
        history
    }

    fn stamps(history: &DwellHistory) -> Vec<f64> {
        let days = |dwell: &Dwell| dwell.at.as_nanos() as f64 / DAY as f64;
        history.dwells().iter().map(days).collect()
    }

    #[test]
    fn the_same_dwell_again_is_not_kept() {
        let mut kept = history([10.0, 11.0, 12.0]);
        let before = kept.clone();
        assert!([10.0, 11.0, 12.0].iter().all(|day| !kept.add(dwell(*day))));
        assert!(!kept.add(Dwell { at: at(13.0), readings: StopReadings::both([f64::NAN, 0.0]) }));
        assert_eq!(kept, before);
    }

    #[test]
    fn a_clock_that_was_set_leaves_the_dwells_in_their_order() {
        // Back by a week, to before everything, and to 1970.
        for (set, expected) in [
            (14.5, vec![10.0, 11.5, 13.0, 14.5]),
            (9.0, vec![-17.0, -9.0, 0.0, 9.0]),
            (0.0, vec![-26.0, -18.0, -9.0, 0.0]),
        ] {
            let mut kept = history([10.0, 18.0, 27.0]);
            assert!(kept.add(dwell(set)), "{set}");
            assert_eq!(stamps(&kept), expected, "{set}");
        }
        // From 1970 to now, which is no idle time.
        let mut kept = history([0.0, 8.0, 17.0]);
        assert!(kept.add(dwell(20_000.0)));
        assert_eq!(stamps(&kept), [19_974.0, 19_982.0, 19_991.0, 20_000.0]);
        // Half a year of it is.
        let mut kept = history([0.0, 8.0, 17.0]);
        assert!(kept.add(dwell(200.0)));
        assert_eq!(stamps(&kept), [0.0, 8.0, 17.0, 200.0]);
    }

    #[test]
    fn another_calibration_of_c2_begins_a_new_history() {
        let gauging = |offset| Gauging { count: 1e-4, corrected: Some([1.0, offset]) };
        let mut kept = history([1.0, 2.0, 3.0]);
        kept.gauge(gauging(2e-3));
        kept.gauge(gauging(2.4e-3));
        assert_eq!(kept.dwells().len(), 3, "it was told better");
        kept.gauge(gauging(3e-3));
        assert_eq!((kept.dwells(), kept.gauging()), (&[][..], &gauging(3e-3)));
    }

    #[test]
    fn a_c2_that_is_taken_off_leaves_c1_its_history_and_one_that_is_fitted_begins_anew() {
        let mut kept = history([1.0, 2.0]);
        kept.gauge(Gauging { count: 1e-4, corrected: Some([1.0, 2e-3]) });
        kept.keep_c1();
        let single = |day: f64| Dwell { at: at(day), readings: StopReadings::single(1e-3 * day) };
        assert_eq!(kept.dwells(), [single(1.0), single(2.0)]);
        assert_eq!(kept.gauging(), &Gauging { count: 1e-4, corrected: None });
        assert!(kept.add(single(3.0)));
        assert_eq!(kept.dwells().len(), 3);
        assert!(kept.add(dwell(4.0)));
        assert_eq!((kept.dwells(), kept.counts()), (&[dwell(4.0)][..], &[1][..]));
    }

    #[test]
    fn what_is_no_history_is_not_restored() {
        let dwells = |count: usize| (0..count).map(|k| dwell(k as f64)).collect::<Vec<_>>();
        let kept = history((0..20).map(f64::from));
        let gauging = Gauging::default();
        let again = DwellHistory::restore(kept.dwells().to_vec(), vec![1; 20], gauging);
        assert_eq!(again, Ok(kept));
        let restore = DwellHistory::restore;
        let many = MOST_READ + 1;
        assert_eq!(restore(dwells(many), vec![1; many], gauging), Err(Flaw::TooMany));
        assert_eq!(restore(dwells(2), vec![1, 0], gauging), Err(Flaw::Count));
        assert_eq!(restore(dwells(2), vec![1], gauging), Err(Flaw::Count));
        let wrong = Gauging { count: f64::NAN, corrected: None };
        assert_eq!(restore(dwells(2), vec![1; 2], wrong), Err(Flaw::Gauging));
        for wrong in [f64::NAN, f64::INFINITY, -1e4] {
            let mut dwells = dwells(2);
            dwells[1].readings.c1 = wrong;
            assert_eq!(restore(dwells, vec![1; 2], gauging), Err(Flaw::Reading), "{wrong}");
        }
        let mut twice = dwells(4);
        twice[2].at = twice[1].at;
        assert_eq!(restore(twice, vec![1; 4], gauging), Err(Flaw::Order));
        let mut mixed = dwells(4);
        mixed[3].readings.c2 = None;
        assert_eq!(restore(mixed, vec![1; 4], gauging), Err(Flaw::Kind));
        // As many as an earlier version kept are put together.
        let long = restore(dwells(MOST_READ), vec![1; MOST_READ], gauging).expect("a history");
        assert!(long.dwells().len() <= MOST_DWELLS, "{}", long.dwells().len());
    }

    #[test]
    fn a_history_of_years_keeps_its_beginning_its_end_and_its_means() {
        let kept = history((0..20_000).map(|k| 0.25 * f64::from(k)));
        let dwells = kept.dwells();
        assert!(dwells.len() <= MOST_DWELLS && dwells.len() > MOST_DWELLS / 2, "{}", dwells.len());
        assert_eq!(dwells[dwells.len() - 1].at, at(0.25 * 19_999.0));
        assert!(dwells.is_sorted_by(|one, next| one.at < next.at));
        assert_eq!(kept.counts().iter().sum::<u32>(), 20_000);
        assert_eq!(stamps(&kept)[0].floor(), 0.0);
        // Each reads what it read on the mean of its days.
        for (stamp, dwell) in stamps(&kept).iter().zip(dwells) {
            assert!((dwell.readings.c1 - 1e-3 * stamp).abs() < 1e-9, "{stamp} {dwell:?}");
        }
        // And what is put together is known.
        assert!(!kept.clone().add(dwell(100.0)));
    }
}
