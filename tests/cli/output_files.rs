//! What the commands write: never over what they read, never over what is somebody's, and whole or
//! not at all.

use std::fs::{self, File};
use std::io::{Read, Write};
use std::os::unix::fs::{PermissionsExt, symlink};
use std::path::Path;
use std::process::Command;
use tertius_testing::support::{
    self, E_TYPE, Run, Scratch, between, command, recorded, replay, tertius,
};

const FAULT: &str = "step,cylinder=1,size=0.01";

/// The files of all commands in one folder.
struct Desk {
    scratch: Scratch,
    log: String,
    config: String,
    faults: String,
    plant: String,
    history: String,
}

impl Desk {
    fn new() -> Self {
        let scratch = Scratch::new();
        let log =
            scratch.write("in.log", between(&recorded("e-type-healthy.log.zst"), 160.0, 162.0));
        let config = scratch.config(&[]);
        let table = "cylinder,sensor,kind,t0,magnitude,parameter,t1\n1,C1,step,0,0.01,,\n";
        let faults = scratch.write("faults.csv", table);
        let plant = fs::read(support::top().join("config/e-type-plant.toml")).expect("it is there");
        let plant = scratch.write("plant.toml", plant);
        let history = scratch.write("e-type.dwells", "a history");
        Self { scratch, log, config, faults, plant, history }
    }

    fn with_history(mut self) -> Self {
        let keys = "[sequential]\nhistory = \"e-type.dwells\"\n\n[plausibility]";
        self.config = self.scratch.config(&[("[plausibility]", keys)]);
        self
    }

    /// Each command with its inputs, and the options that name its outputs.
    fn calls(&self) -> Vec<(Vec<&str>, Vec<&'static str>)> {
        let Self { log, config, faults, plant, .. } = self;
        let of = |command: &'static str, inputs: &[&'static str]| -> Vec<&str> {
            let mut call = vec![command];
            for input in inputs {
                match *input {
                    "log" => call.push(log),
                    "faults" => call.extend(["--faults", faults]),
                    "plant" => call.extend(["--plant", plant]),
                    other => call.push(other),
                }
            }
            call.extend(["--config", config]);
            call
        };
        let tables = ["--output", "--report"];
        let replay = ["--residuals", "--estimates", "--warnings", "--report"];
        vec![
            (of("replay", &["log"]), replay.to_vec()),
            (of("inject", &["log", "faults"]), vec!["--output"]),
            (of("simulate", &["plant", "faults"]), vec!["--output", "--truth"]),
            (of("evaluate", &["plant", "--quick"]), tables.to_vec()),
            (of("identify", &["log"]), tables.to_vec()),
            (of("calibrate", &["log"]), tables.to_vec()),
            (of("tune", &["log"]), tables.to_vec()),
        ]
    }

    fn left(&self) -> Vec<String> {
        let folder = Path::new(&self.log).parent().expect("a folder");
        let entries = fs::read_dir(folder).expect("it can be read");
        let names = entries.map(|entry| entry.expect("an entry").file_name());
        let mut names: Vec<_> = names.map(|name| name.to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }
}

#[test]
fn no_output_of_any_command_is_written_over_an_input() {
    let desk = Desk::new().with_history();
    let scratch = &desk.scratch;
    let dbc = scratch.path("e-type.dbc");
    let known = [&desk.log, &desk.config, &dbc, &desk.faults, &desk.plant, &desk.history];
    let before: Vec<_> = known.iter().map(|file| fs::read(file).expect("it is there")).collect();
    let (linked, hard) = (scratch.path("link"), scratch.path("hard"));
    for (call, options) in desk.calls() {
        for option in options {
            let reads = |file: &str| call.contains(&file) || file == dbc || file == desk.history;
            for input in known.into_iter().filter(|file| reads(file)) {
                symlink(input, &linked).expect("a link");
                fs::hard_link(input, &hard).expect("another name");
                for name in [input, &linked, &hard] {
                    let forced = [&call[..], &[option, name, "--force"]].concat();
                    tertius(&forced, b"").failed(2, &[name, "over the input", "another file"]);
                }
                fs::remove_file(&linked).expect("it is there");
                fs::remove_file(&hard).expect("it is there");
            }
        }
    }
    for (file, before) in known.iter().zip(before) {
        assert!(fs::read(file).expect("it is there") == before, "{file} was changed");
    }
    assert_eq!(desk.left().len(), known.len(), "{:?}", desk.left());
}

