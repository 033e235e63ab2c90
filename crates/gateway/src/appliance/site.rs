//! Where the gateway's telemetry is served and published, and the log lines about it.

use super::http::{Desk, DeskPlan, Identity, Server, TlsFiles};
use super::outputs::{Output, OutputPlan, UNIT, advice_on, outputs};
use super::store::StoreHandle;
use super::telemetry::Recorder;
use std::net::SocketAddr;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use tracing::{info, warn};

/// What the configuration asks for.
#[derive(Clone, Debug)]
pub struct SitePlan {
    /// Address to listen on; port 0 becomes another one. `None`: there is no server.
    pub listen: Option<SocketAddr>,
    /// Files of the certificate; `None`: what is sent is not encrypted.
    pub tls: Option<TlsFiles>,
    pub desk: DeskPlan,
    pub outputs: OutputPlan,
}

/// The servers, as far as there are any. The gateway also works without them.
#[derive(Debug)]
pub(super) struct Site {
    /// Address as requested; port 0 becomes another one.
    listen: Option<SocketAddr>,
    desk: Desk,
    server: Option<Server>,
    outputs: Vec<Box<dyn Output>>,
}

impl Site {
    /// A site that serves what `store` keeps, and lets people ask for recordings by `demand`.
    pub fn new(store: StoreHandle, demand: Arc<AtomicBool>) -> Self {
        let desk = Desk::new(store, demand);
        Self { listen: None, desk, server: None, outputs: outputs() }
    }

    /// Serves what `recorder` writes by `plan` from now on. Where that fails, the previous servers continue.
    pub fn listen(&mut self, plan: SitePlan, recorder: &Recorder) {
        for output in &mut self.outputs {
            output.follow(&plan.outputs, recorder);
        }
        self.listen_for_http(plan, recorder);
    }

    fn listen_for_http(&mut self, plan: SitePlan, recorder: &Recorder) {
        self.desk.follow(plan.desk);
        let Some(wanted) = plan.listen else {
            if self.server.take().is_some() {
                info!("telemetry over HTTP is now off");
            }
            self.listen = None;
            return;
        };
        let Ok(identity) = self.identity(plan.tls.as_ref(), recorder, wanted) else { return };
        if let Some(server) = self.server.as_ref().filter(|_| self.listen == plan.listen) {
            server.identify(identity);
            return;
        }
        let scheme = if identity.is_some() { "https" } else { "http" };
        match Server::start(wanted, recorder, self.desk.clone(), identity) {
            Ok(server) => {
                let address = server.address();
                info!(
                    "page: {scheme}://{address}/, telemetry: {scheme}://{address}/health and \
                     {scheme}://{address}/metrics"
                );
                if !address.ip().is_loopback() {
                    warn!(
                        "{address} can be reached from other machines, where /health and /metrics can be read \
                         without a login; a loopback address restricts it to this one. {UNIT}"
                    );
                }
                (self.listen, self.server) = (plan.listen, Some(server));
            }
            Err(error) => {
                let help = advice_on(&error, "http.listen");
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

    /// The identity in `files`, or that there is none. One that cannot be used is told, and so is one whose time is
    /// over; then nothing changes on `wanted`.
    fn identity(
        &self,
        files: Option<&TlsFiles>,
        recorder: &Recorder,
        wanted: SocketAddr,
    ) -> Result<Option<Identity>, ()> {
        let Some(files) = files else { return Ok(None) };
        let identity = Identity::read(files).map_err(|error| {
            let then = match &self.server {
                None => "nothing is served over HTTP",
                Some(_) => "what was served before still is",
            };
            warn!("no TLS on {wanted}: {error}. Until a reload finds it right, {then}");
        })?;
        if let Some(lapse) = identity.lapse(recorder.clock().system()) {
            warn!("the certificate in {} {lapse}", files.certificate.display());
        }
        Ok(Some(identity))
    }
}
