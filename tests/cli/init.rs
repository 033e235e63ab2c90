//! `tertius init`: what is proposed is what the machine's own configuration says, and nothing where there is no
//! machine.

use std::fs;
use tertius::config::{self, Settings};
use tertius_testing::support::{Run, Scratch, recording, tertius, top};

const DBC: &str = "dbc/e-type.dbc";
const SIMULATED: &str = "config/e-type-simulated.toml";

fn settings(text: &str) -> Settings {
    config::parse("proposed.toml", text).unwrap_or_else(|error| panic!("{error}\n{text}")).0
}

fn kept(path: &str) -> Settings {
    config::load(&top().join(path)).expect("it is sound").settings
}

/// The names of every signal of every cylinder, with its key.
fn names(settings: &Settings) -> Vec<(String, String)> {
    let signals = &settings.signals.cylinder;
    let of = |n| signals.named().map(move |(key, name)| (key, n, name));
    let name = |(key, n, name): (&str, u8, &str)| {
        (format!("{key} of {n}"), config::settings::CylinderSignals::of_cylinder(name, n))
    };
    (1..=settings.machine.cylinders).flat_map(of).map(name).collect()
}

/// Every signal is that of the machine's own configuration.
#[track_caller]
fn assert_same(found: &Settings, expected: &Settings) {
    assert_eq!(names(found), names(expected));
    assert_eq!(found.signals.sync, expected.signals.sync);
    assert_eq!(found.signals.state, expected.signals.state);
    assert_eq!(found.signals.supply, expected.signals.supply);
    let (found, expected) = (&found.machine, &expected.machine);
    assert_eq!(found.monitored_states, expected.monitored_states);
    assert_eq!(found.sample_time, expected.sample_time);
    assert_eq!(found.stroke, expected.stroke);
}

fn simulated(scratch: &Scratch, name: &str, options: &[&str]) -> String {
    let log = scratch.path(name);
    let mut call = vec!["simulate", "--config", SIMULATED, "--output", &log, "--force"];
    call.extend(options);
    tertius(&call, b"").ok();
    log
}

fn init(arguments: &[&str]) -> Run {
    let mut call = vec!["init"];
    call.extend(arguments);
    tertius(&call, b"")
}

#[test]
fn a_simulated_machine_is_proposed_as_it_is_configured() {
    let scratch = Scratch::new();
    for (name, options) in [
        ("short.log", &["--duration", "30", "--seed", "1"][..]),
        ("all.log", &["--duration", "120", "--seed", "2", "--start", "settled"]),
        ("lost.log", &["--duration", "60", "--fault", "loss,cylinder=2,sensor=c1,at=20,until=24"]),
        (
            "fault.log",
            &["--duration", "60", "--fault", "step,cylinder=5,sensor=c2,at=30,size=0.02"],
        ),
    ] {
        let log = simulated(&scratch, name, options);
        assert_same(&settings(&init(&[DBC, &log]).ok().stdout), &kept(SIMULATED));
    }
}

#[test]
fn recordings_of_machines_are_proposed_as_they_are_configured() {
    let log = recording("e-type-faults.log.zst");
    assert_same(&settings(&init(&[DBC, &log]).ok().stdout), &kept("config/e-type.toml"));

    let (dbc, log) = (recording("hanging-load.dbc"), recording("hanging-load.log.gz"));
    let run = init(&[&dbc, &log]).ok();
    let found = settings(&run.stdout);
    let expected = kept("tests/recordings/hanging-load.toml");
    assert_eq!(names(&found), names(&expected));
    assert_eq!(found.machine.stroke, expected.machine.stroke);
    assert!(
        run.stdout.contains("guessed: the two agree to 0.0592 mm over 2.74 m"),
        "{}",
        run.stdout
    );
    assert!(run.stdout.contains("guessed: leads the rod's speed by 127 ms"), "{}", run.stdout);
}

