//! The live gateway: the monitor between the frames of an interface and the frames that it sends.

pub mod gateway;
pub mod health;
pub mod imitation;
pub mod listener;
pub mod outbox;
pub mod proxy;
pub mod several;
pub mod supervisor;
