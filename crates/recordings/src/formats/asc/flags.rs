//! What a line tells of a frame of CAN FD.

/// Flags of [`Kind::Fd`](tertius_core::frame::Kind::Fd).
pub(super) const BIT_RATE_SWITCH: u8 = 1;
pub(super) const ERROR_STATE: u8 = 2;
