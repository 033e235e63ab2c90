//! Keys of CANopen devices.

use super::super::schema::{Key, Kind, Limits, Scalar, Table};
use super::super::text::TextRule;
use super::{MOST_CYLINDERS, number, text, whole};

#[rustfmt::skip]
pub(super) static CANOPEN: Table = Table { keys: &[
    Key::optional("device", Kind::Tables(&DEVICE), "",
        "a device whose objects are read as its EDS or DCF says"),
] };

#[rustfmt::skip]
pub(super) static DEVICE: Table = Table { keys: &[
    Key::required("node", whole(1, 127, "CANopen has the node-IDs 1 to 127"), "1", "the device's node-ID"),
    Key::required("kind", Kind::One(Scalar::Choice(&["transducer", "valve"])), "\"transducer\"",
        "a position transducer (CiA 406) or a proportional valve (CiA 408)"),
    Key::required("cylinder", whole(1, MOST_CYLINDERS as i128, "cylinders are numbered from 1"), "1",
        "the cylinder that it is on"),
    Key::optional("role", Kind::One(Scalar::Choice(&["c1", "c2"])), "\"c1\"",
        "which transducer of the cylinder it is; a valve has none"),
    Key::required("eds", text(TextRule::Path), "\"../dbc/transducer.eds\"",
        "the device's EDS or DCF, relative to this file"),
    Key::optional("full_speed",
        number(Limits::above(0.0, "a speed in metres per second").most(100.0)), "1.0",
        "the commanded speed at 100 % of a valve's set point, m/s, where the set point has no unit"),
] };
