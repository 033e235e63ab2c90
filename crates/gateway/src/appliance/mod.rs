//! The computer around the live gateway: signals, the service manager, the log. Only this module
//! knows what runs the gateway.

mod activity;
mod aside;
pub mod doctor;
mod durable;
pub mod flight;
pub mod history;
pub mod http;
mod journald;
pub mod link_watch;
pub mod logging;
mod notice_log;
pub mod outputs;
mod quota;
pub mod realtime;
mod site;
pub mod store;
pub mod surroundings;
pub mod telemetry;
mod warning_log;
mod watchdog;
