//! Values of single keys from outside the file.

use crate::common::EXAMPLE;
use tertius::config::{
    Document, Override, Overrides, Settings, load, load_with, parse, parse_with,
};
use tertius_testing::oracle::top;

fn set(arguments: &[&str]) -> Overrides {
    let one = |text: &&str| Override::of_argument(text).expect("KEY=VALUE");
    Overrides::new(arguments.iter().map(one))
}

fn with(arguments: &[&str]) -> (Settings, Document) {
    parse_with("machine.toml", EXAMPLE, &set(arguments)).expect("it is sound")
}

/// What is said of the example with these overrides, as lines.
fn refusal(overrides: &Overrides) -> Vec<String> {
    let refused = parse_with("machine.toml", EXAMPLE, overrides).expect_err("it is refused");
    refused.to_string().lines().map(str::to_owned).collect()
}

#[test]
fn values_of_every_sort_replace_those_of_the_file() {
    let (settings, _) = with(&[
        "fde.high=0.002",
        "bus.interface=can1",
        "machine.name=\"The other\"",
        "machine.monitored_states=[\"engaged\", \"neutral\"]",
        "observer.q = [1, 2.5, 3]",
        "estimate.bound=0.01",
        "alarm.levels.located=orange",
        "signals.cylinder.pressure_rod=Rod{n}.Pressure",
        "realtime.lock_memory=true",
    ]);
    assert_eq!(settings.fde.high, 0.002);
    assert_eq!(settings.bus.interface, "can1");
    assert_eq!(settings.machine.name, "The other");
    assert_eq!(settings.machine.monitored_states.expect("some").len(), 2);
    assert_eq!(settings.observer.q, [1.0, 2.5, 3.0]);
    assert_eq!(settings.estimate.bound, 0.01);
    assert_eq!(settings.signals.cylinder.pressure_rod.as_deref(), Some("Rod{n}.Pressure"));
    assert!(settings.realtime.lock_memory);
    // What is not named stays.
    assert_eq!(settings.fde.low, 7.5e-4);
    assert_eq!(settings.cylinder.len(), 1);
    // A text that looks like a number is one all the same.
    assert_eq!(with(&["machine.name=7"]).0.machine.name, "7");
}

#[test]
fn the_effective_text_says_the_same_as_the_overrides() {
    let overrides =
        ["fde.high=0.002", "bus.interface=can1", "store.file=kept.events", "alarm.levels.both=red"];
    let (settings, document) = with(&overrides);
    let (again, _) = parse("machine.toml", document.effective()).expect("it is sound");
    assert_eq!(again, settings);
    assert_eq!(document.text(), EXAMPLE);
    // Comments stay, and what was not asked for.
    assert!(document.effective().contains("interface = \"can1\"            # SocketCAN"));
    assert!(document.effective().contains("\nlow = 7.5e-4\n"));
    assert!(document.has("store.file") && document.has("store") && !document.has("store.days"));
}

#[test]
fn the_later_one_counts() {
    let (settings, document) = with(&["fde.high=0.002", "fde.high=0.003"]);
    assert_eq!(settings.fde.high, 0.003);
    assert_eq!(document.overrides().all().len(), 1);
}

#[test]
fn variables_are_named_as_the_keys() {
    let one = |name| Override::of_variable(name, "1").map(|it| it.key().to_owned());
    assert_eq!(one("TERTIUS_BUS__INTERFACE").as_deref(), Some("bus.interface"));
    assert_eq!(one("TERTIUS_MACHINE__SAMPLE_TIME").as_deref(), Some("machine.sample_time"));
    assert_eq!(one("TERTIUS_ALARM__LEVELS__BOTH").as_deref(), Some("alarm.levels.both"));
    for other in ["TERTIUS_PYTHON", "TERTIUS_TOKEN", "PATH", "OTHER_TERTIUS_BUS__INTERFACE"] {
        assert_eq!(one(other), None, "{other}");
    }
    for wrong in ["fde.high", "=1", " =1", ""] {
        assert!(Override::of_argument(wrong).expect_err(wrong).contains("KEY=VALUE"));
    }
}

