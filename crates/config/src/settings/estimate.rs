//! `[estimate]`, the virtual third sensor.

use crate::kinds::{DURATION, number};
use crate::schema::{Kind, Limits, Scalar, table};

table! {
    /// Settings of the estimates of each cylinder's length.
    pub struct Estimate = ESTIMATE {
        send: bool = false => Kind::One(Scalar::Switch),
            "false", "whether Fd_Estimate is sent, for each cylinder in each cycle";
        accommodate_after: Option<f64> = None => number(Limits::least(1.0, DURATION).most(3600.0)),
            "60.0",
            "where no other transducer is left, the step of one that has stood still this long is subtracted from its \
             reading, s; absent: never";
        accommodate_for: f64 = 600.0 => number(Limits::above(0.0, DURATION).most(86_400.0)),
            "600.0", "a step is subtracted no longer than this after the other transducer has confirmed it, s";
        bound: f64 = 5e-3 =>
            number(Limits::above(0.0, "a standard deviation in metres; Fd_Estimate has room for 0.065").most(0.065)),
            "0.005", "an estimate with a larger standard deviation is not valid, m";
    }
}
