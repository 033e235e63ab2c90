//! Outputs that listen on an address of their own.

use super::{Output, OutputPlan};
use crate::appliance::telemetry::Recorder;
use std::fmt::Debug;
use std::io::{self, ErrorKind};
use std::net::SocketAddr;
use tertius_config::settings::Settings;
use tracing::{info, warn};

/// A protocol in words.
pub struct ServedProtocol {
    pub name: &'static str,
    /// What precedes the address.
    pub title: &'static str,
    /// What everybody should know who lets others reach it.
    pub warning: &'static str,
    /// Key of the configuration that has its address.
    pub key: &'static str,
}

/// A server of the machine's state; it ends when this is dropped.
pub trait StateServer: Debug + Sized {
    const PROTOCOL: ServedProtocol;

    /// Address to listen on; `None`: it is switched off.
    fn wanted(settings: &Settings) -> Option<SocketAddr>;

    /// Serves what `recorder` writes on `listen`, or on a free port if its port is 0.
    ///
    /// # Errors
    /// The address is in use or not available, or the system provides no thread.
    fn start(listen: SocketAddr, recorder: &Recorder) -> io::Result<Self>;

    /// Address that the server listens on.
    fn address(&self) -> SocketAddr;
}

/// The output of a server `S`, and its address as requested.
#[derive(Debug)]
pub struct Listening<S>(Option<(SocketAddr, S)>);

impl<S> Default for Listening<S> {
    fn default() -> Self {
        Self(None)
    }
}

impl<S: StateServer> Output for Listening<S> {
    fn follow(&mut self, plan: &OutputPlan, recorder: &Recorder) {
        let ServedProtocol { name, title, warning, key } = S::PROTOCOL;
        let Some(wanted) = S::wanted(&plan.settings) else {
            if self.0.take().is_some() {
                info!("{name} is now off");
            }
            return;
        };
        if self.0.as_ref().is_some_and(|(listen, _)| *listen == wanted) {
            return;
        }
        match S::start(wanted, recorder) {
            Ok(server) => {
                let address = server.address();
                info!("{title}{address}");
                if !address.ip().is_loopback() {
                    warn!("{address} can be reached from other machines, and {warning}. {UNIT}");
                }
                self.0 = Some((wanted, server));
            }
            Err(error) => {
                let advice = advice_on(&error, key);
                let then = match &self.0 {
                    None => String::new(),
                    Some((_, old)) => format!(". It stays on {}", old.address()),
                };
                warn!("no {name} on {wanted}: {error}; {advice}{then}");
            }
        }
    }
}

/// What else decides who reaches a server.
pub const UNIT: &str = "Under systemd IPAddressAllow= of the unit also applies";

/// Advice on an error of the address in the configuration's `key`.
pub fn advice_on(error: &io::Error, key: &str) -> String {
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
