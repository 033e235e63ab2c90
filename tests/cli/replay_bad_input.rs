//! Whatever a recording or a call has wrong, a replay counts it, says it and ends.

use flate2::Compression;
use flate2::write::GzEncoder;
use serde_json::Value;
use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io::{BufRead, BufReader, Read, Write};
use std::path::Path;
use std::process::Command;
use tertius::blame::Rule;
use tertius_testing::support::{
    E_TYPE, HANGING_LOAD, Run, Scratch, Seeded, between, command, recorded, recording, replay,
    tertius,
};

/// Five seconds around the begin of a fault, and as many warnings.
fn excerpt() -> String {
    between(&recorded("e-type-faults.log.zst"), 88.0, 93.0)
}

/// All lines but the summary.
fn said(run: &Run) -> Vec<Value> {
    run.lines().into_iter().filter(|line| line["type"] != "summary").collect()
}

/// A second device sends C1 of cylinder 1, too, and another device cuts off the alive counter of C1 of cylinder 2.
#[test]
fn frames_that_cannot_be_relied_on_are_told_first() {
    let scratch = Scratch::new();
    let log: String = excerpt()
        .lines()
        .flat_map(|line| match line.split_once(" 181#") {
            Some((before, data)) => {
                let other = if data.starts_with('F') { '0' } else { 'F' };
                vec![line.to_owned(), format!("{before} 181#{other}{}", &data[1..])]
            }
            None if line.contains(" 182#") => vec![line[..line.len() - 2].to_owned()],
            None => vec![line.to_owned()],
        })
        .map(|line| line + "\n")
        .collect();
    let doubtful = scratch.write("doubtful.log", log);
    let text = tertius(&["replay", &doubtful, "--config", E_TYPE], b"").ok().stdout;
    let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
    let words = [
        "Look at the bus: 250 frames with the same count as another one",
        "Look at the bus: 250 frames too short for the signals that are configured",
        "frames 0x181 contradict each other",
        "frames 0x182 are too short",
        "its frames could not be relied on",
    ];
    words.into_iter().for_each(|it| assert!(text.contains(it), "{it:?} is not in\n{text}"));
    let run = replay(&[&doubtful], E_TYPE, &[]).ok();
    let summary = run.summary();
    assert_eq!(
        (&summary["contradicting_frames"], &summary["short_frames"]),
        (&250.into(), &250.into())
    );
    assert_eq!(summary["remarks"].as_array().map(Vec::len), Some(2));
    let blamed =
        |it: &Value| it["type"] == "warning" && (it["cylinder"] == 1 || it["cylinder"] == 2);
    assert!(!run.lines().iter().any(|it| blamed(it) && it["suspect"] == "c1"));
}

/// Bits 2 and 5 of the status of C1 of cylinder 3 come and go; the mask has bits 0 and 1.
#[test]
fn a_status_that_nothing_is_known_of_is_told_and_changes_no_verdict() {
    let scratch = Scratch::new();
    let sound = excerpt();
    let mut before = 0;
    let log: String = sound
        .lines()
        .map(|line| match line.split_once(" 183#") {
            Some((stamp, data)) => {
                before += 1;
                let status = ["00", "04", "24"][before / 50 % 3];
                format!("{stamp} 183#{}{status}{}\n", &data[..8], &data[10..])
            }
            None => format!("{line}\n"),
        })
        .collect();
    let odd = scratch.write("odd.log", log);
    let text = tertius(&["replay", &odd, "--config", E_TYPE], b"").ok().stdout;
    let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
    let words = [
        "Look at the status signals: 2 bits that `plausibility.status_mask` does not have",
        "cylinder 3, C1: the status has 0x4, which",
        "cylinder 3, C1: the status has 0x20, which",
    ];
    words.into_iter().for_each(|it| assert!(text.contains(it), "{it:?} is not in\n{text}"));
    let run = replay(&[&odd], E_TYPE, &[]).ok();
    let is_told = |it: &&Value| it["notice"] == "unnamed_status";
    let told: Vec<[Value; 3]> = run
        .lines()
        .iter()
        .filter(is_told)
        .map(|it| ["cylinder", "device", "status"].map(|key| it[key].clone()))
        .collect();
    let of = |bits: &str| [Value::from(3), "c1".into(), bits.into()];
    assert_eq!(told, [of("0x4"), of("0x20")]);
    assert_eq!(run.summary()["unnamed_status_bits"], 2);
    let expected = replay(&[&scratch.write("sound.log", sound)], E_TYPE, &[]).ok();
    let warnings = |run: &Run| -> Vec<Value> {
        run.lines().into_iter().filter(|line| line["type"] == "warning").collect()
    };
    assert_eq!(warnings(&run), warnings(&expected));
}

fn bad_lines() -> [Vec<u8>; 14] {
    [
        b"no candump line at all".to_vec(),
        b"(1700000090.000000) can0 181#B8000000000".to_vec(),
        b"(1700000090.000000) can0 181#00112233445566778899".to_vec(),
        b"(1700000090.000000) can0 800#00".to_vec(),
        b"(1700000090.000000) can0 181".to_vec(),
        b"(1700000090.000000)".to_vec(),
        b"(nan) can0 181#B80000000000".to_vec(),
        b"(99999999999999999999.0) can0 181#B80000000000".to_vec(),
        b"(1700000090.000000) can0 181#B8000000000G".to_vec(),
        b"(1700000090.000000) can0 181#B80000000000 trailing".to_vec(),
        "(1700000090.000000) can0 181#\u{1F6A2}".into(),
        b"\xFF\xFE\x00(\x00".to_vec(),
        vec![0; 300],
        vec![b'('; 100_000],
    ]
}