/// The names of the DBC replaced by ones that say nothing, and the table of the state left out.
fn anonymous() -> String {
    let text = fs::read_to_string(top().join(DBC)).expect("it is there");
    let (mut lines, mut count, mut own) = (String::new(), 0, false);
    for line in text.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        match words.first().copied() {
            Some("BO_") => own = line.contains(" Fd_"),
            Some("CM_" | "VAL_" | "BA_") if line.contains(';') => continue,
            _ => {}
        }
        count += 1;
        let renamed = match words.as_slice() {
            ["BO_", _, name, ..] if !own => {
                line.replacen(&format!(" {name}"), &format!(" M{count}:"), 1)
            }
            ["SG_", name, ..] if !own => {
                line.replacen(&format!("SG_ {name} "), &format!("SG_ S{count} "), 1)
            }
            _ => line.to_owned(),
        };
        lines += &(renamed + "\n");
    }
    lines
}

#[test]
fn evidence_alone_finds_what_names_do_not_tell() {
    let scratch = Scratch::new();
    let dbc = scratch.write("anonymous.dbc", anonymous());
    let log = simulated(&scratch, "machine.log", &["--duration", "60", "--seed", "7"]);
    let found = settings(&init(&[&dbc, &log]).ok().stdout);
    // The same places in the frames: each name's line is that of the true name.
    let place = |dbc: &str, name: &str| {
        let text =
            if dbc == DBC { fs::read_to_string(top().join(dbc)) } else { fs::read_to_string(dbc) };
        let database =
            tertius::dbc::Database::parse(&text.expect("it is there")).expect("it is sound");
        let (message, signal) = database.signal(name).expect("it is in it");
        (message.id, signal.plan.clone())
    };
    let expected = names(&kept(SIMULATED));
    let found = names(&found);
    for (key, name) in &expected {
        // Nothing shows what a bit that is always 0 means.
        if key.contains("_status") {
            continue;
        }
        let (_, other) = found.iter().find(|(other, _)| other == key).expect("it was found");
        assert_eq!(place(&dbc, other), place(DBC, name), "{key}");
    }
    init(&[&dbc]).failed(1, &["no pair of transducers found"]);
}

#[test]
fn a_machine_at_rest_is_a_guess_and_says_so() {
    let scratch = Scratch::new();
    let log = simulated(&scratch, "rest.log", &["--duration", "30", "--sea", "0.02,7"]);
    let run = init(&[DBC, &log]).ok();
    assert!(
        run.stderr.contains("a recording of the machine in motion is needed"),
        "{}",
        run.stderr
    );
    assert!(!run.stdout.contains("the two agree"), "{}", run.stdout);
    assert_eq!(names(&settings(&run.stdout)), names(&kept(SIMULATED)));
}

const CAR: &str = "VERSION \"\"\nBU_: Car\n\
BO_ 170 WHEELS: 8 Car\n\
\x20SG_ SPEED_FL : 0|16@1+ (0.01,0) [0|250] \"km/h\" Car\n\
\x20SG_ SPEED_FR : 16|16@1+ (0.01,0) [0|250] \"km/h\" Car\n\
\x20SG_ ANGLE : 32|16@1- (0.1,0) [-800|800] \"deg\" Car\n\
\x20SG_ ANGLE_2 : 48|16@1- (0.1,0) [-800|800] \"deg\" Car\n\
BO_ 180 ENGINE: 6 Car\n\
\x20SG_ TORQUE : 0|16@1- (0.1,0) [-500|500] \"Nm\" Car\n\
\x20SG_ LANE_POSITION : 16|16@1- (0.001,0) [-5|5] \"m\" Car\n\
\x20SG_ MODE : 32|8@1+ (1,0) [0|255] \"\" Car\n";

