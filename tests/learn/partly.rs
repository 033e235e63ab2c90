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
    /// The shipped configuration, which knows that the load rests under a command, or not.
    fn new(knows_rests: bool) -> Self {
        let scratch = Scratch::new();
        let read = |name: &str| std::fs::read(top().join(name)).expect("it ships");
        scratch.write("hanging-load.dbc", read("tests/recordings/hanging-load.dbc"));
        let text = String::from_utf8(read(HANGING_LOAD)).expect("UTF-8");
        let kept = text.lines().filter(|line| knows_rests || !line.starts_with("frozen"));
        let text: String = kept.map(|line| format!("{line}\n")).collect();
        let config = scratch.write("machine.toml", text);
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
    let rig = Rig::new(true);
    let run = rig.commission(&[]).failed(3, &["FDE1 and FDE2 left out and switched off"]);
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

/// Without this rule, five minutes of the healthy rig became 13 incidents, one of them black.
#[test]
fn a_load_that_rests_and_counts_as_frozen_is_refused_with_what_to_do() {
    let rig = Rig::new(false);
    let before = rig.scratch.read("machine.toml");
    let run = rig.commission(&[]).failed(1, &["nothing was written"]);
    for words in [
        "Hanging load is not fit for use: ",
        "plausibility of cylinder 1 warns at ",
        "a rod that rests counts as frozen: raise plausibility.frozen_speed",
    ] {
        assert!(run.stdout.contains(words), "{words:?} is not in\n{}", run.stdout);
    }
    assert!(!run.stdout.contains("allow as many false alarms"), "{}", run.stdout);
    assert_eq!(rig.scratch.read("machine.toml"), before);
}
