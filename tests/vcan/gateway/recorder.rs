//! The flight recorder on a real SocketCAN.

use std::fs;
use std::path::PathBuf;
use std::process::Command;
use tertius_testing::bench::{Bench, excerpt, wait_for};
use tertius_testing::process::read;
use tertius_testing::program;

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
    let folder = &recordings(&bench, "incident-1")[0];
    let output = Command::new(program()).args(["replay", "--format", "jsonl"]).arg(folder).output();
    let text = String::from_utf8(output.expect("it runs").stdout).expect("UTF-8");
    let manifest = fs::read_to_string(folder.join("incident.json")).expect("it is there");
    let told = manifest.lines().map(|line| line.trim().trim_end_matches(','));
    let told: Vec<&str> = told.filter(|line| line.starts_with(r#"{"type":"incident""#)).collect();
    assert!(!told.is_empty() && told.iter().all(|told| text.lines().any(|line| line == *told)));
}
