//! The pages of HTML in a browser: `scripts/with-chromium cargo test --test rendering`.
//!
//! Each page is loaded without a network, and then measured and drawn by the script beside this
//! file: every figure has a size, no text is cut off, lies over another one or in a plot, and every
//! curve can be seen.

mod login;
mod technician;

use serde_json::Value;
use std::env;
use std::path::Path;
use std::process::{Command, Stdio};
use tertius::bus::LogWriter;
use tertius_testing::support::{E_TYPE, HANGING_LOAD, Scratch, recording, tertius};
use tertius_testing::visits::{CONFIG, visits};

const SCRIPT: &str = include_str!("measure.js");

/// Chromium's answer to `page`, and what it complained of.
fn browse(page: &Path) -> (String, String) {
    let chromium = env::var("CHROMIUM").expect("scripts/with-chromium says which browser to use");
    let profile = tempfile::tempdir().expect("a temporary directory");
    let output = Command::new(&chromium)
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage"])
        // Nothing outside can be found, were it asked for.
        .arg("--host-resolver-rules=MAP * ~NOTFOUND")
        .args(["--window-size=1000,1400", "--virtual-time-budget=60000"])
        .args(["--enable-logging=stderr", "--v=0", "--dump-dom"])
        .arg(format!("--user-data-dir={}", profile.path().display()))
        .arg(format!("file://{}", page.display()))
        .stdin(Stdio::null())
        .output()
        .unwrap_or_else(|error| panic!("{chromium}: {error}"));
    assert!(output.status.success(), "{chromium}: {output:?}");
    let text = |bytes: Vec<u8>| String::from_utf8_lossy(&bytes).into_owned();
    (text(output.stdout), text(output.stderr))
}

/// Makes the page of `command`, and has it looked at.
fn assert_looks_right(command: &[&str], figures: usize) {
    let scratch = Scratch::new();
    let path = scratch.path("page.html");
    _ = tertius(&[command, &["--report", &path]].concat(), b"");
    let html = scratch.read("page.html");

    // As it is: nothing is asked for that its policy forbids, and nothing is wrong with it.
    let (dom, complaints) = browse(Path::new(&path));
    assert!(dom.contains("</footer>"), "it did not load");
    let console = complaints.lines().filter(|line| line.contains("CONSOLE"));
    assert_eq!(console.collect::<Vec<_>>(), [] as [&str; 0]);

    // With a script at its end, which the policy would not let run.
    let begin = html.find("<meta http-equiv=").expect("a policy");
    let end = begin + html[begin..].find("/>").expect("its end") + 2;
    let script = format!("<pre id=\"measured\"></pre><script>{SCRIPT}</script></body>");
    let measured = format!("{}{}", &html[..begin], &html[end..]).replace("</body>", &script);
    let (dom, _) = browse(Path::new(&scratch.write("measured.html", measured)));
    let found = dom.split_once("id=\"measured\">").expect("the script ran").1;
    let found = found.split_once("</pre>").expect("its end").0.replace("&gt;", ">");
    let found: Value = serde_json::from_str(&found).unwrap_or_else(|_| panic!("{found:?}"));
    assert_eq!(found["wrong"], serde_json::json!([]), "{command:?}");
    assert_eq!(found["figures"], figures, "{command:?}");
    assert!(found["curves"].as_u64().is_some_and(|curves| curves as usize >= figures), "{found}");
}

#[test]
fn the_page_of_a_replay_looks_right() {
    let faults = recording("e-type-faults.log.zst");
    assert_looks_right(&["replay", &faults, "--config", E_TYPE], 6 + 27 + 3);
    let hanging = recording("hanging-load.log.gz");
    assert_looks_right(&["replay", &hanging, "--config", HANGING_LOAD], 1 + 40 + 3);
}

/// On the stops, R3 over time (R1 and R2 are not judged there), around the warnings, how large R3 was.
#[test]
fn a_drift_on_the_stops_looks_right() {
    let scratch = Scratch::new();
    let mut log = LogWriter::new(Vec::new(), "can0");
    visits(0..40).iter().for_each(|frame| log.write(frame).expect("memory takes it"));
    let log = scratch.write("visits.log", log.into_inner());
    let config = format!("{}/{CONFIG}", env!("CARGO_MANIFEST_DIR"));
    assert_looks_right(&["replay", &log, "--config", &config], 6 + 6 + 3 + 1);
}

#[test]
fn the_pages_of_what_learns_look_right() {
    let healthy = recording("e-type-healthy.log.zst");
    let of = |command: &[&str], figures| {
        assert_looks_right(&[command, &[&healthy, "--config", E_TYPE]].concat(), figures);
    };
    of(&["calibrate"], 12 + 6);
    of(&["identify", "--nonlinear", "--supply", "200"], 6 + 12 + 6 + 6);
    of(&["tune", "--keep-weights"], 2 + 24);
}
