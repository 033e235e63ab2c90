//! A recording whose cycle is not that of the configuration is told, and nothing is learnt from it.

use serde_json::Value;
use tertius_testing::support::{E_TYPE, Scratch, between, recorded, replay, tertius};

/// A minute in which the machine works.
fn minute() -> String {
    between(&recorded("e-type-healthy.log.zst"), 160.0, 220.0)
}

/// The recording as a clock would stamp it that runs `times` as fast.
fn stamped(log: &str, times: f64) -> String {
    let begin = 1_700_000_160.0;
    let line = |line: &str| {
        let (stamp, rest) = line.split_once(") ").expect("a candump line");
        let at: f64 = stamp[1..].parse().expect("a time stamp");
        format!("({:.6}) {rest}\n", begin + (at - begin) * times)
    };
    log.lines().map(line).collect()
}

/// The recording without its Sync.
fn unsynchronised(log: &str) -> String {
    log.split_inclusive('\n').filter(|line| !line.contains(" 080#")).collect()
}

/// The remarks of a replay of `log`, which are on its pages, too.
fn remarks(scratch: &Scratch, log: &str) -> Vec<String> {
    let (log, page) = (scratch.write("machine.log", log), scratch.path("page.html"));
    let summary = replay(&[&log], E_TYPE, &["--report", &page, "--force"]).ok().summary();
    let remarks = summary.get("remarks").and_then(Value::as_array).cloned().unwrap_or_default();
    let text = tertius(&["replay", &log, "--config", E_TYPE], b"").ok().stdout;
    let (text, page) =
        (text.split_whitespace().collect::<Vec<_>>().join(" "), scratch.read("page.html"));
    let told: Vec<String> =
        remarks.iter().map(|it| it.as_str().expect("a text").to_owned()).collect();
    for remark in &told {
        assert!(text.contains(&format!("Look at {remark}.")), "{text}");
        assert!(page.contains(&format!("<li>Look at {}", &remark[..20])), "{remark}");
    }
    assert_eq!(text.contains("Look at `"), !told.is_empty(), "{text}");
    told
}

#[test]
fn a_replay_names_a_sync_that_did_not_come_and_another_sample_time() {
    let scratch = Scratch::new();
    let log = minute();
    assert_eq!(remarks(&scratch, &log), [""; 0]);
    // A clock that runs by a thousandth off is none of another machine.
    assert_eq!(remarks(&scratch, &stamped(&log, 1.001)), [""; 0]);
    // In so short a recording no observer judges, either.
    let short = replay(&[&scratch.write("short.log", between(&log, 160.0, 160.5))], E_TYPE, &[]);
    assert_eq!((short.code, short.summary().get("remarks")), (Some(1), None), "too short to tell");

    let told = remarks(&scratch, &unsynchronised(&log));
    assert!(
        told.len() == 1 && told[0].contains("`signals.sync`: no frame of Sync (080)"),
        "{told:?}"
    );
    for (times, words) in [
        (1.03, "Sync came every 20.600 ms"),
        (0.97, "Sync came every 19.400 ms"),
        (1.006, "0.6 % more than the 20.000 ms of the configuration"),
    ] {
        let told = remarks(&scratch, &stamped(&log, times));
        assert!(told.len() == 1 && told[0].contains(words), "{told:?}");
        assert!(told[0].starts_with("`machine.sample_time`: "), "{told:?}");
    }
    // Without Sync a message with readings tells.
    let told = remarks(&scratch, &unsynchronised(&stamped(&log, 1.03)));
    assert!(told.len() == 2 && told[1].contains("0x181 came every 20.600 ms"), "{told:?}");
}

/// Lost frames and pauses are neither a longer cycle nor a Sync that does not come.
#[test]
fn what_is_lost_does_not_change_the_pace() {
    let scratch = Scratch::new();
    let log = minute();
    let gaps =
        [(160.0, 170.0), (180.0, 183.0), (190.5, 200.0)].map(|(from, to)| between(&log, from, to));
    assert_eq!(remarks(&scratch, &gaps.concat()), [""; 0]);
    let mut count = 0;
    let mut every_fifth = |line: &&str| {
        count += usize::from(line.contains(" 080#"));
        !line.contains(" 080#") || count % 5 != 0
    };
    let lossy: String = log.split_inclusive('\n').filter(|line| every_fifth(line)).collect();
    assert_eq!(remarks(&scratch, &lossy), [""; 0]);
}

#[test]
fn nothing_is_learnt_at_another_sample_time() {
    let scratch = Scratch::new();
    let log = minute();
    let slow = scratch.write("slow.log", stamped(&log, 1.03));
    let words = ["`machine.sample_time`: Sync came every 20.600 ms", "Nothing is learnt"];
    let config = scratch.config(&[]);
    for command in ["commission", "identify", "calibrate", "tune"] {
        tertius(&[command, &slow, "--config", &config], b"").failed(2, &words);
    }
    let without = scratch.write("without.log", unsynchronised(&log));
    let run = tertius(&["commission", &without, "--config", &config, "--dry-run"], b"");
    assert!(run.stdout.contains("`signals.sync`: no frame of Sync (080)"), "{}", run.stdout);
}
