//! What the doctor says of those who tried tokens at the gateway that is running.

use crate::tls::ask_over_tls;
use std::fs;
use std::net::TcpListener;
use std::process::Command;
use tertius_testing::certificates::certify;
use tertius_testing::process::{Running, configuration, excerpt, wait_for, write};
use tertius_testing::program;

#[test]
fn the_doctor_asks_the_running_gateway_for_wrong_tokens_and_lockouts() {
    let folder = tempfile::tempdir().expect("there is room");
    let path = |name: &str| folder.path().join(name).to_str().expect("a plain name").to_owned();
    let files = certify(folder.path(), "page", 2100);
    let free = TcpListener::bind("127.0.0.1:0").and_then(|free| free.local_addr());
    let address = free.expect("a free port");
    let config = configuration(folder.path(), "virtual");
    let text = fs::read_to_string(&config).expect("it was written");
    let http = format!(
        "[http]\nlisten = \"{address}\"\ncertificate = \"page.crt\"\nkey = \"page.key\"\nlogin_failures = 3\n\
         token = \"{}\"\n\n",
        // Of a token that nobody knows.
        "5e".repeat(32)
    );
    fs::write(&config, http + &text).expect("the folder is ours");
    write(&folder.path().join("bus.log"), "can0", &excerpt(0.0, 60.0));
    let doctor = || {
        let arguments = ["doctor", "--config", &path("machine.toml"), "--listen", "0"];
        let said = Command::new(program()).args(arguments).output().expect("it runs").stdout;
        let said = String::from_utf8(said).expect("text");
        let of = |line: &&str| line.split_whitespace().nth(1) == Some("logins");
        said.lines().find(of).map(str::to_owned)
    };
    assert_eq!(doctor(), None, "there is no gateway to ask");

    let arguments = ["run", "--config", &path("machine.toml"), "--play", &path("bus.log")];
    let _gateway = Running::start(program(), &arguments, &folder.path().join("run.log"));
    let record = "POST /api/record HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n\
                  Content-Length: 0\r\nAuthorization: Bearer ";
    let tried = || {
        let request = format!("{record}wrong\r\n\r\n");
        ask_over_tls(address, &files.certificate, &request).map(|it| it.code).ok()
    };
    wait_for("the page", || tried() == Some(401));
    assert_eq!(tried(), Some(401));
    let line = doctor().expect("it is told");
    assert!(line.starts_with("ok") && line.contains("2 wrong tokens since"), "{line}");
    assert_eq!(tried(), Some(401));
    assert_eq!(tried(), Some(429), "it is locked out");
    let line = doctor().expect("it is told");
    assert!(line.starts_with("warn") && line.contains("3 wrong tokens since"), "{line}");
    assert!(line.contains(", and 1 lockout -> ") && line.contains("journalctl"), "{line}");
    let log = fs::read_to_string(folder.path().join("run.log")).expect("it was written");
    let told = log.lines().find(|line| line.contains("a wrong token from")).expect("it is logged");
    assert!(told.contains("shorter than 128 bits") && told.contains("`tertius token`"), "{told}");
}
