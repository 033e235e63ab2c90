//! The machine's temperature, which all transducers show more or less alike, from the other
//! cylinders.

use super::StopParameters;
use super::days::Day;
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
            [0, 1].map(|which| {
                let first = days.iter().take(P.first_days).map(|day| day.readings[which]);
                median(&mut first.collect::<Vec<_>>())
            })
        };
        let mut begins: Vec<[f64; 2]> = cylinders.iter().map(first).collect();
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
    begins: &[[f64; 2]],
    read: &BTreeMap<i64, usize>,
) -> BTreeMap<i64, f64> {
    let mut on: BTreeMap<i64, Vec<f64>> = BTreeMap::new();
    for (days, begin) in cylinders.iter().zip(begins) {
        for day in days.iter().filter(|day| read.contains_key(&day.number)) {
            let values = on.entry(day.number).or_default();
            values.extend([0, 1].map(|which| day.readings[which] - begin[which]));
        }
    }
    on.into_iter().map(|(number, mut values)| (number, median(&mut values))).collect()
}

fn begin(days: &[Day], common: &BTreeMap<i64, f64>, old: [f64; 2]) -> [f64; 2] {
    [0, 1].map(|which| {
        let less = |day: &Day| Some(day.readings[which] - common.get(&day.number)?);
        let mut values: Vec<f64> = days.iter().filter_map(less).collect();
        if values.is_empty() { old[which] } else { median(&mut values) }
    })
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
