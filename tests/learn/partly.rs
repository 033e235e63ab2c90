//! Machines that some detectors are fit for, and others are not.

use tertius_testing::support::{HANGING_LOAD, Run, Scratch, recording, tertius};
use tertius_testing::top;
use toml::Table;

/// A measured cylinder whose command only holds its load: by it no model can tell where the rod will be.
struct Rig {
    scratch: Scratch,
    config: String,
    log: String,
}

impl Rig {
    fn new() -> Self {
        let scratch = Scratch::new();
        let read = |name: &str| std::fs::read(top().join(name)).expect("it ships");
        scratch.write("hanging-load.dbc", read("tests/recordings/hanging-load.dbc"));
        let config = scratch.write("machine.toml", read(HANGING_LOAD));
        Self { config, log: recording("hanging-load.log.gz"), scratch }
    }

    fn commission(&self, options: &[&str]) -> Run {
        tertius(&[&["commission", &self.log, "--config", &self.config], options].concat(), b"")
    }

    /// What a replay of `log` says to a person.
    fn page(&self, log: &str) -> String {
        tertius(&["replay", log, "--config", &self.config], b"").ok().stdout
    }

    fn faulty(&self, fault: &str) -> String {
        let faulty = self.scratch.path("faulty.log");
        let put = ["inject", &self.log, "--config", &self.config, "--output", &faulty, "--force"];
        tertius(&[&put[..], &["--fault", fault]].concat(), b"").ok();
        faulty
    }
}

#[test]
fn a_machine_whose_model_does_not_follow_is_fit_but_for_its_observers() {
    let rig = Rig::new();
    let run = rig.commission(&[]).failed(3, &["the tables have no FDE1 and FDE2"]);
    assert!(
        run.stdout.starts_with("Hanging load is fit for use but for FDE1 and FDE2: no false"),
        "{}",
        run.stdout
    );
    let why = "FDE1 and FDE2 left out (identify): the model does not follow its command";
    assert!(run.stdout.contains(why), "{}", run.stdout);
    let table: Table = rig.scratch.read("machine.toml").parse().expect("TOML");
    assert_eq!(table["fde"]["enabled"].as_bool(), Some(false));
    assert!(table["cylinder"][0].get("sequential").is_some());

    let healthy = rig.page(&rig.log);
    assert!(healthy.contains("No incident in 5 min."), "{healthy}");
    for (sensor, name) in [("c1", "C1"), ("c2", "C2")] {
        for size in ["0.005", "-0.005"] {
            let log = rig.faulty(&format!("step,cylinder=1,sensor={sensor},at=150,size={size}"));
            let text = rig.page(&log);
            let found = format!("\n1 incident in 5 min: cylinder 1, {name}, yellow: step of");
            assert!(text.contains(&found), "{text}");
        }
    }
}