#[test]
fn two_outputs_are_not_written_into_one_file() {
    let desk = Desk::new();
    let (one, other) = (desk.scratch.write("one", ""), desk.scratch.path("other"));
    fs::hard_link(&one, &other).expect("another name");
    let future = desk.scratch.path("future");
    let beside = desk.scratch.path("./future");
    for [a, b] in [[&one, &other], [&future, &beside]] {
        for (command, options) in [
            ("replay", ["--residuals", "--estimates"]),
            ("simulate", ["--output", "--truth"]),
            ("calibrate", ["--output", "--report"]),
        ] {
            let mut call = vec![command, "--config", &desk.config];
            call.extend((command != "simulate").then_some(desk.log.as_str()));
            call.extend([options[0], a, options[1], b, "--force"]);
            tertius(&call, b"").failed(2, &["is to hold two outputs"]);
        }
    }
    assert!(!fs::exists(&future).expect("it can be asked"));
}

fn inject(desk: &Desk, output: &str, more: &[&str]) -> Run {
    let call = ["inject", &desk.log, "--config", &desk.config, "--fault", FAULT];
    tertius(&[&call[..], &["--output", output], more].concat(), b"")
}

#[test]
fn what_exists_is_written_over_only_when_asked() {
    let desk = Desk::new();
    let before = desk.left().len();
    let mine = desk.scratch.write("mine", "my notes\n");
    for (call, options) in desk.calls() {
        for option in options {
            tertius(&[&call[..], &[option, &mine]].concat(), b"").failed(2, &[&mine, "--force"]);
            assert_eq!(desk.scratch.read("mine"), "my notes\n", "{} {option}", call[0]);
        }
    }
    // A recording shows nobody who wrote it.
    inject(&desk, &mine, &["--force"]).ok();
    let faulty = desk.scratch.read("mine");
    assert!(faulty.starts_with('(') && faulty.lines().count() > 1000);
    inject(&desk, &mine, &[]).failed(2, &[&mine, "a recording does not show", "--force"]);
    // Of an empty file nothing is lost.
    let empty = desk.scratch.write("empty", "");
    inject(&desk, &empty, &[]).ok();
    assert_eq!(desk.scratch.read("empty"), faulty);
    assert_eq!(desk.left().len(), before + 2, "{:?}", desk.left());
}

#[test]
fn a_command_writes_over_what_it_wrote_itself() {
    let desk = Desk::new();
    let [table, page] = ["table.csv", "page.html"].map(|name| desk.scratch.path(name));
    let call = ["replay", &desk.log, "--config", &desk.config, "--report", &page];
    for option in ["--residuals", "--residuals"] {
        tertius(&[&call[..], &[option, &table]].concat(), b"").ok();
    }
    tertius(&[&call[..], &["--estimates", &table]].concat(), b"").failed(2, &[&table, "--force"]);
    let rig = support::recording("hanging-load.log.gz");
    let [tables, report] = ["tables.toml", "report.html"].map(|name| desk.scratch.path(name));
    let learn = |command: &str| {
        let call = [command, &rig, "--config", support::HANGING_LOAD, "--to", "50%"];
        tertius(&[&call[..], &["--output", &tables, "--report", &report]].concat(), b"")
    };
    learn("calibrate").ok();
    learn("calibrate").ok();
    learn("identify").failed(2, &[&tables, "this command did not write it"]);
    // The truth of the same call is the same table; another's is somebody's.
    let truth = desk.scratch.path("truth.csv");
    let simulate = |at: &str| {
        let fault = format!("step,cylinder=1,at={at},size=0.01");
        let call = ["simulate", "--config", &desk.config, "--duration", "1", "--fault", &fault];
        tertius(&[&call[..], &["--output", "/dev/null", "--truth", &truth]].concat(), b"")
    };
    simulate("0.5").ok();
    simulate("0.5").ok();
    simulate("0.6").failed(2, &[&truth, "holds something else"]);
}

#[test]
fn a_run_that_fails_leaves_what_was_there() {
    let desk = Desk::new();
    let kept = desk.scratch.write("kept.csv", "t,cylinder\n");
    let before = desk.left();
    let call = ["replay", &desk.log, "--config", &desk.config, "--format", "jsonl"];
    let full = File::create("/dev/full").expect("every Linux has it");
    let output = command(&[&call[..], &["--residuals", &kept, "--force"]].concat())
        .stdout(full)
        .output()
        .expect("it starts");
    assert_eq!(output.status.code(), Some(1));
    assert_eq!(desk.scratch.read("kept.csv"), "t,cylinder\n");
    assert_eq!(desk.left(), before);
}

