//! What is saved of a cylinder.

use super::Cylinder;
use crate::state::state;

state! {
    Cylinder {
        inputs, pending, plausibility, motions, implausible, observers, commands, uncorrected, bank, blame, last, tilted, drifted, estimated,
        critical, approach, length, apart, was_critical, command_missing, command_silent, way, judged, blanks, supply_is_odd, is_busy, is_watched, quantities, tally,
    }
    parts { devices, sequential, on_stop, process, sensor, reckoning }
    but { design }
    sound |it| it.blanks.begin_before(it.tally.cycles)
}
