//! A recording in which C1 − C2 changes and stays so teaches nothing, wherever its beginning is.

use tertius_testing::support::{self, Run, Scratch};

const CONFIG: &str = "config/e-type-simulated.toml";

/// Calibrates by a recording of so many seconds, in which a transducer of cylinder 3 has the `fault`.
fn calibrated(
    [seconds, seed]: [&str; 2],
    simulated: &[&str],
    fault: Option<&str>,
    more: &[&str],
) -> Run {
    let scratch = Scratch::new();
    let log = scratch.path("in.log");
    let call = ["simulate", "--config", CONFIG, "--duration", seconds, "--seed", seed];
    let fault = fault.map(|fault| format!("step,cylinder=3,{fault}"));
    let fault: Vec<&str> = fault.iter().flat_map(|fault| ["--fault", fault]).collect();
    support::tertius(&[&call[..], simulated, &fault, &["--output", &log]].concat(), b"").ok();
    let tables = scratch.path("tables.toml");
    let call = ["calibrate", &log, "--config", CONFIG, "--output", &tables];
    support::tertius(&[&call[..], more].concat(), b"")
}

/// Where the seconds around it are left out, each of the sides is healthy by itself.
#[test]
fn a_step_of_which_the_beginning_is_left_out_is_refused() {
    let hydraulic: &[&str] = &["--plant", "config/e-type-hydraulic-plant.toml"];
    let changes = |mm: &str| format!("cylinder 3: C1 - C2 changes by {mm} mm between");
    calibrated(["700", "6"], hydraulic, Some("at=325,size=0.0012"), &[])
        .failed(1, &[&changes("1.20"), " 300 and 330 s, and stays so", "--from, --to"]);
    calibrated(["700", "5"], &[], Some("sensor=c2,at=200,size=0.0015"), &[])
        .failed(1, &[&changes("-1.50")]);
}

#[test]
fn a_step_before_what_is_held_back_is_refused() {
    for fault in ["at=300,size=0.0015", "at=720,size=0.0015"] {
        calibrated(["1200", "3"], &[], Some(fault), &["--held-back", "40"])
            .failed(1, &["cylinder 3: C1 - C2 changes by 1.50 mm between"]);
    }
}

/// A machine that is stowed stands where it seldom is at work, and then swings about another place.
#[test]
fn a_machine_that_stops_and_engages_again_has_no_step() {
    let stowed: &[&str] = &["--states", "0:engaged,250:safe,400:engaged"];
    calibrated(["700", "7"], stowed, None, &[]).ok();
}

/// A half of the recording that lies beside the line makes C1 and C2 no transducers in each other's place, and an eighth of
/// it no samples without a line.
#[test]
fn a_large_step_is_said_to_be_one() {
    for (fault, mm) in [("at=325,size=0.005", "5.0"), ("at=600,size=0.03", "29.99")] {
        let words = format!("cylinder 3: C1 - C2 changes by {mm}");
        calibrated(["700", "6"], &[], Some(fault), &[]).failed(1, &[&words, "and stays so"]);
    }
}
