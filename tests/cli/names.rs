//! Names of cylinders and transducers beside their numbers, wherever a person reads of them.

use serde_json::Value;
use std::fs;
use tertius_testing::support::{Scratch, between, changed, recorded, replay, tertius, top};

const FAULTS: &str = "tests/recordings/e-type-faults.log.zst";
const CONFIG: &str = "tests/recordings/e-type-sequential.toml";

/// The configuration with the names of all cylinders, and of the transducers of the first five.
pub fn named(scratch: &Scratch) -> String {
    let text = fs::read_to_string(top().join(CONFIG)).expect("it ships");
    let dbc = top().join("dbc").display().to_string();
    let mut text = changed(&text, &[("../../dbc", &dbc)]);
    for n in 1..=6 {
        let tags = format!("c1_name = \"LT-10{n}A\"\nc2_name = \"LT-10{n}B\"\n");
        let tags = if n < 6 { tags } else { String::new() };
        let own = format!("[[cylinder]]\nn = {n}\n");
        assert_eq!(text.matches(&own).count(), 1, "{own:?}");
        text = text.replace(&own, &format!("{own}name = \"<u>{n}\\\"&\"\n{tags}"));
    }
    scratch.write("named.toml", text)
}

/// What a name is in the text of a report.
fn name(n: u64) -> String {
    format!("<u>{n}\"&")
}

#[test]
fn a_report_has_numbers_with_their_names() {
    let scratch = Scratch::new();
    let config = named(&scratch);
    let page = scratch.path("page.html");
    let run = tertius(&["replay", FAULTS, "--config", &config, "--report", &page], b"").ok();
    let plain = tertius(&["replay", FAULTS, "--config", CONFIG], b"").ok();
    let story = "Cylinder 5, C1, black: ";
    assert!(plain.stdout.contains(story), "{}", plain.stdout);
    assert!(!run.stdout.contains(story), "{}", run.stdout);
    let text = run.stdout.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(text.contains(&format!("Cylinder 5 ({}), C1 (LT-105A), black: ", name(5))), "{text}");
    assert!(text.contains(" of C1 (LT-105A)"), "the advice names the transducer: {text}");
    // In the tables, too, of incidents and of cylinders.
    assert!(text.contains(&format!(" 5 {} C1 black growing error", name(5))), "{text}");
    assert!(text.contains(&format!(" 6 {} 50 0 245 ", name(6))), "{text}");
    assert!(text.contains(&format!("Not judged: C2 of cylinder 6 ({}) from", name(6))), "{text}");
    assert!(plain.stdout.contains("Not judged: cylinder 6's C2 from"), "{}", plain.stdout);
    let html = scratch.read("page.html");
    assert!(!html.contains("<u>"), "a name is no markup");
    let shown = |n: u64| format!("{n} (&lt;u&gt;{n}&quot;&amp;)");
    assert!(html.contains(&format!("Cylinder {}, C1 (LT-105A), black: ", shown(5))));
    assert!(html.contains(&format!("Cylinder {}: residuals", shown(6))));
}

#[test]
fn lines_of_json_have_names_beside_numbers() {
    let scratch = Scratch::new();
    let [with, without] =
        [named(&scratch).as_str(), CONFIG].map(|it| replay(&[FAULTS], it, &[]).ok().lines());
    assert_eq!(with.len(), without.len());
    let tag = |n: u64, suspect: &Value| match suspect.as_str() {
        Some("c1") if n < 6 => Some(format!("LT-10{n}A")),
        Some("c2") if n < 6 => Some(format!("LT-10{n}B")),
        _ => None,
    };
    let (mut warnings, mut tagged) = (0, 0);
    for (with, without) in with.iter().zip(&without) {
        assert_eq!(with["cylinder"], without["cylinder"], "the number stays");
        assert!(without.get("name").is_none() && without.get("suspect_name").is_none());
        let Some(n) = with["cylinder"].as_u64() else { continue };
        assert_eq!(with["name"], name(n), "{with}");
        if with["type"] == "warning" || with["type"] == "incident" {
            let expected = tag(n, &with["suspect"]);
            assert_eq!(with.get("suspect_name").and_then(Value::as_str), expected.as_deref());
            warnings += 1;
            tagged += usize::from(expected.is_some());
        }
    }
    assert!(warnings > 20 && tagged > 10, "{warnings} {tagged}");
    let [own, bare] = [&with, &without].map(|lines| {
        let summary = lines.last().expect("a summary");
        summary["cylinders"].as_array().expect("a list").clone()
    });
    assert_eq!((own[1]["name"].as_str(), &own[1]["c2_name"]), (Some(&*name(2)), &"LT-102B".into()));
    assert!(own[5].get("c1_name").is_none() && bare[1].get("name").is_none());
}

/// Whoever opens a table sees them; without them nothing of it is there.
#[test]
fn tables_of_each_cycle_have_names_behind_the_numbers() {
    let scratch = Scratch::new();
    let log = scratch.write("some.log", between(&recorded("e-type-faults.log.zst"), 88.0, 90.0));
    let tables = |config: &str| {
        let [residuals, estimates] = ["r.csv", "e.csv"].map(|name| scratch.path(name));
        let options = ["--residuals", &residuals, "--estimates", &estimates];
        replay(&[&log], config, &options).ok();
        ["r.csv", "e.csv"].map(|name| {
            let text = scratch.read(name);
            fs::remove_file(scratch.path(name)).expect("it was written");
            text
        })
    };
    for (with, without) in tables(&named(&scratch)).iter().zip(tables(CONFIG)) {
        assert!(without.lines().count() > 500, "{}", without.lines().count());
        let begin =
            without.lines().next().expect("a head").replace("t,cylinder,", "t,cylinder,name,");
        assert!(with.starts_with(&begin), "{begin}");
        let bare = |(k, line): (usize, &str)| {
            if k == 0 {
                return line.replace(",name,", ",") + "\n";
            }
            let n = line.split(',').nth(1).and_then(|it| it.parse().ok()).expect("a cylinder");
            let name = format!(",\"{}\",", name(n).replace('"', "\"\""));
            assert_eq!(line.matches(&name).count(), 1, "{name} in {line}");
            line.replace(&name, ",") + "\n"
        };
        assert!(with.lines().enumerate().map(bare).collect::<String>() == without);
    }
}

#[test]
fn check_shows_names_and_refuses_them_by_line() {
    let scratch = Scratch::new();
    let config = named(&scratch);
    let text = tertius(&["check", &config], b"").ok().stdout;
    let of = format!("\ncylinder 5 ({})\n  names     C1 (LT-105A), C2 (LT-105B)\n", name(5));
    assert!(text.contains(&of), "{of:?} is not in\n{text}");
    assert!(text.contains(&format!("\ncylinder 6 ({})\n  frames ", name(6))), "{text}");
    let text = scratch.read("named.toml").replace("LT-105B", "LT-101a");
    let line = text.lines().position(|line| line.contains("LT-101a")).expect("it is there") + 1;
    let twice = scratch.write("twice.toml", text);
    let run = tertius(&["check", &twice], b"").failed(2, &["is \"LT-101a\", and so is"]);
    assert!(run.stderr.contains(&format!("[{twice}:{line}:")), "{}", run.stderr);
}
