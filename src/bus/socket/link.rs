//! What the kernel knows of an interface and its controller.

use crate::error_frame::ControllerState;
use std::io;

use socketcan::CanInterface;
use socketcan::nl::CanState;

/// An interface as the kernel sees it now. A virtual one (vcan) has no bit rate and no controller.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LinkState {
    /// The kernel's number for it: another one each time it is created.
    pub index: u32,
    /// Whether it was brought up; a controller that is bus-off still is.
    pub up: bool,
    /// Largest frame, bytes of SocketCAN: 16 classic, 72 CAN FD. `None` if it is another.
    pub mtu: Option<u32>,
    /// bit/s.
    pub bit_rate: Option<u32>,
    /// Where in a bit it is read, in tenths of a percent of the bit.
    pub sample_point: Option<u32>,
    /// Of CAN FD's data phase, bit/s.
    pub data_bit_rate: Option<u32>,
    /// The controller's state.
    pub state: Option<ControllerState>,
    /// The controller's transmit error counter; bus-off from 256, which it does not show.
    pub transmit_errors: Option<u16>,
    /// The controller's receive error counter.
    pub receive_errors: Option<u16>,
    /// After how many milliseconds bus-off ends by itself; zero is never.
    pub restart_ms: Option<u32>,
    /// Frames that may wait to be sent.
    pub queue_length: Option<u32>,
}

/// Why nothing is known of an interface.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LinkError {
    #[error("there is no interface {interface}; `ip -br link` lists those that there are")]
    NoInterface {
        /// As the caller named it.
        interface: String,
    },
    #[error("cannot ask the kernel about {interface}: {error}")]
    Netlink {
        /// As the caller named it.
        interface: String,
        #[source]
        error: io::Error,
    },
}

impl LinkState {
    /// Asks the kernel (netlink, one round trip). Needs no privilege.
    ///
    /// # Errors
    /// No such interface, or netlink is not to be had.
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

    /// Whether frames longer than classic ones can be sent.
    pub fn is_fd(&self) -> bool {
        self.mtu == Some(socketcan::nl::Mtu::Fd as u32)
    }
}

/// The crate does not ask for it.
fn queue_length(interface: &str) -> Option<u32> {
    let path = format!("/sys/class/net/{interface}/tx_queue_len");
    std::fs::read_to_string(path).ok()?.trim().parse().ok()
}

/// What the kernel says of the controller, in our words.
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
