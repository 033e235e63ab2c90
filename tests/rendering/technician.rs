//! The page of a running gateway, used by a technician with a real browser (`technician.py`).

use serde_json::Value;
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Command, Stdio};
use tertius::appliance::http::TokenDigest;
use tertius_testing::process::Running;
use tertius_testing::support::{E_TYPE, Scratch, tertius};

const TOKEN: &str = "c8d1f0a3c8d1f0a3c8d1f0a3c8d1f0a3";

#[test]
fn a_technician_sees_a_fault_arrive_and_deals_with_it() {
    let scratch = Scratch::new();
    let digest = TokenDigest::of(TOKEN);
    let config = std::fs::read_to_string(E_TYPE).expect("the configuration is there");
    // Beside it, so that a picture shows no path of this computer.
    let dbc = format!("{}/dbc/e-type.dbc", env!("CARGO_MANIFEST_DIR"));
    scratch.write("e-type.dbc", std::fs::read(dbc).expect("the DBC is there"));
    let config = config
        .replace("interface = \"can0\"", "interface = \"virtual\"")
        .replace("../../dbc/e-type.dbc", "e-type.dbc")
        .replace(
            "[[cylinder]]\nn = 3\n",
            "[[cylinder]]\nn = 3\nname = \"<u>Fwd</u>\"\nc1_name = \"LT-103A\"\n",
        )
        + &format!(
            "\n[calibration]\nrecorded = \"2023-11-01\"\n\n[http]\nlisten = \"127.0.0.1:0\"\ntoken = \"{digest}\"\n[store]\nfile = \"events.db\"\n\
             [recorder]\nfolder = \"recordings\"\nbefore = 10.0\nafter = 5.0\n"
        );
    let config = scratch.write("machine.toml", config);
    let log = scratch.path("machine.log");
    let fault = "step,cylinder=3,sensor=c1,at=25,size=0.004";
    tertius(
        &["simulate", "--config", &config, "--duration", "150", "--output", &log, "--fault", fault],
        b"",
    )
    .ok();
    let (running, url) = Running::gateway(&config, &log);

    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let of = |script: &str| {
        let output = Command::new(here.join("scripts").join(script)).output().expect("it runs");
        assert!(output.status.success(), "{output:?}");
        String::from_utf8_lossy(&output.stdout).trim().to_owned()
    };
    let mut technician = Command::new(of("oracle-python"));
    technician.arg(here.join("tests/rendering/technician.py")).args([&url, TOKEN, &of("axe-core")]);
    technician.arg(env!("CARGO_BIN_EXE_tertius"));
    // Where pictures are wanted, they go here.
    technician.args(std::env::var("TERTIUS_PICTURES"));
    technician.stdin(Stdio::piped()).stdout(Stdio::piped());
    let mut technician = technician.spawn().expect("Python is there");
    let mut said = BufReader::new(technician.stdout.take().expect("piped")).lines();
    let first = said.next().and_then(Result::ok).unwrap_or_default();
    assert!(first.contains("stop"), "the technician complains: {first}");
    drop(running);
    technician.stdin.take().expect("piped").write_all(b"\n").expect("it listens");
    let last = said.next().and_then(Result::ok).unwrap_or_default();
    assert!(technician.wait().expect("it ends").success(), "{last}");
    let result: Value = serde_json::from_str(&last).unwrap_or_else(|_| panic!("{last:?}"));
    assert!(
        result["incident"]
            .as_str()
            .is_some_and(|it| it.starts_with("cylinder 3 (<u>Fwd</u>), C1 (LT-103A)")),
        "{result}"
    );
    println!("{result}");
}