/// A car of which two steering angles and two wheels agree, and whose speed follows the torque.
fn drive() -> String {
    let (mut log, mut speed) = (String::new(), 60.0_f64);
    for k in 0..6000 {
        let t = f64::from(k) * 0.01;
        let torque = 120.0 * (0.31 * t).sin();
        let angle = 90.0 * (0.7 * t).sin() + 40.0 * (0.23 * t).cos();
        speed += 0.0008 * torque;
        let counts = [speed * 100.0, speed * 100.0 + 3.0, angle * 10.0, angle * 10.0 + 2.0];
        let hex = |values: &[f64]| -> String {
            let count = |value: &f64| u16::from_le_bytes((*value as i32 as u16).to_be_bytes());
            values.iter().map(|value| format!("{:04X}", count(value))).collect()
        };
        let engine = [torque * 10.0, 300.0 * (0.11 * t).sin(), 0.0];
        log += &format!(
            "({t:.6}) can0 0AA#{}\n({:.6}) can0 0B4#{}\n",
            hex(&counts),
            t + 0.001,
            hex(&engine)
        );
    }
    log
}

#[test]
fn nothing_is_invented_where_there_is_no_machine() {
    let scratch = Scratch::new();
    let (dbc, log) = (scratch.write("car.dbc", CAR), scratch.write("car.log", drive()));
    let output = scratch.path("car.toml");
    let run = init(&[&dbc, &log, "--yes", "--output", &output]);
    let run = run.failed(1, &["no pair of transducers found"]);
    assert_eq!(run.stdout, "");
    init(&[&dbc]).failed(1, &["no pair of transducers found"]);
    assert!(!fs::exists(&output).expect("it can be looked for"));
    // The recording of another bus has nothing of the DBC.
    init(&[&recording("hanging-load.dbc"), &log]).failed(1, &["is it the DBC of this bus?"]);
}

#[test]
fn minutes_are_whole() {
    for wrong in ["0.1", "0", "1441", "ten"] {
        let words = [&*format!("'{wrong}'"), "expected whole minutes, 1 to 1440"];
        init(&["machine.dbc", "--minutes", wrong]).failed(2, &words);
    }
    init(&["machine.dbc", "--minutes", "1440"]).failed(2, &["machine.dbc"]);
}

#[test]
fn a_recording_without_a_frame_is_named_with_what_it_seems_to_be() {
    let scratch = Scratch::new();
    let dbc = scratch.write("car.dbc", CAR);
    for (name, content, seems) in [
        ("empty.log", "", "empty.log: it is empty"),
        ("notes.log", "Dear diary\n", "notes.log: no frame in 1 line; it is text"),
        ("remote.log", "(1.0) can0 123#R\n", "its only frame is not a data frame"),
    ] {
        let log = scratch.write(name, content);
        let run = init(&[&dbc, &log]).failed(1, &["nothing was read", seems]);
        assert!(!run.stderr.contains("in the DBC"), "{}", run.stderr);
    }
    let log = scratch.write("car.log", drive());
    let words = ["nothing was read", "no frame is from", "can7"];
    init(&[&dbc, &log, "--interface", "can7"]).failed(1, &words);
}

#[test]
fn a_file_is_written_once_and_leads_to_a_sound_configuration() {
    let scratch = Scratch::new();
    let log = simulated(&scratch, "machine.log", &["--duration", "60", "--seed", "4"]);
    let output = scratch.path("machine.toml");
    // Nobody can be asked here.
    init(&[DBC, &log, "--output", &output]).failed(2, &["no terminal", "--yes"]);
    assert!(!fs::exists(&output).expect("it can be looked for"));

    let call =
        [DBC, &log, "--yes", "--output", &output, "--name", "Rig \"7\"", "--interface", "can0"];
    init(&call).ok();
    let text = fs::read_to_string(&output).expect("it was written");
    assert_eq!(settings(&text).machine.name, "Rig \"7\"");
    init(&call).failed(2, &["it exists", "--force"]);

    let text = tertius(&["check", &output], b"").ok().stdout;
    assert!(text.contains("machine.toml: sound"), "{text}");
    assert!(text.contains("`tertius commission` learns this machine's"), "{text}");
    tertius(&["replay", &log, "--config", &output], b"").ok();
}

