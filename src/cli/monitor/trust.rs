//! Who is believed to be the gateway over https, and the token by which it believes us.

use crate::cli::Failure;
use axum::http::HeaderValue;
use std::fs::File;
use std::io::Read;
use std::path::Path;
use std::sync::Arc;
use tokio::net::TcpStream;
use tokio_rustls::TlsConnector;
use tokio_rustls::client::TlsStream;
use tokio_rustls::rustls::client::WebPkiServerVerifier;
use tokio_rustls::rustls::client::danger::{
    HandshakeSignatureValid, ServerCertVerified, ServerCertVerifier,
};
use tokio_rustls::rustls::crypto::ring;
use tokio_rustls::rustls::pki_types::pem::PemObject;
use tokio_rustls::rustls::pki_types::{CertificateDer, ServerName, UnixTime};
use tokio_rustls::rustls::{
    self, CertificateError, ClientConfig, DigitallySignedStruct, RootCertStore, SignatureScheme,
};

/// Most bytes of a file of certificates: that of a whole system has some hundred kilobytes.
const LARGEST_FILE: u64 = 4 << 20;

/// Most bytes of a file with a token.
const LARGEST_TOKEN: u64 = 1024;

/// The variable that bears the token where no file is named.
const VARIABLE: &str = "TERTIUS_TOKEN";

/// What a gateway has to show.
pub struct Trust {
    connector: TlsConnector,
    name: ServerName<'static>,
}

impl Trust {
    /// For the gateway `host`, by the certificates in the file `authorities`, else by those that this computer trusts.
    ///
    /// # Errors
    /// The file has no certificates, or this computer has none.
    pub fn new(host: &str, authorities: Option<&Path>) -> Result<Self, Failure> {
        let name = ServerName::try_from(host.to_owned())
            .map_err(|_| Failure::Wrong(format!("{host:?} is no name and no address of a host")))?;
        let known = match authorities {
            Some(path) => certificates(path)?,
            None => rustls_native_certs::load_native_certs().certs,
        };
        let mut roots = RootCertStore::empty();
        roots.add_parsable_certificates(known.iter().cloned());
        let unusable = |error: &dyn std::fmt::Display| {
            let source = authorities.map_or_else(
                || "this computer trusts nobody".to_owned(),
                |path| format!("{} cannot be used", path.display()),
            );
            Failure::Failed(format!("{source}: {error}; give certificates with --ca FILE"))
        };
        let provider = Arc::new(ring::default_provider());
        let usual = WebPkiServerVerifier::builder_with_provider(roots.into(), provider.clone());
        let usual = usual.build().map_err(|error| unusable(&error))?;
        let named = if authorities.is_some() { known } else { Vec::new() };
        let config = ClientConfig::builder_with_provider(provider)
            .with_safe_default_protocol_versions()
            .map_err(|error| unusable(&error))?
            .dangerous()
            .with_custom_certificate_verifier(Arc::new(Verifier { usual, named }))
            .with_no_client_auth();
        Ok(Self { connector: TlsConnector::from(Arc::new(config)), name })
    }

    /// Encrypts `stream`.
    ///
    /// # Errors
    /// Who answers is not trusted, with the reason.
    pub async fn connect(&self, stream: TcpStream) -> Result<TlsStream<TcpStream>, String> {
        let connected = self.connector.connect(self.name.clone(), stream).await;
        connected.map_err(|error| {
            let refused = error.get_ref().and_then(|it| it.downcast_ref::<rustls::Error>());
            refused.map_or_else(|| error.to_string(), refusal)
        })
    }
}

/// Takes a certificate that was named itself, and judges every other one as usual. The usual way refuses one that
/// certifies itself and says that it may certify others, as those of `openssl req -x509` do.
#[derive(Debug)]
struct Verifier {
    usual: Arc<WebPkiServerVerifier>,
    named: Vec<CertificateDer<'static>>,
}

