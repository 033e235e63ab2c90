//! Machines other than the default one: the A-type, and machines of which only some cylinders are monitored.

use std::collections::BTreeSet;
use tertius::config::settings::CylinderSignals;
use tertius::config::{self, Settings};
use tertius::dbc::{Database, Message, text};
use tertius::decode::Value;
use tertius::frame::Frame;
use tertius::simulator::EPOCH;
use tertius_testing::oracle;
use tertius_testing::process::read;
use tertius_testing::support::{Run, Scratch, changed, tertius, top};

const CONFIG: &str = "config/a-type-simulated.toml";
const PLANT: &str = "config/a-type-plant.toml";
const DBC: &str = "dbc/a-type.dbc";

fn database(dbc: &str) -> Database {
    let bytes = std::fs::read(top().join(dbc)).expect("it ships");
    Database::parse(&text::from_bytes(&bytes)).expect("it is sound")
}

/// A recording of the A-type.
fn simulated(scratch: &Scratch, config: &str, more: &[&str]) -> String {
    let log = scratch.path("machine.log");
    let call = ["simulate", "--config", config, "--plant", PLANT, "--output", &log, "--force"];
    let run = tertius(&[&call[..], more].concat(), b"").ok();
    assert!(!run.stderr.contains("another machine"), "{}", run.stderr);
    log
}

/// The values of a signal, in the order of its frames.
fn values(database: &Database, frames: &[Frame], name: &str) -> Vec<f64> {
    let (message, signal) = database.signal(name).expect(name);
    let own = frames.iter().filter(|frame| frame.id == message.id);
    let value = |frame| signal.plan.decode(frame).value().expect("it is whole").physical;
    own.map(value).collect()
}

/// The configuration `text` with the first `count` cylinders only.
fn fewer(text: &str, count: usize) -> String {
    let mut parts = text.split("\n[[cylinder]]\n");
    let head = parts.next().expect("there is a beginning");
    let dbc = top().join("dbc").display().to_string();
    let head =
        changed(head, &[("cylinders = 6", &format!("cylinders = {count}")), ("../dbc", &dbc)]);
    let tables = parts.take(count).map(|part| format!("\n[[cylinder]]\n{part}"));
    head + &tables.collect::<String>()
}

fn three(scratch: &Scratch) -> String {
    let text = std::fs::read_to_string(top().join(CONFIG)).expect("it ships");
    scratch.write("three.toml", fewer(&text, 3))
}

/// What is peculiar to the machine is on its bus: states with numbers of their own, spools in volts, signals that no
/// configuration names, counters of other widths.
#[test]
fn the_a_type_is_on_its_bus_as_its_own_dbc_has_it() {
    let scratch = Scratch::new();
    let log = simulated(&scratch, CONFIG, &["--start", "safe", "--duration", "40"]);
    let (database, frames) = (database(DBC), read(log.as_ref()));
    let of = |name: &str| values(&database, &frames, name);
    let mut modes = of("Rig_State.Mode");
    modes.dedup();
    assert_eq!(modes, [1.0, 2.0, 4.0, 8.0], "safe, settled, neutral, engaged");
    let sequence = of("Tick.Sequence");
    assert_eq!(sequence.len(), 1600, "40 Hz");
    assert!(sequence.iter().zip(0..).all(|(found, count)| *found == f64::from(count)));
    assert!(of("Leg4_EncB.Alive").iter().zip(0..).all(|(it, n)| *it == f64::from(n % 16)));
    let supply = of("Rig_State.Accumulator");
    assert!(supply.iter().all(|bar| (150.0..215.0).contains(bar)), "{supply:?}");
    let reach = |name: &str| of(name).iter().fold(0.0_f64, |most, it| most.max(it.abs()));
    let spool = reach("Leg3_Servo.Spool");
    assert!((1.0..10.0).contains(&spool), "10 V are the full stroke: {spool}");
    for still in ["Imu_Angles.Roll", "Imu_Angles.Yaw", "Imu_Offsets.Heave", "Imu_Offsets.Surge"] {
        assert!(reach(still) > 1e-3, "{still} moves with the sea");
    }
    let expected: BTreeSet<&str> = (database.messages().iter().map(|it| &*it.name))
        .filter(|name| !name.starts_with("Fd_"))
        .collect();
    let name = |frame: &Frame| database.message_by_id(frame.id).map(|it| &*it.name);
    let sent: BTreeSet<&str> = frames.iter().map(|it| name(it).expect("the DBC has it")).collect();
    assert_eq!(sent, expected);
    let last = frames.last().expect("there are frames").timestamp.since(EPOCH).as_seconds();
    assert!((39.9..40.0).contains(&last), "{last}");
}

