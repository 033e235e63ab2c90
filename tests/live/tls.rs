//! The page over https: certificates that are refused, logins that are needed, and clients that stand still.

use crate::metrics_support::{Answer, ask};
use std::fs;
use std::io::{self, Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;
use tempfile::TempDir;
use tertius::appliance::http::{
    Desk, DeskPlan, Identity, LoginLimits, Server, TlsFiles, TokenDigest,
};
use tertius::appliance::telemetry::Recorder;
use tertius::appliance::telemetry::clock::{Clock, SystemClock};
use tertius_testing::certificates::{allow, certify};
use tertius_testing::process::{Running, configuration, excerpt, said, wait_for, write};
use tertius_testing::program;
use tokio_rustls::rustls::crypto::ring;
use tokio_rustls::rustls::pki_types::CertificateDer;
use tokio_rustls::rustls::pki_types::pem::PemObject;
use tokio_rustls::rustls::{ClientConfig, ClientConnection, RootCertStore, StreamOwned};

const TOKEN: &str = "0123456789abcdef0123456789abcdef";

/// The answer at `address` to who trusts `certificate` alone.
pub fn ask_over_tls(address: SocketAddr, certificate: &Path, request: &str) -> io::Result<Answer> {
    let mut trusted = RootCertStore::empty();
    let certificate = CertificateDer::from_pem_file(certificate).expect("it was written");
    trusted.add(certificate).expect("it is a certificate");
    let config = ClientConfig::builder_with_provider(Arc::new(ring::default_provider()))
        .with_safe_default_protocol_versions()
        .expect("it has versions")
        .with_root_certificates(trusted)
        .with_no_client_auth();
    let name = "localhost".try_into().expect("a name");
    let client = ClientConnection::new(Arc::new(config), name).expect("a client");
    let stream = TcpStream::connect(("127.0.0.1", address.port()))?;
    stream.set_read_timeout(Some(Duration::from_secs(30)))?;
    let mut stream = StreamOwned::new(client, stream);
    stream.write_all(request.as_bytes())?;
    let mut text = String::new();
    stream.read_to_string(&mut text)?;
    Ok(Answer::new(&text))
}

/// A gateway that everybody can reach, with a certificate and a token.
struct Office {
    server: Server,
    desk: Desk,
    files: TlsFiles,
    folder: TempDir,
}

impl Office {
    fn new() -> Self {
        let folder = tempfile::tempdir().expect("there is room");
        let files = certify(folder.path(), "page", 2100);
        let identity = Identity::read(&files).expect("it is in order");
        let recorder = Recorder::new(Arc::new(SystemClock::new()));
        let desk = Desk::default();
        desk.follow(DeskPlan { token: Some(TokenDigest::of(TOKEN)), ..DeskPlan::default() });
        let everywhere = "0.0.0.0:0".parse().expect("an address");
        let server = Server::start(everywhere, &recorder, desk.clone(), Some(identity));
        Self { server: server.expect("there is a free port"), desk, files, folder }
    }

    fn ask(&self, request: &str) -> Answer {
        let certificate = &self.files.certificate;
        ask_over_tls(self.server.address(), certificate, request).expect("it answers")
    }

    fn get(&self, path: &str, headers: &str) -> Answer {
        self.ask(&format!("GET {path} HTTP/1.1\r\nHost: localhost\r\n{headers}\r\n"))
    }

    fn post(&self, path: &str, headers: &str, body: &str) -> Answer {
        let length = body.len();
        let head =
            format!("POST {path} HTTP/1.1\r\nHost: localhost\r\nContent-Length: {length}\r\n");
        self.ask(&format!("{head}{headers}\r\n{body}"))
    }

    /// The header by which a browser tells of a login with the token.
    fn cookie(&self) -> String {
        let answer =
            self.post("/login", "Origin: https://localhost\r\n", &format!("token={TOKEN}"));
        assert_eq!((answer.code, header(&answer, "location")), (303, Some("/")), "{}", answer.head);
        let cookie = header(&answer, "set-cookie").expect("a cookie");
        for words in ["__Host-", "; Path=/", "; Secure", "; HttpOnly", "; SameSite=Strict"] {
            assert!(cookie.contains(words), "{cookie}");
        }
        let pair = cookie.split(';').next().expect("it begins with name and value");
        format!("Cookie: {pair}\r\n")
    }
}

fn header<'a>(answer: &'a Answer, name: &str) -> Option<&'a str> {
    let of = |line: &'a str| line.split_once(": ").filter(|(key, _)| *key == name);
    answer.head.lines().find_map(of).map(|(_, value)| value)
}

