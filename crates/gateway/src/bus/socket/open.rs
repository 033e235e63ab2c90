//! A RAW socket that is set up before it is bound, so that every frame has passed its filters.

use std::io;
use std::os::fd::{AsFd, AsRawFd, BorrowedFd, RawFd};
use std::time::Duration;

use nix::errno::Errno;
use socket2::{Domain, Protocol, Socket, Type};
use socketcan::{CanAddr, SocketOptions};

use super::error::OpenError;
use super::link::LinkState;
use super::load::BitRates;
use super::wire;
use crate::bus::port::Identifiers;

/// Most filters that the kernel takes (CAN_RAW_FILTER_MAX).
const MOST_FILTERS: usize = 512;

/// Frames to receive, and the size of the buffer for them.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Options {
    pub identifiers: Identifiers,
    /// Receive buffer, bytes; `None` is a second of a full bus.
    pub receive_buffer: Option<usize>,
    /// Whether as few frames as the kernel allows (about six) may be under way to the controller.
    /// Frames that cannot be sent then wait with their owner, where they have an age, and do not
    /// burst out stale when the bus returns.
    pub few_under_way: bool,
}

/// A socket bound to an interface, with the settings that the kernel granted.
pub(super) struct Opened {
    pub(super) socket: Bound,
    pub(super) index: u32,
    /// Receive buffer, bytes by the kernel's count.
    pub(super) buffer: usize,
    pub(super) rates: BitRates,
    pub(super) stamping: Stamping,
    pub(super) filters: Option<usize>,
}

/// Socket option that provides the time stamps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Stamping {
    /// SO_TIMESTAMPING: time stamps of the kernel and of the controller.
    Both,
    /// SO_TIMESTAMPNS: time stamps of the kernel.
    Kernel,
}

/// A CAN_RAW socket before it is bound. Only this type can be set up, so that no frame comes
/// earlier.
struct Unbound(Socket);

/// A CAN_RAW socket on an interface.
pub(super) struct Bound(Socket);

impl AsRawFd for Unbound {
    fn as_raw_fd(&self) -> RawFd {
        self.0.as_raw_fd()
    }
}

impl SocketOptions for Unbound {}

impl AsFd for Bound {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.0.as_fd()
    }
}

impl AsRawFd for Bound {
    fn as_raw_fd(&self) -> RawFd {
        self.0.as_raw_fd()
    }
}

impl Bound {
    /// Sends without waiting.
    pub(super) fn send(&self, bytes: &[u8]) -> io::Result<usize> {
        self.0.send_with_flags(bytes, libc::MSG_DONTWAIT)
    }

    /// Sets the longest wait of a read.
    pub(super) fn set_patience(&self, patience: Duration) -> io::Result<()> {
        self.0.set_read_timeout(Some(patience))
    }
}

impl Unbound {
    fn new() -> io::Result<Self> {
        let protocol = Protocol::from(libc::CAN_RAW);
        Socket::new(Domain::from(libc::PF_CAN), Type::RAW, Some(protocol)).map(Self)
    }

    fn set(&self, option: libc::c_int, value: libc::c_int) -> io::Result<()> {
        self.set_socket_option_int(libc::SOL_SOCKET, option, value)
    }

    fn set_can(&self, option: libc::c_int, value: &[u8]) -> io::Result<()> {
        self.set_socket_option_bytes(libc::SOL_CAN_RAW, option, value)
    }

    /// Sets the receive buffer. The kernel doubles the size, because it counts its own structures.
    fn set_receive_buffer(&self, bytes: usize) -> io::Result<usize> {
        let half = libc::c_int::try_from(bytes.div_ceil(2)).unwrap_or(libc::c_int::MAX / 2);
        // Beyond net.core.rmem_max, for those who may.
        if self.set(libc::SO_RCVBUFFORCE, half).is_err() {
            self.set(libc::SO_RCVBUF, half)?;
        }
        self.get_socket_option_int(libc::SOL_SOCKET, libc::SO_RCVBUF)
            .map(|bytes| usize::try_from(bytes).unwrap_or_default())
    }

    /// Sets the send buffer to the smallest that the kernel allows, about six frames.
    fn set_smallest_send_buffer(&self) -> io::Result<()> {
        self.set(libc::SO_SNDBUF, 1)
    }

