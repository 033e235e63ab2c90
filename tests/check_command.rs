//! `tertius check`: what a sound configuration leads to, and where an unsound one is wrong.

#[path = "support/mod.rs"]
mod support;

use std::fs;
use support::{HANGING_LOAD, Run, Scratch, changed, recording, replay, tertius, top};

fn check(config: &str) -> Run {
    tertius(&["check", config], b"")
}

/// Refused in exactly `problems` places, the first of them where `place` stands in the
/// configuration, with `words` in the message.
#[track_caller]
fn refused(scratch: &Scratch, config: &str, problems: usize, place: &str, words: &[&str]) {
    let text = fs::read_to_string(config).expect("the configuration is there");
    assert_eq!(text.matches(place).count(), 1, "{place:?} is not once in it");
    let before = text.split(place).next().expect("there is something before it");
    let line = before.lines().count() + usize::from(before.ends_with('\n'));
    let column = before.len() - before.rfind('\n').map_or(0, |end| end + 1) + 1;
    let run = check(config).failed(2, words);
    let position = format!("[{config}:{line}:{column}]");
    assert!(run.stderr.contains(&position), "{position} is not in\n{}", run.stderr);
    let found = run.stderr.matches(&format!("[{config}:")).count();
    assert_eq!(found, problems, "{}", run.stderr);
    assert_eq!(run.stdout, "");

    // A replay refuses it with the same words, and touches nothing.
    let table = scratch.path("residuals.csv");
    let log = recording("hanging-load.log.gz");
    assert_eq!(
        replay(&[&log], config, &["--residuals", &table]).failed(2, words).stderr,
        run.stderr
    );
    assert!(!fs::exists(&table).expect("it can be looked for"));
}

#[test]
fn a_sound_configuration_is_described() {
    let text = check("config/e-type.toml").ok().stdout;
    for line in [
        "config/e-type.toml: sound",
        "25 messages, of which 20 are listened to",
        "Ampelmann E-type: 6 cylinders, every 0.02 s; FDE1 and FDE2 judge when engaged",
        "cylinder 6",
        "frames    0x186 0x196 0x1A6",
        // Table 4-1: nearly integrating, a commanded metre per second moves one.
        "model     moduli of the poles 0.99878, 0.99878, 0.87704; steady speed per commanded speed 1.002",
        "FDE1      gain of the position's innovation 1.7023, 32.0305, -9612.4",
        "FDE3      C1 − (1 C2 +0 m)",
        "estimate  both transducers and the model; valid up to σ = 5 mm; not sent",
    ] {
        assert!(text.contains(line), "{line:?} is not in\n{text}");
    }
    assert!(!text.contains("worth a look"), "the shipped DBC is clean: {text}");

    let text = check(HANGING_LOAD).ok().stdout;
    assert!(text.contains("1 cylinders, every 0.02 s; FDE1 and FDE2 always judge"), "{text}");
    assert!(text.contains("frames    0x201 0x211"), "{text}");
    assert!(text.contains("FDE3      C1 − (1.0031 C2 +0.0034 m)"), "{text}");
}

#[test]
fn a_signal_or_message_that_the_dbc_lacks() {
    let scratch = Scratch::new();
    let config = scratch.config(&[("\"Cyl{n}_C2.Position\"", "\"Cyl{n}_C2.Postion\"")]);
    // One mistake, although it is of each of the six cylinders.
    let words = ["Cyl1_C2 has no signal \"Postion\"", "nearest: Position"];
    refused(&scratch, &config, 1, "\"Cyl{n}_C2.Postion\"", &words);
    let config = scratch.config(&[("\"Plc_State.PlatformState\"", "\"Plc_Stat.PlatformState\"")]);
    let words = ["no message \"Plc_Stat\"", "nearest: Plc_State"];
    refused(&scratch, &config, 1, "\"Plc_Stat.PlatformState\"", &words);
    let config = scratch.config(&[("sync = \"Sync\"", "sync = \"Synk\"")]);
    refused(&scratch, &config, 1, "\"Synk\"", &["no message \"Synk\"", "nearest: Sync"]);
    let config = scratch.config(&[("_Valve.PressureRod\"", "_Valve.PressureRot\"")]);
    let words = ["no signal \"PressureRot\"", "nearest: PressureRod"];
    refused(&scratch, &config, 1, "\"Cyl{n}_Valve.PressureRot\"", &words);
}

#[test]
fn a_key_that_is_unknown() {
    let scratch = Scratch::new();
    let config = scratch.config(&[("sample_time = 0.02", "sampel_time = 0.02")]);
    let run = check(&config).failed(2, &["sampel_time", "sample_time"]);
    assert!(run.stderr.contains(&format!("[{config}:")), "{}", run.stderr);
}