#[test]
fn who_is_not_logged_in_reads_nothing_and_who_is_can_read_and_leave() {
    let office = Office::new();
    let entrance = office.get("/", "");
    assert_eq!((entrance.code, header(&entrance, "location")), (303, Some("/login")));
    for path in ["/api/machine", "/api/overview", "/api/stream", "/api/events", "/api/recordings"] {
        assert_eq!(office.get(path, "").code, 401, "{path}");
    }
    let form = office.get("/login", "");
    assert!(form.code == 200 && form.body.contains("type=\"password\""), "{}", form.body);
    assert!(
        form.head.contains("form-action 'self'") && !form.head.contains("script-src"),
        "{}",
        form.head
    );
    assert_eq!(office.get("/assets/page.css", "").code, 200, "the form needs it");
    assert_eq!(office.get("/health", "").code, 503, "what machines read: nothing turns here");
    for path in ["/", "/login", "/health", "/metrics", "/assets/page.css"] {
        let answer = office.get(path, "");
        assert_eq!(header(&answer, "strict-transport-security"), Some("max-age=2592000"), "{path}");
        assert_eq!(header(&answer, "x-content-type-options"), Some("nosniff"), "{path}");
    }
    let other = office.ask("GET /health HTTP/1.1\r\nHost: box.example\r\n\r\n");
    assert_eq!(other.code, 503, "a monitoring system may know this computer by any name");

    let cookie = office.cookie();
    let page = office.get("/", &cookie);
    assert!(page.code == 200 && page.body.contains("<title>Tertius"), "{}", page.head);
    assert_eq!(office.get("/api/overview", &cookie).code, 200);
    assert_eq!(
        office.get("/api/overview", &format!("Authorization: Bearer {TOKEN}\r\n")).code,
        200
    );
    assert_eq!(office.get("/api/overview", &cookie.replace("tertius=", "tertius=0")).code, 401);

    let elsewhere = format!("{cookie}Origin: https://evil.example\r\n");
    assert_eq!(office.post("/logout", &elsewhere, "").code, 403, "only this page may");
    let left = office.post("/logout", &cookie, "");
    assert_eq!((left.code, header(&left, "location")), (303, Some("/login")));
    assert!(left.head.contains("Max-Age=0"), "{}", left.head);
    assert_eq!(office.get("/api/overview", &cookie).code, 401, "it is forgotten here, too");
}

#[test]
fn a_login_without_all_that_it_needs_is_refused() {
    let office = Office::new();
    let enter = |headers: &str, body: &str| {
        let answer = office.post("/login", headers, body);
        assert_eq!(header(&answer, "set-cookie"), None, "{}", answer.head);
        answer.code
    };
    for body in ["", &format!("token={TOKEN}0"), &format!("other={TOKEN}"), "\u{e4}"] {
        assert_eq!(enter("", body), 401, "{body}");
    }
    let right = format!("token={TOKEN}");
    for elsewhere in [
        "Origin: https://evil.example\r\n",
        "Origin: null\r\n",
        "Origin: https://localhost.evil.example\r\n",
        "Sec-Fetch-Site: cross-site\r\n",
    ] {
        assert_eq!(enter(elsewhere, &right), 403, "{elsewhere}");
    }
    assert_eq!(enter("", &format!("token={}", "a".repeat(2000))), 413);

    // A login reads; it does not act.
    let cookie = office.cookie();
    let act = format!("{cookie}Content-Type: application/json\r\n");
    assert_eq!(office.post("/api/record", &act, "").code, 401);
    assert_eq!(office.post("/api/record", "Content-Type: application/json\r\n", "").code, 401);
    // With another token in force all have to log in again; without one nobody can.
    office.desk.follow(DeskPlan { token: Some(TokenDigest::of("another")), ..DeskPlan::default() });
    assert_eq!(office.get("/api/overview", &cookie).code, 401);
    office.desk.follow(DeskPlan::default());
    let refused = office.get("/", &cookie);
    assert!(refused.code == 403 && refused.body.contains("tertius token"), "{}", refused.body);
    assert_eq!(office.post("/login", "", &right).code, 403);
}

