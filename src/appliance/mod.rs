//! The box around the live gateway: signals, the service manager, the log. The only room that knows
//! what runs the gateway.

mod activity;
pub mod link_watch;
pub mod logging;
pub mod surroundings;
mod watchdog;
