//! The files by which the page is served over TLS.

use super::machine::Machine;
use crate::appliance::http::TlsFiles;
use std::path::Path;

/// Certificate and key of the page, relative to the configuration `path`.
pub fn tls_files(path: &Path, machine: &Machine) -> Option<TlsFiles> {
    let http = &machine.loaded.settings.http;
    let folder = path.parent().unwrap_or(Path::new(""));
    let (certificate, key) = http.certificate.as_ref().zip(http.key.as_ref())?;
    Some(TlsFiles { certificate: folder.join(certificate), key: folder.join(key) })
}
