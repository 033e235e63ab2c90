//! What the mechanical stops are read and judged by.

const MILLIMETRE: f64 = 1e-3;

/// The numbers by which the stops of a machine tell a drift. Times are those of the calendar, and no cycle
/// is in them. They come from the study of `scripts/sweep-stops`: simulated years of healthy machines, and of
/// drifting and worn ones.
#[derive(Clone, Debug, PartialEq)]
pub struct StopParameters {
    /// A rod rests while its readings stay within this, m; more than counts and vibration make …
    pub still: f64,
    /// … and is read when it has rested for this long, s; 1 to 10.
    pub rest: f64,
    /// A reading repeats to no better than this, m.
    pub repeatability: f64,
    /// A calibration that has C2 read otherwise by more than this, m, is that of another transducer, or of
    /// one that was adjusted.
    pub adjusted: f64,
    /// No machine lies idle for so many years: its clock was set.
    pub idle: f64,
    /// Newest intervals between dwells of which the median is the usual one.
    pub intervals: usize,
    /// Of so many healthy transducers one seems to drift, which is one machine of some eighty.
    pub in_so_many: f64,
    /// Readings of one day whose difference has changed by more than this are no one mean, m.
    pub same_day: f64,
    /// Readings that move in counts up to this are rounded up and down by their own noise, so that a mean
    /// of them is finer, m.
    pub dithered: f64,
    /// A ramp may have begun so long ago, years …
    pub ramps: [f64; 6],
    /// … of an only transducer also so long: beside the wear that it may have, a ramp that begins at another time fits its
    /// drift so badly that what was found seems to be over, …
    pub more_ramps: [f64; 11],
    /// … with so many readings before and since; …
    pub side: usize,
    /// … and a step so many readings ago; …
    pub steps: [usize; 5],
    /// … of an only transducer also where so many readings differ most from as many before: no ramp stands for its old
    /// step, because stops wear along ramps.
    pub beside: usize,
    /// Deviations of what is known beforehand, m: the season in the difference, …
    pub season_apart: f64,
    /// … in the mean of both, of which the other cylinders tell the largest that they may have, m, …
    pub seasons: [f64; 4],
    /// … so many nats less likely than the likeliest, …
    pub maybe: f64,
    /// … the mean's own trend, as stops wear, with other cylinders and without, m a year, …
    pub wear: [f64; 2],
    /// … and what both may have stepped by together, m.
    pub common_step: f64,
    /// How the difference scatters, …
    pub apart: Scatter,
    /// … and the mean of both, with other cylinders and without.
    pub together: [Scatter; 2],
    /// What is expected of the scatter weighs as much as so many readings.
    pub expected: f64,
    /// Neighbours are never taken for more alike than this; 0 to 1.
    pub most_alike: f64,
    /// Nobody calls it a drift while the readings have come apart by less, m …
    pub least: f64,
    /// … or by less than so many of the counts they move in.
    pub counts: f64,
    /// Deviations beyond chance of a difference, …
    pub beyond: f64,
    /// … and of an only transducer, which every cylinder's own weather moves: at 4 it seemed to drift in 14 of 2400
    /// healthy years of weekly visits, …
    pub beyond_alone: f64,
    /// … and how that grows where few readings tell the scatter.
    pub few: f64,
    /// Twice the nats that name one of them.
    pub named: f64,
    /// Variances that both of them have moved by, …
    pub both: f64,
    /// … what the one that has moved less has of the other's move, …
    pub part: f64,
    /// … and what it has moved at least, m: a stop that wears takes both along. So does it an only transducer.
    pub own: f64,
    /// The mean square of all but the largest of a few normal values is less than their variance by this.
    pub trimmed: f64,
    /// From so many cylinders on, that were read on the same day, the others are a thermometer.
    pub cylinders: usize,
    /// So many of the first days say where a transducer begins, until all days do.
    pub first_days: usize,
}

impl StopParameters {
    pub const DEFAULT: Self = Self {
        still: 1.5e-3,
        rest: 3.0,
        repeatability: 5e-5,
        adjusted: 5e-4,
        idle: 3.0,
        intervals: 16,
        in_so_many: 1000.0,
        same_day: 5e-4,
        dithered: 2e-4,
        ramps: [0.125, 0.25, 0.5, 1.0, 2.0, 4.0],
        more_ramps: [
            0.0156, 0.0221, 0.0313, 0.0442, 0.0625, 0.0884, 0.177, 0.354, 0.707, 1.41, 2.83,
        ],
        side: 3,
        steps: [1, 2, 4, 8, 16],
        beside: 8,
        season_apart: 0.06 * MILLIMETRE,
        seasons: [0.05 * MILLIMETRE, 0.10 * MILLIMETRE, 0.20 * MILLIMETRE, 0.40 * MILLIMETRE],
        maybe: 3.0,
        wear: [0.20 * MILLIMETRE, 0.50 * MILLIMETRE],
        common_step: 0.30 * MILLIMETRE,
        apart: Scatter { usual: 0.08 * MILLIMETRE, least: 0.05 * MILLIMETRE },
        together: [
            Scatter { usual: 0.12 * MILLIMETRE, least: 0.05 * MILLIMETRE },
            Scatter { usual: 0.15 * MILLIMETRE, least: 0.05 * MILLIMETRE },
        ],
        expected: 4.0,
        most_alike: 0.9,
        least: 0.3 * MILLIMETRE,
        counts: 1.5,
        beyond: 4.0,
        beyond_alone: 5.0,
        few: 17.0 / 4.0,
        named: 12.0,
        both: 16.0,
        part: 0.3,
        own: 0.6 * MILLIMETRE,
        trimmed: 3.0,
        cylinders: 4,
        first_days: 3,
    };
}

/// How readings scatter about a fit, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scatter {
    /// What is expected, weighing as much as [`StopParameters::expected`] readings.
    pub usual: f64,
    /// Least scatter.
    pub least: f64,
}
