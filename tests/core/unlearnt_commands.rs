//! Commands beyond those of the recording that the thresholds of R1 and R2 were learnt from.

use serde_json::Value;
use tertius_testing::support::{Scratch, tertius};

const CONFIG: &str = "config/e-type-simulated.toml";

/// A time at which a healthy machine does what its lesson did not show, and what that has taught.
struct Day {
    /// Tables, as values of `--set`.
    learnt: &'static [&'static str],
    /// The limits that belong to them.
    limits: &'static [&'static str],
    seed: &'static str,
    sea: &'static str,
    /// When the innovations of cylinder 2 are beyond δ_h, s.
    at: f64,
}

/// Two hours in the sea of the plant at 12.5 Hz, in which cylinder 2 never came near the end of its workspace. A wave of
/// another day drives cylinders 2 and 5 there, where the controller brakes them: the command falls by 0.27 m/s in a
/// cycle, and both innovations reach 5.5 mm.
const BRAKED: Day = Day {
    learnt: &[
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
    ],
    limits: &["fde.command_change=0.06"],
    seed: "507",
    sea: "2.5,8",
    at: 720.0,
};

/// Three quarters of an hour in a sea of 1.2 m and 6.5 s, in which no cylinder was commanded to go faster than 0.38 m/s. In
/// one of 3 m cylinder 2 goes with 0.8 m/s, where the valve gives less than the model says, and both innovations are
/// 1.7 mm.
const ROUGH: Day = Day {
    learnt: &[
        "model.theta=[-0.0080094, -0.158285, -5.88354e-7, -13.02515, -6.78048e-5]",
        "model.gamma=[0.1538415, 12.7267482]",
        "observer.q=[5e-5, 2e-6, 100.0]",
        "observer.r=[1e-8, 5.0]",
        "fde.low=0.0004327",
        "fde.high=0.001551",
        "comparator.bound=0.002388",
    ],
    limits: &["fde.command=0.3148", "fde.command_change=0.0083"],
    seed: "9",
    sea: "3,8.5",
    at: 4.0,
};

fn set<'a>(values: impl Iterator<Item = &'a &'a str>) -> Vec<&'a str> {
    values.flat_map(|value| ["--set", *value]).collect()
}

impl Day {
    /// Machine-readable lines of a replay of it until 20 s after its time, with `fault` in it, and with its limits or
    /// without.
    fn warnings(&self, fault: &[&str], limits: &[&str]) -> Vec<Value> {
        self.simulated(fault, limits, &[])
    }

    /// The same of a machine that is simulated with these options.
    fn simulated(&self, fault: &[&str], limits: &[&str], options: &[&str]) -> Vec<Value> {
        let scratch = Scratch::new();
        let log = scratch.path("day.log");
        let duration = (self.at + 20.0).to_string();
        let mut call = vec!["simulate", "--config", CONFIG, "--duration", &duration];
        call.extend(["--seed", self.seed, "--sea", self.sea, "--output", &log]);
        call.extend(fault.iter().flat_map(|spec| ["--fault", spec]));
        call.extend(options);
        call.extend(set(self.learnt.iter()));
        tertius(&call, b"").ok();
        let mut call = vec!["replay", &log, "--config", CONFIG, "--format", "jsonl"];
        call.extend(set(self.learnt.iter().chain(limits)));
        tertius(&call, b"").ok().warnings()
    }
}

#[test]
fn a_machine_that_does_what_was_not_taught_has_no_fault() {
    for (day, suspect) in [(BRAKED, "process"), (ROUGH, "c1")] {
        let unlimited = day.warnings(&[], &[]);
        let blamed = |w: &Value| w["detector"] == "fde1" && w["suspect"] == suspect;
        assert!(unlimited.iter().any(blamed), "{unlimited:?}");
        assert_eq!(day.warnings(&[], day.limits), [] as [Value; 0]);
    }
}

/// The observers share the error of their model, and a transducer's fault is in one of them only.
#[test]
fn a_step_in_the_middle_of_it_is_found_and_blamed_right() {
    for (day, size) in [(BRAKED, 0.012), (ROUGH, -0.004)] {
        for (sensor, detector) in [("c1", "fde1"), ("c2", "fde2")] {
            let at = day.at + 0.5;
            let spec = format!("step,cylinder=2,sensor={sensor},at={at},size={size}");
            let found = day.warnings(&[&spec], day.limits);
            let of_it = |w: &&Value| w["cylinder"] == 2 && w["detector"] == detector;
            let raised = found.iter().find(of_it).unwrap_or_else(|| panic!("{spec}: {found:?}"));
            assert_eq!(raised["suspect"], sensor, "{raised}");
            assert!(raised["t"].as_f64().is_some_and(|t| (at..at + 0.2).contains(&t)), "{raised}");
        }
    }
}

/// The controller has driven the rod to its stop without a C1, and takes it back at full speed once C1 reads again. C2's
/// observer has what the model makes of a stop, and C1's, which starts anew, has not.
#[test]
fn an_observer_that_starts_in_the_middle_of_it_accuses_nobody() {
    for (cylinder, until) in [(1, 14.0), (3, 12.0), (6, 14.0)] {
        let spec = format!("out_of_range,cylinder={cylinder},sensor=c1,at=5,until={until}");
        let found = ROUGH.simulated(&[&spec], ROUGH.limits, &["--in-loop"]);
        assert!(found.iter().any(|w| w["suspect"] == "c1"), "{found:?}");
        let wrong: Vec<&Value> = found.iter().filter(|w| w["suspect"] == "c2").collect();
        assert_eq!(wrong, Vec::<&Value>::new(), "{spec}");
    }
}
