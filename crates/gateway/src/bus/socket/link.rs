//! State of an interface and its controller in the kernel.

use std::io;
use tertius_core::error_frame::ControllerState;

use socketcan::CanInterface;
use socketcan::nl::CanState;

/// State of an interface in the kernel. A virtual one (vcan) has no bit rate and no controller.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LinkState {
    /// Index of the interface in the kernel: a new one each time it is created.
    pub index: u32,
    /// Whether it was brought up; a bus-off controller still is.
    pub up: bool,
    /// Largest frame, bytes of SocketCAN: 16 classic, 72 CAN FD. `None` for another size.
    pub mtu: Option<u32>,
    /// Nominal bit rate, bit/s.
    pub bit_rate: Option<u32>,
    /// Sample point within a bit, tenths of a percent.
    pub sample_point: Option<u32>,
    /// Bit rate of CAN FD's data phase, bit/s.
    pub data_bit_rate: Option<u32>,
    /// State of the controller.
    pub state: Option<ControllerState>,
    /// Transmit error counter of the controller; bus-off from 256, which it does not show.
    pub transmit_errors: Option<u16>,
    /// Receive error counter of the controller.
    pub receive_errors: Option<u16>,
    /// Time after which bus-off ends by itself, ms; zero means never.
    pub restart_ms: Option<u32>,
    /// Most frames that may wait to be sent.
    pub queue_length: Option<u32>,
}

/// Why the state of an interface is not known.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LinkError {
    #[error("there is no interface {interface}; `ip -br link` lists them")]
    NoInterface {
        /// Name as given by the caller.
        interface: String,
    },
    #[error("cannot ask the kernel about {interface}: {error}")]
    Netlink {
        /// Name as given by the caller.
        interface: String,
        #[source]
        error: io::Error,
    },
}

impl LinkState {
    /// Reads the state from the kernel (netlink, one round trip). Needs no privilege.
    ///
    /// # Errors
    /// There is no such interface, or netlink is not available.
    pub fn read(interface: &str) -> Result<Self, LinkError> {
        let index = nix::net::if_::if_nametoindex(interface)
            .map_err(|_| LinkError::NoInterface { interface: interface.to_owned() })?;
        let details = CanInterface::open_iface(index).details().map_err(|error| {
            LinkError::Netlink { interface: interface.to_owned(), error: io::Error::other(error) }
        })?;
        let can = details.can;
        // Zero is a controller that has not been given one.
        let rate = |timing: Option<socketcan::nl::CanBitTiming>| {
            timing.map(|timing| timing.bitrate).filter(|&rate| rate != 0)
        };
        Ok(Self {
            index,
            up: details.is_up,
            mtu: details.mtu.map(|mtu| mtu as u32),
            bit_rate: rate(can.bit_timing),
            sample_point: { can.bit_timing }
                .map(|timing| timing.sample_point)
                .filter(|&point| point != 0),
            data_bit_rate: rate(can.data_bit_timing),
            state: can.state.map(controller_state),
            transmit_errors: can.berr_counter.map(|counter| counter.txerr),
            receive_errors: can.berr_counter.map(|counter| counter.rxerr),
            restart_ms: can.restart_ms,
            queue_length: queue_length(interface),
        })
    }

    /// Whether CAN FD frames can be sent.
    pub fn is_fd(&self) -> bool {
        self.mtu == Some(socketcan::nl::Mtu::Fd as u32)
    }
}

/// Length of the send queue, which the crate does not read.
fn queue_length(interface: &str) -> Option<u32> {
    let path = format!("/sys/class/net/{interface}/tx_queue_len");
    std::fs::read_to_string(path).ok()?.trim().parse().ok()
}

/// The controller's state in our terms.
const fn controller_state(state: CanState) -> ControllerState {
    match state {
        CanState::ErrorActive => ControllerState::ErrorActive,
        CanState::ErrorWarning => ControllerState::Warning,
        CanState::ErrorPassive => ControllerState::Passive,
        CanState::BusOff => ControllerState::BusOff,
        CanState::Stopped => ControllerState::Stopped,
        CanState::Sleeping => ControllerState::Sleeping,
    }
}
