//! The live gateway, and the computer around it.
//!
//! - [`bus`]: live interfaces: SocketCAN, and a bus inside the program.
//! - [`live`]: the monitor on a port: outbox, recovery, several buses, the proxy of a test bench.
//! - [`alarm_list`]: incidents as alarms that people acknowledge.
//! - `appliance`, with the feature of that name: signals, the service manager, the log, event store and flight recorder, the page,
//!   health and metrics, Modbus and MQTT. OPC UA is the feature `opcua`.

pub mod alarm_list;
#[cfg(feature = "appliance")]
pub mod appliance;
pub mod bus;
pub mod live;
