//! `replay --state`: recordings replayed one by one give what they give together.

use serde_json::Value;
use std::fs;
use tertius_testing::support::{E_TYPE, Run, Scratch, Seeded, between, recorded, replay, tertius};

const SEQUENTIAL: &str = "tests/recordings/e-type-sequential.toml";

/// A scratch directory with the state, and the tables that are written.
struct Bench {
    scratch: Scratch,
    config: &'static str,
}

/// What replays wrote, one after the other, without the summaries and repeated headings.
#[derive(Debug, Default, PartialEq, Eq)]
struct Written {
    lines: Vec<String>,
    residuals: String,
    estimates: String,
    frames: String,
    summaries: Vec<Value>,
}

impl Bench {
    fn new(config: &'static str) -> Self {
        Self { scratch: Scratch::new(), config }
    }

    fn replay(&self, log: &str, state: &str, written: &mut Written) {
        let path = |name| self.scratch.path(name);
        let [state, residuals, estimates, frames] = [state, "r.csv", "e.csv", "f.log"].map(path);
        let log = self.scratch.write("part.log", log);
        let options = [
            ["--state", &state],
            ["--residuals", &residuals],
            ["--estimates", &estimates],
            ["--warnings", &frames],
        ];
        // A part of which nothing was judged is replayed, too.
        let run = replay(&[&log], self.config, &[&options.concat()[..], &["--force"]].concat());
        assert!(matches!(run.code, Some(0 | 1)), "{run:?}");
        let mut lines: Vec<&str> = run.stdout.lines().collect();
        let summary = lines.pop().expect("a summary");
        written.summaries.push(serde_json::from_str(summary).expect("JSON"));
        written.lines.extend(lines.into_iter().map(str::to_owned));
        let rows = |name, before: &str| {
            let text = self.scratch.read(name);
            let heading = text.find('\n').map_or(0, |end| end + 1);
            if before.is_empty() { text } else { text[heading..].to_owned() }
        };
        written.residuals += &rows("r.csv", &written.residuals);
        written.estimates += &rows("e.csv", &written.estimates);
        written.frames += &self.scratch.read("f.log");
    }
}

/// Replays `log` whole and in parts, with cuts before any frames, and compares.
fn assert_parts_add_up(config: &'static str, log: &str, count: u64, seed: u64) -> Written {
    let (bench, mut seeded) = (Bench::new(config), Seeded(seed));
    let lines: Vec<&str> = log.split_inclusive('\n').collect();
    let mut cuts: Vec<usize> =
        (0..count).map(|_| seeded.below(lines.len() as u64) as usize).collect();
    cuts.extend([0, lines.len()]);
    cuts.sort_unstable();
    let [mut whole, mut parts] = [Written::default(), Written::default()];
    bench.replay(log, "whole.state", &mut whole);
    for pair in cuts.windows(2).filter(|pair| pair[0] < pair[1]) {
        bench.replay(&lines[pair[0]..pair[1]].concat(), "parts.state", &mut parts);
    }
    let texts = |it: &Written| {
        [it.lines.join("\n"), it.residuals.clone(), it.estimates.clone(), it.frames.clone()]
    };
    for (whole, parts) in texts(&whole).iter().zip(&texts(&parts)) {
        let differs = whole.lines().zip(parts.lines()).find(|(whole, parts)| whole != parts);
        assert!(whole == parts, "{cuts:?}: {differs:?}");
    }
    for key in ["frames", "ignored_frames", "cycles", "incomplete_cycles"] {
        let total =
            |it: &Written| it.summaries.iter().map(|it| it[key].as_u64()).sum::<Option<u64>>();
        assert_eq!(total(&whole), total(&parts), "{key}");
    }
    whole
}

#[test]
fn parts_of_a_recording_with_faults_add_up() {
    let log = between(&recorded("e-type-faults.log.zst"), 160.0, 190.5);
    let whole = assert_parts_add_up(SEQUENTIAL, &log, 5, 1);
    assert!(whole.lines.len() > 10 && whole.frames.len() > 10_000, "{}", whole.lines.len());
}

