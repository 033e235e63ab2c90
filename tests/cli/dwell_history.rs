//! What is read on the stops outlives a restart, live as in replays, and says where it is going.

use std::fs;
use std::path::Path;
use std::sync::Arc;
use tertius::appliance::history::{HistoryFile, Keeper, Kept};
use tertius::appliance::telemetry::Recorder;
use tertius::appliance::telemetry::clock::SystemClock;
use tertius::appliance::telemetry::exposition::exposition;
use tertius::config::design;
use tertius::config::{self, Settings};
use tertius::dbc::{Database, text};
use tertius::monitor::{Monitor, Sink};
use tertius::sequential::{Archive, Blame, DriftLimits, Dwell, Judgement, stops};
use tertius_testing::process::{Running, read, said, top, wait_for, wire, write};
use tertius_testing::program;
use tertius_testing::support::{self, Scratch, changed, replay, tertius};
use tertius_testing::visits::{CONFIG, COUNT, DRIFTING, NAME, STEP, visits};

#[derive(Default)]
struct Heard(Vec<(u8, Dwell)>);

impl Sink for Heard {
    fn dwell(&mut self, cylinder: u8, dwell: &Dwell) {
        self.0.push((cylinder, *dwell));
    }
}

fn monitor() -> Monitor {
    monitor_of(|_| ())
}

fn monitor_of(change: impl Fn(&mut Settings)) -> Monitor {
    let mut loaded = config::load(&top().join(CONFIG)).expect("it ships");
    change(&mut loaded.settings);
    let database = Database::parse(&text::from_bytes(&loaded.dbc_text)).expect("it is sound");
    Monitor::new(design::judging(&loaded.settings, &database).expect("they fit"))
}

/// What `monitor` reads on the stops.
fn play(monitor: &mut Monitor, days: std::ops::Range<u16>) -> Heard {
    let mut heard = Heard::default();
    visits(days).iter().for_each(|frame| monitor.take(frame, &mut heard));
    monitor.finish(&mut heard);
    heard
}

fn judged(monitor: &Monitor) -> Vec<Option<Judgement>> {
    stops::judge(monitor.dwells().map(|(_, dwells)| dwells))
}

fn kept(monitor: &Monitor) -> Archive {
    let mut archive = Archive::new(NAME, 6);
    monitor.save(&mut archive);
    archive
}

#[test]
fn a_drift_that_began_before_a_restart_is_blamed_after_it() {
    let mut before = monitor();
    let heard = play(&mut before, 0..10);
    assert_eq!(heard.0.len(), 60, "each cylinder is read at each visit");
    let text = kept(&before).to_text();

    let mut after = monitor();
    after.restore(&Archive::parse(text.as_bytes(), NAME, 6).expect("it was just written"));
    assert_eq!(play(&mut after, 10..12).0.len(), 12);
    let judged = judged(&after);
    for (cylinder, judgement) in (1..).zip(&judged) {
        let judgement = judgement.expect("there is a history");
        let expected = if cylinder == DRIFTING { Blame::C1 } else { Blame::Neither };
        assert_eq!(judgement.blame, expected, "{cylinder}: {judgement:?}");
    }
    let by = judged[2].expect("there is a history").moved.c1;
    let moved = f64::from(6 * STEP) * COUNT;
    assert!((0.5 * moved..1.1 * moved).contains(&by), "since the first visits: {by} of {moved}");

    // As if there had been no restart.
    let mut whole = monitor();
    play(&mut whole, 0..12);
    assert_eq!(kept(&after), kept(&whole));
    // And without what was kept nothing is known.
    let mut without = monitor();
    play(&mut without, 10..12);
    assert!(self::judged(&without).iter().all(Option::is_none));
}

/// A configuration on the embedded bus with a history beside it, and the visits of `days` as a
/// recording.
fn stage(scratch: &Scratch, days: std::ops::Range<u16>) -> (String, String) {
    let text = fs::read_to_string(top().join(CONFIG)).expect("it ships");
    let dbc = format!("{:?}", top().join("dbc/e-type.dbc"));
    let history = "stop_states = [\"safe\", \"settled\"]\nhistory = \"kept.dwells\"";
    let text = changed(
        &text,
        &[
            ("\"../../dbc/e-type.dbc\"", &dbc),
            ("\"can0\"", "\"virtual\""),
            ("stop_states = [\"safe\", \"settled\"]", history),
        ],
    );
    let log = scratch.path(&format!("{}-{}.log", days.start, days.end));
    write(Path::new(&log), "can0", &visits(days));
    (scratch.write("machine.toml", text), log)
}

