//! `tertius monitor` on a terminal (`tests/oracle/terminal.py`), at a running gateway.

use serde_json::Value;
use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};
use tertius_testing::support::{E_TYPE, Scratch, tertius};
use tertius_testing::{oracle, program, top};

/// A running gateway; it ends with this.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        // It may have ended by itself.
        _ = self.0.kill();
        _ = self.0.wait();
    }
}

/// Runs a gateway on the embedded bus, and returns it with the address of its page.
fn start(config: &str, log: &str) -> (Running, String) {
    let mut run = Command::new(program());
    run.args(["run", "--config", config, "--play", log]).stderr(Stdio::piped());
    let mut child = run.stdin(Stdio::null()).spawn().expect("it starts");
    let lines = BufReader::new(child.stderr.take().expect("it is piped")).lines();
    let running = Running(child);
    let mut lines = lines.map_while(Result::ok);
    let page = lines.find_map(|line| Some(line.split_once("page: ")?.1.to_owned()));
    let page = page.expect("it tells where its page is");
    let url = page.split("/,").next().expect("an address").to_owned();
    std::thread::spawn(move || lines.for_each(drop));
    (running, url)
}

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
    let (running, url) = start(&config, &log);
    let pid = running.0.id().to_string();
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