#[test]
fn parts_of_a_canopen_recording_add_up() {
    let (scratch, config) = (Scratch::new(), "config/e-type-canopen.toml");
    let log = scratch.path("machine.log");
    let fault = "broken_wire,cylinder=3,sensor=c1_emergency,at=4,until=6";
    let call = ["simulate", "--config", config, "--duration", "12", "--fault", fault];
    tertius(&[&call[..], &["--seed", "5", "--output", &log]].concat(), b"").ok();
    let whole = assert_parts_add_up(config, &scratch.read("machine.log"), 3, 2);
    assert!(whole.lines.iter().any(|line| line.contains("\"plausibility\"")));
}

/// Replays `log` with `options`.
fn go_on(log: &str, options: &[&str]) -> Run {
    replay(&[log], E_TYPE, options)
}

#[test]
fn a_piece_of_a_cycle_that_opened_before_it_is_said_to_be_that() {
    let scratch = Scratch::new();
    let whole = recorded("e-type-healthy.log.zst");
    let part = between(&whole, 160.0, 166.1);
    let lines: Vec<&str> = part.lines().collect();
    let is_sync = |line: &&str| line.contains(" 080#");
    let open = 1 + lines.iter().rposition(is_sync).expect("there are Syncs");
    // Some readings behind the Sync and the first reading.
    let first = scratch.write("first.log", lines[..open + 1].join("\n") + "\n");
    let piece = scratch.write("piece.log", lines[open + 1..open + 5].join("\n") + "\n");
    let state = scratch.path("machine.state");
    go_on(&first, &["--state", &state]).ok();
    let told = ["opened a cycle: what came is of a cycle from before this recording"];
    go_on(&piece, &["--state", &state]).failed(1, &told);
}

#[test]
fn a_state_is_refused_where_it_does_not_belong() {
    let scratch = Scratch::new();
    let whole = recorded("e-type-healthy.log.zst");
    let first = scratch.write("first.log", between(&whole, 160.0, 166.0));
    let second = scratch.write("second.log", between(&whole, 166.0, 172.0));
    let state = scratch.path("machine.state");
    go_on(&first, &["--state", &state]).ok();
    let kept = fs::read(&state).expect("it was left");

    // The same recording once more, and another configuration.
    go_on(&first, &["--state", &state]).failed(2, &["has seen frames up to 1700000165.98"]);
    let other = scratch.config(&[("stale = 0.1", "stale = 0.12")]);
    replay(&[&second], &other, &["--state", &state]).failed(2, &["another design", "same ones"]);
    let estimates = scratch.path("estimates.csv");
    let asked = ["--state", &state, "--estimates", &estimates];
    go_on(&second, &asked).failed(2, &["another design", "estimates"]);
    // A recording is no output, and a table no state.
    go_on(&first, &["--state", &first]).failed(2, &["written over the input"]);
    let table = scratch.write("table.csv", "t,cylinder\n");
    go_on(&second, &["--state", &table]).failed(2, &["this command did not write it"]);
    let forced = go_on(&second, &["--state", &table, "--force"]);
    forced.failed(2, &["not the state of a monitor", "Nothing was changed"]);
    assert_eq!(scratch.read("table.csv"), "t,cylinder\n");
    assert_eq!(fs::read(&state).expect("it is there"), kept);

    let mut damaged = kept.clone();
    damaged[kept.len() / 2] ^= 4;
    let path = scratch.write("damaged.state", &damaged);
    go_on(&second, &["--state", &path]).failed(2, &["changed or truncated", "begin anew"]);
    assert_eq!(fs::read(&path).expect("it is there"), damaged);
    // Where it belongs it is taken up, and left anew.
    go_on(&second, &["--state", &state]).ok();
    assert_ne!(fs::read(&state).expect("it is there"), kept);
}

/// A recording without a frame leaves no state, and a state as it was.
#[test]
fn an_empty_recording_changes_nothing() {
    let scratch = Scratch::new();
    let empty = scratch.write("empty.log", "");
    let log = scratch.write("log", between(&recorded("e-type-healthy.log.zst"), 160.0, 166.0));
    let state = scratch.path("machine.state");
    assert_eq!(go_on(&empty, &["--state", &state]).code, Some(1));
    assert!(fs::metadata(&state).is_err());
    go_on(&log, &["--state", &state]).ok();
    let kept = fs::read(&state).expect("it was left");
    assert_eq!(go_on(&empty, &["--state", &state]).code, Some(1));
    assert_eq!(fs::read(&state).expect("it is there"), kept);
}
