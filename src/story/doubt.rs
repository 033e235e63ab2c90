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
        (Doubt::Uncounted, false) => format!(
            "the alive counter of frames 0x{id} does not count them, so that it proves nothing: a frame that is late, or comes \
             twice, is told by its time alone; look at their sender, or at the counter in the configuration"
        ),
        (Doubt::Uncounted, true) => format!("the alive counter of frames 0x{id} counts them again"),
        (Doubt::Flood, false) => format!(
            "Sync (0x{id}) comes more often than the machine has cycles: somebody else sends it, too, so that readings open \
             the cycles; find it on the bus, no transducer is to blame"
        ),
        (Doubt::Flood, true) => format!("Sync (0x{id}) comes as often as the machine has cycles"),
        (Doubt::Absent, false) => format!(
            "Sync (0x{id}) comes for fewer than half of the cycles: readings open them, whose times are less exact; look at \
             its sender"
        ),
        (Doubt::Absent, true) => format!("Sync (0x{id}) comes again"),
        (Doubt::Imitation, false) => format!(
            "another device sends frames 0x{id}, which are this gateway's own: whoever receives them cannot tell the two \
             apart; find it on the bus, or give one of two gateways another node number"
        ),
        (Doubt::Imitation, true) => format!("nobody else sends frames 0x{id} any more"),
    }
}
