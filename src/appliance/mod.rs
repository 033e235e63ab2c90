//! The computer around the live gateway: signals, the service manager, the log. Only this module
//! knows what runs the gateway.

mod aside;
#[cfg(any(feature = "cli", feature = "mqtt"))]
mod durable;
pub mod http;
#[cfg(feature = "modbus")]
pub mod modbus;
#[cfg(feature = "mqtt")]
pub mod mqtt;
#[cfg(feature = "opcua")]
pub mod opcua;
#[cfg(all(feature = "cli", not(feature = "opcua")))]
#[path = "without_opcua.rs"]
pub mod opcua;
#[cfg(any(feature = "modbus", feature = "opcua"))]
mod patience;
pub mod realtime;
pub mod store;
pub mod telemetry;

#[cfg(feature = "cli")]
mod activity;
#[cfg(feature = "cli")]
pub mod doctor;
#[cfg(feature = "cli")]
pub mod flight;
#[cfg(feature = "cli")]
pub mod history;
#[cfg(feature = "cli")]
mod journald;
#[cfg(feature = "cli")]
pub mod link_watch;
#[cfg(feature = "cli")]
pub mod logging;
#[cfg(feature = "cli")]
mod notice_log;
#[cfg(feature = "cli")]
mod quota;
#[cfg(feature = "cli")]
mod site;
#[cfg(feature = "cli")]
pub mod surroundings;
#[cfg(feature = "cli")]
mod warning_log;
#[cfg(feature = "cli")]
mod watchdog;
