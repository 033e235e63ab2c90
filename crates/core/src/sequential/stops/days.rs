//! Readings by day: the dwells of a day share the same weather and are one reading.

use super::StopParameters;
use alloc::vec::Vec;

/// Readings of one cylinder on a day.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Day {
    /// Number of the day since 1970.
    pub number: i64,
    /// Time, years since 1970.
    pub at: f64,
    /// Means of C1 and C2, m.
    pub readings: [f64; 2],
    /// Number of dwells.
    pub dwells: u32,
}

/// Puts another reading, of `dwells` dwells, to those of its day.
pub(in crate::sequential) fn put(days: &mut Vec<Day>, day: Day) {
    let apart = |day: &Day| day.readings[0] - day.readings[1];
    let same = StopParameters::DEFAULT.same_day;
    match days.last_mut() {
        Some(last) if last.number == day.number && (apart(last) - apart(&day)).abs() <= same => {
            let whole = f64::from(last.dwells) + f64::from(day.dwells);
            let share = f64::from(day.dwells) / whole;
            let mix = |old: f64, new: f64| old + share * (new - old);
            last.at = mix(last.at, day.at);
            last.readings = [0, 1].map(|i| mix(last.readings[i], day.readings[i]));
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
        Day { number: 3, at: hour, readings: [c1, 2.0], dwells }
    }

    #[test]
    fn dwells_of_a_day_are_one_reading_by_their_number() {
        let mut days = Vec::new();
        put(&mut days, read(0.1, 1.0, 1));
        put(&mut days, read(0.5, 1.0004, 3));
        let [day] = days[..] else { panic!("one day: {days:?}") };
        assert!((day.at - 0.4).abs() < 1e-12, "{day:?}");
        assert!((day.readings[0] - 1.0003).abs() < 1e-12, "{day:?}");
        assert_eq!((day.number, day.readings[1], day.dwells), (3, 2.0, 4));
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
        put(&mut days, Day { readings: [1.01, 2.01], ..read(0.5, 0.0, 1) });
        assert_eq!(days.len(), 1);
    }
}
