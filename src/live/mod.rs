//! The gateway, live: the monitor between an interface's frames and the frames it sends.

pub mod gateway;
pub mod health;
pub mod outbox;
pub mod proxy;
pub mod supervisor;
