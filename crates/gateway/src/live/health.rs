//! State of the bus according to the driver's error frames.

use tertius_core::error_frame::{ControllerState, ErrorFrame};

/// Sum of the error frames since the port was opened.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BusHealth {
    /// Newest state that was reported; `None` where none was, as on a virtual interface.
    pub state: Option<ControllerState>,
    /// Transmit and receive error counters of the controller, as last reported.
    pub counters: Option<[u8; 2]>,
    pub bus_offs: u64,
    pub restarts: u64,
    /// Number of frames that nobody acknowledged.
    pub unacknowledged: u64,
    /// Number of times that the controller itself lost frames for lack of room; the number of
    /// frames is not known.
    pub receive_overflows: u64,
    pub protocol_errors: u64,
    pub transceiver_errors: u64,
}

impl BusHealth {
    /// Takes an error frame; returns `true` if the controller's state has changed.
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

    /// Notes that a frame came: whatever was reported before, the controller takes part in the bus.
    /// Returns `true` if that is new.
    pub fn spoke(&mut self) -> bool {
        let was_off = self.is_off();
        if was_off {
            self.state = None;
        }
        was_off
    }

    /// Whether the controller takes no part in the bus, so that frames handed to it now would burst
    /// out stale.
    pub fn is_off(&self) -> bool {
        self.state == Some(ControllerState::BusOff)
    }
}
