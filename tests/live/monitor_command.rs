//! `tertius monitor` on a terminal (`tests/oracle/terminal.py`), at a running gateway.

use serde_json::Value;
use std::path::PathBuf;
use tertius::appliance::http::TokenDigest;
use tertius_testing::certificates::{certify, certify_by_authority};
use tertius_testing::process::Running;
use tertius_testing::support::{E_TYPE, Scratch, tertius};
use tertius_testing::{oracle, program, top};

#[test]
fn a_person_sees_a_fault_arrive_in_a_terminal() {
    let scratch = Scratch::new();
    let config = std::fs::read_to_string(top().join(E_TYPE)).expect("the configuration is there");
    let dbc = top().join("dbc/e-type.dbc");
    let config = config
        .replace("interface = \"can0\"", "interface = \"virtual\"")
        .replace("../../dbc/e-type.dbc", &dbc.display().to_string())
        + "\n[http]\nlisten = \"127.0.0.1:0\"\n";
    let config = scratch.write("machine.toml", config);
    let log = scratch.path("machine.log");
    let fault = "step,cylinder=3,sensor=c1,at=15,size=0.004";
    let simulate = ["simulate", "--config", &config, "--duration", "150", "--output", &log];
    tertius(&[&simulate[..], &["--fault", fault]].concat(), b"").ok();
    let (running, url) = Running::gateway(&config, &log);
    let pid = running.id().to_string();
    let told = oracle::run("terminal.py", &["gateway", program(), &url, &pid], "");
    let told: Value = serde_json::from_str(&told).expect("JSON");
    println!("{told}");
}

/// A gateway that other computers reach, over https and with a token, for a certificate by an authority of its own.
#[test]
fn a_gateway_is_watched_over_https_by_who_trusts_it_and_has_its_token() {
    let scratch = Scratch::new();
    let folder = PathBuf::from(scratch.path("."));
    let (authority, page) = certify_by_authority(&folder);
    let config = std::fs::read_to_string(top().join(E_TYPE)).expect("the configuration is there");
    let dbc = top().join("dbc/e-type.dbc");
    let http = format!(
        "\n[http]\nlisten = \"0.0.0.0:0\"\ntoken = \"{}\"\ncertificate = \"{}\"\nkey = \"{}\"\n",
        TokenDigest::of("0123456789abcdef0123456789abcdef"),
        page.certificate.display(),
        page.key.display()
    );
    let config = config
        .replace("interface = \"can0\"", "interface = \"virtual\"")
        .replace("../../dbc/e-type.dbc", &dbc.display().to_string())
        + &http;
    let config = scratch.write("machine.toml", config);
    let log = scratch.path("machine.log");
    tertius(&["simulate", "--config", &config, "--duration", "150", "--output", &log], b"").ok();
    let (_running, told) = Running::gateway(&config, &log);
    let port = told.rsplit_once(':').expect("a port").1;
    let (named, by_number) =
        (format!("https://localhost:{port}"), format!("https://127.0.0.1:{port}"));
    let right = scratch.write("token", "0123456789abcdef0123456789abcdef\n");
    let wrong = scratch.write("wrong", "fedcba9876543210fedcba9876543210");
    let other = certify(&folder, "other", 2100).certificate.display().to_string();
    let own = page.certificate.display().to_string();
    for (words, url, ca, token) in [
        ("● good", &named, &authority, Some(&right)),
        ("● good", &by_number, &own, Some(&right)),
        ("it asks for its token", &named, &authority, None),
        ("it refuses the token", &named, &authority, Some(&wrong)),
        ("nobody who is trusted here has certified it", &named, &other, Some(&right)),
        ("its certificate is for a host of another name", &by_number, &authority, Some(&right)),
    ] {
        let mut call = vec!["words", program(), words, url, "--ca", ca];
        call.extend(token.iter().flat_map(|token| ["--token-file", token.as_str()]));
        oracle::run("terminal.py", &call, "");
    }
}

#[test]
fn a_call_that_cannot_be_followed_is_refused_with_what_to_do() {
    let refused = |arguments: &[&str], words: &[&str]| {
        tertius(&[&["monitor"], arguments].concat(), b"").failed(2, words);
    };
    refused(&["http://127.0.0.1:9481"], &["no terminal", "tertius replay"]);
    refused(&[], &["URL", "--config"]);
    refused(&["http://127.0.0.1:9481", "--config", E_TYPE], &["cannot be used with"]);
    refused(&["http://127.0.0.1:9481", "--interface", "can0"], &["--config"]);
    refused(&["--config", E_TYPE, "--ca", "page.crt"], &["cannot be used with"]);
}