#[test]
fn wrong_tokens_are_counted_slowed_down_and_locked_out() {
    let office = Office::new();
    let cookie = office.cookie();
    let logins = LoginLimits { failures: 6, lockout: Duration::from_secs(300) };
    let token = Some(TokenDigest::of(TOKEN));
    office.desk.follow(DeskPlan { token, logins, ..DeskPlan::default() });
    for n in 0..5 {
        assert_eq!(office.post("/login", "", &format!("token={n}")).code, 401, "{n}");
    }
    let wait = |answer: &Answer| -> u64 {
        assert_eq!(answer.code, 429, "{}", answer.body);
        assert!(answer.body.contains("too many wrong tokens; try again in"), "{}", answer.body);
        header(answer, "retry-after").and_then(|wait| wait.parse().ok()).expect("seconds")
    };
    let right = format!("token={TOKEN}");
    assert_eq!(wait(&office.post("/login", "", &right)), 1, "also with the right one");
    let bearer =
        |token: &str| office.get("/api/overview", &format!("Authorization: Bearer {token}\r\n"));
    assert_eq!(wait(&bearer(TOKEN)), 1, "by whatever way");
    let mut last = bearer("wrong");
    wait_for("another try", || {
        last = bearer("wrong");
        last.code == 401
    });
    assert!(wait(&bearer(TOKEN)) > 290, "it is locked out");
    assert_eq!(office.get("/api/overview", &cookie).code, 200, "who is in stays in");
    let metrics = office.get("/metrics", "").body;
    assert!(metrics.contains("\ntertius_login_failures_total 6\n"), "{metrics}");
}

/// Only the digest is configured, so that the length is seen when somebody comes with the token.
#[test]
fn a_configured_token_that_can_be_guessed_opens_nothing() {
    let office = Office::new();
    let weak = &TOKEN[1..];
    office.desk.follow(DeskPlan { token: Some(TokenDigest::of(weak)), ..DeskPlan::default() });
    let bearer = format!("Authorization: Bearer {weak}\r\n");
    let act = format!("Content-Type: application/json\r\n{bearer}");
    for answer in [
        office.post("/login", "", &format!("token={weak}")),
        office.get("/api/overview", &bearer),
        office.post("/api/record", &act, ""),
    ] {
        assert_eq!(answer.code, 401, "{}", answer.body);
        for words in ["shorter than 128 bits", "`tertius token`"] {
            assert!(answer.body.contains(words), "{}", answer.body);
        }
    }
}

#[test]
fn no_token_is_taken_where_others_can_read_it() {
    let office = Office::new();
    office.server.identify(None);
    let plain =
        |request: &str| ask(&office.server, &format!("{request}Host: localhost\r\n\r\n")).code;
    assert_eq!(plain("GET /login HTTP/1.1\r\n"), 403);
    assert_eq!(plain("POST /login HTTP/1.1\r\nContent-Length: 0\r\n"), 403);
    assert_eq!(
        plain(&format!("GET /api/overview HTTP/1.1\r\nAuthorization: Bearer {TOKEN}\r\n")),
        403
    );
}

#[test]
fn files_that_cannot_be_used_are_refused_in_words() {
    let folder = tempfile::tempdir().expect("there is room");
    let good = certify(folder.path(), "good", 2100);
    let refused = |files: &TlsFiles, words: &[&str]| {
        let told = Identity::read(files).expect_err("it is refused").to_string();
        words.iter().for_each(|word| assert!(told.contains(word), "{told}"));
    };
    allow(&good.key, 0o644);
    refused(&good, &["good.key", "everybody on this computer may read it (mode 644)", "chmod"]);
    allow(&good.key, 0o640);
    Identity::read(&good).expect("its group may");

    let other = certify(folder.path(), "other", 2100);
    refused(
        &TlsFiles { key: other.key, ..good.clone() },
        &["good.crt", "other.key", "belong together"],
    );
    let lost = folder.path().join("lost");
    refused(&TlsFiles { key: lost.clone(), ..good.clone() }, &["lost cannot be read"]);
    refused(&TlsFiles { certificate: lost, ..good.clone() }, &["lost cannot be read"]);
    // Nor is a pipe, which would be waited for.
    let folder_itself = folder.path().to_owned();
    refused(&TlsFiles { key: folder_itself, ..good.clone() }, &["it is no file"]);
    refused(&TlsFiles { key: good.certificate.clone(), ..good.clone() }, &["mode 644"]);
    allow(&good.certificate, 0o640);
    refused(
        &TlsFiles { key: good.certificate.clone(), ..good.clone() },
        &["good.crt has no private key"],
    );
    refused(
        &TlsFiles { certificate: good.key.clone(), ..good.clone() },
        &["good.key has no certificate"],
    );
    fs::write(&good.certificate, vec![b'a'; (1 << 20) + 1]).expect("the folder is ours");
    refused(&good, &["good.crt has more than"]);

    let now = SystemClock::new().system();
    let lapse =
        |end| Identity::read(&certify(folder.path(), "old", end)).expect("it is used").lapse(now);
    assert!(lapse(2021).is_some_and(|told| told.starts_with("has expired")));
    assert_eq!(lapse(2100), None);
}

