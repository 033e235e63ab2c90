//! Tables that are learnt, put into the configuration itself.

use std::fs;
use std::io::Write;
use tertius_testing::support::{self, Run, Scratch, between, merge, recorded, top};
use toml::Table;

/// A recording of two minutes, and the configuration that ships.
struct Desk {
    scratch: Scratch,
    log: String,
    config: String,
}

impl Desk {
    fn new() -> Self {
        let scratch = Scratch::new();
        let log = between(&recorded("e-type-healthy.log.zst"), 200.0, 320.0);
        let log = scratch.write("in.log", log);
        let text = fs::read_to_string(top().join("config/e-type.toml")).expect("it ships");
        let dbc = format!("{:?}", top().join("dbc/e-type.dbc"));
        let config = scratch.write("e-type.toml", text.replace("\"../dbc/e-type.dbc\"", &dbc));
        Self { scratch, log, config }
    }

    fn text(&self) -> String {
        fs::read_to_string(&self.config).expect("it is there")
    }

    fn table(&self) -> Table {
        self.text().parse().expect("it is TOML")
    }
}

fn tertius(arguments: &[&str]) -> Run {
    support::tertius(arguments, b"")
}

/// The lines that are nothing but a comment.
fn comments(text: &str) -> Vec<&str> {
    text.lines().filter(|line| line.starts_with('#')).collect()
}

#[test]
fn tables_in_place_are_those_of_the_file_of_their_own() {
    let desk = Desk::new();
    let original = desk.text();
    for (round, command) in ["identify", "calibrate", "tune"].into_iter().enumerate() {
        let (before, output) = (desk.text(), desk.scratch.path(&format!("{command}.toml")));
        let call = [command, &desk.log, "--config", &desk.config, "--into", &desk.config];
        // Values of a call are no part of what is written.
        let set = ["--dry-run", "--set", "bus.interface=can7", "--set", "store.days=7"];
        let dry = tertius(&[&call[..], &set].concat()).ok();
        assert!(
            !dry.stdout.contains("can7") && !dry.stdout.contains("days = 7\n"),
            "{}",
            dry.stdout
        );
        assert_eq!(desk.text(), before, "{command} --dry-run changes nothing");
        assert!(dry.stdout.contains("\n+++ with the tables\n"), "{}", dry.stdout);
        let told = tertius(&[&call[..], &["--output", &output]].concat()).ok();
        let kept = format!("{}.bak-{}", desk.config, round + 1);
        assert!(told.stderr.contains(&kept), "{}", told.stderr);
        assert_eq!(fs::read_to_string(&kept).expect("it is kept"), before);
        let mut expected: Table = before.parse().expect("it is TOML");
        merge(
            &mut expected,
            &fs::read_to_string(&output).expect("it wrote").parse().expect("TOML"),
        );
        assert_eq!(desk.table(), expected, "{command}");
        for line in dry.stdout.lines().filter(|line| line.starts_with('+') && line.len() > 4) {
            let shown = line.trim_start_matches('+');
            assert!(shown == " with the tables" || desk.text().contains(shown), "{line}");
        }
        tertius(&["check", &desk.config]).ok();
    }
    let (before, after) = (original, desk.text());
    assert_eq!(comments(&after)[..comments(&before).len()], comments(&before), "they stay");
    for command in ["identify", "calibrate", "tune"] {
        assert_eq!(after.matches(&format!(" {command}, for ")).count(), 1, "{after}");
    }
    // Once more: nothing but where it came from could change, and that is the same.
    tertius(&["calibrate", &desk.log, "--config", &desk.config, "--into", &desk.config]).ok();
    let again = desk.table();
    assert_eq!(again, after.parse::<Table>().expect("it is TOML"));
}

#[test]
fn what_would_be_refused_is_not_written() {
    let desk = Desk::new();
    let text = desk.text().replace("bound = 1.5e-3\n", "bound = 2e-2\nlow = 1e-2\n");
    assert_ne!(text, desk.text(), "what is calibrated will be below `low`");
    fs::write(&desk.config, &text).expect("it is ours");
    let call = ["calibrate", &desk.log, "--config", &desk.config, "--into", &desk.config];
    tertius(&call).failed(1, &["would be refused; nothing was changed", "comparator.low"]);
    assert_eq!(desk.text(), text);
    assert!(!fs::exists(format!("{}.bak-1", desk.config)).expect("it can be looked for"));
}

#[test]
fn only_a_configuration_is_written_into() {
    let desk = Desk::new();
    let log = fs::read(&desk.log).expect("it is there");
    let call = ["calibrate", &desk.log, "--config", &desk.config, "--into", &desk.log];
    tertius(&call).failed(2, &["would be written over the input"]);
    let other = desk.scratch.write("notes.toml", "[notes]\n");
    let call = ["calibrate", &desk.log, "--config", &desk.config, "--into", &other];
    tertius(&call).failed(2, &["notes.toml"]);
    assert_eq!(fs::read_to_string(&other).expect("it is there"), "[notes]\n");
    assert_eq!(fs::read(&desk.log).expect("it is there"), log);
    let call = ["calibrate", &desk.log, "--config", &desk.config, "--dry-run"];
    tertius(&call).failed(2, &["--into"]);
}

