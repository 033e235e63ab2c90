//! The identity of the server: its certificate and key, as files of PEM.

use std::fs::{self, File};
use std::io::{self, Read};
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use tertius_core::time::Timestamp;
use thiserror::Error;
use tokio_rustls::rustls::crypto::ring;
use tokio_rustls::rustls::pki_types::pem::PemObject;
use tokio_rustls::rustls::pki_types::{CertificateDer, PrivateKeyDer};
use tokio_rustls::rustls::{self, ServerConfig};
use x509_cert::Certificate;
use x509_cert::der::Decode;

/// Most bytes of a file; a chain of certificates has some thousands.
const LARGEST_FILE: u64 = 1 << 20;

/// Permissions of those who are neither the owner of a file nor of its group.
const OTHERS: u32 = 0o007;

/// Where certificate and key are.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TlsFiles {
    /// The certificate, and those that certify it, up to but without that of the root.
    pub certificate: PathBuf,
    pub key: PathBuf,
}

/// A certificate with its key.
#[derive(Clone, Debug)]
pub struct Identity {
    pub(super) config: Arc<ServerConfig>,
    /// First and last time at which the certificate is valid.
    valid: [Timestamp; 2],
}

/// Why there is no identity.
#[derive(Debug, Error)]
pub enum IdentityError {
    #[error("{path} cannot be read: {error}")]
    Unreadable { path: PathBuf, error: io::Error },
    #[error("{path} has more than {LARGEST_FILE} bytes, which is no certificate or key")]
    TooLong { path: PathBuf },
    #[error(
        "{path} is the private key, and everybody on this computer may read it (mode {mode:03o}): chmod 640 {path}"
    )]
    Public { path: PathBuf, mode: u32 },
    #[error("{path} has no certificate in PEM (-----BEGIN CERTIFICATE-----)")]
    NoCertificate { path: PathBuf },
    #[error("{path} has no private key in PEM without a passphrase (-----BEGIN PRIVATE KEY-----)")]
    NoKey { path: PathBuf },
    #[error(
        "the key in {key} is not that of the first certificate in {certificate}; give the two that belong together"
    )]
    Mismatch { key: PathBuf, certificate: PathBuf },
    #[error("the certificate in {certificate} cannot be used: {reason}")]
    Unusable { certificate: PathBuf, reason: String },
}

impl Identity {
    /// The identity in `files`.
    ///
    /// # Errors
    /// A file that is missing, that others may read, or that is not what it should be.
    pub fn read(files: &TlsFiles) -> Result<Self, IdentityError> {
        let TlsFiles { certificate, key } = files;
        let chain: Result<Vec<_>, _> =
            CertificateDer::pem_slice_iter(&read(certificate, 0)?).collect();
        let chain = chain.unwrap_or_default();
        let Some(first) = chain.first() else {
            return Err(IdentityError::NoCertificate { path: certificate.clone() });
        };
        let valid = validity(first).map_err(|reason| unusable(certificate, reason))?;
        let secret = PrivateKeyDer::from_pem_slice(&read(key, OTHERS)?);
        let secret = secret.map_err(|_| IdentityError::NoKey { path: key.clone() })?;
        let provider = Arc::new(ring::default_provider());
        let config = ServerConfig::builder_with_provider(provider)
            .with_safe_default_protocol_versions()
            .map_err(|error| unusable(certificate, error.to_string()))?
            .with_no_client_auth()
            .with_single_cert(chain, secret);
        let mut config = config.map_err(|error| match error {
            rustls::Error::InconsistentKeys(_) => {
                IdentityError::Mismatch { key: key.clone(), certificate: certificate.clone() }
            }
            other => unusable(certificate, other.to_string()),
        })?;
        config.alpn_protocols = vec![b"http/1.1".to_vec()];
        Ok(Self { config: Arc::new(config), valid })
    }

    /// What people who look at `now` have to know of its validity; `None` where it is valid.
    pub fn lapse(&self, now: Timestamp) -> Option<String> {
        let [begin, end] = self.valid;
        let days = |from: Timestamp, to: Timestamp| to.since(from).as_seconds() / 86_400.0;
        if now > end {
            return Some(format!("has expired {:.0} days ago: browsers refuse it", days(end, now)));
        }
        (now < begin).then(|| {
            let days = days(now, begin);
            format!("is valid only in {days:.0} days: look at the clock of this computer")
        })
    }
}

fn unusable(certificate: &Path, reason: String) -> IdentityError {
    IdentityError::Unusable { certificate: certificate.to_owned(), reason }
}

/// The bytes of the file `path`, which must have none of these permissions.
fn read(path: &Path, forbidden: u32) -> Result<Vec<u8>, IdentityError> {
    let unreadable = |error| IdentityError::Unreadable { path: path.to_owned(), error };
    // To open a pipe would wait for somebody who writes into it.
    if !fs::metadata(path).map_err(unreadable)?.is_file() {
        return Err(unreadable(io::Error::other("it is no file")));
    }
    let file = File::open(path).map_err(unreadable)?;
    let mode = file.metadata().map_err(unreadable)?.permissions().mode() & 0o777;
    if mode & forbidden != 0 {
        return Err(IdentityError::Public { path: path.to_owned(), mode });
    }
    let mut bytes = Vec::new();
    file.take(LARGEST_FILE + 1).read_to_end(&mut bytes).map_err(unreadable)?;
    if bytes.len() as u64 > LARGEST_FILE {
        return Err(IdentityError::TooLong { path: path.to_owned() });
    }
    Ok(bytes)
}

/// First and last time at which a certificate is valid.
fn validity(certificate: &CertificateDer<'_>) -> Result<[Timestamp; 2], String> {
    let certificate = Certificate::from_der(certificate).map_err(|error| error.to_string())?;
    let validity = certificate.tbs_certificate().validity();
    let times = [validity.not_before, validity.not_after];
    Ok(times.map(|time| {
        let nanos = time.to_unix_duration().as_nanos();
        Timestamp::from_nanos(i64::try_from(nanos).unwrap_or(i64::MAX))
    }))
}
