//! Controllers with their driver: can0 and can1 on one bus, at 500 kbit/s and with restart-ms 100.
//! `scripts/with-controller cargo test --test controller`.

mod gateway;
mod port;
