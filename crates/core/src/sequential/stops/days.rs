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
