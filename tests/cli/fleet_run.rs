//! `fleet run`: the recordings of many machines, some machines at a time.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use tertius_testing::support::{E_TYPE, Run, Scratch, between, recorded, replay, tertius, top};

/// Three machines of which each has two recordings; there is a step in the second one of all but the first machine.
fn fleet(scratch: &Scratch) -> String {
    let log = recorded("e-type-faults.log.zst");
    let config = top().join(E_TYPE).display().to_string();
    let mut fleet = String::new();
    for (name, begin, end) in [("A1", 48.0, 59.0), ("B 2", 52.0, 64.0), ("C3", 54.0, 66.0)] {
        fs::create_dir(scratch.path(name)).expect("ours");
        scratch.write(&format!("{name}/1.log"), between(&log, begin, 58.0));
        scratch.write(&format!("{name}/2.log"), between(&log, 58.0, end));
        fleet += &format!(
            "[[machine]]\nname = {name:?}\nconfig = {config:?}\nrecordings = [{name:?}]\n\n"
        );
    }
    scratch.write("fleet.toml", fleet)
}

fn run(fleet: &str, output: &str, options: &[&str]) -> Run {
    tertius(&[&["fleet", "run", fleet, "--output", output], options].concat(), b"")
}

/// What a run left, by its path; of a mark, which says how long it took, only what it is of.
fn left(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut files = BTreeMap::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(next) = folders.pop() {
        for entry in fs::read_dir(next).expect("it is there") {
            let path = entry.expect("it is there").path();
            if path.is_dir() {
                folders.push(path);
                continue;
            }
            let mut bytes = fs::read(&path).expect("it is there");
            if path.extension().is_some_and(|it| it == "done") {
                let text = String::from_utf8(bytes).expect("UTF-8");
                bytes = text.split("\"seconds\"").next().expect("JSON").into();
            }
            let name = path.strip_prefix(folder).expect("it is below");
            files.insert(name.display().to_string(), bytes);
        }
    }
    files
}

#[test]
fn machines_beside_each_other_leave_what_they_leave_one_after_the_other() {
    let scratch = Scratch::new();
    let fleet = fleet(&scratch);
    let (one, three) = (scratch.path("one"), scratch.path("three"));
    let first = run(&fleet, &one, &["--jobs", "1"]).ok();
    let second = run(&fleet, &three, &["--jobs", "3"]).ok();
    assert_eq!(second.stdout.replace(&three, &one), first.stdout);
    let lines: Vec<&str> = first.stdout.lines().collect();
    let expected = [
        "A1: 2 of 2 done, 0 incidents in 0.00 h",
        "B 2: 2 of 2 done, 1 incident in 0.00 h",
        "C3: 2 of 2 done, 1 incident in 0.00 h",
    ];
    assert_eq!(lines[..3], expected);
    assert!(lines[3].starts_with("6 of 6 recordings done: 0.01 machine-hours."), "{lines:?}");

    let all = left(Path::new(&one));
    assert_eq!(left(Path::new(&three)), all);
    let names: Vec<&str> =
        all.keys().filter(|name| name.starts_with("folded/B 2/")).map(String::as_str).collect();
    let expected = ["000001.done", "000001.jsonl", "000002.done", "000002.jsonl", "000002.state"];
    assert_eq!(names, expected.map(|name| format!("folded/B 2/{name}")));

    // The second recording goes on from the state that the first one has left.
    let state = scratch.path("state");
    for index in 1..=2 {
        let log = scratch.path(&format!("B 2/{index}.log"));
        let lines = replay(&[&log], E_TYPE, &["--state", &state]).ok().stdout;
        let name = format!("folded/B 2/00000{index}.jsonl");
        assert!(all[&name] == lines.into_bytes(), "{name}");
    }
    assert!(all["folded/B 2/000002.state"] == fs::read(state).expect("it was left"));
}