/// The beginning of the recording is enough: they refuse before they learn.
#[test]
fn tables_of_one_machine_do_not_go_into_another_ones_configuration() {
    let desk = Desk::new();
    let short = between(&recorded("e-type-healthy.log.zst"), 200.0, 205.0);
    let log = desk.scratch.write("short.log", short);
    let slower = desk.text().replace("sample_time = 0.02 ", "sample_time = 0.025 ");
    let fewer = desk.text().replace("cylinders = 6", "cylinders = 5");
    let dbc = fs::read_to_string(top().join("dbc/e-type.dbc")).expect("it ships");
    let dbc =
        desk.scratch.write("elsewhere.dbc", dbc.replace("BO_ 385 Cyl1_C1", "BO_ 1234 Cyl1_C1"));
    let dbc = format!("{dbc:?}");
    let elsewhere = desk.text().replace(&format!("{:?}", top().join("dbc/e-type.dbc")), &dbc);
    let exchanged =
        desk.text().replace("_C1.", "_C3.").replace("_C2.", "_C1.").replace("_C3.", "_C2.");
    let alone = desk.text().replace("c2_velocity", "# c2_velocity");
    for (text, found) in [
        (slower, "machine.sample_time is 0.025 s, expected 0.02 s"),
        (fewer, "machine.cylinders is 5, expected 6"),
        (elsewhere, "signals.cylinder.c1 of cylinder 1 is in frame 0x4D2, expected in frame 0x181"),
        (exchanged, "signals.cylinder.c1 of cylinder 1 is in frame 0x191, expected in frame 0x181"),
        (alone, "signals.cylinder.c2_velocity of cylinder 1 is not named, expected in frame 0x191"),
    ] {
        assert_ne!(text, desk.text(), "{found}");
        let other = desk.scratch.write("other.toml", &text);
        for command in ["identify", "calibrate", "tune"] {
            let call = [command, &log, "--config", &desk.config, "--into", &other];
            for more in [&[] as &[&str], &["--dry-run"]] {
                let words = [&other, &desk.config, found, "Nothing was changed"];
                tertius(&[&call[..], more].concat()).failed(2, &words);
            }
            assert_eq!(fs::read_to_string(&other).expect("it is there"), text);
        }
    }
}

/// What a DBC says beside where the signals are makes no other machine.
#[test]
fn another_comment_in_the_dbc_makes_no_other_machine() {
    let desk = Desk::new();
    let dbc = fs::read_to_string(top().join("dbc/e-type.dbc")).expect("it ships");
    let dbc = format!("{}\r\nCM_ \"Typed anew.\";\r\n", dbc.replace('\n', "\r\n"));
    let dbc = format!("{:?}", desk.scratch.write("anew.dbc", dbc));
    let text = desk.text().replace(&format!("{:?}", top().join("dbc/e-type.dbc")), &dbc);
    let other = desk.scratch.write("other.toml", &text);
    tertius(&["calibrate", &desk.log, "--config", &desk.config, "--into", &other]).ok();
    assert_ne!(fs::read_to_string(&other).expect("it is there"), text, "it has the tables");
}

#[test]
fn a_recording_that_is_cut_off_changes_no_configuration() {
    let desk = Desk::new();
    let cut = |bytes: Vec<u8>| bytes[..bytes.len() * 9 / 10].to_vec();
    let text = fs::read(&desk.log).expect("it is there");
    let packed = zstd::encode_all(&text[..], 1).expect("it can be compressed");
    let mut gzip = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    gzip.write_all(&text).expect("there is room");
    let gzip = gzip.finish().expect("there is room");
    let logs = [("cut.log.zst", cut(packed)), ("cut.log.gz", cut(gzip))];
    let logs = logs.map(|(name, bytes)| desk.scratch.write(name, bytes));
    let (before, output) = (desk.text(), desk.scratch.path("tables.toml"));
    for command in ["identify", "calibrate", "tune", "commission"] {
        let wanted: &[&[&str]] = match command {
            "commission" => &[&[]],
            _ => &[&["--into", &desk.config], &["--output", &output]],
        };
        for (log, wanted) in logs.iter().flat_map(|log| wanted.iter().map(move |it| (log, it))) {
            let call = [&[command, log, "--config", &desk.config], *wanted].concat();
            let words = [log, "truncated", "nothing is learnt", "tertius convert"];
            let run = tertius(&call).failed(1, &words);
            assert_eq!(run.stdout, "", "it refuses before it learns");
        }
    }
    assert_eq!(desk.text(), before);
    assert!(!fs::exists(&output).expect("it can be looked for"));
    // Figures to look at are none to keep.
    let page = tertius(&["calibrate", &logs[0], "--config", &desk.config]);
    assert!(page.failed(1, &["truncated"]).stdout.contains("cylinder"));
}