fn run(config: &str, log: &str, options: &[&str]) -> support::Run {
    let arguments = ["run", "--config", config, "--play", log, "--speed", "max"];
    tertius(&[&arguments, options].concat(), b"").ok()
}

#[test]
fn replays_and_the_gateway_go_on_where_the_last_one_ended() {
    let scratch = Scratch::new();
    let (config, first) = stage(&scratch, 0..8);
    let (_, second) = stage(&scratch, 8..12);
    let path = scratch.path("replayed.dwells");
    let history: &[&str] = &["--history", &path];
    // The rods stand on their stops all the time, where the observers judge nothing; the history is kept all the same.
    let parked = &["never in a monitored state"];
    let one = replay(&[&first], &config, history).failed(1, parked);
    let two = replay(&[&second], &config, history).failed(1, parked);
    let blames = |run: &support::Run| -> Vec<String> {
        let told = run.warnings().into_iter();
        told.map(|w| format!("{} {} {}", w["cylinder"], w["detector"], w["suspect"])).collect()
    };
    assert!(blames(&one).is_empty());
    // R3 sees it, too, and cannot tell whose it is.
    let expected = ["3 \"fde3\" \"undecided\"", "3 \"sequential\" \"c1\""];
    assert_eq!(blames(&two), expected, "{}", two.stdout);
    let trends = two.summary()["trends"].as_array().expect("trends").clone();
    assert_eq!(trends.len(), 12);
    for trend in trends {
        assert_eq!(trend["dwells"], 12);
        let drifts = (&trend["cylinder"], &trend["transducer"]) == (&3.into(), &"c1".into());
        assert_eq!(trend["months_until_maintenance"].is_object(), drifts, "{trend}");
        assert_eq!(trend["months_until_critical"].is_object(), drifts, "{trend}");
        let moved = trend["moved_mm"].as_f64().expect("a number");
        assert!(
            (moved - if drifts { 6e3 * f64::from(STEP) * COUNT } else { 0.0 }).abs() < 0.06,
            "{trend}"
        );
    }
    // Two visits alone say nothing of it, and the configuration's file is the gateway's.
    let (_, short) = stage(&scratch, 10..12);
    let alone = blames(&replay(&[&short], &config, &[]).failed(1, parked));
    assert!(alone.iter().all(|blame| !blame.contains("sequential")), "{alone:?}");
    assert!(!Path::new(&scratch.path("kept.dwells")).exists());

    // Live, in two runs: the same dwells, and the same warning.
    run(&config, &first, &[]);
    let record = scratch.path("sent.log");
    run(&config, &second, &["--record", &record]);
    assert_eq!(scratch.read("kept.dwells"), scratch.read("replayed.dwells"));
    let sent = wire(&read(Path::new(&record)));
    let warned = sent.iter().any(|(id, data)| {
        // Cylinder 3, detector 5, suspect 1.
        id.value() == 0x2D1 && data[3] & 0x3F == 3 | 5 << 3 && data[4] >> 1 & 0b11 == 1
    });
    assert!(warned, "{sent:?}");

    // Once more is not twice.
    replay(&[&second], &config, history).failed(1, parked);
    assert_eq!(scratch.read("kept.dwells"), scratch.read("replayed.dwells"));
}

#[test]
fn a_reload_keeps_the_history() {
    let scratch = Scratch::new();
    let (config, log) = stage(&scratch, 0..12);
    let (file, said_by) = (scratch.path("kept.dwells"), scratch.path("run.txt"));
    let arguments = ["run", "--config", &config, "--play", &log, "--speed", "10"];
    let mut gateway = Running::start(program(), &arguments, Path::new(&said_by));
    let read = || {
        let bytes = fs::read(&file).unwrap_or_default();
        Archive::parse(&bytes, NAME, 6).map_or(0, |archive| archive.cylinders[2].dwells().len())
    };
    wait_for("the third dwell", || read() >= 3);
    gateway.signal("HUP");
    assert!(gateway.end().success());
    assert!(said(Path::new(&said_by), "the configuration was read again"));
    // The visit in which it was read again may have been too short then.
    let dwells = read();
    assert!((11..=12).contains(&dwells), "{dwells}");
}

