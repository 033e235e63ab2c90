//! `tertius inject` as people call it.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn top() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn inject(log: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_tertius"))
        .arg("inject")
        .arg(log)
        .arg("--config")
        .arg(top().join("tests/recordings/e-type.toml"))
        .args(arguments)
        .output()
        .unwrap()
}

fn log(directory: &tempfile::TempDir, text: &str) -> PathBuf {
    let path = directory.path().join("in.log");
    std::fs::write(&path, text).unwrap();
    path
}

const LOG: &str = "(1700000000.000100) can0 080#01
(1700000000.000200) can1 181#003600000001
(1700000000.000300) can0 181#003600000001
(1700000000.000400) can0 191#00
(1700000000.000500) can0 123#R
this is no frame
(1700000000.000600) can0 181##1003600000001
";

#[test]
fn only_the_frames_of_the_interface_change_and_all_keep_their_places() {
    let directory = tempfile::tempdir().unwrap();
    let log = log(&directory, LOG);
    let step = "step,cylinder=1,size=3";
    let output = inject(
        &log,
        &["--interface", "can0", "--fault", step, "--fault", "step,cylinder=1,sensor=c2,size=1"],
    );
    assert!(output.status.success());
    let text = String::from_utf8(output.stdout).unwrap();
    // 13824 counts are 0 m; three metres more are 41472, and nothing else of the frame changes.
    let expected = "(1700000000.000100) can0 080#01
(1700000000.000200) can1 181#003600000001
(1700000000.000300) can0 181#00A200000001
(1700000000.000400) can0 191#00
(1700000000.000500) can0 123#R
(1700000000.000600) can0 181##100A200000001
";
    assert_eq!(text, expected);
    let report = String::from_utf8(output.stderr).unwrap();
    assert!(report.contains("6 frames read, 6 written"), "{report}");
    assert!(report.contains("in.log:6:"), "the bad line is shown: {report}");
    assert!(report.contains("size=3\": 2 of 2 frames changed"), "{report}");
    assert!(report.contains("0 of 0 frames changed or lost, 1 without the signal"), "{report}");
}

#[test]
fn what_the_signal_cannot_hold_is_clamped_and_told() {
    let directory = tempfile::tempdir().unwrap();
    let log = log(&directory, "(1.0) can0 181#003600000001\n(2.0) can0 181#003600000002\n");
    let output = inject(&log, &["--fault", "drift,cylinder=1,at=0.5,rate=-7"]);
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.ends_with("181#000000000002\n"), "{text}");
    let report = String::from_utf8(output.stderr).unwrap();
    assert!(report.contains("1 of 1 frame changed or lost, 1 clamped"), "{report}");
}

#[test]
fn a_fault_that_meets_no_frame_says_so() {
    let directory = tempfile::tempdir().unwrap();
    let log = log(&directory, LOG);
    let output = inject(&log, &["--fault", "freeze,cylinder=6", "--fault", "stale,cylinder=1"]);
    assert!(output.status.success());
    let report = String::from_utf8(output.stderr).unwrap();
    assert!(report.contains("nothing: none of its frames came during the fault"), "{report}");
}

#[test]
fn a_recording_on_which_no_fault_has_an_effect_is_not_written_as_a_faulty_one() {
    let directory = tempfile::tempdir().unwrap();
    let out = directory.path().join("out.log");
    let out = out.to_str().unwrap();
    let foreign = LOG.replace("181#", "7A1#").replace("191#", "7A2#");
    let foreign = foreign.replace("181##", "7A1##");
    for (text, fault, words) in [
        (LOG, "freeze,cylinder=1,at=100", "in.log (6 frames in 0.00 s)"),
        (&foreign, "freeze,cylinder=1", "is it a recording of this machine"),
        ("", "freeze,cylinder=1", "in.log: it is empty"),
        ("Dear diary\n", "freeze,cylinder=1", "in.log: no frame in 1 line; it is text"),
        ("(1.0) can0 191#\n", "step,cylinder=1,sensor=c2,size=1", "1 without the signal"),
    ] {
        let log = log(&directory, text);
        let call = ["--fault", fault, "--fault", "stale,cylinder=1,at=200"];
        let output = inject(&log, &[&call[..], &["--output", out]].concat());
        let report = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(1), "{report}");
        for word in
            [words, "no fault had an effect on", "nothing was written", fault, "at=200\": nothing"]
        {
            assert!(report.contains(word), "{word:?} is not in {report}");
        }
        assert_eq!(
            std::fs::read_dir(directory.path()).unwrap().count(),
            1,
            "something was written"
        );
        // A pipe has what was read, and the exit code says that it is not what was asked for.
        let output = inject(&log, &call);
        assert_eq!(output.status.code(), Some(1));
        let report = String::from_utf8(output.stderr).unwrap();
        assert!(report.contains("standard output is the recording as it was"), "{report}");
    }
}

