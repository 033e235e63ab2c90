//! The computer around the live gateway: signals, the service manager, the log. Only this module
//! knows what runs the gateway.

mod aside;
#[cfg(any(feature = "surroundings", feature = "mqtt"))]
mod durable;
pub mod http;
pub mod outputs;
pub mod realtime;
pub mod store;
pub mod telemetry;

#[cfg(feature = "surroundings")]
mod activity;
#[cfg(feature = "surroundings")]
pub mod doctor;
#[cfg(feature = "surroundings")]
pub mod flight;
#[cfg(feature = "surroundings")]
pub mod history;
#[cfg(feature = "surroundings")]
mod journald;
#[cfg(feature = "surroundings")]
pub mod link_watch;
#[cfg(feature = "surroundings")]
pub mod logging;
#[cfg(feature = "surroundings")]
mod notice_log;
#[cfg(feature = "surroundings")]
mod quota;
#[cfg(feature = "surroundings")]
mod site;
#[cfg(feature = "surroundings")]
pub mod surroundings;
#[cfg(feature = "surroundings")]
mod warning_log;
#[cfg(feature = "surroundings")]
mod watchdog;
