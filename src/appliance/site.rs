//! The address at which the gateway's telemetry is served, and its log lines.

use super::http::Server;
use super::telemetry::Recorder;
use std::io::{self, ErrorKind};
use std::net::SocketAddr;
use tracing::{info, warn};

/// The server, if there is one. The gateway also works without it.
#[derive(Debug, Default)]
pub(super) struct Site {
    /// Address as requested; port 0 becomes another one.
    listen: Option<SocketAddr>,
    server: Option<Server>,
}

impl Site {
    /// Serves what `recorder` writes on `listen` from now on. Where that fails, the previous server
    /// continues.
    pub fn listen(&mut self, listen: Option<SocketAddr>, recorder: &Recorder) {
        if self.listen == listen && self.server.is_some() == listen.is_some() {
            return;
        }
        let Some(wanted) = listen else {
            *self = Self::default();
            info!("no telemetry over HTTP any more");
            return;
        };
        match Server::start(wanted, recorder) {
            Ok(server) => {
                let address = server.address();
                info!("telemetry: http://{address}/health and http://{address}/metrics");
                if !address.ip().is_loopback() {
                    warn!(
                        "{address} can be reached from other machines, and whoever reaches it may \
                         read everything there; a loopback address keeps it on this one. Under systemd \
                         IPAddressAllow= of the unit decides, too"
                    );
                }
                *self = Self { listen, server: Some(server) };
            }
            Err(error) => {
                let help = help(&error);
                match &self.server {
                    None => warn!("no telemetry over HTTP on {wanted}: {error}; {help}"),
                    Some(old) => warn!(
                        "no telemetry over HTTP on {wanted}: {error}; {help}. It stays on {}",
                        old.address()
                    ),
                }
            }
        }
    }
}

/// Advice on an error.
fn help(error: &io::Error) -> &'static str {
    match error.kind() {
        ErrorKind::AddrInUse => {
            "something listens there already. Several gateways on one box need a port each: change \
             `http.listen`, then reload"
        }
        ErrorKind::AddrNotAvailable => {
            "no interface of this machine has the address: change `http.listen`, then reload"
        }
        ErrorKind::PermissionDenied => {
            "ports below 1024 need a privilege, which the gateway does without: change \
             `http.listen`, then reload"
        }
        _ => "change `http.listen`, then reload; or switch it off with `http.listen = \"off\"`",
    }
}
