//! Where the gateway's telemetry is served and published, and the log lines about it.

use super::http::{Desk, DeskPlan, Identity, Server, TlsFiles};
use super::modbus::ModbusServer;
use super::mqtt::{MqttPlan, MqttPublisher};
use super::opcua::OpcuaServer;
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
    /// Files of the certificate; `None`: what is sent is not encrypted.
    pub tls: Option<TlsFiles>,
    pub desk: DeskPlan,
    /// Address to listen on for Modbus; port 0 becomes another one. `None`: there is no such server.
    pub modbus: Option<SocketAddr>,
    /// Address to listen on for OPC UA, in the same way.
    pub opcua: Option<SocketAddr>,
    /// What is published over MQTT; `None`: nothing.
    pub mqtt: Option<MqttPlan>,
}

/// The servers, as far as there are any. The gateway also works without them.
#[derive(Debug, Default)]
pub(super) struct Site {
    /// Address as requested; port 0 becomes another one.
    listen: Option<SocketAddr>,
    desk: Desk,
    server: Option<Server>,
    /// The Modbus server, and its address as requested.
    modbus: Option<(SocketAddr, ModbusServer)>,
    /// The OPC UA server, and its address as requested.
    opcua: Option<(SocketAddr, OpcuaServer)>,
    /// The publisher, and its plan.
    mqtt: Option<(MqttPlan, MqttPublisher)>,
}

impl Site {
    /// A site that serves what `store` keeps, and lets people ask for recordings by `demand`.
    pub fn new(store: StoreHandle, demand: Arc<AtomicBool>) -> Self {
        Self { desk: Desk::new(store, demand), ..Self::default() }
    }

    /// Serves what `recorder` writes by `plan` from now on. Where that fails, the previous servers continue.
    pub fn listen(&mut self, mut plan: SitePlan, recorder: &Recorder) {
        let start = |listen| ModbusServer::start(listen, recorder);
        follow(&MODBUS, &mut self.modbus, plan.modbus, start, ModbusServer::address);
        let start = |listen| OpcuaServer::start(listen, recorder);
        follow(&OPCUA, &mut self.opcua, plan.opcua, start, OpcuaServer::address);
        self.publish(plan.mqtt.take(), recorder);
        self.listen_for_http(plan, recorder);
    }

    fn publish(&mut self, wanted: Option<MqttPlan>, recorder: &Recorder) {
        if self.mqtt.as_ref().map(|(plan, _)| plan) == wanted.as_ref() {
            return;
        }
        // The one before goes first: a broker knows both by the same name.
        if self.mqtt.take().is_some() && wanted.is_none() {
            info!("nothing is published over MQTT any more");
        }
        let Some(plan) = wanted else { return };
        if plan.store.is_none() {
            info!("without `store.file` no events are published over MQTT, only the state");
        }
        if plan.login.is_some() && plan.authority.is_none() {
            warn!(
                "the password for {}:{} is sent unencrypted; `mqtt.authority` encrypts",
                plan.host, plan.port
            );
        }
        match MqttPublisher::start(plan.clone(), recorder) {
            Ok(publisher) => self.mqtt = Some((plan, publisher)),
            Err(error) => warn!("nothing is published over MQTT: {error}"),
        }
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
                let help = help(&error, "http.listen");
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

/// A protocol over which the state is served, in words.
struct Protocol {
    name: &'static str,
    /// What precedes the address.
    title: &'static str,
    /// What everybody should know who lets others reach it.
    warning: &'static str,
    key: &'static str,
}

const MODBUS: Protocol = Protocol {
    name: "Modbus",
    title: "Modbus TCP, read only: ",
    warning: "Modbus knows no login",
    key: "modbus.listen",
};

const OPCUA: Protocol = Protocol {
    name: "OPC UA",
    title: "OPC UA, read only: opc.tcp://",
    warning: "nothing is asked of them or encrypted",
    key: "opcua.listen",
};

/// Has what `served` holds listen on `wanted`, or on nothing. Where it cannot, the previous server continues.
fn follow<S>(
    protocol: &Protocol,
    served: &mut Option<(SocketAddr, S)>,
    wanted: Option<SocketAddr>,
    start: impl FnOnce(SocketAddr) -> io::Result<S>,
    address: impl Fn(&S) -> SocketAddr,
) {
    let Protocol { name, title, warning, key } = protocol;
    let Some(wanted) = wanted else {
        if served.take().is_some() {
            info!("{name} is now off");
        }
        return;
    };
    if served.as_ref().is_some_and(|(listen, _)| *listen == wanted) {
        return;
    }
    match start(wanted) {
        Ok(server) => {
            let address = address(&server);
            info!("{title}{address}");
            if !address.ip().is_loopback() {
                warn!("{address} can be reached from other machines, and {warning}. {UNIT}");
            }
            *served = Some((wanted, server));
        }
        Err(error) => {
            let help = help(&error, key);
            let then = match served {
                None => String::new(),
                Some((_, old)) => format!(". It stays on {}", address(old)),
            };
            warn!("no {name} on {wanted}: {error}; {help}{then}");
        }
    }
}

/// What else decides who reaches a server.
const UNIT: &str = "Under systemd IPAddressAllow= of the unit also applies";

/// Advice on an error of the address in the configuration's `key`.
fn help(error: &io::Error, key: &str) -> String {
    let (reason, then) = match error.kind() {
        ErrorKind::AddrInUse => (
            "something else listens there. Several gateways on one computer need a port each: ",
            "",
        ),
        ErrorKind::AddrNotAvailable => ("no interface of this machine has the address: ", ""),
        ErrorKind::PermissionDenied => {
            ("ports below 1024 need a privilege, which the gateway does without: ", "")
        }
        _ => ("", "; or switch it off with \"off\""),
    };
    format!("{reason}change `{key}`, then reload{then}")
}
