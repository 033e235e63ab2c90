//! The flight recorder on a real SocketCAN.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use tertius_testing::bench::{Bench, excerpt, run, wait_for};
use tertius_testing::process::read;
use tertius_testing::support::tertius;
use tertius_testing::{program, top};

fn recordings(bench: &Bench, of: &str) -> Vec<PathBuf> {
    let Ok(entries) = fs::read_dir(bench.path("recordings")) else { return Vec::new() };
    let paths = entries.map(|entry| entry.expect("it is there").path());
    paths.filter(|path| path.to_string_lossy().contains(of)).collect()
}

/// Steps of C1 from 60 s on.
#[test]
fn an_incident_and_a_demand_leave_folders_with_what_candump_saw() {
    let bench = Bench::up("t-flight");
    let keys = "\n[recorder]\nfolder = \"recordings\"\nafter = 2\nframes = \"all\"\n";
    bench.configure(&format!("{}{keys}", bench.configuration()));
    let _dump = bench.candump();
    let gateway = bench.gateway();
    bench.play(&excerpt(57.0, 64.5));
    wait_for("the recording", || recordings(&bench, "incident-1").len() == 1);
    gateway.signal("USR1");
    wait_for("what was asked for", || recordings(&bench, "on-demand").len() == 1);
    bench.stop(gateway);
    for folder in [&recordings(&bench, "incident-1")[0], &recordings(&bench, "on-demand")[0]] {
        let recorded = read(&folder.join("frames.log.zst"));
        let seen = read(&bench.path("bus.log"));
        let is_own = |id: u32| [0x1D1, 0x2D1, 0x3D1].contains(&id);
        // Own frames have the time of their hand-over, and not of the bus.
        let recorded: Vec<_> = recorded.iter().filter(|it| !is_own(it.id.value())).collect();
        let seen: Vec<_> = seen.iter().filter(|it| !is_own(it.id.value())).collect();
        assert!(recorded.len() > 2000, "{}", recorded.len());
        let begin = seen.iter().position(|it| *it == recorded[0]).expect("candump saw it, too");
        assert!(seen[begin..].iter().zip(&recorded).all(|(seen, recorded)| seen == recorded));
    }
    is_told_again(&recordings(&bench, "incident-1")[0]);
}

/// A replay of the recording tells its incident as the gateway did.
fn is_told_again(folder: &Path) {
    let output = Command::new(program()).args(["replay", "--format", "jsonl"]).arg(folder).output();
    let text = String::from_utf8(output.expect("it runs").stdout).expect("UTF-8");
    let manifest = fs::read_to_string(folder.join("incident.json")).expect("it is there");
    let told = manifest.lines().map(|line| line.trim().trim_end_matches(','));
    let told: Vec<&str> = told.filter(|line| line.starts_with(r#"{"type":"incident""#)).collect();
    assert!(
        !told.is_empty() && told.iter().all(|told| text.lines().any(|line| line == *told)),
        "{manifest}\n{text}"
    );
}

/// The machine of a shipped configuration, with a step of C1 of its third cylinder, plays on the bus. Nobody has
/// calibrated it, which is no incident of its other cylinders.
fn leaves_recordings(interface: &'static str, config: &str) {
    let bench = Bench::up(interface);
    let text = fs::read_to_string(top().join(config)).expect("it ships");
    let text = text
        .replace("\"can0\"", &format!("{interface:?}"))
        .replace("../dbc", top().join("dbc").to_str().expect("plain"))
        .replace("max_age = 0.2", "max_age = 10.0")
        .replace("guard = 0.01", "guard = 0.5")
        + "\n[recorder]\nfolder = \"recordings\"\nafter = 2.0\n";
    bench.configure(&text);
    let (machine, log) = (bench.name("machine.toml"), bench.name("machine.log"));
    let fault = ["--fault", "step,cylinder=3,at=5,size=0.02"];
    let simulate = ["simulate", "--config", &machine, "--duration", "10", "--output", &log];
    tertius(&[&simulate[..], &fault].concat(), b"").ok();
    let _dump = bench.candump();
    let gateway = bench.gateway();
    run("canplayer", &["-I", &log]);
    wait_for("the recording", || !recordings(&bench, "incident").is_empty());
    bench.stop(gateway);
    let folders = recordings(&bench, "incident");
    assert!(
        folders.len() == 1 && folders[0].to_string_lossy().contains("cylinder-3"),
        "{folders:?}"
    );
    is_told_again(&folders[0]);
}

#[test]
fn a_coarse_machine_leaves_recordings_that_say_the_same() {
    leaves_recordings("t-coarse", "config/e-type-coarse.toml");
}

/// Its layout is in EDS files, which the folders need, too.
#[test]
fn a_machine_of_canopen_devices_leaves_recordings_that_say_the_same() {
    leaves_recordings("t-objects", "config/e-type-canopen.toml");
}
