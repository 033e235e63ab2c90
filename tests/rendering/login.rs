//! The login to a page over https, by a person with a real browser (`login.py`).

use std::process::Command;
use tertius::appliance::http::TokenDigest;
use tertius_testing::certificates::certify;
use tertius_testing::process::Running;
use tertius_testing::support::{E_TYPE, Scratch, tertius};
use tertius_testing::top;

const TOKEN: &str = "c8d1f0a3c8d1f0a3c8d1f0a3c8d1f0a3";

#[test]
fn a_person_logs_in_from_another_computer_reads_and_leaves() {
    let scratch = Scratch::new();
    let page = certify(scratch.path(".").as_ref(), "page", 2100);
    let config = std::fs::read_to_string(top().join(E_TYPE)).expect("the configuration is there");
    let dbc = top().join("dbc/e-type.dbc");
    let config = config
        .replace("interface = \"can0\"", "interface = \"virtual\"")
        .replace("../../dbc/e-type.dbc", &dbc.display().to_string())
        + &format!(
            "\n[http]\nlisten = \"0.0.0.0:0\"\ntoken = \"{}\"\ncertificate = \"{}\"\nkey = \"{}\"\n",
            TokenDigest::of(TOKEN),
            page.certificate.display(),
            page.key.display()
        );
    let config = scratch.write("machine.toml", config);
    let log = scratch.path("machine.log");
    tertius(&["simulate", "--config", &config, "--duration", "120", "--output", &log], b"").ok();
    let (_running, url) = Running::gateway(&config, &log);
    let port = url.rsplit_once(':').expect("a port").1;

    let of = |script: &str| {
        let output = Command::new(top().join("scripts").join(script)).output().expect("it runs");
        assert!(output.status.success(), "{output:?}");
        String::from_utf8_lossy(&output.stdout).trim().to_owned()
    };
    let mut person = Command::new(of("oracle-python"));
    person.arg(top().join("tests/rendering/login.py")).args([port, TOKEN, &of("axe-core")]);
    let person = person.output().expect("Python is there");
    let said = String::from_utf8_lossy(&person.stdout);
    assert!(person.status.success(), "{said}{}", String::from_utf8_lossy(&person.stderr));
    println!("{said}");
}
