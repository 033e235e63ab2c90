//! The computer around the live gateway: signals, the service manager, the log. Only this module
//! knows what runs the gateway.

mod activity;
pub mod doctor;
pub mod history;
pub mod http;
mod journald;
pub mod link_watch;
pub mod logging;
mod quota;
pub mod realtime;
mod site;
pub mod surroundings;
pub mod telemetry;
mod warning_log;
mod watchdog;
