//! Live SocketCAN: a RAW socket behind [`Port`](super::Port).
//!
//! There is no unsafe code: nix provides `recvmmsg`, socketcan the addresses, options and netlink.

mod batch;
mod drops;
mod error;
mod kind;
mod link;
mod live;
mod load;
mod open;
mod stamp;
mod wire;

pub use error::OpenError;
pub use kind::is_virtual;
pub use link::{LinkError, LinkState};
pub use live::SocketPort;
pub use open::Options;
pub use stamp::HARDWARE_TOLERANCE;
pub use tertius_core::error_frame::ControllerState;
