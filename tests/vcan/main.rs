//! What needs a kernel with CAN: the port, the gateway and the proxy on a real SocketCAN.
//! `scripts/with-vcan cargo test --test vcan -- --test-threads=1`: there may be one processor, and a gateway that
//! starves beside another test is late with reason.

mod gateway;
mod inject;
mod socket;
