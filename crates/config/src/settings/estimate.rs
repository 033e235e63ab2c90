//! `[estimate]`, the virtual third sensor.

use crate::kinds::number;
use crate::schema::{Kind, Limits, Scalar, table};

table! {
    /// Settings of the estimates of each cylinder's length.
    pub struct Estimate = ESTIMATE {
        send: bool = false => Kind::One(Scalar::Switch),
            "false", "whether Fd_Estimate is sent, for each cylinder in each cycle";
        bound: f64 = 5e-3 =>
            number(Limits::above(0.0, "a standard deviation in metres; Fd_Estimate has room for 0.065").most(0.065)),
            "0.005", "an estimate with a larger standard deviation is not valid, m";
    }
}
