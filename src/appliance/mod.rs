//! The box around the live gateway: signals, the service manager, the log. The only room that knows
//! what runs the gateway.

mod activity;
pub mod http;
pub mod link_watch;
pub mod logging;
mod site;
pub mod surroundings;
pub mod telemetry;
mod watchdog;
