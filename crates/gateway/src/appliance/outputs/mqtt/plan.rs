//! Where and as whom the publisher connects.

use super::sparkplug::EdgeNode;
use crate::appliance::outputs::OutputPlan;
use std::fs::{self, File};
use std::io::{self, Read};
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;
use tertius_config::settings::SYSTEM;
use thiserror::Error;
use tokio_rustls::TlsConnector;
use tokio_rustls::rustls::crypto::ring;
use tokio_rustls::rustls::pki_types::CertificateDer;
use tokio_rustls::rustls::pki_types::pem::PemObject;
use tokio_rustls::rustls::{ClientConfig, RootCertStore};

/// Most bytes of a file of certificates, and of one with a password.
const LARGEST_AUTHORITY: u64 = 1 << 20;
const LARGEST_PASSWORD: u64 = 1024;

/// Permissions of those who are neither the owner of a file nor of its group.
const OTHERS: u32 = 0o007;

/// What is published where.
#[derive(Clone, Debug, PartialEq)]
pub struct MqttPlan {
    /// Name or address of the broker.
    pub host: String,
    pub port: u16,
    /// First levels of the topics.
    pub topic: String,
    /// User, and the file with the password.
    pub login: Option<(String, PathBuf)>,
    /// Who certifies the broker; `None`: nothing is encrypted.
    pub authority: Option<Authority>,
    /// Longest time from one state to the next.
    pub period: Duration,
    /// Event store whose news are published; `None`: there are none.
    pub store: Option<PathBuf>,
    /// The edge node as which everything is published by Sparkplug B; `None`: it is published as JSON.
    pub sparkplug: Option<EdgeNode>,
}

/// Who certifies a broker.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Authority {
    /// Whom this computer trusts.
    System,
    /// The certificates (PEM) in this file.
    File(PathBuf),
}

/// Why a file of the plan cannot be used.
#[derive(Debug, Error)]
pub enum MqttFileError {
    #[error("{path} cannot be read: {error}")]
    Unreadable { path: PathBuf, error: io::Error },
    #[error("{path} has more than {largest} bytes, which is no {what}")]
    TooLong { path: PathBuf, largest: u64, what: &'static str },
    #[error(
        "{path} is the password, and everybody on this computer may read it (mode {mode:03o}): chmod 640 {path}"
    )]
    Public { path: PathBuf, mode: u32 },
    #[error("{path} has no password: one line of text")]
    NoPassword { path: PathBuf },
    #[error("{path} has no certificate in PEM (-----BEGIN CERTIFICATE-----) that can be used")]
    NoCertificate { path: PathBuf },
    #[error(
        "this computer trusts nobody, so that no broker is certified: {reason}; install ca-certificates, or name a file"
    )]
    Nobody { reason: String },
    #[error("no TLS: {0}")]
    Tls(#[from] tokio_rustls::rustls::Error),
}

impl MqttPlan {
    /// What the configuration has published; `None`: nothing.
    pub fn of(plan: &OutputPlan) -> Option<Self> {
        let mqtt = &plan.settings.mqtt;
        let (host, port) = mqtt.address()?;
        let password = mqtt.password.as_ref().map(|password| plan.folder.join(password));
        let authority = mqtt.authority.as_deref();
        let edge = mqtt.edge();
        Some(Self {
            host: host.to_owned(),
            port,
            topic: mqtt.topic.clone(),
            login: mqtt.user.clone().zip(password),
            authority: authority.map(|name| Authority::named(name, &plan.folder)),
            period: Duration::from_secs_f64(mqtt.period),
            store: plan.store.clone(),
            sparkplug: edge
                .map(|(group, node)| EdgeNode { group: group.to_owned(), node: node.to_owned() }),
        })
    }

    /// Client identifier: another one for each gateway of a broker, as the topic is.
    pub fn client(&self) -> String {
        let plain = |c: char| if c.is_ascii_alphanumeric() { c } else { '-' };
        let name = self.sparkplug.as_ref().map_or(self.topic.clone(), EdgeNode::to_string);
        format!("tertius-{}", name.chars().map(plain).collect::<String>())
    }

    /// User and password, read anew for each connection.
    pub(super) fn credentials(&self) -> Result<Option<[String; 2]>, MqttFileError> {
        let Some((user, path)) = &self.login else { return Ok(None) };
        let text = read(path, LARGEST_PASSWORD, "password", OTHERS)?;
        let text = String::from_utf8(text).unwrap_or_default();
        let password = text.trim_end_matches(['\r', '\n']);
        if password.is_empty() || password.contains(char::is_control) {
            return Err(MqttFileError::NoPassword { path: path.clone() });
        }
        Ok(Some([user.clone(), password.to_owned()]))
    }

