//! Transducers that send by timers of their own instead of answering the SYNC.

use crate::canopen::{config, shipped};
use std::fs;
use tertius_testing::support::{Scratch, changed, replay, tertius};

/// Standard deviations of R1 and R3 of all cylinders, mm, with transducers that send by timers of this time.
fn noise(timer: Option<&str>) -> [f64; 2] {
    let scratch = Scratch::new();
    let config = config(&scratch, &[]);
    let simulated = shipped("config/e-type-simulated.toml");
    let corrections = simulated.find("[[cylinder]]").expect("it has them");
    let mut text = scratch.read("machine.toml");
    if let Some(timer) = timer {
        let role = |role: &str| format!("role = \"{role}\"\n");
        for name in ["c1", "c2"] {
            text = text.replace(&role(name), &format!("{}event_timer = {timer}\n", role(name)));
        }
    }
    scratch.write("machine.toml", text + &simulated[corrections..]);
    let (log, table) = (scratch.path("machine.log"), scratch.path("residuals.csv"));
    let call =
        ["simulate", "--config", &config, "--duration", "120", "--seed", "2", "--output", &log];
    tertius(&call, b"").ok();
    let summary = replay(&[&log], &config, &["--residuals", &table]).ok().summary();
    assert_eq!(summary["incomplete_cycles"], 0, "{summary}");
    assert_eq!((&summary["late_frames"], &summary["repeated_frames"]), (&0.into(), &0.into()));
    let table = scratch.read("residuals.csv");
    // t,cylinder,c1,c2,c2_corrected,u,estimate1,estimate2,r1,r2,r3,gated
    [8, 10].map(|column| {
        let value = |line: &str| line.split(',').nth(column).and_then(|it| it.parse::<f64>().ok());
        let values: Vec<f64> = table.lines().skip(1).filter_map(value).collect();
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let square = values.iter().map(|it| (it - mean).powi(2)).sum::<f64>() / values.len() as f64;
        1e3 * square.sqrt()
    })
}

/// The readings of a cycle are then of different instants, by chance and in proportion to the timer: R3 is
/// off by the way that the rod goes in the time between them.
#[test]
fn readings_by_timers_cost_what_the_rod_moves_in_their_time() {
    let by_sync = noise(None);
    let by_timers = ["0.001", "0.002", "0.004"].map(|timer| noise(Some(timer)));
    eprintln!("R1 and R3 by SYNC {by_sync:.3?} mm, by timers of 1, 2 and 4 ms {by_timers:.3?} mm");
    let added = by_timers.map(|[_, r3]| (r3.powi(2) - by_sync[1].powi(2)).sqrt());
    assert!((1.7..2.3).contains(&(added[2] / added[1])), "{added:?}");
    assert!(by_timers.is_sorted_by(|one, other| one[0] < other[0] && one[1] < other[1]));
    assert!(by_sync[1] < by_timers[0][1]);
}

#[test]
fn a_dcf_has_the_timer_of_its_device_and_an_eds_that_of_the_factory() {
    let scratch = Scratch::new();
    let config = config(&scratch, &[]);
    let check = || tertius(&["check", &config], b"");
    let by_timer = "sends every 0.001 s by its own timer";
    assert!(!check().ok().stdout.contains(by_timer), "the EDS has a timer of 1 ms");
    let sheet = shipped("dbc/encoder.eds");
    for (timer, told) in [("1", true), ("0", false)] {
        let own = sheet.clone() + "\n[DeviceComissioning]\nNodeID=3\nBaudrate=500\n";
        let place = "ParameterName=Event timer\n";
        let own = changed(&own, &[(place, &format!("{place}ParameterValue={timer}\n"))]);
        scratch.write("third.dcf", own);
        let text = fs::read_to_string(&config).expect("it was written");
        let eds = "role = \"c1\"\neds = \"encoder.eds\"\n\n[[canopen.device]]\nnode = 19\n";
        let dcf = eds.replace("encoder.eds", "third.dcf");
        let with_dcf =
            if text.contains("third.dcf") { text } else { changed(&text, &[(eds, &dcf)]) };
        fs::write(&config, with_dcf).expect("the folder is ours");
        assert_eq!(check().ok().stdout.matches(by_timer).count(), usize::from(told));
    }
}

#[test]
fn a_timer_takes_a_sync_and_less_than_half_a_cycle() {
    let role = "node = 3\nkind = \"transducer\"";
    let refused = |timer: &str, sync: &str| {
        let scratch = Scratch::new();
        let timed = format!("event_timer = {timer}\n{role}");
        let config = config(&scratch, &[(role, &timed), ("sync = \"Sync\"\n", sync)]);
        tertius(&["check", &config], b"")
    };
    refused("0.004", "sync = \"Sync\"\n").ok();
    let words =
        ["a transducer sends every 0.02 s by its own timer", "at most half a sample time, 0.01 s"];
    refused("0.02", "sync = \"Sync\"\n").failed(2, &words);
    refused("0.004", "").failed(2, &["that takes a Sync"]);
}
