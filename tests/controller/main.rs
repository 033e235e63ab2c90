//! Controllers with their driver: can0 and can1 on one bus, at 500 kbit/s and with restart-ms 100.
//! `scripts/with-controller cargo test --test controller`.

#[path = "../live_vcan/bench.rs"]
#[allow(dead_code, reason = "the tests on vcan use the rest")]
mod bench;
mod gateway;
mod port;