    /// What encrypts the connection; `None` if nothing does.
    pub(super) fn connector(&self) -> Result<Option<TlsConnector>, MqttFileError> {
        let Some(authority) = &self.authority else { return Ok(None) };
        let roots = authority.roots()?;
        let config = ClientConfig::builder_with_provider(Arc::new(ring::default_provider()))
            .with_safe_default_protocol_versions()?
            .with_root_certificates(roots)
            .with_no_client_auth();
        Ok(Some(TlsConnector::from(Arc::new(config))))
    }
}

impl Authority {
    /// The authority that a configuration in `folder` calls `name`: a file, or `system`.
    pub fn named(name: &str, folder: &Path) -> Self {
        if name == SYSTEM { Self::System } else { Self::File(folder.join(name)) }
    }

    /// The certificates, read anew for each connection.
    fn roots(&self) -> Result<RootCertStore, MqttFileError> {
        let mut roots = RootCertStore::empty();
        match self {
            Self::System => {
                let found = rustls_native_certs::load_native_certs();
                roots.add_parsable_certificates(found.certs);
                if roots.is_empty() {
                    let reason = found.errors.first().map(ToString::to_string);
                    let reason = reason.unwrap_or_else(|| "it has no certificate".to_owned());
                    return Err(MqttFileError::Nobody { reason });
                }
            }
            Self::File(path) => {
                let text = read(path, LARGEST_AUTHORITY, "file of certificates", 0)?;
                let found: Result<Vec<_>, _> = CertificateDer::pem_slice_iter(&text).collect();
                roots.add_parsable_certificates(found.unwrap_or_default());
                if roots.is_empty() {
                    return Err(MqttFileError::NoCertificate { path: path.clone() });
                }
            }
        }
        Ok(roots)
    }
}

/// The bytes of the file `path`, which must have none of these permissions.
fn read(
    path: &Path,
    largest: u64,
    what: &'static str,
    forbidden: u32,
) -> Result<Vec<u8>, MqttFileError> {
    let unreadable = |error| MqttFileError::Unreadable { path: path.to_owned(), error };
    // To open a pipe would wait for somebody who writes into it.
    let found = fs::metadata(path).map_err(unreadable)?;
    if !found.is_file() {
        return Err(unreadable(io::Error::other("it is no file")));
    }
    let mode = found.permissions().mode() & 0o777;
    if mode & forbidden != 0 {
        return Err(MqttFileError::Public { path: path.to_owned(), mode });
    }
    let mut bytes = Vec::new();
    let file = File::open(path).map_err(unreadable)?;
    file.take(largest + 1).read_to_end(&mut bytes).map_err(unreadable)?;
    if bytes.len() as u64 > largest {
        return Err(MqttFileError::TooLong { path: path.to_owned(), largest, what });
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plan(login: Option<(String, PathBuf)>) -> MqttPlan {
        MqttPlan {
            host: "broker".to_owned(),
            port: 1883,
            topic: "ship/gangway 1".to_owned(),
            login,
            authority: None,
            period: Duration::from_secs(10),
            store: None,
            sparkplug: None,
        }
    }

    #[test]
    fn a_password_is_one_line_that_others_cannot_read() {
        let folder = tempfile::tempdir().expect("there is room");
        let path = folder.path().join("password");
        let plan = plan(Some(("gateway".to_owned(), path.clone())));
        let told = || plan.credentials().expect_err("it is no password").to_string();
        let permit = |mode| fs::set_permissions(&path, PermissionsExt::from_mode(mode));
        assert!(told().contains("cannot be read"), "{}", told());
        for (text, wrong) in [("", "no password"), ("\n", "no password"), ("a\nb\n", "no password")]
        {
            fs::write(&path, text).expect("the folder is ours");
            permit(0o600).expect("it is ours");
            assert!(told().contains(wrong), "{text:?}: {}", told());
        }
        fs::write(&path, "p w\n").expect("the folder is ours");
        permit(0o644).expect("it is ours");
        assert!(told().contains("chmod 640"), "{}", told());
        permit(0o640).expect("it is ours");
        let expected = Some(["gateway".to_owned(), "p w".to_owned()]);
        assert_eq!(plan.credentials().expect("it is one"), expected);
        assert_eq!(plan.client(), "tertius-ship-gangway-1");
    }
}