#[test]
fn a_wrong_call_ends_with_2_and_says_what_was_expected() {
    let directory = tempfile::tempdir().unwrap();
    let log = log(&directory, LOG);
    let table = directory.path().join("faults.csv");
    std::fs::write(&table, "cylinder,sensor,kind,t0,magnitude,parameter,t1\n1,C1,step,x,1,,\n")
        .unwrap();
    let table = table.to_str().unwrap();
    let unknown = directory.path().join("unknown.csv");
    std::fs::write(&unknown, "cylinder,sensor,kind,t0,magnitude,parameter,t1\n1,,stikking,1,1,,\n")
        .unwrap();
    let unknown = unknown.to_str().unwrap();
    let itself = log.to_str().unwrap();
    for (arguments, expected) in [
        (&[] as &[&str], "no fault to inject"),
        (&["--fault", "stepp,cylinder=1"], "nearest: step"),
        (&["--fault", "step,cylinder=1,siz=1"], "nearest: size"),
        (&["--fault", "step,cylinder=7,size=1"], "cylinders 1 to 6"),
        (&["--fault", "out_of_range,cylinder=1,raw=5"], "valid range raw 1 to 27648"),
        (&["--faults", table], "line 2: column t0: at is \"x\", expected seconds"),
        (&["--fault", "stale,cylinder=1", "--output", itself], "name another file"),
        // Only simulated machines have faults of their own, which are not offered here.
        (&["--fault", "stp,cylinder=1"], "there are step, noise, incipient, drift, scale, freeze"),
        (&["--fault", "stp,cylinder=1"], "broken_wire, stale, loss\n"),
        (&["--fault", "leakag,cylinder=1"], "no fault is called \"leakag\"; there are step"),
        (&["--faults", unknown], "line 2: no fault is called \"stikking\"; there are step"),
    ] {
        let output = inject(&log, arguments);
        let report = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {report}");
        assert!(report.contains(expected), "{arguments:?}: {report}");
    }
    assert_eq!(std::fs::read_to_string(&log).unwrap(), LOG, "the recording was harmed");
}

#[test]
fn a_wrong_call_for_two_interfaces_ends_with_2_and_says_what_was_expected() {
    let fault = "stale,cylinder=1";
    for (arguments, expected) in [
        (&["--from", "can7", "--to", "can7"] as &[&str], "--from and --to are both can7"),
        (&["--from", "can7"], "--to <NAME>"),
        (&["--to", "can7"], "--from <NAME>"),
        (&["--to", "can7", "in.log"], "cannot be used with '[LOG]...'"),
        (&["--from", "can7", "--to", "can8", "in.log"], "cannot be used with '[LOG]...'"),
        (&["--from", "can7", "--to", "can8", "--output", "x.log"], "cannot be used with"),
        (&["--from", "can7", "--to", "can8", "--for=-1"], "expected seconds, such as 60"),
        (&["--from", "can7", "--to", "can8", "--for", "0"], "expected seconds, such as 60"),
        (&["--for", "1", "in.log"], "cannot be used with '[LOG]...'"),
    ] {
        let output = Command::new(env!("CARGO_BIN_EXE_tertius"))
            .arg("inject")
            .arg("--config")
            .arg(top().join("tests/recordings/e-type.toml"))
            .args(["--fault", fault])
            .args(arguments)
            .output()
            .unwrap();
        let report = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {report}");
        assert!(report.contains(expected), "{arguments:?}: {report}");
    }
}

#[test]
fn the_help_says_what_two_interfaces_are_for() {
    let output =
        Command::new(env!("CARGO_BIN_EXE_tertius")).args(["inject", "--help"]).output().unwrap();
    let help = String::from_utf8(output.stdout).unwrap();
    let help = help.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(help.contains("It is for test benches. Never put it between a machine and"), "{help}");
}
