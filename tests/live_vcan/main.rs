//! `tertius run` on a real SocketCAN: `scripts/with-vcan cargo test --test live_vcan`.

mod bench;
mod doctor;
mod life;
#[path = "../oracle/mod.rs"]
mod oracle;
mod simulated;
mod wire;