#[test]
fn bad_lines_are_counted_and_change_nothing_else() {
    let scratch = Scratch::new();
    let log = excerpt();
    let good = replay(&[&scratch.write("good.log", &log)], E_TYPE, &[]).ok();
    assert_eq!(good.warnings().len(), 3);

    let mut seeded = Seeded(93);
    let (mut spoilt, mut added) = (Vec::new(), 0);
    for line in log.split_inclusive('\n') {
        while seeded.chance(0.1) {
            spoilt.extend(&bad_lines()[added % bad_lines().len()]);
            spoilt.push(b'\n');
            added += 1;
        }
        spoilt.extend(line.as_bytes());
    }
    assert!(added > 500, "{added}");
    let file = scratch.write("spoilt.log", spoilt);
    let run = replay(&[&file], E_TYPE, &[]).ok();
    assert_eq!(said(&run), said(&good));
    let (mut found, expected) = (run.summary(), good.summary());
    assert_eq!(found["bad_lines"], added);
    found["bad_lines"] = 0.into();
    assert_eq!(found, expected, "everything else is counted as without them");

    let page = tertius(&["replay", &file, "--config", E_TYPE], b"").ok().stdout;
    let lines = log.lines().count() + added;
    assert!(page.contains(&format!("{added} of {lines} lines were bad; the first 5:")), "{page}");
    assert!(page.contains(&format!("{file}:")) && page.contains("no candump line"), "{page}");
}

#[test]
fn a_call_that_is_wrong_names_the_file_and_the_line() {
    let scratch = Scratch::new();
    let log = scratch.write("good.log", excerpt());
    let missing = scratch.path("missing.log");
    replay(&[&log, &missing], E_TYPE, &[]).failed(2, &[&missing, "No such file"]);
    replay(&[&scratch.path("")], E_TYPE, &[]).failed(2, &["is a directory"]);
    replay(&[&log], &scratch.path("no.toml"), &[]).failed(2, &["no.toml", "No such file"]);
    let config = scratch.config(&[("sample_time = 0.02", "sample_time = -0.02")]);
    let sample_time = format!("{config}:");
    let run = replay(&[&log], &config, &[]).failed(2, &[&sample_time, "sample_time", "-0.02"]);
    let text = fs::read_to_string(&config).expect("it was written");
    let line = text.lines().position(|line| line.starts_with("sample_time")).expect("it is there");
    assert!(run.stderr.contains(&format!("e-type.toml:{}:", line + 1)), "{}", run.stderr);
    let table = scratch.path("no/such/directory/residuals.csv");
    replay(&[&log], E_TYPE, &["--residuals", &table]).failed(2, &[&table, "No such file"]);
    replay(&[&log], E_TYPE, &["--warnings", &table]).failed(2, &[&table, "No such file"]);
    tertius(&["replay", "--config", E_TYPE], b"").failed(2, &["<LOG>"]);
}

#[test]
fn an_output_never_replaces_what_is_read() {
    let scratch = Scratch::new();
    let text = excerpt();
    let log = scratch.write("good.log", &text);
    let config = scratch.config(&[]);
    let dbc = scratch.path("e-type.dbc");
    for (option, file) in [
        ("--residuals", &log),
        ("--warnings", &log),
        ("--residuals", &config),
        ("--warnings", &dbc),
        ("--residuals", &scratch.path("./good.log")),
    ] {
        let before = fs::read(file).expect("it is there");
        replay(&[&log], &config, &[option, file]).failed(2, &[file, "name another file"]);
        assert_eq!(fs::read(file).expect("it is there still"), before);
    }
    let both = scratch.path("both");
    replay(&[&log], &config, &["--residuals", &both, "--warnings", &both]).failed(2, &["both"]);
    replay(&[&log], &config, &["--residuals", "/dev/null", "--warnings", "/dev/null"]).ok();
}

#[test]
fn what_cannot_be_written_is_a_failure() {
    let log = recording("e-type-faults.log.zst");
    let table = ["--residuals", "/dev/full"];
    replay(&[&log], E_TYPE, &table).failed(1, &["table of residuals", "No space left"]);
    let frames = ["--warnings", "/dev/full"];
    replay(&[&log], E_TYPE, &frames).failed(1, &["log of warnings", "No space left"]);
    for format in ["human", "jsonl"] {
        let full = File::create("/dev/full").expect("every Linux has it");
        let arguments = ["replay", &log, "--config", E_TYPE, "--format", format];
        let output = command(&arguments).stdout(full).output().expect("it starts");
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(1), "{message}");
        assert!(message.contains("standard output cannot be written"), "{message}");
    }
}

