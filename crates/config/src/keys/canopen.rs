//! Keys of the gateway as a CANopen node.

use super::super::schema::{Key, Kind, Limits, Scalar, Table};
use super::number;

#[rustfmt::skip]
pub(super) static CANOPEN: Table = Table { keys: &[
    Key::optional("node", Kind::One(Scalar::Switch), "true",
        "whether the gateway is a CANopen node, with heartbeat, EMCY, SDO and NMT; its number is gateway.node"),
    Key::optional("heartbeat",
        number(Limits::least(0.0, "a time in seconds that object 0x1017 can hold").most(65.535)), "1.0",
        "from one heartbeat to the next, s, 0.05 at least; 0: no heartbeat; a master may set another \
         time by object 0x1017"),
    Key::optional("autostart", Kind::One(Scalar::Switch), "true",
        "whether the node becomes operational by itself; otherwise no Fd_ frame is sent until an NMT \
         master starts it"),
] };