#[test]
fn problems_name_the_override_and_not_the_file() {
    for (argument, message) in [
        (
            "fde.hihg=1",
            "--set fde.hihg=1: there is no key `fde.hihg` (the nearest known key is `fde.high`)",
        ),
        (
            "interface=can1",
            "--set interface=can1: there is no key `interface` (the nearest known key is `bus.interface`)",
        ),
        (
            "zzz=1",
            "--set zzz=1: there is no key `zzz` (a key has the name of its table before it, such as fde.high; \
          `tertius config --defaults` lists all)",
        ),
        (
            "fde.high.more=1",
            "--set fde.high.more=1: there is no key `fde.high.more` (the nearest known key is `fde.high`)",
        ),
        (
            "fde=3",
            "--set fde=3: `fde` is a table, of which single keys can be overridden (they are fde.enabled, fde.low, fde.high, fde.joint, fde.command, fde.command_change)",
        ),
        (
            "cylinder.theta=1",
            "--set cylinder.theta=1: [[cylinder]] is a list of tables, of which no key can be overridden \
          (change the file; each of its tables says whose it is)",
        ),
        (
            "cylinder[0].n=2",
            "--set cylinder[0].n=2: [[cylinder]] is a list of tables, of which no key can be overridden \
          (change the file; each of its tables says whose it is)",
        ),
        (
            "canopen.device.node=3",
            "--set canopen.device.node=3: [[canopen.device]] is a list of tables, of which no key \
          can be overridden (change the file; each of its tables says whose it is)",
        ),
        (
            "fde.high=much",
            "--set fde.high=much: `fde.high` is a string, but must be a number (above this R1 and R2 raise \
          a warning, m; for example high = 1.0e-3)",
        ),
        (
            "fde.high=-1",
            "--set fde.high=-1: `fde.high` is -1, but must be above 0 and finite (a threshold in metres; \
          residuals are compared by their size)",
        ),
        (
            "observer.q=[1, -2, 3]",
            "--set observer.q=[1, -2, 3]: `observer.q[1]` is -2, but must be at least 0 and finite (",
        ),
        (
            "observer.q=[1, 2]",
            "--set observer.q=[1, 2]: `observer.q` is a list of 2, but must be one of 3 (",
        ),
        ("bus.interface=", "--set bus.interface=: `bus.interface` is , but must be not empty ("),
        ("machine.name=\"a\nb\"", "--set machine.name=\"a"),
    ] {
        let lines = refusal(&set(&[argument]));
        assert!(lines[0].starts_with(message), "\n   found {}\nexpected {message}", lines[0]);
    }
    let variable = Override::of_variable("TERTIUS_BUS__INTERFAC", "can1");
    assert_eq!(
        refusal(&Overrides::new(variable)),
        [
            "TERTIUS_BUS__INTERFAC=can1: there is no key `TERTIUS_BUS__INTERFAC` (the nearest known key is \
          `TERTIUS_BUS__INTERFACE`)"
        ]
    );
}

#[test]
fn an_override_that_does_not_fit_the_file_is_at_fault_and_not_the_file() {
    let lines = refusal(&set(&["fde.high=0.0001"]));
    assert_eq!(lines.len(), 1, "{lines:?}");
    assert!(
        lines[0].starts_with("--set fde.high=0.0001: `fde.low` is 0.00075, but must not be"),
        "{}",
        lines[0]
    );
}

#[test]
fn the_file_keeps_its_lines_beside_an_override() {
    let text = EXAMPLE.replace("critical = 0.05", "critical = -1");
    let refused =
        parse_with("machine.toml", &text, &set(&["fde.hihg=1", "machine.name=An E-type"]));
    let lines: Vec<String> =
        refused.expect_err("refused").to_string().lines().map(str::to_owned).collect();
    assert_eq!(lines.len(), 2, "{lines:?}");
    assert!(lines[0].starts_with("--set fde.hihg=1: "), "{}", lines[0]);
    assert!(
        lines[1].starts_with("machine.toml:39:12: `comparator.critical` is -1"),
        "{}",
        lines[1]
    );
}

#[test]
fn an_override_mends_what_is_wrong_or_missing_in_the_file() {
    let text = EXAMPLE.replace("interface = \"can0\" ", "").replace("high = 1.0e-3", "high = -1");
    parse("machine.toml", &text).expect_err("the file alone is not sound");
    let overrides = set(&["bus.interface=can1", "fde.high=1e-3"]);
    parse_with("machine.toml", &text, &overrides).expect("it is sound");
}

#[test]
fn identities_and_portable_files_are_of_what_is_in_force() {
    let path = top().join("config/e-type.toml");
    let plain = load(&path).expect("it ships");
    let same = load_with(&path, &set(&[&format!("fde.high={:?}", plain.settings.fde.high)]))
        .expect("sound");
    assert_eq!(same.fingerprints(), plain.fingerprints());
    assert!(!same.differs_from_file());
    let other = load_with(&path, &set(&["fde.high=0.002"])).expect("sound");
    assert_ne!(other.fingerprints().configuration, plain.fingerprints().configuration);
    assert!(other.differs_from_file());
    assert!(other.title().ends_with("e-type.toml, with --set fde.high=0.002"), "{}", other.title());

    let [machine, ..] = &other.portable(&[]).expect("TOML")[..] else { panic!("no files") };
    let text = String::from_utf8(machine.bytes.clone()).expect("UTF-8");
    let (settings, _) = parse("machine.toml", &text).expect("it is sound");
    assert_eq!(settings.fde.high, 0.002);
}

#[test]
fn learnt_tables_go_into_the_file_without_the_overrides() {
    let (_, document) =
        with(&["fde.high=0.002", "fde.low=1e-4", "store.days=7", "bus.interface=can1"]);
    // What a command has learnt replaces one of the overrides.
    let learnt = document
        .effective()
        .replace("low = 1e-4", "low = 0.0005")
        .replace("critical = 0.05", "critical = 0.04");
    let text = document.without_overrides(&learnt);
    let (settings, _) = parse("machine.toml", &text).expect("it is sound");
    assert_eq!((settings.fde.low, settings.fde.high), (0.0005, 1.0e-3));
    assert_eq!((settings.bus.interface.as_str(), settings.comparator.critical), ("can0", 0.04));
    assert!(!text.contains("days"), "{text}");
    assert!(text.contains("interface = \"can0\"            # SocketCAN"), "{text}");
    // Without overrides every byte stays.
    let (_, plain) = parse("machine.toml", EXAMPLE).expect("it is sound");
    assert_eq!(plain.without_overrides(EXAMPLE), EXAMPLE);
}
