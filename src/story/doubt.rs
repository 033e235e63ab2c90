//! Words for frames that cannot be relied on.

use crate::frame::Id;
use crate::sample::dispute::Doubt;

/// What is wrong with the frames of a message, or is no longer.
pub fn doubt(id: Id, doubt: Doubt, is_over: bool) -> String {
    match (doubt, is_over) {
        (Doubt::Contradiction, false) => format!(
            "frames 0x{id} contradict each other: a second device sends them, too, so what they carry is unknown; find it \
             on the bus, no transducer is to blame"
        ),
        (Doubt::Contradiction, true) => format!("frames 0x{id} no longer contradict each other"),
        (Doubt::TooShort, false) => format!(
            "frames 0x{id} are too short for the signals that are configured, and are left out; compare their sender with \
             the DBC, no transducer is to blame"
        ),
        (Doubt::TooShort, true) => format!("frames 0x{id} are no longer too short"),
    }
}