/// What no recording shows is told as a guess, in the table, in the file and at the end.
#[test]
fn every_guess_is_shown_as_one() {
    let scratch = Scratch::new();
    let log = simulated(&scratch, "machine.log", &["--duration", "60", "--seed", "4"]);
    let output = scratch.path("machine.toml");
    let run = init(&[DBC, &log, "--yes", "--output", &output]).ok();
    let text = scratch.read("machine.toml");
    let told = run.stderr.lines().find(|line| line.starts_with("guessed, and to be looked at"));
    let told = told.expect("the guesses are told together");
    for (key, line) in [
        ("signals.cylinder.c1", "c1 = \"Cyl{n}_C1.Position\""),
        ("signals.cylinder.c2", "c2 = \"Cyl{n}_C2.Position\""),
        ("bus.bitrate", "bitrate = 500000"),
        ("comparator.critical", "critical = 0.05"),
        ("machine.stroke", "stroke = [-1.5, 1.5]"),
        ("signals.state", "state = \"Plc_State.PlatformState\""),
    ] {
        let row = run.stderr.lines().find(|row| row.trim_start().starts_with(key));
        assert!(row.is_some_and(|row| row.contains(" guessed ")), "{key}: {}", run.stderr);
        let (before, _) = text.split_once(line).expect("it is in the file");
        assert!(before.lines().last().is_some_and(|it| it.starts_with("# guessed: ")), "{text}");
        assert!(told.contains(key), "{told}");
    }
    let row = run.stderr.lines().find(|row| row.trim_start().starts_with("bus.interface"));
    assert!(
        row.is_some_and(|row| row.contains("can0") && row.contains(" sure ")),
        "{}",
        run.stderr
    );
    assert!(run.stderr.contains("not found: in which states the rods stand"), "{}", run.stderr);
    // Without a recording the interface is a guess, too.
    let run = init(&[DBC]).ok();
    let row = run.stderr.lines().find(|row| row.trim_start().starts_with("bus.interface"));
    assert!(row.is_some_and(|row| row.contains(" guessed ")), "{}", run.stderr);
}

/// The call that `init` names next works on the file that it has written, whatever the machine.
#[test]
fn the_next_call_works_for_every_machine() {
    let scratch = Scratch::new();
    for machine in ["e-type", "e-type-top", "a-type"] {
        let (log, output) = (scratch.path("machine.log"), scratch.path(&format!("{machine}.toml")));
        let (config, dbc) = (format!("config/{machine}.toml"), format!("dbc/{machine}.dbc"));
        let mut call =
            vec!["simulate", "--config", &config, "--duration", "60", "--output", &log, "--force"];
        if machine == "a-type" {
            call.extend(["--plant", "config/a-type-plant.toml"]);
        }
        tertius(&call, b"").ok();
        let run = init(&[&dbc, &log, "--yes", "--output", &output]).ok();
        let next = run.stderr.lines().find_map(|line| line.strip_prefix("next: tertius "));
        let next: Vec<&str> = next.expect("it names the next call").split(' ').collect();
        let checked = tertius(&next, b"").ok();
        assert!(checked.stdout.contains("`tertius commission`"), "{machine}: {}", checked.stdout);
    }
}

/// A configuration with a number as the interface would fit no recording.
#[test]
fn a_channel_that_is_chosen_by_number_is_written_by_its_name() {
    let scratch = Scratch::new();
    let log = simulated(&scratch, "machine.log", &["--duration", "60", "--seed", "4"]);
    let other = "(1700000000.000000) can9 7FF#00\n";
    let both = scratch.write("both.log", format!("{other}{}", scratch.read("machine.log")));
    let (blf, output) = (scratch.path("both.blf"), scratch.path("machine.toml"));
    tertius(&["convert", &both, &blf], b"").ok();
    init(&[DBC, &blf, "--yes", "--output", &output, "--channel", "2"]).ok();
    let by_number = fs::read_to_string(&output).expect("it was written");
    assert_eq!(settings(&by_number).bus.interface, "channel2");
    // Of the two channels it is the one that is read from then on.
    tertius(&["replay", &blf, "--config", &output], b"").ok();
    init(&[DBC, &log, "--yes", "--output", &output, "--channel", "can0", "--force"]).ok();
    assert_eq!(settings(&scratch.read("machine.toml")).bus.interface, "can0");
}
