//! The address at which the gateway's telemetry is served, and its log lines.

use super::http::{Desk, DeskPlan, Server};
use super::store::StoreHandle;
use super::telemetry::Recorder;
use std::io::{self, ErrorKind};
use std::net::SocketAddr;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use tracing::{info, warn};

/// What the configuration asks for.
#[derive(Clone, Debug, Default)]
pub struct SitePlan {
    /// Address to listen on; port 0 becomes another one. `None`: there is no server.
    pub listen: Option<SocketAddr>,
    pub desk: DeskPlan,
}

/// The server, if there is one. The gateway also works without it.
#[derive(Debug, Default)]
pub(super) struct Site {
    /// Address as requested; port 0 becomes another one.
    listen: Option<SocketAddr>,
    desk: Desk,
    server: Option<Server>,
}

impl Site {
    /// A site that serves what `store` keeps, and lets people ask for recordings by `demand`.
    pub fn new(store: StoreHandle, demand: Arc<AtomicBool>) -> Self {
        Self { desk: Desk::new(store, demand), ..Self::default() }
    }

    /// Serves what `recorder` writes by `plan` from now on. Where that fails, the previous server continues.
    pub fn listen(&mut self, plan: SitePlan, recorder: &Recorder) {
        self.desk.follow(plan.desk);
        if self.listen == plan.listen && self.server.is_some() == plan.listen.is_some() {
            return;
        }
        let Some(wanted) = plan.listen else {
            (self.listen, self.server) = (None, None);
            info!("telemetry over HTTP is now off");
            return;
        };
        match Server::start(wanted, recorder, self.desk.clone()) {
            Ok(server) => {
                let address = server.address();
                info!(
                    "page: http://{address}/, telemetry: http://{address}/health and http://{address}/metrics"
                );
                if !address.ip().is_loopback() {
                    warn!(
                        "{address} can be reached from other machines, where everything can be \
                         read; a loopback address restricts it to this one. Under systemd \
                        IPAddressAllow= of the unit also applies"
                    );
                }
                (self.listen, self.server) = (plan.listen, Some(server));
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
            "something else listens there. Several gateways on one computer need a port each: \
             change \
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