#[test]
fn a_renewed_certificate_is_shown_from_the_next_connection_on() {
    let office = Office::new();
    let renewed = certify(office.folder.path(), "renewed", 2100);
    let get = "GET /login HTTP/1.1\r\nHost: localhost\r\n\r\n";
    let shows = |files: &TlsFiles| {
        ask_over_tls(office.server.address(), &files.certificate, get)
            .is_ok_and(|it| it.code == 200)
    };
    assert!(shows(&office.files) && !shows(&renewed));
    office.server.identify(Some(Identity::read(&renewed).expect("it is in order")));
    assert!(shows(&renewed) && !shows(&office.files));
}

/// As many as there can be, and more, begin a handshake and say nothing more.
#[test]
fn handshakes_that_stand_still_hold_nobody_up_and_come_to_an_end() {
    let office = Office::new();
    let address = ("127.0.0.1", office.server.address().port());
    let still = || {
        let mut stream = TcpStream::connect(address).expect("it listens");
        // The begin of a client's greeting.
        stream.write_all(&[0x16, 0x03, 0x01]).expect("it takes it");
        stream.set_read_timeout(Some(Duration::from_secs(30))).expect("a time limit");
        stream
    };
    let mut standing: Vec<TcpStream> = (0..40).map(|_| still()).collect();
    assert_eq!(office.get("/login", "").code, 200);
    for stream in &mut standing {
        // An end or a reset, but no time-out.
        let ended = stream.read(&mut [0; 16]);
        let is_over = match &ended {
            Ok(read) => *read == 0,
            Err(error) => error.kind() == io::ErrorKind::ConnectionReset,
        };
        assert!(is_over, "{ended:?}");
    }
    assert!(
        ask_over_tls(office.server.address(), &office.files.certificate, "no request\r\n\r\n")
            .is_ok_and(|answer| answer.code == 400)
    );
}

#[test]
fn a_gateway_tells_what_is_wrong_with_its_certificate_and_takes_another_at_a_reload() {
    let folder = tempfile::tempdir().expect("there is room");
    let path = |name: &str| folder.path().join(name);
    let plain = |name: &str| path(name).to_str().expect("a plain name").to_owned();
    let config = configuration(folder.path(), "virtual");
    let text = fs::read_to_string(&config).expect("it was written");
    let http =
        "[http]\nlisten = \"127.0.0.1:0\"\ncertificate = \"page.crt\"\nkey = \"page.key\"\n\n";
    fs::write(&config, format!("{http}{text}")).expect("the folder is ours");
    write(&path("bus.log"), "can0", &excerpt(20.0, 60.0));
    let files = certify(folder.path(), "page", 2021);
    allow(&files.key, 0o604);

    let log = path("run.log");
    let arguments = ["run", "--config", &plain("machine.toml"), "--play", &plain("bus.log")];
    let gateway = Running::start(program(), &arguments, &log);
    wait_for("the refusal", || said(&log, "may read it (mode 604)"));
    assert!(!said(&log, "page: http"), "it serves nothing in plain text instead");
    allow(&files.key, 0o600);
    gateway.signal("HUP");
    wait_for("the page", || said(&log, "page: https://"));
    assert!(said(&log, "page.crt has expired"), "which people have to know");

    let told = fs::read_to_string(&log).expect("it was written");
    let (_, address) = told.split_once("page: https://").expect("its address");
    let address: SocketAddr = address.split('/').next().unwrap_or("").parse().expect("an address");
    let renewed = certify(folder.path(), "page", 2100);
    gateway.signal("HUP");
    let get = "GET /api/machine HTTP/1.1\r\nHost: localhost\r\n\r\n";
    wait_for("the new certificate", || {
        ask_over_tls(address, &renewed.certificate, get).is_ok_and(|answer| answer.code == 200)
    });
}
