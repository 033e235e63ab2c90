//! The live gateway, and the computer around it.
//!
//! - [`bus`]: live interfaces: SocketCAN, and a bus inside the program.
//! - [`live`]: the monitor on a port: outbox, recovery, several buses, the proxy of a test bench.
//! - [`alarm_list`]: incidents as alarms that people acknowledge.
//! - `appliance`, with the feature `http`: event store, page, health and metrics. Further features have Modbus, MQTT, OPC UA,
//!   and, as `surroundings`, what runs the gateway: signals, the service manager, the log, the flight recorder.

pub mod alarm_list;
#[cfg(feature = "http")]
pub mod appliance;
pub mod bus;
pub mod live;