/// python-can reads it, cantools decodes all of it, and the thesis's linear model accounts for the motion.
#[test]
fn a_recording_of_the_a_type_passes_for_real_elsewhere() {
    let scratch = Scratch::new();
    let log = simulated(&scratch, CONFIG, &["--duration", "240", "--seed", "3"]);
    let judged = oracle::run("simulate.py", &[DBC, &log], "");
    let rows: Vec<Vec<f64>> = judged
        .lines()
        .map(|line| line.split(' ').map(|word| word.parse().expect("a number")).collect())
        .collect();
    assert_eq!(rows[0], [240.0 * 40.0 * 28.0, 0.0, 0.0, 0.0], "{judged}");
    for row in &rows[1..7] {
        assert!(row[1] >= 90.0 && row[2] >= 90.0, "{judged}");
    }
}

#[test]
fn the_a_type_is_proposed_as_it_is_configured() {
    let scratch = Scratch::new();
    let log = simulated(&scratch, CONFIG, &["--duration", "120", "--seed", "2", "--start", "safe"]);
    let proposed = tertius(&["init", DBC, &log], b"").ok().stdout;
    let found = config::parse("proposed.toml", &proposed).expect(&proposed).0;
    let kept = config::load(&top().join(CONFIG)).expect("it is sound").settings;
    let names = |settings: &Settings| -> Vec<(String, String)> {
        let signals = &settings.signals.cylinder;
        let of = |n| signals.named().map(move |(key, name)| (key, n, name));
        let name = |(key, n, name): (&str, u8, &str)| {
            (format!("{key} of {n}"), CylinderSignals::of_cylinder(name, n))
        };
        (1..=settings.machine.cylinders).flat_map(of).map(name).collect()
    };
    assert_eq!(names(&found), names(&kept));
    assert_eq!(found.signals.sync, kept.signals.sync);
    assert_eq!(found.signals.state, kept.signals.state);
    assert_eq!(found.signals.supply, kept.signals.supply);
    assert_eq!(found.machine.sample_time, kept.machine.sample_time);
    assert_eq!(found.machine.stroke, kept.machine.stroke);
}

/// The other three cylinders are there, and their readings are the controller's alone, whose wire does not round speeds to
/// counts: the first three move as on the whole machine, to a count.
#[test]
fn a_machine_of_which_three_cylinders_are_monitored_moves_like_the_whole_one() {
    let scratch = Scratch::new();
    let options = ["--duration", "30", "--seed", "4", "--in-loop"];
    let fault = ["--fault", "step,cylinder=2,sensor=c1,at=10,size=0.01"];
    let options = [&options[..], &fault].concat();
    let whole = read(simulated(&scratch, CONFIG, &options).as_ref());
    let some = read(simulated(&scratch, &three(&scratch), &options).as_ref());
    let database = database(DBC);
    let message = |frame: &Frame| -> &Message { database.message_by_id(frame.id).expect("known") };
    let is_other = |frame: &&Frame| {
        ["Leg4", "Leg5", "Leg6"].iter().any(|it| message(frame).name.starts_with(it))
    };
    assert_eq!(some.iter().filter(is_other).count(), 0);
    let own: Vec<&Frame> = whole.iter().filter(|frame| !is_other(frame)).collect();
    assert_eq!(own.len(), some.len());
    for (one, other) in own.into_iter().zip(&some.iter().collect::<Vec<_>>()) {
        assert_eq!((one.id, one.data().len()), (other.id, other.data().len()));
        for signal in &message(one).signals {
            let [one, other] = [one, *other].map(|frame| signal.plan.decode(frame).value());
            let counts = |value: Option<Value>| value.and_then(|it| it.raw.as_i64());
            let off = counts(one).expect("a count") - counts(other).expect("a count");
            assert!(off.abs() <= 1, "{}: {off} counts", signal.name);
        }
    }
}

/// `count` faults found as announced, and nothing else.
#[track_caller]
fn assert_shown(run: &Run, cylinders: &str) {
    assert!(
        run.stdout.contains("5 of 5 as announced, 0 warnings without a fault."),
        "{}",
        run.stdout
    );
    assert!(run.stdout.contains(cylinders), "{}", run.stdout);
    assert!(!run.stdout.contains("cylinder 7") && run.stderr.is_empty(), "{}", run.stderr);
    let longest = run.stdout.lines().map(|line| line.chars().count()).max();
    assert!(longest.is_some_and(|longest| longest <= 80), "{longest:?}");
}

