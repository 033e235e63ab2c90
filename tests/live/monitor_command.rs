//! `tertius monitor` on a terminal (`tests/oracle/terminal.py`), at a running gateway.

use serde_json::Value;
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

#[test]
fn a_call_that_cannot_be_followed_is_refused_with_what_to_do() {
    let refused = |arguments: &[&str], words: &[&str]| {
        tertius(&[&["monitor"], arguments].concat(), b"").failed(2, words);
    };
    refused(&["http://127.0.0.1:9481"], &["no terminal", "tertius replay"]);
    refused(&[], &["URL", "--config"]);
    refused(&["http://127.0.0.1:9481", "--config", E_TYPE], &["cannot be used with"]);
    refused(&["http://127.0.0.1:9481", "--interface", "can0"], &["--config"]);
}