#[test]
fn a_platform_state_that_there_is_not() {
    let scratch = Scratch::new();
    let config = scratch.config(&[("[\"engaged\"]", "[\"engagd\"]")]);
    let words = ["no state \"engagd\"", "safe, settled, neutral, engaged"];
    refused(&scratch, &config, 1, "[\"engagd\"]", &words);
    // By number, and in capitals.
    let config = scratch.config(&[("[\"engaged\"]", "[\"3\", \"NEUTRAL\"]")]);
    assert!(check(&config).ok().stdout.contains("judge when 3 or NEUTRAL"));
    let config = scratch.config(&[("state = \"Plc_State.PlatformState\"\n", "")]);
    let words = ["there is no signal that tells the platform's state", "signals.state"];
    refused(&scratch, &config, 1, "[\"engaged\"]", &words);
}

#[test]
fn identifiers_of_the_gateway_as_inputs() {
    let scratch = Scratch::new();
    let config = scratch.config(&[("[plausibility]", "[gateway]\nnode = 33\n\n[plausibility]")]);
    let words = ["identifier 0x1A1 is the gateway's own and also an input", "choose a node"];
    refused(&scratch, &config, 1, "33\n", &words);
}

#[test]
fn one_signal_for_two_things() {
    let scratch = Scratch::new();
    let config =
        scratch.config(&[("\"Cyl{n}_Valve.ControlSpeed\"", "\"Cyl1_Valve.ControlSpeed\"")]);
    refused(&scratch, &config, 1, "\"Cyl1_Valve.ControlSpeed\"", &["{n} is missing"]);
    let config = scratch.config(&[("c2 = \"Cyl{n}_C2.Position\"", "c2 = \"Cyl{n}_C1.Position\"")]);
    let run = check(&config).failed(2, &["Cyl{n}_C1.Position"]);
    assert!(run.stderr.contains(&format!("[{config}:")), "{}", run.stderr);
}

/// A configuration beside the default DBC with one change.
fn with_dbc(scratch: &Scratch, from: &str, to: &str) -> String {
    let config = scratch.config(&[]);
    let text = fs::read_to_string(top().join("dbc/e-type.dbc")).expect("the DBC is there");
    scratch.write("e-type.dbc", changed(&text, &[(from, to)]));
    config
}

const CYL1_C1: &str = "BO_ 385 Cyl1_C1: 6 Transducer1_C1\n SG_ Position : 0|16@1+ \
                       (0.00010850694444444444,-1.5) [-1.49989149305556|1.5] \"m\"";

#[test]
fn a_length_that_is_not_in_metres() {
    let scratch = Scratch::new();
    let millimetres = CYL1_C1
        .replace("(0.00010850694444444444,-1.5) [-1.49989149305556|1.5]", "(0.1085,-1500) [0|0]")
        .replace("\"m\"", "\"mm\"");
    let config = with_dbc(&scratch, CYL1_C1, &millimetres);
    let words = ["Cyl1_C1.Position is in \"mm\", expected \"m\"", "scale factor, offset and range"];
    refused(&scratch, &config, 1, "\"Cyl{n}_C1.Position\"", &words);
    // Without a unit it is believed.
    let config = with_dbc(&scratch, CYL1_C1, &CYL1_C1.replace("\"m\"", "\"\""));
    check(&config).ok();
}

#[test]
fn an_error_of_the_dbc_matters_where_the_message_is_used() {
    let scratch = Scratch::new();
    let config = with_dbc(&scratch, "SG_ Roll : 0|16@1-", "SG_ Roll : 40|16@1-");
    let text = check(&config).ok().stdout;
    let (_, noted) = text.split_once("e-type.dbc: worth a look\n").expect("it is told");
    assert!(noted.contains("message Mru_Attitude, signal Roll: it ends in byte 7"), "{noted}");
    assert_eq!(noted.lines().count(), 1, "{noted}");

    for (from, to, words) in [
        (CYL1_C1.to_owned(), CYL1_C1.replace("0|16@1+", "8|16@1+"), "it shares bits with Position"),
        (CYL1_C1.to_owned(), CYL1_C1.replace(": 6 ", ": 5 "), "but the message has 5 bytes"),
        ("\nBO_ 386 ".to_owned(), "\nBO_ 385 ".to_owned(), "has its identifier"),
    ] {
        let config = with_dbc(&scratch, &from, &to);
        let words = ["message Cyl1_C1 cannot be used: line", words, "correct the message"];
        let run = check(&config).failed(2, &words);
        assert!(run.stderr.contains(&format!("[{config}:")), "{}", run.stderr);
    }
    let config = with_dbc(&scratch, "BO_ 433 Mru_Attitude: 6", "BO_ 433 Mru_Attitude 6");
    let words = ["e-type.dbc: line 125", "it should look like BO_ identifier Name: length"];
    refused(&scratch, &config, 1, "\"e-type.dbc\"", &words);
}

#[test]
fn files_that_are_not_there() {
    let scratch = Scratch::new();
    check(&scratch.path("no.toml")).failed(2, &["no.toml", "No such file"]);
    let config = scratch.config(&[("\"e-type.dbc\"", "\"e-typ.dbc\"")]);
    refused(&scratch, &config, 1, "\"e-typ.dbc\"", &["e-typ.dbc", "No such file"]);
}
