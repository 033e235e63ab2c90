//! How often something happens in a year of one machine.

use super::interval::{CONFIDENCE, poisson_upper};
use serde::Serialize;
use tertius_learn::extremes::HOURS_PER_YEAR;

/// Events in some hours of one machine, all its cylinders together.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Rate {
    pub events: u64,
    /// Events in a year of monitored time.
    pub per_year: f64,
    /// Upper bound of `per_year` with [`CONFIDENCE`]; the rule of three where no event was seen.
    pub at_most: f64,
}

impl Rate {
    /// The rate of `events` in `hours`; not a number where `hours` is 0.
    pub fn new(events: u64, hours: f64) -> Self {
        let yearly = |events: f64| events / hours * HOURS_PER_YEAR;
        Self {
            events,
            per_year: yearly(events as f64),
            at_most: yearly(poisson_upper(events, CONFIDENCE)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_in_three_years_is_at_most_one_a_year() {
        let rate = Rate::new(0, 3.0 * HOURS_PER_YEAR);
        assert_eq!((rate.events, rate.per_year), (0, 0.0));
        assert!((rate.at_most - 0.998_577_4).abs() < 1e-6, "{}", rate.at_most);
    }
}
