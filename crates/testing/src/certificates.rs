//! Certificates of their own for gateways that serve their page over https.

use rcgen::{BasicConstraints, CertificateParams, IsCa, Issuer, KeyPair, date_time_ymd};
use std::fs::{self, Permissions};
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use tertius::appliance::http::TlsFiles;

/// Writes a certificate of `localhost` that ends with the year before `end`, and its key, as `name.crt` and `name.key`.
pub fn certify(folder: &Path, name: &str, end: i32) -> TlsFiles {
    let pair = KeyPair::generate().expect("a key");
    let certificate = of_localhost(end).self_signed(&pair).expect("it signs itself");
    put(folder, name, &certificate.pem(), &pair)
}

/// Writes a certificate of `localhost` and its key, and the one of who certified it, whose path is the first.
pub fn certify_by_authority(folder: &Path) -> (String, TlsFiles) {
    let mut about = of_localhost(2100);
    about.is_ca = IsCa::Ca(BasicConstraints::Unconstrained);
    let own = KeyPair::generate().expect("a key");
    let authority = about.self_signed(&own).expect("it signs itself");
    let path = folder.join("authority.crt");
    fs::write(&path, authority.pem()).expect("the folder is ours");
    let pair = KeyPair::generate().expect("a key");
    let signed = of_localhost(2100).signed_by(&pair, &Issuer::new(about, own));
    (path.display().to_string(), put(folder, "page", &signed.expect("it is signed").pem(), &pair))
}

fn of_localhost(end: i32) -> CertificateParams {
    let mut about = CertificateParams::new(vec!["localhost".to_owned()]).expect("a name");
    about.not_before = date_time_ymd(2020, 1, 1);
    about.not_after = date_time_ymd(end, 1, 1);
    about
}

fn put(folder: &Path, name: &str, certificate: &str, pair: &KeyPair) -> TlsFiles {
    let files = TlsFiles {
        certificate: folder.join(format!("{name}.crt")),
        key: folder.join(format!("{name}.key")),
    };
    fs::write(&files.certificate, certificate).expect("the folder is ours");
    fs::write(&files.key, pair.serialize_pem()).expect("the folder is ours");
    allow(&files.key, 0o600);
    files
}

/// Sets the mode of a file.
pub fn allow(path: &Path, mode: u32) {
    fs::set_permissions(path, Permissions::from_mode(mode)).expect("the file is ours");
}