#[test]
fn what_is_no_history_is_set_aside_live_and_left_alone_in_replays() {
    let scratch = Scratch::new();
    let (config, log) = stage(&scratch, 0..4);
    run(&config, &log, &[]);
    let whole = scratch.read("kept.dwells");
    for (n, (damaged, told)) in [
        (whole[..whole.len() / 2].to_owned(), "it was changed or truncated"),
        (whole.replacen("dwells 2", "dwells 4", 1), "a newer one wrote it"),
    ]
    .into_iter()
    .enumerate()
    {
        let file = scratch.write("kept.dwells", &damaged);
        replay(&[&log], &config, &["--history", &file]).failed(2, &[&file, told, "move this one"]);
        assert_eq!(scratch.read("kept.dwells"), damaged);
        let run = run(&config, &log, &[]);
        let aside = format!("kept.dwells.aside-{}", n + 1);
        for word in [&file, told, &aside, "the history restarts"] {
            assert!(run.stderr.contains(word), "{word}: {}", run.stderr);
        }
        assert_eq!(scratch.read(&aside), damaged);
        assert_eq!(scratch.read("kept.dwells"), whole, "it began anew");
    }
}

#[test]
fn a_history_that_cannot_be_written_stops_nothing_and_is_told_once() {
    let scratch = Scratch::new();
    let (config, log) = stage(&scratch, 0..4);
    let text = scratch.read("machine.toml").replace("kept.dwells", "nowhere/kept.dwells");
    let config = scratch.write(config.rsplit('/').next().expect("a name"), text);
    let run = run(&config, &log, &[]);
    let told = run.stderr.matches("the history of the stops cannot be written").count();
    assert_eq!(told, 1, "{}", run.stderr);
}

#[test]
fn the_reports_show_where_it_is_going() {
    let scratch = Scratch::new();
    let (config, log) = stage(&scratch, 0..12);
    let page = scratch.path("page.html");
    let run =
        tertius(&["replay", &log, "--config", &config, "--report", &page], b"").failed(1, &[]);
    let page = scratch.read("page.html");
    for text in [&run.stdout, &page] {
        assert!(text.contains("The stops show a drift: C1 of cylinder 3."), "{text}");
        assert!(text.contains("11.0") && text.contains("until"), "{text}");
        assert!(text.contains("+1.9"), "{text}");
    }
    assert_eq!(page.matches("no drift seen").count() % 11, 0, "of eleven transducers");
    assert_eq!(page.matches("readings on the stop</p>").count(), 6, "a figure for each cylinder");
    // Of two dwells nothing is claimed.
    let (_, log) = stage(&scratch, 0..2);
    let few = tertius(&["replay", &log, "--config", &config], b"").failed(1, &[]);
    assert!(few.stdout.contains("Too few readings on the stops"));
    let summary = replay(&[&log], &config, &[]).failed(1, &[]).summary();
    assert!(summary.get("trends").is_none(), "{summary}");
}

#[test]
fn a_history_that_would_harm_a_file_or_have_nothing_in_it_is_refused() {
    let scratch = Scratch::new();
    let (config, log) = stage(&scratch, 0..1);
    let before = fs::read(&log).expect("it is there");
    replay(&[&log], &config, &["--history", &log]).failed(2, &["written over the input"]);
    assert_eq!(fs::read(&log).expect("it is there"), before);
    let no_use = "tests/recordings/e-type.toml";
    let history = scratch.path("x.dwells");
    let lack = format!("{no_use} has no `sequential.stop_states`");
    let words = [&*lack, "add for example stop_states = [\"settled\"] to [sequential]"];
    replay(&[&log], no_use, &["--history", &history]).failed(2, &words);
    let untaught = "config/e-type.toml";
    let words = [untaught, "no cylinder with `sequential`", "`tertius calibrate`", "--into"];
    replay(&[&log], untaught, &["--history", &history]).failed(2, &words);
    let text = tertius(&["check", &config], b"").ok().stdout;
    let kept = format!("due after 5 mm; the history is kept in {}", scratch.path("kept.dwells"));
    assert!(text.contains(&format!("end stops   read when safe or settled; {kept}")), "{text}");
    let text = scratch.read("machine.toml").replace("kept.dwells", "machine.toml");
    let config = scratch.write("machine.toml", text);
    tertius(&["check", &config], b"").failed(2, &["`sequential.history` would overwrite"]);
}

fn keeper() -> Keeper {
    Keeper::new(Recorder::new(Arc::new(SystemClock::new())).telemetry())
}