impl ServerCertVerifier for Verifier {
    fn verify_server_cert(
        &self,
        end_entity: &CertificateDer<'_>,
        intermediates: &[CertificateDer<'_>],
        server_name: &ServerName<'_>,
        ocsp_response: &[u8],
        now: UnixTime,
    ) -> Result<ServerCertVerified, rustls::Error> {
        if self.named.contains(end_entity) {
            return Ok(ServerCertVerified::assertion());
        }
        let usual = &self.usual;
        usual.verify_server_cert(end_entity, intermediates, server_name, ocsp_response, now)
    }

    fn verify_tls12_signature(
        &self,
        message: &[u8],
        certificate: &CertificateDer<'_>,
        signature: &DigitallySignedStruct,
    ) -> Result<HandshakeSignatureValid, rustls::Error> {
        self.usual.verify_tls12_signature(message, certificate, signature)
    }

    fn verify_tls13_signature(
        &self,
        message: &[u8],
        certificate: &CertificateDer<'_>,
        signature: &DigitallySignedStruct,
    ) -> Result<HandshakeSignatureValid, rustls::Error> {
        self.usual.verify_tls13_signature(message, certificate, signature)
    }

    fn supported_verify_schemes(&self) -> Vec<SignatureScheme> {
        self.usual.supported_verify_schemes()
    }
}

fn refusal(error: &rustls::Error) -> String {
    let rustls::Error::InvalidCertificate(why) = error else {
        return format!("no encrypted connection: {error}");
    };
    match why {
        // The second is of who has the same name and another key.
        CertificateError::UnknownIssuer | CertificateError::BadSignature => {
            "nobody who is trusted here has certified it: give its certificate, or that of who did, with --ca FILE"
                .to_owned()
        }
        CertificateError::Expired | CertificateError::ExpiredContext { .. } => {
            "its certificate has expired".to_owned()
        }
        CertificateError::NotValidForName | CertificateError::NotValidForNameContext { .. } => {
            "its certificate is for a host of another name: use that name, or give the certificate itself with --ca FILE"
                .to_owned()
        }
        other => format!("its certificate is refused: {other}"),
    }
}

/// What is told where the gateway asks for the token.
pub fn unauthorized(given: bool) -> String {
    let what = if given { "it refuses the token" } else { "it asks for its token" };
    format!("{what}: give that of its [http] with --token-file FILE or {VARIABLE}")
}

/// The header with the token in the file, else with that in the environment.
///
/// # Errors
/// The file cannot be read, or what is there is no token.
pub fn token(file: Option<&Path>) -> Result<Option<HeaderValue>, Failure> {
    let (place, text) = match file {
        Some(path) => (path.display().to_string(), read(path, LARGEST_TOKEN, "token")?),
        None => match std::env::var_os(VARIABLE) {
            Some(value) => (VARIABLE.to_owned(), value.into_encoded_bytes()),
            None => return Ok(None),
        },
    };
    let text = String::from_utf8(text).unwrap_or_default();
    let text = text.trim();
    let is_one = !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_graphic());
    let header = HeaderValue::from_str(&format!("Bearer {text}")).ok().filter(|_| is_one);
    let Some(mut header) = header else {
        return Err(Failure::Wrong(format!(
            "{place} has no token: one word, as `tertius token` makes it"
        )));
    };
    header.set_sensitive(true);
    Ok(Some(header))
}

fn certificates(path: &Path) -> Result<Vec<CertificateDer<'static>>, Failure> {
    let text = read(path, LARGEST_FILE, "file of certificates")?;
    let found: Result<Vec<_>, _> = CertificateDer::pem_slice_iter(&text).collect();
    found.ok().filter(|found| !found.is_empty()).ok_or_else(|| {
        let name = path.display();
        Failure::Wrong(format!("{name} has no certificate in PEM (-----BEGIN CERTIFICATE-----)"))
    })
}

fn read(path: &Path, largest: u64, what: &str) -> Result<Vec<u8>, Failure> {
    let name = path.display();
    let mut text = Vec::new();
    let read = File::open(path).and_then(|file| file.take(largest + 1).read_to_end(&mut text));
    read.map_err(|error| Failure::Wrong(format!("{name} cannot be read: {error}")))?;
    if text.len() as u64 > largest {
        return Err(Failure::Wrong(format!(
            "{name} has more than {largest} bytes, which is no {what}"
        )));
    }
    Ok(text)
}
