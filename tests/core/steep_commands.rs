//! Commands that change by more than the recording that the thresholds of R1 and R2 were learnt from.

use serde_json::Value;
use tertius_testing::support::{Scratch, tertius};

const CONFIG: &str = "config/e-type-simulated.toml";

/// What two hours in the sea of the plant have taught at 12.5 Hz, in which cylinder 2 never came near the end of its
/// workspace.
const LEARNT: [&str; 12] = [
    "machine.sample_time=0.08",
    "machine.max_gap=0.4",
    "plausibility.stale=0.4",
    "plausibility.frozen=0.4",
    "model.theta=[-0.0140, -0.5869, -1.6455e-5, -18.8647, -5.762e-4]",
    "model.gamma=[0.5595, 18.3096]",
    "observer.q=[5e-7, 6.3246e-7, 1e5]",
    "observer.r=[1e-8, 5.0]",
    "fde.low=0.001145",
    "fde.high=0.003615",
    "comparator.bound=0.001614",
    "model.sample_time=0.08",
];

/// When a wave of another day drives cylinders 2 and 5 towards the end of their workspace, where the controller brakes
/// them, s: the command falls by 0.27 m/s in a cycle, and both innovations reach 5.5 mm.
const BRAKED: f64 = 720.0;

fn set<'a>(more: &[&'a str]) -> Vec<&'a str> {
    LEARNT.iter().chain(more).flat_map(|value| ["--set", value]).collect()
}

/// Machine-readable lines of a replay of that day up to `BRAKED` and 20 s more, with `fault` in it, the tables with `more`.
fn warnings(fault: &[&str], more: &[&str]) -> Vec<Value> {
    let scratch = Scratch::new();
    let log = scratch.path("day.log");
    let mut call = vec![
        "simulate",
        "--config",
        CONFIG,
        "--duration",
        "740",
        "--seed",
        "507",
        "--output",
        &log,
    ];
    call.extend(fault.iter().flat_map(|spec| ["--fault", spec]));
    call.extend(set(&[]));
    tertius(&call, b"").ok();
    let mut call = vec!["replay", &log, "--config", CONFIG, "--format", "jsonl"];
    call.extend(set(more));
    tertius(&call, b"").ok().warnings()
}

const TAUGHT: &[&str] = &["fde.command_change=0.06"];

#[test]
fn braking_beyond_what_was_taught_is_no_fault_of_the_machine() {
    let untaught = warnings(&[], &[]);
    assert!(untaught.iter().any(|w| w["detector"] == "fde1" && w["suspect"] == "process"));
    assert_eq!(warnings(&[], TAUGHT), [] as [Value; 0]);
}

/// The observers share the error of their model, and a transducer's fault is in one of them only.
#[test]
fn a_step_in_the_middle_of_it_is_found_and_blamed_right() {
    for (sensor, detector) in [("c1", "fde1"), ("c2", "fde2")] {
        let at = BRAKED + 0.5;
        let spec = format!("step,cylinder=2,sensor={sensor},at={at},size=0.012");
        let found = warnings(&[&spec], TAUGHT);
        let of_it = |w: &&Value| w["cylinder"] == 2 && w["detector"] == detector;
        let raised = found.iter().find(of_it).unwrap_or_else(|| panic!("{spec}: {found:?}"));
        assert_eq!(raised["suspect"], sensor, "{raised}");
        assert!(raised["t"].as_f64().is_some_and(|t| (at..at + 0.2).contains(&t)), "{raised}");
    }
}
