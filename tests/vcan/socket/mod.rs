//! The port over a real SocketCAN. Needs a kernel with vcan and the right to make interfaces.

mod frames;
mod life;
mod link;
mod load;
mod time;
mod traffic;
mod vcan;
