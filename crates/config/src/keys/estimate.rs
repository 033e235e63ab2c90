//! Keys of the virtual third sensor.

use super::super::schema::{Key, Kind, Limits, Scalar, Table};
use super::number;

#[rustfmt::skip]
pub(super) static ESTIMATE: Table = Table { keys: &[
    Key::optional("send", Kind::One(Scalar::Switch), "false",
        "whether Fd_Estimate is sent, for each cylinder in each cycle"),
    Key::optional("bound",
        number(Limits::above(0.0, "a standard deviation in metres; Fd_Estimate has room for 0.065").most(0.065)),
        "0.005", "an estimate with a larger standard deviation is not valid, m"),
] };
