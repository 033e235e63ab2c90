//! The bus as the driver's error frames tell it.

use crate::error_frame::{ControllerState, ErrorFrame};

/// What the error frames since the port was opened add up to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BusHealth {
    /// The newest state that was told; `None` where none was, as on a virtual interface.
    pub state: Option<ControllerState>,
    /// The controller's transmit and receive error counters, as last told.
    pub counters: Option<[u8; 2]>,
    pub bus_offs: u64,
    pub restarts: u64,
    /// Frames that nobody acknowledged.
    pub unacknowledged: u64,
    /// Times that the controller itself lost frames for want of room; how many, nobody knows.
    pub receive_overflows: u64,
    pub protocol_errors: u64,
    pub transceiver_errors: u64,
}

impl BusHealth {
    /// Takes an error frame; `true` if the controller's state is another one now.
    pub fn take(&mut self, error: &ErrorFrame) -> bool {
        let before = self.state;
        self.state = error.state.or(before);
        self.counters = error.counters.or(self.counters);
        self.bus_offs += u64::from(error.is_bus_off());
        self.restarts += u64::from(error.restarted);
        self.unacknowledged += u64::from(error.unacknowledged);
        self.receive_overflows += u64::from(error.receive_overflow);
        self.protocol_errors += u64::from(error.protocol);
        self.transceiver_errors += u64::from(error.transceiver);
        self.state != before
    }

    /// A frame came: whatever was told before, the controller takes part in the bus. `true` if that
    /// is news.
    pub fn spoke(&mut self) -> bool {
        let was_off = self.is_off();
        if was_off {
            self.state = None;
        }
        was_off
    }

    /// The controller takes no part in the bus: what is handed to it now would burst out stale.
    pub fn is_off(&self) -> bool {
        self.state == Some(ControllerState::BusOff)
    }
}
