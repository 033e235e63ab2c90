//! The OPC UA server of a program that was built without it: there is none.

use super::telemetry::Recorder;
use std::io;
use std::net::SocketAddr;

pub use NoOpcuaServer as OpcuaServer;

/// What is never made.
#[derive(Debug)]
pub enum NoOpcuaServer {}

impl NoOpcuaServer {
    /// Refuses.
    ///
    /// # Errors
    /// Always.
    pub fn start(_: SocketAddr, _: &Recorder) -> io::Result<Self> {
        Err(io::Error::other("this program was built without it"))
    }

    /// Address that the server listens on.
    pub const fn address(&self) -> SocketAddr {
        match *self {}
    }
}
