//! Words for frames that cannot be relied on.

use crate::frame::Id;
use crate::sample::dispute::Doubt;

/// That these bits of a status have no meaning in the configuration.
pub fn unnamed_status(bits: u64) -> String {
    format!(
        "the status has 0x{bits:X}, which `plausibility.status_mask` does not have, so it is taken for no fault; look up what it \
         means, and add it to the mask if it means a broken wire"
    )
}

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
        (Doubt::Uncounted, false) => format!(
            "the alive counter of frames 0x{id} does not count, so only their times show whether frames are late or repeated; \
             check their sender, or the counter in the configuration"
        ),
        (Doubt::Uncounted, true) => format!("the alive counter of frames 0x{id} counts again"),
        (Doubt::Flood, false) => format!(
            "Sync (0x{id}) arrives more often than once per cycle: a second device sends it. Readings open the cycles until it \
             stops; find that device on the bus, no transducer is at fault"
        ),
        (Doubt::Flood, true) => format!("Sync (0x{id}) arrives once per cycle again"),
        (Doubt::Absent, false) => format!(
            "Sync (0x{id}) is missing in more than half of the cycles: readings open them, with less exact times; check the \
             sender of Sync"
        ),
        (Doubt::Absent, true) => format!("Sync (0x{id}) arrives again"),
        (Doubt::Imitation, false) => format!(
            "another device sends frames 0x{id}, which only this gateway should send: receivers cannot tell them apart; find \
             that device, or give a second gateway another node number"
        ),
        (Doubt::Imitation, true) => format!("no other device sends frames 0x{id} any more"),
    }
}