#[test]
fn a_reader_that_has_enough_is_no_failure() {
    // More than a pipe holds.
    let log = recording("hanging-load.log.gz");
    let arguments = ["replay", &log, "--config", HANGING_LOAD, "--format", "jsonl"];
    let mut child = command(&arguments).spawn().expect("it starts");
    let mut lines = BufReader::with_capacity(512, child.stdout.take().expect("it is piped"));
    let mut first = String::new();
    lines.read_line(&mut first).expect("it writes a line");
    assert!(first.starts_with(r#"{"type":"warning","t":3.6"#), "{first}");
    drop(lines);
    let mut message = String::new();
    let mut stderr = child.stderr.take().expect("it is piped");
    stderr.read_to_string(&mut message).expect("UTF-8");
    let status = child.wait().expect("it ends");
    assert_eq!((status.code(), &*message), (Some(0), ""));
}

#[test]
fn a_compressed_recording_that_is_cut_off_is_replayed_as_far_as_it_goes() {
    let scratch = Scratch::new();
    let log = between(&recorded("e-type-faults.log.zst"), 70.0, 93.0);
    let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(log.as_bytes()).expect("memory takes all");
    let gzip = encoder.finish().expect("memory takes all");
    let zstd = zstd::encode_all(log.as_bytes(), 3).expect("memory takes all");
    for (name, whole) in [("cut.log.gz", gzip), ("cut.log.zst", zstd)] {
        let file = scratch.write(name, &whole[..whole.len() / 2]);
        let next = scratch.write("next.log", between(&log, 90.0, 93.0));
        let run = replay(&[&file], E_TYPE, &[]).failed(1, &[name, "truncated"]);
        assert_eq!(run.summary()["damaged_inputs"], 1);
        let frames = run.summary()["frames"].as_u64().expect("a count") as usize;
        let lines = log.lines().count();
        assert!(frames > lines / 4 && frames < lines * 3 / 4, "{frames} of {lines}");
        assert!(run.warnings().len() >= 2, "the fault at 75 s is in it: {}", run.stdout);
        let both = replay(&[&file, &next], E_TYPE, &[]).failed(1, &[name, "truncated"]);
        let blamed =
            both.warnings().into_iter().any(|w| w["timestamp"].as_f64() > Some(1.70000009e9));
        assert!(blamed, "what follows the damaged input is replayed: {}", both.stdout);
    }
}

/// Nothing was judged: all that a replay says says so, with `reason`, and it is a failure.
#[track_caller]
fn assert_not_judged(scratch: &Scratch, log: &str, config: &str, options: &[&str], reason: &str) {
    let html = scratch.path("page.html");
    let run = replay(&[log], config, &[options, &["--report", &html]].concat());
    let summary = run.failed(1, &["nothing was judged", reason]).summary();
    assert_eq!(summary["judged"], false);
    let reasons = summary["reasons"].as_array().expect("a list");
    let told = |it: &Value| it.as_str().is_some_and(|it| it.contains(reason));
    assert!(reasons.iter().any(told), "{reason:?}: {summary}");

    let call = [&["replay", log, "--config", config], options].concat();
    let page = tertius(&call, b"").failed(1, &[reason]).stdout;
    let headline = page.lines().nth(2).expect("a headline");
    assert!(headline.starts_with("NOTHING WAS JUDGED"), "{page}");
    assert!(page.contains(reason) && !page.contains("No warnings.\n"), "{page}");
    assert!(!page.contains("NaN"), "{page}");
    let html = scratch.read("page.html");
    let (before, _) = html.split_once("NOTHING WAS JUDGED").expect("it is on the page, too");
    assert!(!before.contains("<h2"), "above everything else");
}

#[test]
fn a_recording_without_anything_for_this_machine() {
    let scratch = Scratch::new();
    let asc = "date Sat Sep 30 15:06:13.191 2017\r\nbase hex  timestamps absolute\r\n";
    for (name, content, seems) in [
        ("empty.log", &b""[..], "it is empty"),
        ("blank.log", b"\n\n\r\n", "it is empty"),
        ("trace.asc", asc.as_bytes(), "a Vector log in ASC"),
        ("trace.blf", b"LOGG\x90\0\0\0\x03\x08\x02\0", "a Vector log in BLF"),
        ("trace.trc", b";$FILEVERSION=2.0\r\n;$STARTTIME=43474.\r\n", "a PEAK trace in TRC"),
        (
            "table.csv",
            b"Time Stamp,ID,Extended,Dir,Bus,LEN,D1,D2\r\n",
            "a table of SavvyCAN (GVRET) in CSV",
        ),
        ("data.mdf", b"MDF     3.30    Vector\0\0", "measurement data in MDF before version 4"),
        ("old.pcap", b"\xD4\xC3\xB2\xA1\x02\0\x04\0\0\0\0\0", "a capture in pcap or pcapng"),
        (
            "new.pcapng",
            b"\x0A\x0D\x0D\x0A\x1C\0\0\0\x4D\x3C\x2B\x1A",
            "a capture in pcap or pcapng",
        ),
        ("log.xz", b"\xFD7zXZ\0\0\x04\xE6\xD6\xB4\x46", "(xz); unpack it first"),
        ("log.bz2", b"BZh91AY&SY\x01\x02", "(bzip2); unpack it first"),
        ("log.7z", b"7z\xBC\xAF\x27\x1C\0\x04", "(7-Zip); unpack it first"),
        ("log.zip", b"PK\x03\x04\x14\0\0\0", "(zip); unpack it first"),
    ] {
        let log = scratch.write(name, content);
        let reason = format!("{log}: no frame; it seems to be ");
        let reason = if seems == "it is empty" { format!("{log}: ") } else { reason };
        assert_not_judged(&scratch, &log, E_TYPE, &[], &reason);
        assert_not_judged(&scratch, &log, E_TYPE, &[], seems);
    }
    let readme = "it is text, but not a recording that can be read";
    assert_not_judged(&scratch, "README.md", E_TYPE, &[], readme);
    let other = recording("hanging-load.log.gz");
    let reason = "frames has an identifier of the configuration (080, 1C1, ";
    assert_not_judged(&scratch, &other, E_TYPE, &[], reason);
    let log = scratch.write("good.log", excerpt());
    let reason = "no frame is from can9; the recording has can0 (5500 frames)";
    assert_not_judged(&scratch, &log, E_TYPE, &["--interface", "can9"], reason);

    let run = replay(&[&scratch.write("none.log", "")], E_TYPE, &[]).failed(1, &[]);
    let summary = run.summary();
    assert_eq!((run.lines().len(), &summary["frames"]), (1, &0.into()));
    assert_eq!((&summary["bad_lines"], &summary["duration"]), (&0.into(), &0.0.into()));
    let run = replay(&[&other], E_TYPE, &[]).failed(1, &[]);
    assert_eq!(run.summary()["frames"], run.summary()["ignored_frames"]);
}

/// Frames alone are no judgement: where no residual came of them, it is said why.
#[test]
fn a_recording_of_which_no_residual_came() {
    let scratch = Scratch::new();
    let log = scratch.write("good.log", excerpt());
    let judged = replay(&[&log], E_TYPE, &[]).ok().summary();
    assert_eq!((&judged["judged"], judged.get("reasons")), (&true.into(), None));
    let elsewhere = ("monitored_states = [\"engaged\"]", "monitored_states = [\"settled\"]");
    let mut changes = vec![
        ("c2 = \"Cyl{n}_C2.Position\"\n", ""),
        ("c2_velocity = \"Cyl{n}_C2.Velocity\"\n", ""),
        ("c2_status = \"Cyl{n}_C2.Status\"\n", ""),
        ("c2_counter = \"Cyl{n}_C2.Counter\"\n", ""),
    ];
    let config = scratch.config(&changes);
    assert_eq!(replay(&[&log], &config, &[]).ok().summary()["judged"], true);
    let soon = scratch.write("soon.log", between(&recorded("e-type-faults.log.zst"), 88.0, 88.1));
    assert_not_judged(&scratch, &soon, &config, &[], "5 cycles are too few for the observers");
    changes.push(elsewhere);
    let config = scratch.config(&changes);
    let reason = "the platform was never in a monitored state: the only state seen is 3 (engaged); \
                  monitored is 1 (settled)";
    assert_not_judged(&scratch, &log, &config, &[], reason);
    let states: String =
        excerpt().split_inclusive('\n').filter(|line| line.contains(" 1C1#")).collect();
    let log = scratch.write("states.log", states);
    assert_not_judged(&scratch, &log, E_TYPE, &[], "there is neither Sync nor a reading");
}

/// R3, which is there whatever the state, does not make a machine look healthy that was parked all the time; what R3
/// finds is told all the same.
#[test]
fn a_recording_in_which_the_platform_was_never_monitored() {
    let scratch = Scratch::new();
    let log = recorded("e-type-faults.log.zst");
    let elsewhere = "monitored_states = [\"settled\", \"safe\"]";
    let config = scratch.config(&[("monitored_states = [\"engaged\"]", elsewhere)]);
    let parked = scratch.write("parked.log", between(&log, 80.0, 85.0));
    let reason = "never in a monitored state: the only state seen is 3 (engaged); monitored are \
                  1 (settled), 0 (safe)";
    assert_not_judged(&scratch, &parked, &config, &[], reason);
    let page = tertius(&["replay", &parked, "--config", &config], b"").failed(1, &[reason]).stdout;
    assert!(page.contains("only what C1 and C2 showed beside each other (R3)"), "{page}");
    assert!(!page.contains("No incident") && !scratch.read("page.html").contains("\"good\""));

    let stateless = between(&log, 80.0, 85.0);
    let without = stateless.split_inclusive('\n').filter(|line| !line.contains(" 1C1#"));
    let stateless = scratch.write("stateless.log", without.collect::<String>());
    let reason = "never in a monitored state: no state was received; monitored is 3 (engaged)";
    assert_not_judged(&scratch, &stateless, E_TYPE, &[], reason);

    let found = tertius(&["replay", &recording("e-type-faults.log.zst"), "--config", &config], b"");
    let found = found.failed(1, &["nothing was judged"]).stdout;
    assert!(found.starts_with(&recording("e-type-faults.log.zst")), "{found}");
    let (_, told) = found.split_once("NOTHING WAS JUDGED").expect("first of all");
    assert!(told.contains(" incidents in ") && told.contains("Worst: "), "{found}");
}

/// Those that learn say the same of the same files.
#[test]
fn nothing_is_learnt_from_nothing() {
    let scratch = Scratch::new();
    let log = scratch.write("good.log", excerpt());
    let blf = scratch.write("trace.blf", b"LOGG\x90\0\0\0\x03\x08\x02\0");
    let other = recording("hanging-load.log.gz");
    for command in ["identify", "calibrate", "tune"] {
        let run = |log: &str, more: &[&str]| {
            tertius(&[&[command, log, "--config", E_TYPE], more].concat(), b"")
        };
        run(&blf, &[]).failed(1, &["nothing was judged", "trace.blf: no frame", "in BLF"]);
        run(&other, &[]).failed(1, &["frames has an identifier of the configuration (080, "]);
        let words = ["no frame is from can9; the recording has can0 (5500 frames)"];
        run(&log, &["--interface", "can9"]).failed(1, &words);
    }
}

/// `log` on another interface, `by` microseconds later.
fn moved(log: &str, interface: &str, by: u64) -> String {
    let line = |line: &str| {
        let digits: String = line[1..18].chars().filter(char::is_ascii_digit).collect();
        let micros = digits.parse::<u64>().expect("digits") + by;
        let (seconds, micros) = (micros / 1_000_000, micros % 1_000_000);
        let rest = line[18..].replacen(") can0", &format!(") {interface}"), 1);
        format!("({seconds:010}.{micros:06}{rest}\n")
    };
    log.lines().map(line).collect()
}

/// The lines of all `logs` in the order of time.
fn merged(logs: &[&str]) -> String {
    let mut lines: Vec<&str> = logs.iter().flat_map(|log| log.split_inclusive('\n')).collect();
    lines.sort_by_key(|line| line[..18].to_owned());
    lines.concat()
}

/// Everything but how many frames there were.
fn without_frames(run: &Run) -> (Vec<Value>, Value) {
    let mut summary = run.summary();
    for key in ["frames", "ignored_frames"] {
        summary[key] = 0.into();
    }
    (said(run), summary)
}

#[test]
fn of_several_interfaces_the_configured_one_is_read() {
    let scratch = Scratch::new();
    let own = excerpt();
    let alone = without_frames(&replay(&[&scratch.write("own.log", &own)], E_TYPE, &[]).ok());
    // The other one first, and second; in one file, and in two.
    for by in [7000, 20_000 - 7000] {
        let other = moved(&own, "can1", by);
        let both = merged(&[&other, &own]);
        let run = replay(&[&scratch.write("both.log", &both)], E_TYPE, &[]).ok();
        assert_eq!(without_frames(&run), alone, "{by} µs");
        let late = both.split_inclusive('\n').skip(7).collect::<String>();
        let (head, tail) = late.split_at(late[..5000].rfind('\n').expect("a line ends") + 1);
        let files = [scratch.write("head.log", head), scratch.write("tail.log", tail)];
        let split = replay(&[&files[0], &files[1]], E_TYPE, &[]).ok();
        let whole = replay(&[&scratch.write("late.log", &late)], E_TYPE, &[]).ok();
        assert_eq!(split.stdout, whole.stdout);
        let call = ["replay", "-", "--config", E_TYPE, "--format", "jsonl"];
        assert_eq!(tertius(&call, late.as_bytes()).ok().stdout, whole.stdout);
        let page = tertius(&["replay", "-", "--config", E_TYPE], both.as_bytes()).ok().stdout;
        for words in ["5500 frames of other interfaces", "can0 (5500 frames)", "can1 (5500 frames)"]
        {
            assert!(page.contains(words), "{words:?}: {page}");
        }
    }
    // Only one, of whatever name, is read as it is.
    let other = scratch.write("other.log", moved(&own, "vcan7", 0));
    assert_eq!(without_frames(&replay(&[&other], E_TYPE, &[]).ok()), alone);
}

#[test]
fn of_several_other_interfaces_the_user_chooses() {
    let scratch = Scratch::new();
    let own = excerpt();
    let [one, two] = [("can1", 0), ("can2", 7000)].map(|(name, by)| moved(&own, name, by));
    let both = scratch.write("both.log", merged(&[&one, &two]));
    let words = ["several interfaces", "can1 (", "can2 (", "--interface", "can0"];
    replay(&[&both], E_TYPE, &[]).failed(2, &words);
    let few = merged(&[&one, &two]).split_inclusive('\n').take(100).collect::<String>();
    let few = scratch.write("few.log", few);
    replay(&[&few], E_TYPE, &[]).failed(2, &["can1 (56 frames), can2 (44 frames)"]);
    for command in ["identify", "calibrate", "tune"] {
        tertius(&[command, &both, "--config", E_TYPE], b"").failed(2, &words);
    }
    let fault = ["--fault", "step,cylinder=1,sensor=c1,size=0.01"];
    let inject = |more: &[&str]| {
        tertius(&[&["inject", &both, "--config", E_TYPE], &fault[..], more].concat(), b"")
    };
    inject(&[]).failed(2, &words);
    let changed = inject(&["--interface", "can2"]).ok().stdout;
    assert!(one.lines().all(|line| changed.contains(line)), "can1 goes through as it is");
    let alone = without_frames(&replay(&[&scratch.write("own.log", &own)], E_TYPE, &[]).ok());
    let chosen = replay(&[&both], E_TYPE, &["--interface", "can1"]).ok();
    assert_eq!(without_frames(&chosen).0, alone.0);

    // Whichever comes only when another one was read for long, it is too late to choose.
    for late in ["can0", "can2"] {
        let last = moved(&own, late, 10_000_000);
        let log = scratch.write("late.log", format!("{one}{}", &last[..last.len() / 2]));
        let words = ["late.log:5501: ", "can1 (5500 frames)", late, "--interface"];
        replay(&[&log], E_TYPE, &[]).failed(2, &words);
    }
}

#[test]
fn recordings_in_the_wrong_order_are_refused_or_put_in_order() {
    let scratch = Scratch::new();
    let log = recorded("e-type-faults.log.zst");
    let parts = [(88.0, 90.0), (90.0, 92.0), (92.0, 93.0)];
    let [a, b, c] =
        parts.map(|(begin, end)| scratch.write(&format!("{begin}.log"), between(&log, begin, end)));
    replay(&[&a, &b, &c], E_TYPE, &[]).ok();
    let order = format!("name them in the order of time: {a} {b} {c}");
    let words = ["90.log begins at 1700000090.000", "before", "92.log", &*order];
    replay(&[&a, &c, &b], E_TYPE, &[]).failed(2, &words);
    // What learns reads them in the order of time itself, and says so.
    for command in ["identify", "calibrate", "tune"] {
        let of = |logs: [&str; 3]| {
            tertius(&[&[command], &logs[..], &["--config", E_TYPE]].concat(), b"")
        };
        let (right, wrong) = (of([&a, &b, &c]), of([&a, &c, &b]));
        assert_eq!(right.code, wrong.code, "{}", wrong.stderr);
        let same = right.stdout.lines().all(|line| wrong.stdout.contains(line));
        assert!(same, "{command}: {} {}", right.stdout, wrong.stdout);
    }
    // Time stamps that count from each one's own beginning say nothing of the order.
    let console = " (0.5)  can0  080   [1]  00\n (0.6)  can0  080   [1]  01\n";
    let [one, two] = ["one", "two"].map(|name| scratch.write(name, console));
    let early = scratch.write("early", console.replace("(0.5)", "(0.1)"));
    replay(&[&one, &two, &early], E_TYPE, &["--interface", "can0"]).failed(1, &["judged"]);
    // Whose pieces are in one file, or come through a pipe, are found by whoever reads them twice.
    let wrong = scratch.write("wrong.log", between(&log, 90.0, 93.0) + &between(&log, 80.0, 90.0));
    for command in ["identify", "calibrate", "tune"] {
        let words = ["11000 of 14300 frames are earlier than the first one, at 1700000090.000"];
        tertius(&[command, &wrong, "--config", E_TYPE], b"").failed(2, &words);
    }
    let early = "(1700000120.500000) can0 7FF#\n".to_owned() + &between(&log, 120.0, 200.0);
    let early = scratch.write("early.log", early);
    let page = tertius(&["identify", &early, "--config", E_TYPE], b"").stdout;
    let told = "of 88001 frames are earlier than the first one, at 1700000120.5, and are left out";
    assert!(page.contains(told), "{page}");
}

#[test]
fn recordings_that_overlap_are_refused_and_those_of_other_interfaces_do_not() {
    let scratch = Scratch::new();
    let log = recorded("e-type-faults.log.zst");
    let write = |name: &str, begin, end| scratch.write(name, between(&log, begin, end));
    let (a, b) = (write("a.log", 88.0, 92.0), write("b.log", 90.5, 94.0));
    let html = scratch.path("page.html");
    let said = "recordings overlap, one is named twice, or the clock was set back; name each recording once";
    for (logs, begin) in [([&*a, &*a], "1700000088.000"), ([&*a, &*b], "1700000090.500")] {
        for threads in ["1", "2"] {
            let words = [logs[1], begin, "up to 1700000091.98", said];
            replay(&logs, E_TYPE, &["--threads", threads, "--report", &html]).failed(2, &words);
        }
    }
    assert!(!fs::exists(&html).expect("it can be looked for"));
    // As one, they are a recording whose clock was set back.
    let both = scratch.write("both.log", scratch.read("a.log") + &scratch.read("b.log"));
    let summary = replay(&[&both], E_TYPE, &[]).ok().summary();
    assert_eq!([&summary["backwards"], &summary["time_jumps"]], [1, 1]);
    // What is not read does not overlap, and neither do frames that are a little out of order.
    let other = scratch.write("other.log", scratch.read("b.log").replace(" can0 ", " can1 "));
    assert_eq!(replay(&[&a, &other], E_TYPE, &[]).ok().summary()["backwards"], 0);
    let next = write("next.log", 91.5, 94.0);
    replay(&[&a, &next], E_TYPE, &[]).ok();
}

/// A page of what was read until the disk was full would look like one of the whole recording.
#[test]
fn a_replay_that_broke_off_has_no_page() {
    let scratch = Scratch::new();
    let log = recording("e-type-faults.log.zst");
    for option in ["--residuals", "--warnings"] {
        let html = scratch.path("page.html");
        let call = ["replay", &log, "--config", E_TYPE, option, "/dev/full", "--report", &html];
        let run = tertius(&call, b"").failed(1, &["No space left", "neither page nor summary"]);
        assert_eq!(run.stdout, "", "{option}");
        assert!(!Path::new(&html).exists());
    }
    // A pipe that nobody reads any more is not the one that the page goes to.
    let pipe = scratch.path("pipe");
    let made = Command::new("mkfifo").arg(&pipe).status().expect("coreutils");
    assert!(made.success());
    let opened = pipe.clone();
    let reader = std::thread::spawn(move || {
        let mut some = [0; 16];
        File::open(opened).and_then(|mut pipe| pipe.read_exact(&mut some)).expect("a line comes");
    });
    let call = ["replay", &log, "--config", E_TYPE, "--residuals", &pipe];
    let run = tertius(&call, b"").failed(1, &["table of residuals", "Broken pipe"]);
    reader.join().expect("it read");
    assert_eq!(run.stdout, "");
}

/// A bus-off is counted where the other counts are, and no curve goes on over it.
#[test]
fn a_lost_bus_is_counted_and_said() {
    let scratch = Scratch::new();
    let (before, after) = (between(&excerpt(), 88.0, 90.0), between(&excerpt(), 90.0, 93.0));
    let bus_off = "(1700000089.999900) can0 20000040#0000000000000000\n";
    let log = scratch.write("off.log", format!("{before}{bus_off}{after}"));
    let html = scratch.path("page.html");
    let run = replay(&[&log], E_TYPE, &["--report", &html]).ok();
    assert_eq!(run.summary()["interruptions"], 1);
    let page = tertius(&["replay", &log, "--config", E_TYPE], b"").ok().stdout;
    assert!(page.contains("1 interruption of the bus (everything restarted)\n"), "{page}");
    let html = scratch.read("page.html");
    assert!(
        html.contains("1 interruption of the bus") && html.contains("bus lost"),
        "it is marked"
    );
}

/// Of the day between two recordings nothing is known, so that nobody says that it had no incident.
#[test]
fn the_time_between_two_recordings_is_no_time_without_an_incident() {
    let scratch = Scratch::new();
    let quiet = between(&recorded("e-type-healthy.log.zst"), 240.0, 260.0);
    let first = scratch.write("first.log", &quiet);
    let later = scratch.write("later.log", quiet.replace("(170000", "(170010"));
    let page = tertius(&["replay", &first, &later, "--config", E_TYPE], b"").ok().stdout;
    assert!(page.contains("No incident in 40.0 s.\n"), "{page}");
    assert!(page.contains("\n0:39.9"), "{page}");
    assert!(page.contains(" of recording within 27:46:59.9"), "{page}");
    assert!(page.contains("\n1 jump of the time stamps (everything restarted)\n"), "{page}");
    let set_back = quiet.replace("(170000", "(170010") + &quiet;
    let page = tertius(&["replay", "-", "--config", E_TYPE], set_back.as_bytes()).ok().stdout;
    assert!(page.contains(" of recording, whose clock was set back by 27:4"), "{page}");
    assert!(!page.contains("within"), "{page}");
    let page = tertius(&["replay", &first, "--config", E_TYPE], b"").ok().stdout;
    assert!(page.contains("No incident in 20.0 s.\n") && !page.contains("within"), "{page}");
    assert!(!page.contains("set back"), "{page}");
}

/// `log` with the time stamps of its cycles moved by what `shift` gives for each, s.
fn shifted(log: &str, shift: impl Fn(i64) -> i64) -> String {
    let (mut cycle, mut text) = (-1, String::new());
    for line in log.lines() {
        cycle += i64::from(line.contains(" 080#"));
        let (seconds, rest) = line[1..].split_once('.').expect("a decimal point");
        let seconds = seconds.parse::<i64>().expect("digits") + shift(cycle);
        text += &format!("({seconds:010}.{rest}\n");
    }
    text
}

const YEAR: i64 = 365 * 86_400;

#[test]
fn time_that_jumps_is_counted_and_said() {
    let scratch = Scratch::new();
    let log = excerpt();
    // How the time goes on after half of it; notice, its seconds; backwards, jumps, missing cycles.
    for (step, notice, seconds, counts) in [
        (300, "gap", 300.0, [0, 0, 15_000]),
        (3 * YEAR, "time_jump", 3.0 * YEAR as f64, [0, 1, 0]),
        (-3600, "time_jump", -3600.0, [1, 1, 0]),
        (-1_600_000_000, "time_jump", -1.6e9, [1, 1, 0]),
    ] {
        let text = shifted(&log, |cycle| if cycle < 125 { 0 } else { step });
        let file = scratch.write("jump.log", text);
        let run = replay(&[&file], E_TYPE, &[]).ok();
        let lines = run.lines();
        let of_kind = |kind: &str| lines.iter().filter(|line| line["notice"] == *kind).count();
        assert_eq!(of_kind("gap") + of_kind("time_jump"), 1, "{}", run.stdout);
        let said = lines.iter().find(|line| line["notice"] == notice).expect("it is said");
        let found = said["seconds"].as_f64().expect("a number");
        assert!((found - seconds).abs() < 0.1, "{found} against {seconds}");
        assert_eq!(of_kind("restart"), 12, "every observer restarts");
        let summary = run.summary();
        for (key, count) in ["backwards", "time_jumps", "missing_cycles"].into_iter().zip(counts) {
            assert_eq!(summary[key], count, "{key} after a step of {step} s");
        }
        let page = tertius(&["replay", &file, "--config", E_TYPE], b"").ok().stdout;
        let words = if notice == "gap" { "after 300.00 s without any" } else { "jumped by" };
        assert!(page.contains(words), "{page}");
    }
}

#[test]
fn time_stamps_without_reason_end_too() {
    let scratch = Scratch::new();
    let log = excerpt();
    let back_and_forth = shifted(&log, |cycle| cycle % 2 * 10 * YEAR);
    let run = replay(&[&scratch.write("wild.log", back_and_forth)], E_TYPE, &[]);
    assert_eq!(run.code, Some(1), "nothing can be judged");
    assert_eq!(run.summary()["time_jumps"], 249);
    assert_eq!(run.summary()["cylinders"][0]["gated"], 250, "nothing can be judged");

    // The ends of what a time stamp can be, in the middle of a good recording.
    let (before, after) = log.split_at(log.len() / 2);
    let (before, rest) = before.split_at(before.rfind('\n').expect("a line ends") + 1);
    let ends = "(9223372036.854775807) can0 080#00\n(9223372036.854775807) can0 181#AF2700000000\n\
                (0.000000) can0 080#00\n(9223372036.854775) can0 080#01\n";
    let text = format!("{before}{ends}{rest}{after}");
    let run = replay(&[&scratch.write("ends.log", text)], E_TYPE, &[]).ok();
    assert_eq!(run.summary()["bad_lines"], 0);
    assert!(run.summary()["time_jumps"].as_u64() >= Some(3), "{}", run.stdout);

    // Frames in an order of their own: each as it came, none later than the recording lasts.
    let mut seeded = Seeded(88);
    let mut lines: Vec<&str> = log.lines().collect();
    for index in (1..lines.len()).rev() {
        lines.swap(index, seeded.below(index as u64 + 1) as usize);
    }
    let run = replay(&[&scratch.write("shuffled.log", lines.join("\n"))], E_TYPE, &[]);
    let summary = run.summary();
    assert_eq!(summary["frames"], lines.len());
    assert!(summary["time_jumps"].as_u64() > Some(1000), "{summary}");
}

/// The words that the description allows.
const WORDS: [(&str, &[&str]); 5] = [
    ("detector", &["fde1", "fde2", "fde3", "plausibility", "sequential", "process"]),
    (
        "fault",
        &[
            "unclassified",
            "abrupt",
            "noise",
            "incipient",
            "out_of_range",
            "broken_wire",
            "frozen",
            "stale",
        ],
    ),
    ("suspect", &["undecided", "c1", "c2", "process"]),
    ("level", &["none", "yellow", "orange", "red", "black"]),
    ("state", &["raised", "changed", "cleared"]),
];

fn keys(line: &Value) -> BTreeSet<&str> {
    line.as_object().expect("an object").keys().map(String::as_str).collect()
}

fn check_warning(line: &Value, cylinders: u64) {
    let numbers = ["t", "timestamp", "cylinder", "residual", "threshold"];
    let words = WORDS.map(|(key, _)| key);
    let expected: BTreeSet<&str> = ["type", "by"].into_iter().chain(numbers).chain(words).collect();
    assert_eq!(keys(line), expected, "{line}");
    for (key, allowed) in WORDS {
        assert!(line[key].as_str().is_some_and(|word| allowed.contains(&word)), "{key}: {line}");
    }
    assert!(Rule::ALL.into_iter().any(|rule| line["by"] == rule.name()), "{line}");
    let cylinder = line["cylinder"].as_u64().expect("a number");
    assert!((1..=cylinders).contains(&cylinder), "{line}");
    let apart = line["timestamp"].as_f64().zip(line["t"].as_f64()).map(|(at, t)| at - t);
    assert!(apart.is_some_and(|first| (first - 1.7e9).abs() < 200.0), "{line}");
    // Only a reading that is not there, or does not move, has no residual.
    let none = line["residual"].is_null() && line["threshold"].is_null();
    let both = line["residual"].is_f64() && line["threshold"].is_number();
    let plausibility = line["detector"] == "plausibility";
    assert!(if plausibility { none || both } else { both }, "{line}");
}

/// An incident: its words, its times in order, and a peak where something was compared.
fn check_incident(line: &Value, cylinders: u64) {
    let expected = [
        "type",
        "t",
        "timestamp",
        "incident",
        "state",
        "cylinder",
        "level",
        "suspect",
        "by",
        "named",
        "named_by_its_end",
        "fault",
        "begin",
        "onset",
        "end",
        "ending",
        "size",
        "quantity",
        "peak",
        "peak_at",
        "limit",
        "now",
        "peaks",
        "detectors",
        "summary",
        "evidence",
    ];
    assert_eq!(keys(line), expected.into_iter().collect(), "{line}");
    for (key, allowed) in &WORDS[1..4] {
        assert!(line[key].as_str().is_some_and(|word| allowed.contains(&word)), "{key}: {line}");
    }
    let states = ["opened", "revised", "standing", "closed"];
    assert!(line["state"].as_str().is_some_and(|word| states.contains(&word)), "{line}");
    assert!((1..=cylinders).contains(&line["cylinder"].as_u64().expect("a number")), "{line}");
    let times = ["onset", "begin", "end", "t"].map(|key| line[key].as_f64());
    assert!(times.iter().flatten().is_sorted(), "{line}");
    let is_closed = line["state"] == "closed";
    assert_eq!((times[2].is_some(), line["ending"].is_string()), (is_closed, is_closed), "{line}");
    let is_named = line["suspect"] != "undecided";
    let named = [line["named"].is_number(), line["named_by_its_end"].is_boolean()];
    assert_eq!(named, [is_named; 2], "{line}");
    assert_eq!(line["by"].is_string(), is_named, "{line}");
    assert!(!is_named || times[1] <= line["named"].as_f64(), "{line}");
    assert!(!is_closed || line["now"].is_null(), "{line}");
    let compared = ["peak", "peak_at", "limit"].map(|key| line[key].is_number());
    assert_eq!(compared, [line["quantity"].is_string(); 3], "{line}");
    assert!(!line["detectors"].as_array().expect("a list").is_empty(), "{line}");
}

fn check_notice(line: &Value) {
    let expected: &[&str] = match line["notice"].as_str() {
        Some("gap" | "time_jump") => &["type", "t", "timestamp", "notice", "seconds"],
        Some("timing") => &["type", "t", "timestamp", "notice", "skew", "jitter"],
        Some("timing_restored" | "interruption") => &["type", "t", "timestamp", "notice"],
        Some("restart") => &["type", "t", "timestamp", "notice", "cylinder", "detector", "reason"],
        _ => panic!("{line}"),
    };
    assert_eq!(keys(line), expected.iter().copied().collect());
}

fn check_summary(line: &Value, warnings: &[&Value]) {
    for key in ["frames", "ignored_frames", "bad_lines", "cycles", "incomplete_cycles"] {
        assert!(line[key].is_u64(), "{key}: {line}");
    }
    assert!(line["duration"].is_f64(), "{line}");
    assert_eq!(keys(&line["warnings"]), WORDS[0].1.iter().copied().collect());
    for detector in WORDS[0].1 {
        let raised = |w: &&&Value| w["detector"] == *detector && w["state"] == "raised";
        let count = warnings.iter().filter(raised).count();
        assert_eq!(line["warnings"][detector], count, "{detector}");
    }
}

#[test]
fn every_line_of_json_is_as_described() {
    let scratch = Scratch::new();
    // Everything implausible: cylinder 2 broken, 3 out of range, 4 silent, all valves of 5 silent.
    let log = between(&recorded("e-type-faults.log.zst"), 58.0, 64.0);
    let mut cycle = 0;
    let spoilt: String = log
        .split_inclusive('\n')
        .filter_map(|line| {
            cycle += u32::from(line.contains(" 080#"));
            let (head, data) = line.split_once('#').expect("a frame");
            match (head.get(25..28), cycle) {
                (Some("182"), 60..80) => Some(format!("{head}#FF7F{}", &data[4..])),
                (Some("193"), 90..110) => Some(format!("{head}#FF6C{}", &data[4..])),
                (Some("184"), 120..140) | (Some("1A5"), 150..170) | (_, 200..220) => None,
                _ => Some(line.to_owned()),
            }
        })
        .collect();
    let spoilt = scratch.write("spoilt.log", spoilt);
    let runs = [
        (replay(&[&recording("e-type-faults.log.zst")], E_TYPE, &[]), 6),
        (replay(&[&recording("hanging-load.log.gz")], HANGING_LOAD, &[]), 1),
        (replay(&[&spoilt], E_TYPE, &[]), 6),
    ];
    let mut faults = BTreeSet::new();
    for (run, cylinders) in runs {
        let lines = run.ok().lines();
        let (summary, others) = lines.split_last().expect("a summary");
        let mut last = 0.0;
        for line in others {
            match line["type"].as_str() {
                Some("warning") => check_warning(line, cylinders),
                Some("notice") => check_notice(line),
                Some("incident") => check_incident(line, cylinders),
                _ => panic!("only the last line is something else: {line}"),
            }
            let t = line["t"].as_f64().expect("a number");
            assert!(t >= last, "lines are in the order of time: {line}");
            last = t;
        }
        assert_eq!(summary["type"], "summary");
        let warnings: Vec<&Value> = others.iter().filter(|l| l["type"] == "warning").collect();
        check_summary(summary, &warnings);
        faults.extend(warnings.iter().map(|w| w["fault"].as_str().expect("a word").to_owned()));
    }
    let faults: Vec<&str> = faults.iter().map(String::as_str).collect();
    let expected =
        ["abrupt", "broken_wire", "frozen", "incipient", "noise", "out_of_range", "stale"];
    assert_eq!(faults, expected, "all kinds were there to be checked");
}
