//! Readings by day: the dwells of a day share the same weather and are one reading.

use super::parameters::StopParameters;
use crate::sequential::dwell::StopReadings;
use alloc::vec::Vec;

/// Readings of one cylinder on a day.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Day {
    /// Number of the day since 1970.
    pub number: i64,
    /// Time, years since 1970.
    pub at: f64,
    /// Means of the readings, m.
    pub readings: StopReadings,
    /// Number of dwells.
    pub dwells: u32,
}

/// Puts another reading, of `dwells` dwells, to those of its day.
pub(in crate::sequential) fn put(days: &mut Vec<Day>, day: Day) {
    let same = |last: &Day| {
        let apart = last.readings.apart().zip(day.readings.apart());
        // What a single transducer has moved by within a day may as well be the rod, or the weather.
        apart.is_none_or(|(last, new)| (last - new).abs() <= StopParameters::DEFAULT.same_day)
    };
    match days.last_mut() {
        Some(last) if last.number == day.number && same(last) => {
            let whole = f64::from(last.dwells) + f64::from(day.dwells);
            let share = f64::from(day.dwells) / whole;
            last.at += share * (day.at - last.at);
            last.readings = last.readings.mixed(day.readings, share);
            last.dwells = last.dwells.saturating_add(day.dwells);
        }
        _ => days.push(day),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::vec;

    /// A reading of `dwells` dwells on day 3; C2 reads 2 m.
    fn read(hour: f64, c1: f64, dwells: u32) -> Day {
        Day { number: 3, at: hour, readings: StopReadings::both([c1, 2.0]), dwells }
    }

    #[test]
    fn dwells_of_a_day_are_one_reading_by_their_number() {
        let mut days = Vec::new();
        put(&mut days, read(0.1, 1.0, 1));
        put(&mut days, read(0.5, 1.0004, 3));
        let [day] = days[..] else { panic!("one day: {days:?}") };
        assert!((day.at - 0.4).abs() < 1e-12, "{day:?}");
        assert!((day.readings.c1 - 1.0003).abs() < 1e-12, "{day:?}");
        assert_eq!((day.number, day.readings.c2, day.dwells), (3, Some(2.0), 4));
        put(&mut days, Day { number: 4, ..day });
        assert_eq!(days.len(), 2, "another day is another reading");
    }

    /// A transducer that was adjusted between two dwells of a day reads two things on it.
    #[test]
    fn dwells_that_came_apart_within_a_day_are_two_readings() {
        for (moved, readings) in [(4e-4, 1), (6e-4, 2), (-4e-4, 1), (-6e-4, 2)] {
            let mut days = Vec::new();
            put(&mut days, read(0.1, 1.0, 1));
            put(&mut days, read(0.5, 1.0 + moved, 1));
            assert_eq!(days.len(), readings, "{moved}");
        }
        // What both have moved by is the rod.
        let mut days = vec![read(0.1, 1.0, 1)];
        let both = StopReadings::both([1.01, 2.01]);
        put(&mut days, Day { readings: both, ..read(0.5, 0.0, 1) });
        assert_eq!(days.len(), 1);
        // So may be what a single one has moved by.
        let mut days = Vec::new();
        for c1 in [1.0, 1.01] {
            put(&mut days, Day { readings: StopReadings::single(c1), ..read(0.5, 0.0, 1) });
        }
        assert_eq!(days.len(), 1);
    }
}
