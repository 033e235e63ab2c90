//! The machine's temperature, which all transducers show more or less alike, from the other
//! cylinders.

use super::days::Day;
use super::parameters::StopParameters;
use crate::sequential::dwell::StopReadings;
use alloc::collections::BTreeMap;
use alloc::vec::Vec;

const P: &StopParameters = &StopParameters::DEFAULT;

/// Rounds in which what is common and where each transducer begins are found in turn.
const ROUNDS: usize = 2;

/// Common part on each day, m; `None` where too few cylinders were ever read on the same days.
#[derive(Clone, Debug, Default)]
pub(super) struct Thermometer {
    common: BTreeMap<i64, f64>,
}

impl Thermometer {
    pub fn of(cylinders: &[Vec<Day>]) -> Option<Self> {
        let mut read: BTreeMap<i64, usize> = BTreeMap::new();
        for days in cylinders {
            let mut last = None;
            for day in days {
                if last.replace(day.number) != Some(day.number) {
                    *read.entry(day.number).or_default() += 1;
                }
            }
        }
        read.retain(|_, count| *count >= P.cylinders);
        if read.len() < P.first_days.min(cylinders.iter().map(Vec::len).max().unwrap_or(0)) {
            return None;
        }
        let first = |days: &Vec<Day>| {
            let first = days.iter().take(P.first_days).map(|day| day.readings);
            medians(&first.collect::<Vec<_>>())
        };
        let mut begins: Vec<Option<StopReadings>> = cylinders.iter().map(first).collect();
        for _ in 0..ROUNDS {
            let common = common_to(cylinders, &begins, &read);
            begins = cylinders
                .iter()
                .zip(&begins)
                .map(|(days, old)| begin(days, &common, *old))
                .collect();
        }
        Some(Self { common: common_to(cylinders, &begins, &read) })
    }

    /// Common part on the day of that number, m; `None` where too few were read.
    pub fn on(&self, number: i64) -> Option<f64> {
        self.common.get(&number).copied()
    }
}

fn common_to(
    cylinders: &[Vec<Day>],
    begins: &[Option<StopReadings>],
    read: &BTreeMap<i64, usize>,
) -> BTreeMap<i64, f64> {
    let mut on: BTreeMap<i64, Vec<f64>> = BTreeMap::new();
    for (days, begin) in cylinders.iter().zip(begins) {
        let Some(begin) = *begin else { continue };
        for day in days.iter().filter(|day| read.contains_key(&day.number)) {
            let since = day.readings.with(begin, |reading, begin| reading - begin);
            on.entry(day.number).or_default().extend(since.each().into_iter().flatten());
        }
    }
    on.into_iter().map(|(number, mut values)| (number, median(&mut values))).collect()
}

fn begin(
    days: &[Day],
    common: &BTreeMap<i64, f64>,
    old: Option<StopReadings>,
) -> Option<StopReadings> {
    let less = |day: &Day| Some(day.readings.less(*common.get(&day.number)?));
    medians(&days.iter().filter_map(less).collect::<Vec<_>>()).or(old)
}

/// The medians of C1 and of C2; `None` without readings.
fn medians(readings: &[StopReadings]) -> Option<StopReadings> {
    let of = |which: usize| {
        let values: Option<Vec<f64>> = readings.iter().map(|it| it.each()[which]).collect();
        values.map(|mut values| median(&mut values))
    };
    readings.first()?;
    Some(StopReadings { c1: of(0)?, c2: of(1) })
}

/// The median; 0 without values.
pub(super) fn median(values: &mut [f64]) -> f64 {
    values.sort_unstable_by(f64::total_cmp);
    match values.len() {
        0 => 0.0,
        n if n % 2 == 1 => values[n / 2],
        n => 0.5 * (values[n / 2 - 1] + values[n / 2]),
    }
}