#[test]
fn the_demonstration_shows_other_machines() {
    let scratch = Scratch::new();
    let run = tertius(&["demo", "--config", CONFIG, "--plant", PLANT], b"").ok();
    assert_shown(&run, "Each of six cylinders has two");
    assert!(run.stdout.contains("the platform is engaged"), "{}", run.stdout);
    let run = tertius(&["demo", "--config", &three(&scratch), "--plant", PLANT], b"").ok();
    assert_shown(&run, "Each of three cylinders has two");
    for absent in 4..=6 {
        assert!(!run.stdout.contains(&format!("cylinder {absent}")), "{}", run.stdout);
    }
    let text = std::fs::read_to_string(top().join("config/e-type-simulated.toml"));
    let one = scratch.write("one.toml", fewer(&text.expect("it ships"), 1));
    assert_shown(&tertius(&["demo", "--config", &one], b"").ok(), "Its cylinder has two");
}

#[test]
fn a_demonstration_that_cannot_be_says_why() {
    let wrong = |call: &[&str]| {
        let run = tertius(&[&["demo"], call].concat(), b"");
        assert_eq!(run.code, Some(2), "{}", run.stderr);
        run.stderr
    };
    assert!(wrong(&["--config", "config/e-type-two-buses.toml"]).contains("several buses"));
    let stderr = wrong(&["--set", "fde.high=0.002"]);
    assert!(stderr.contains("add --config FILE"), "{stderr}");
    let stderr = wrong(&["--config", "tests/recordings/hanging-load.toml"]);
    assert!(stderr.contains("\"Fd_Status\""), "{stderr}");
}

/// A configuration of one machine and the plant of another are told apart.
#[test]
fn whoever_simulates_another_machine_than_the_configured_one_is_told() {
    let scratch = Scratch::new();
    let log = scratch.path("machine.log");
    let call = ["simulate", "--config", CONFIG, "--duration", "1", "--output", &log];
    let run = tertius(&call, b"").ok();
    let told = "go from -1.5 to 1.5 m, and machine.stroke is from -1 to 1 m";
    assert!(run.stderr.contains(told), "{}", run.stderr);
}

/// Figures of a row of `evaluate` as JSON.
fn rows(call: &[&str]) -> serde_json::Value {
    let more = ["--quick", "--seed", "5", "--format", "json"];
    let run = tertius(&[&["evaluate"], call, &more].concat(), b"").ok();
    serde_json::from_str(&run.stdout).expect("JSON")
}

/// Every monitored cylinder has its fault, hours are a machine's however many cylinders it has, and nothing is counted
/// for cylinders that are not monitored.
#[test]
fn evaluate_counts_the_cylinders_that_are_monitored() {
    let scratch = Scratch::new();
    let three = three(&scratch);
    for (config, cylinders) in [(CONFIG, 6), (&*three, 3)] {
        let asked =
            ["--trials", "6", "--hours", "0.15", "--rows", "step,drift,estimate,healthy,weights"];
        let found = rows(&[&["--config", config, "--plant", PLANT], &asked[..]].concat());
        for row in found["rows"].as_array().expect("rows") {
            let size = row["size"].as_f64().expect("a size");
            if row["study"] == "step" && size < 1.5e-3 || row["grade"] == "coarse" && size < 2e-3 {
                continue;
            }
            assert_eq!(row["faults"], 6, "{row}");
            assert_eq!(row["sea"], serde_json::json!([1.75, 6.5]), "the plant's");
            let in_time = &row["thesis"]["found"]["count"];
            assert!(row["study"] != "step" || *in_time == 6, "{row}");
        }
        for cell in found["healthy"].as_array().expect("cells") {
            let hours = cell["hours"].as_f64().expect("a number");
            assert!((hours - 1.0 / 6.0).abs() < 1e-3, "one stretch less the settling: {hours}");
        }
        for estimate in found["estimates"].as_array().expect("estimates") {
            assert_eq!(estimate["cylinders"], 6, "{estimate}");
            assert!(cylinders == 6 || estimate["cycles"].as_u64() > Some(0));
        }
        for set in found["weights"].as_array().expect("weights") {
            assert!(set["levels"].is_array(), "each residual has its tail: {set}");
            let of = |fault: &serde_json::Value| fault["found"]["of"] == 6;
            let seen = set["seen"].as_array().expect("thresholds");
            assert!(seen.iter().all(|it| it["faults"].as_array().expect("faults").iter().all(of)));
        }
    }
}