#[test]
fn what_fails_stops_its_machine_alone_and_is_gone_on_with() {
    let scratch = Scratch::new();
    let fleet = fleet(&scratch);
    let output = scratch.path("results");
    // Overlaps are found by the replay if only first frames are planned by.
    let log = recorded("e-type-faults.log.zst");
    let later = scratch.write("B 2/2.log", between(&log, 55.0, 62.0));
    let options = ["--quick", "--jobs", "2"];
    let failed = run(&fleet, &output, &options);
    let failed = failed.failed(1, &["machine \"B 2\" stands still", "2.log", "exit code 2"]);
    for line in ["A1: 2 of 2 done", "B 2: 1 of 2 done", "C3: 2 of 2 done"] {
        assert!(failed.stdout.contains(line), "{line}: {}", failed.stdout);
    }
    let before = left(Path::new(&output));
    assert!(!before.contains_key("folded/B 2/000002.jsonl"));
    assert!(before.contains_key("folded/B 2/000001.state"), "the next one goes on from it");

    // What is done is not done again, and what failed is.
    let inode = |name: &str| {
        use std::os::unix::fs::MetadataExt;
        fs::metadata(Path::new(&output).join("folded").join(name)).expect("it is there").ino()
    };
    let done = ["A1/000002.jsonl", "B 2/000001.jsonl"];
    let inodes = done.map(inode);
    scratch.write("B 2/2.log", between(&log, 58.0, 62.0));
    let fixed = run(&fleet, &output, &options).ok();
    assert!(fixed.stdout.contains("B 2: 2 of 2 done"), "{}", fixed.stdout);
    assert_eq!(done.map(inode), inodes);
    let after = left(Path::new(&output));
    assert!(!after.contains_key("folded/B 2/000001.state"), "nobody goes on from it any more");

    // A recording that has changed since is another one.
    scratch.write("B 2/2.log", between(&log, 58.0, 63.0));
    let changed = run(&fleet, &output, &options);
    changed.failed(1, &["machine \"B 2\"", "000002.done", "begin the machine anew", &later]);
    assert_eq!(left(Path::new(&output)), after);
}

#[test]
fn nothing_judged_is_no_success_and_wrong_calls_are_refused_before_anything_is_done() {
    let scratch = Scratch::new();
    let fleet = fleet(&scratch);
    let output = scratch.path("results");
    run(&fleet, &output, &["--jobs", "0"]).failed(2, &["--jobs", "1 to 1024"]);
    run(&fleet, &output, &["--format", "shell"]).failed(2, &["--format", "tertius fleet plan"]);
    run(&fleet, &scratch.path("B 2"), &[]).failed(2, &["1.log is below", "another folder"]);
    tertius(&["fleet", "run", &fleet], b"").failed(2, &["--output"]);
    tertius(&["fleet", "plan", &fleet, "--jobs", "2"], b"").failed(2, &["--jobs", "fleet run"]);
    let config = top().join(E_TYPE).display().to_string();
    let entry = |recording: &str| {
        let recordings = format!("recordings = [{recording:?}]");
        format!("[[machine]]\nname = \"A\"\nconfig = {config:?}\n{recordings}\n")
    };
    let remote = scratch.write("remote.toml", entry("https://example.org/1.log"));
    run(&remote, &output, &[]).failed(2, &["https://example.org/1.log", "tertius-fleet run"]);
    assert!(!Path::new(&output).join("folded").exists());

    // Its first frame opens a cycle, and no reading follows.
    let short = recorded("e-type-faults.log.zst").split_inclusive('\n').take(1).collect::<String>();
    let short = scratch.write("short.toml", entry(&scratch.write("short.log", short)));
    let blank = run(&short, &output, &[]);
    let blank = blank.failed(1, &["machine \"A\": nothing was judged in any of its recordings"]);
    assert!(blank.stdout.contains("A: 1 of 1 done"), "{}", blank.stdout);
    assert!(blank.stdout.contains("nothing was judged in 1"), "{}", blank.stdout);
}
