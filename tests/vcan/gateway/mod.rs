//! `tertius run` on a real SocketCAN.

mod canopen;
mod doctor;
mod life;
mod simulated;
mod wire;
