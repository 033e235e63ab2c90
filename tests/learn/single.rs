//! What is learnt of cylinders that have C1 alone.

use crate::yard::{Yard, moved, tertius};
use std::fs;
use toml::{Table, Value};

/// Eleven minutes in two seas, and the configuration with `more`, which loses its lines of C2 if `alone`.
fn recorded(more: &str, alone: bool) -> (Yard, String) {
    let yard = Yard::new();
    let text = yard.read("config.toml");
    let is_kept = |line: &&str| !(alone && line.starts_with("c2"));
    let kept = text.lines().filter(is_kept).map(|line| format!("{line}\n"));
    yard.0.write("config.toml", kept.collect::<String>() + more);
    let seas = [["1.2,6.5", "31"], ["2.5,8", "32"]];
    let parts = seas.iter().zip(0..).map(|(sea, number)| {
        let log = yard.simulate(&format!("{number}.log"), *sea, 330, &["--force"]);
        moved(&fs::read_to_string(log).expect("it was written"), number * 360)
    });
    let log = yard.0.write("healthy.log", parts.collect::<String>());
    (yard, log)
}

fn cylinder(text: &str, n: i64) -> Option<Table> {
    let table: Table = text.parse().expect("TOML");
    let all = table.get("cylinder")?.as_array()?.clone();
    let tables = all.into_iter().filter_map(|it| it.try_into::<Table>().ok());
    tables.into_iter().find(|it| it["n"].as_integer() == Some(n))
}

#[test]
fn a_mixed_machine_is_commissioned_and_its_report_says_what_is_left_out() {
    let (yard, log) = recorded("\n[[cylinder]]\nn = 3\nc2 = false\n", false);
    let config = yard.path("config.toml");
    let run = tertius(&["commission", &log, "--config", &config]).ok();
    let page = &run.stdout;
    assert!(page.lines().next().expect("a line").contains(" is fit for use: "), "{page}");
    let left_out = "it has no C2, so nothing of C1 - C2 is learnt: no correction";
    assert!(page.contains("cylinder 3") && page.contains(left_out), "{page}");
    assert!(!page.contains("refused"), "{page}");
    let after = yard.read("config.toml");
    let alone = cylinder(&after, 3).expect("it has a table");
    assert_eq!(alone["c2"], Value::Boolean(false));
    for key in ["c2_gain", "c2_offset", "sequential"] {
        assert!(!alone.contains_key(key), "{key}: {alone:?}");
    }
    let process = alone["process"].as_table().expect("spool and chambers are learnt");
    assert!(process.contains_key("spool"), "{process:?}");
    assert!(process.contains_key("flow") && process.contains_key("friction"), "{process:?}");
    for n in [1, 2, 4, 5, 6] {
        let both = cylinder(&after, n).expect("it has a table");
        assert!(both.contains_key("sequential") && both.contains_key("c2_gain"), "{both:?}");
    }
    tertius(&["check", &config]).ok();
}

#[test]
fn a_machine_without_any_c2_is_identified_and_tuned_by_c1() {
    let (yard, log) = recorded("", true);
    let config = yard.path("config.toml");
    let run = tertius(&["commission", &log, "--config", &config]).ok();
    let page = &run.stdout;
    assert!(page.lines().next().expect("a line").contains(" is fit for use: "), "{page}");
    assert!(page.contains("are not found"), "{page}");
    assert!(!page.contains("FDE2") && !page.contains("FDE3"), "{page}");
    assert!(!page.contains("C2 cannot be calibrated") && !page.contains("refused"), "{page}");
    assert!(page.contains("model (4-1)") && page.contains("δ_l, δ_h"), "{page}");
    assert!(page.contains("it has no C2, so nothing of C1 - C2 is learnt"), "{page}");
    assert!(!page.contains("\n bound of R3"), "{page}");
    assert!(!page.contains("whether C1 and C2 are swapped"), "{page}");
    let after = yard.read("config.toml");
    for n in 1..=6 {
        let process = cylinder(&after, n).expect("it has a table")["process"].clone();
        assert!(process.get("flow").is_some() && process.get("friction").is_some(), "{process:?}");
    }
    tertius(&["check", &config]).ok();
}