    fn set_stamping(&self) -> io::Result<Stamping> {
        let wanted = libc::SOF_TIMESTAMPING_RX_HARDWARE
            | libc::SOF_TIMESTAMPING_RAW_HARDWARE
            | libc::SOF_TIMESTAMPING_RX_SOFTWARE
            | libc::SOF_TIMESTAMPING_SOFTWARE;
        if self.set(libc::SO_TIMESTAMPING, wanted as libc::c_int).is_ok() {
            return Ok(Stamping::Both);
        }
        self.set(libc::SO_TIMESTAMPNS, 1).map(|()| Stamping::Kernel)
    }
}

/// Opens `interface`, whose index is looked up again.
pub(super) fn open(interface: &str, options: &Options) -> Result<Opened, OpenError> {
    let failed =
        |step| move |error| OpenError::Step { interface: interface.to_owned(), step, error };
    let socket = Unbound::new().map_err(|error| match errno(&error) {
        Errno::EAFNOSUPPORT | Errno::EPROTONOSUPPORT => OpenError::NoCan { error },
        _ => failed("open a CAN socket")(error),
    })?;

    let (filters, count) = match &options.identifiers {
        Identifiers::All => (wire::no_filter(), None),
        Identifiers::Only(ids) => {
            let filters = wire::filters(ids);
            let count = filters.len() / wire::FILTER;
            if count > MOST_FILTERS {
                return Err(OpenError::TooManyIdentifiers { count, most: MOST_FILTERS });
            }
            (filters, Some(count))
        }
    };
    socket.set_can(libc::CAN_RAW_FILTER, &filters).map_err(failed("set the filters"))?;
    let errors = libc::CAN_ERR_MASK.to_ne_bytes();
    socket.set_can(libc::CAN_RAW_ERR_FILTER, &errors).map_err(failed("ask for error frames"))?;
    socket.set_can(libc::CAN_RAW_FD_FRAMES, &on()).map_err(failed("ask for CAN FD"))?;
    // Others on this machine, such as candump, see what is sent here; this socket does not.
    socket.set_can(libc::CAN_RAW_LOOPBACK, &on()).map_err(failed("switch the loopback on"))?;
    socket.set_can(libc::CAN_RAW_RECV_OWN_MSGS, &off()).map_err(failed("leave own frames out"))?;
    socket.set(libc::SO_RXQ_OVFL, 1).map_err(failed("have lost frames counted"))?;
    if options.few_under_way {
        socket.set_smallest_send_buffer().map_err(failed("size the send buffer"))?;
    }
    let stamping = socket.set_stamping().map_err(failed("get time stamps"))?;

    // What cannot be known of the interface makes no difference but to the buffer's size.
    let link = LinkState::read(interface).ok();
    let rates = link.map_or(BitRates::new(None, None, true), |link| {
        BitRates::new(link.bit_rate, link.data_bit_rate, link.is_fd())
    });
    let wanted = options
        .receive_buffer
        .unwrap_or_else(|| usize::try_from(rates.second()).unwrap_or(usize::MAX));
    let buffer = socket.set_receive_buffer(wanted).map_err(failed("size the receive buffer"))?;

    let (socket, index) = bind(socket, interface)?;
    Ok(Opened { socket, index, buffer, rates, stamping, filters: count })
}

/// Binds to the interface that has the name now; also returns its index.
fn bind(Unbound(socket): Unbound, interface: &str) -> Result<(Bound, u32), OpenError> {
    let name = || interface.to_owned();
    let no_interface = |_| OpenError::NoInterface { interface: name() };
    let index = nix::net::if_::if_nametoindex(interface).map_err(no_interface)?;
    if let Err(error) = socket.bind(&CanAddr::new(index).into_sock_addr()) {
        if errno(&error) != Errno::ENODEV {
            return Err(OpenError::Step { interface: name(), step: "listen", error });
        }
        // Not of the right kind, or deleted since its index was asked for.
        let still = nix::net::if_::if_nametoindex(interface).map_err(no_interface)? == index;
        return Err(match still {
            true => OpenError::NotCan { interface: name() },
            false => OpenError::NoInterface { interface: name() },
        });
    }
    // One that is down can be bound to, and says so afterwards.
    match socket.take_error() {
        Ok(Some(error)) if errno(&error) == Errno::ENETDOWN => {
            Err(OpenError::Down { interface: name() })
        }
        Ok(Some(error)) | Err(error) => {
            Err(OpenError::Step { interface: name(), step: "listen", error })
        }
        Ok(None) => Ok((Bound(socket), index)),
    }
}

pub(super) fn errno(error: &io::Error) -> Errno {
    error.raw_os_error().map_or(Errno::UnknownErrno, Errno::from_raw)
}

fn on() -> [u8; 4] {
    1_i32.to_ne_bytes()
}

fn off() -> [u8; 4] {
    0_i32.to_ne_bytes()
}
