//! Keys of the computer that the gateway runs on.

use super::super::schema::{Key, Kind, Scalar, Table};
use super::super::text::TextRule;
use super::{text, whole};

#[rustfmt::skip]
pub(super) static HTTP: Table = Table { keys: &[
    Key::optional("listen", text(TextRule::Listen), "\"127.0.0.1:9481\"",
        "where /health and /metrics are served, ADDRESS:PORT; or off"),
] };

#[rustfmt::skip]
pub(super) static REALTIME: Table = Table { keys: &[
    Key::optional("priority", whole(0, 99, "SCHED_FIFO has priorities 1 to 99; 0 is ordinary"), "0",
        "the real-time priority of the data path, from the gateway's start on; 0 for none"),
    Key::optional("lock_memory", Kind::One(Scalar::Switch), "false",
        "whether the gateway's memory is locked, from its start on"),
] };