#[test]
fn links_and_permissions_stay() {
    let desk = Desk::new();
    let real = desk.scratch.write("real.log", "");
    fs::set_permissions(&real, fs::Permissions::from_mode(0o640)).expect("it is ours");
    let link = desk.scratch.path("link.log");
    symlink("real.log", &link).expect("a link");
    inject(&desk, &link, &[]).ok();
    assert!(fs::symlink_metadata(&link).expect("it is there").is_symlink());
    let mode = |path: &str| fs::metadata(path).expect("it is there").permissions().mode() & 0o777;
    assert_eq!(mode(&real), 0o640);
    assert!(desk.scratch.read("real.log").starts_with('('));
    // A link that leads to nothing yet.
    let ahead = desk.scratch.path("ahead.log");
    symlink("later.log", &ahead).expect("a link");
    inject(&desk, &ahead, &[]).ok();
    assert_eq!(desk.scratch.read("later.log"), desk.scratch.read("real.log"));
    assert!(fs::symlink_metadata(&ahead).expect("it is there").is_symlink());
    // A new file has what the umask leaves, as any other.
    let usual = mode(&desk.scratch.write("usual", ""));
    assert_eq!(mode(&desk.scratch.path("later.log")), usual);
}

#[test]
fn pipes_and_devices_are_written_to_and_stay() {
    let desk = Desk::new();
    let expected = inject(&desk, "-", &[]).ok().stdout;
    assert!(expected.starts_with('('));
    assert_eq!(inject(&desk, "/dev/stdout", &[]).ok().stdout, expected);
    inject(&desk, "/dev/null", &[]).ok();
    inject(&desk, "/dev/full", &[]).failed(1, &["/dev/full", "No space left"]);
    let pipe = desk.scratch.path("pipe");
    assert!(Command::new("mkfifo").arg(&pipe).status().expect("it starts").success());
    let read = std::thread::scope(|scope| {
        let reader = scope.spawn(|| {
            let mut text = String::new();
            File::open(&pipe).and_then(|mut it| it.read_to_string(&mut text)).expect("a text");
            text
        });
        inject(&desk, &pipe, &[]).ok();
        reader.join().expect("it read")
    });
    assert_eq!(read, expected);
    // What a shell has redirected is written on from where it stands.
    let redirected = desk.scratch.write("redirected", "before\n");
    let mut file = fs::OpenOptions::new().append(true).open(&redirected).expect("it is ours");
    file.write_all(b"so far\n").expect("it is ours");
    let call = ["inject", &desk.log, "--config", &desk.config, "--fault", FAULT];
    let output = command(&[&call[..], &["--output", "/dev/stdout"]].concat())
        .stdout(file)
        .output()
        .expect("it starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(desk.scratch.read("redirected"), format!("before\nso far\n{expected}"));
}

/// A shell that appends to what is read would have it grow while it is read, without an end.
#[test]
fn standard_output_is_no_input_either() {
    let desk = Desk::new();
    let before = fs::read(&desk.log).expect("it is there");
    for call in [
        &["replay", &desk.log, "--config", &desk.config][..],
        &["inject", &desk.log, "--config", &desk.config, "--fault", FAULT],
    ] {
        let file = fs::OpenOptions::new().append(true).open(&desk.log).expect("it is ours");
        let output = command(call).stdout(file).output().expect("it starts");
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(said.contains("standard output would be written over the input"), "{said}");
        assert_eq!(fs::read(&desk.log).expect("it is there"), before);
    }
}

#[cfg(not(feature = "parquet"))]
#[test]
fn a_program_without_tables_says_how_to_build_one_with_them() {
    let desk = Desk::new();
    let before = desk.left();
    let call =
        ["replay", &desk.log, "--config", &desk.config, "--parquet", &desk.scratch.path("columns")];
    tertius(&call, b"").failed(2, &["--parquet", "built without it", "--features parquet"]);
    assert_eq!(desk.left(), before);
}

/// The temporary file beside an output is no name that anybody has given.
#[test]
fn an_output_that_cannot_be_created_is_named_as_it_was_given() {
    let scratch = Scratch::new();
    let log = scratch.write("short.log", between(&recorded("e-type-faults.log.zst"), 88.0, 89.0));
    // Nobody, not even the superuser, may create a file there.
    for option in ["--report", "--residuals", "--warnings", "--state"] {
        let run = replay(&[&log], E_TYPE, &[option, "/proc/sys/out.x"]);
        let run = run.failed(2, &["tertius: /proc/sys/out.x cannot be created: "]);
        assert!(!run.stderr.contains(".part"), "{}", run.stderr);
    }
}
