//! `tertius run` on a real SocketCAN.

mod doctor;
mod life;
mod simulated;
mod wire;
