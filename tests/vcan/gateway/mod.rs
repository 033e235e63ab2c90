//! `tertius run` on a real SocketCAN.

mod buses;
mod canopen;
mod devices;
mod doctor;
mod life;
mod monitor;
mod recorder;
mod simulated;
mod wire;