fn keep(machine: &str, path: Option<&str>) -> Kept {
    Kept {
        machine: machine.to_owned(),
        cylinders: 6,
        limits: DriftLimits { maintenance: 5e-3, critical: 0.05 },
        file: path.map(|path| HistoryFile::new(path.into())),
    }
}

#[test]
fn a_configuration_that_is_read_again_loses_nothing_of_its_machine() {
    let scratch = Scratch::new();
    let [one, two] = ["one.dwells", "two.dwells"].map(|name| scratch.path(name));
    let mut gateway = monitor();
    let mut keeper = keeper();
    assert!(keeper.open(keep(NAME, None), None).is_empty());
    play(&mut gateway, 0..5);
    keeper.dwelt();
    keeper.turned(&gateway);
    let known = kept(&gateway);
    // In memory only, then in a file, then in another one, then in memory again.
    for file in [Some(&one), Some(&two), None] {
        let kept = keep(NAME, file.map(String::as_str));
        assert_eq!(keeper.open(kept, Some(&gateway)), &known);
        keeper.turned(&gateway);
    }
    // What a file has of an earlier time is what a machine without a history goes on with.
    assert_eq!(keeper.open(keep(NAME, Some(&two)), Some(&gateway)), &known);
    // Another machine is not judged by it, and that file is set aside.
    let other = keeper.open(keep("another", Some(&two)), Some(&gateway));
    assert_eq!(other, &Archive::new("another", 6));
    keeper.finish(&monitor());
    for name in ["one.dwells", "two.dwells.aside-1"] {
        assert_eq!(scratch.read(name), known.to_text(), "{name}");
    }
    assert!(!Path::new(&two).exists(), "of the other machine nothing was read");
}

#[test]
fn what_found_no_room_or_no_disk_is_written_with_the_next() {
    let scratch = Scratch::new();
    let recorder = Recorder::new(Arc::new(SystemClock::new()));
    let telemetry = recorder.telemetry();
    let mut keeper = Keeper::new(telemetry);
    let mut gateway = monitor();
    let file = scratch.path("later/kept.dwells");
    keeper.open(keep(NAME, Some(&file)), None);
    play(&mut gateway, 0..3);
    keeper.dwelt();
    keeper.turned(&gateway);
    let failed = || {
        let text = exposition(telemetry, &SystemClock::new()).expect("text takes it");
        text.contains("tertius_history_failures_total 1\n")
    };
    wait_for("the disk's refusal", failed);
    fs::create_dir(scratch.path("later")).expect("the folder is ours");
    // Nobody hands it on any more: the gateway stops.
    play(&mut gateway, 3..4);
    keeper.finish(&gateway);
    assert_eq!(scratch.read("later/kept.dwells"), kept(&gateway).to_text());
}

/// Without the tables of a calibration nothing is read, and nothing that was is lost.
#[test]
fn a_cylinder_that_reads_nothing_keeps_what_it_had() {
    let mut before = monitor();
    play(&mut before, 0..3);
    let known = kept(&before);
    let mut without = monitor_of(|settings| settings.cylinder[0].sequential = None);
    let scratch = Scratch::new();
    let file = scratch.write("kept.dwells", known.to_text());
    let mut keeper = keeper();
    without.restore(keeper.open(keep(NAME, Some(&file)), None));
    play(&mut without, 3..5);
    keeper.finish(&without);
    let text = scratch.read("kept.dwells");
    let after = Archive::parse(text.as_bytes(), NAME, 6).expect("it was just written");
    assert_eq!(after.cylinders[0], known.cylinders[0]);
    assert!(after.cylinders[1..].iter().all(|history| history.dwells().len() == 5));
}

#[test]
fn a_file_that_can_not_be_set_aside_is_never_written_over() {
    let scratch = Scratch::new();
    let file = scratch.write("kept.dwells", "somebody's letters");
    (1..=8).for_each(|n| drop(scratch.write(&format!("kept.dwells.aside-{n}"), "older ones")));
    let mut gateway = monitor();
    let mut keeper = keeper();
    gateway.restore(keeper.open(keep(NAME, Some(&file)), None));
    play(&mut gateway, 0..4);
    keeper.dwelt();
    keeper.turned(&gateway);
    keeper.finish(&gateway);
    assert_eq!(scratch.read("kept.dwells"), "somebody's letters");
    assert_eq!(fs::read_dir(scratch.path("")).expect("it is there").count(), 9);
}
