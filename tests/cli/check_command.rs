//! `tertius check`: what a sound configuration leads to, and where an unsound one is wrong.

use std::fs;
use tertius_testing::support::{
    self, HANGING_LOAD, Run, Scratch, changed, recording, replay, tertius, top,
};

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
        "25 messages, of which 20 are used",
        "Ampelmann E-type: 6 cylinders, every 0.02 s; FDE1 and FDE2 judge when engaged",
        "cylinder 6",
        "frames    0x186 0x196 0x1A6",
        // Table 4-1: nearly integrating, a commanded metre per second moves one.
        "model     moduli of the poles 0.99878, 0.99878, 0.87704; steady speed per commanded speed 1.002",
        "FDE1      gain of the position's innovation 1.7034, 38.1411, -255525.1",
        "FDE3      C1 − C2",
        "estimate  both transducers and the model; valid up to σ = 5 mm; not sent",
    ] {
        assert!(text.contains(line), "{line:?} is not in\n{text}");
    }
    assert!(!text.contains("dbc: worth a look"), "the shipped DBC is clean: {text}");

    let text = check(HANGING_LOAD).ok().stdout;
    assert!(text.contains("1 cylinder, every 0.02 s; FDE1 and FDE2 always judge"), "{text}");
    assert!(text.contains("frames    0x201 0x211"), "{text}");
    assert!(text.contains("FDE3      C1 − (1.0031 C2 + 3.4 mm)"), "{text}");
}

#[test]
fn cylinders_that_are_judged_alike_are_told_once() {
    let text = check("config/e-type.toml").ok().stdout;
    assert_eq!(text.matches("\ncylinders 1–6\n  model     moduli").count(), 1, "{text}");
    assert_eq!(text.matches("  model     ").count(), 1, "{text}");
    for n in 1..=6 {
        let own = format!("\ncylinder {n}\n  frames    0x18{n} 0x19{n} 0x1A{n}\n");
        assert_eq!(text.matches(&own).count(), 1, "{own:?} is not once in\n{text}");
    }

    let scratch = Scratch::new();
    scratch.config(&[]);
    let text = fs::read_to_string(top().join("config/e-type.toml")).expect("it ships");
    let text = changed(&text, &[("../dbc/e-type.dbc", "e-type.dbc")]);
    let third = "\n[[cylinder]]\nn = 3\nc2_gain = 1.002\n";
    let config = scratch.write("machine.toml", text + third);
    let text = check(&config).ok().stdout;
    assert!(text.contains("\ncylinders 1, 2, 4–6\n  model     "), "{text}");
    let own = "\ncylinder 3\n  frames    0x183 0x193 0x1A3\n  model     ";
    assert!(text.contains(own), "{text}");
    assert!(text.contains("  FDE3      C1 − (1.002 C2 + 0 mm)\n"), "{text}");
    assert_eq!(text.matches("  model     ").count(), 2, "{text}");
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
fn the_gateway_as_a_node_is_told() {
    let scratch = Scratch::new();
    let node = |keys| format!("[canopen]\nnode = true\n{keys}\n\n[plausibility]");
    for (keys, told) in [
        ("", "CANopen    node 81, heartbeat every 1 s, operational by itself"),
        (
            "heartbeat = 0\nautostart = false",
            "node 81, no heartbeat, operational when a master starts it",
        ),
    ] {
        let config = scratch.config(&[("[plausibility]", &node(keys))]);
        let text = check(&config).ok().stdout;
        assert!(text.contains(told), "{told:?} is not in\n{text}");
    }
    assert!(!check(&scratch.config(&[])).ok().stdout.contains("CANopen"));
}

#[test]
fn identifiers_of_the_node_as_inputs() {
    let scratch = Scratch::new();
    // C1 of cylinder 1 on 0x0D1, the EMCY of node 81.
    let dbc = fs::read_to_string(top().join("dbc/e-type.dbc")).expect("it ships");
    let dbc = dbc.replacen("BO_ 385 ", "BO_ 209 ", 1);
    let change = [("[plausibility]", "[canopen]\nnode = true\n\n[plausibility]")];
    for (changes, code) in [(&change[..], 2), (&[], 0)] {
        let config = scratch.config(changes);
        scratch.write("e-type.dbc", &dbc);
        let run = check(&config);
        assert_eq!(run.code, Some(code), "{}", run.stderr);
        if code == 2 {
            run.failed(2, &["identifier 0x0D1 is the gateway's own and also an input"]);
        }
    }
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
    let feet = CYL1_C1
        .replace("(0.00010850694444444444,-1.5) [-1.49989149305556|1.5]", "(0.000356,-4.92) [0|0]")
        .replace("\"m\"", "\"ft\"");
    let config = with_dbc(&scratch, CYL1_C1, &feet);
    let words = ["Cyl1_C1.Position is in \"ft\", expected \"m\"", "scale factor, offset and range"];
    refused(&scratch, &config, 1, "\"Cyl{n}_C1.Position\"", &words);
    // A unit that is known is converted.
    let millimetres = CYL1_C1
        .replace("(0.00010850694444444444,-1.5) [-1.49989149305556|1.5]", "(0.1085,-1500) [0|0]")
        .replace("\"m\"", "\"mm\"");
    let text = check(&with_dbc(&scratch, CYL1_C1, &millimetres)).ok().stdout;
    assert!(text.contains("\nCyl1_C1.Position in \"mm\" are read in \"m\"\n"), "{text}");
    // A command has any unit, and one that is another speed is told.
    let speed = "ControlSpeed : 0|16@1- (0.0001,0) [-3.2768|3.2767] \"m/s\"";
    let dbc = "BO_ 417 Cyl1_Valve: 8 Valve1\n SG_ ";
    let [known, unknown] = ["mm/s", "km/h"].map(|unit| {
        let other = format!("{dbc}{}", speed.replace("m/s", unit));
        check(&with_dbc(&scratch, &format!("{dbc}{speed}"), &other)).ok().stdout
    });
    assert!(known.contains("Cyl1_Valve.ControlSpeed in \"mm/s\" are read in \"m/s\""), "{known}");
    assert!(!known.contains("control_speed"), "{known}");
    let (_, doubts) = unknown.split_once("worth a look").expect("a doubt");
    let words = "signals.cylinder.control_speed: Cyl1_Valve.ControlSpeed is in \"km/h\"";
    assert!(doubts.contains(words), "{unknown}");
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
    // Nobody is sent to the command that has just said it, and a replay says the same.
    let run = check(&config);
    assert!(run.stderr.contains("correct the DBC"), "{}", run.stderr);
    assert!(!run.stderr.contains("tertius check"), "{}", run.stderr);
}

#[test]
fn files_that_are_not_there() {
    let scratch = Scratch::new();
    check(&scratch.path("no.toml")).failed(2, &["no.toml", "No such file"]);
    let config = scratch.config(&[("\"e-type.dbc\"", "\"e-typ.dbc\"")]);
    refused(&scratch, &config, 1, "\"e-typ.dbc\"", &["e-typ.dbc", "No such file"]);
}

/// A configuration that sends its estimates, of a machine of `stroke`, beside a changed DBC.
fn estimating(scratch: &Scratch, stroke: &str, from: &str, to: &str) -> String {
    let tables = "[estimate]\nsend = true\n\n[gateway]\nbus_share = 0.15\n\n[plausibility]";
    let changes = [("[plausibility]", tables), ("[-1.5, 1.5]", stroke)];
    let config = scratch.config(&changes);
    let text = fs::read_to_string(top().join("dbc/e-type.dbc")).expect("the DBC is there");
    scratch.write("e-type.dbc", changed(&text, &[(from, to)]));
    config
}

#[test]
fn estimates_that_do_not_fit_their_message() {
    const POSITION: &str = " SG_ Position : 32|16@1+ (0.00010850694444444444,-1.5) \
                            [-1.49989149305556|1.5] \"m\" Plc\n SG_ Sigma";
    let scratch = Scratch::new();
    let config =
        estimating(&scratch, "[-2.0, 2.0]", "BO_ 977 Fd_Estimate: 8", "BO_ 977 Fd_Estimate: 8");
    let words = [
        "line 178 of the DBC: Fd_Estimate.Position reaches from -1.4999 m to 1.5000 m",
        "`machine.stroke` is [-2.0, 2.0]",
        "or send no estimates",
    ];
    refused(&scratch, &config, 1, "true\n", &words);
    // Raw counts alone would reach that far up, and not that far down.
    let config = estimating(&scratch, "[-2.0, 2.0]", " Fd_Estimate:", " My_Estimate:");
    let words = ["the DBC has no Fd_Estimate", "from -1.4999 m to 5.6110 m"];
    refused(&scratch, &config, 1, "true\n", &words);
    let config = estimating(&scratch, "[-1.5, 1.5]", " Fd_Estimate:", " My_Estimate:");
    check(&config).ok();
    let room = POSITION.replace("-1.5) [-1.49989149305556|1.5]", "-2.0) [-2|2]");
    let config = estimating(&scratch, "[-2.0, 2.0]", POSITION, &room);
    check(&config).ok();

    let fine = " SG_ Sigma : 48|16@1+ (0.000001,0) [0|0.065535]";
    let finer = " SG_ Sigma : 48|16@1+ (0.00000005,0) [0|0]";
    let config = estimating(&scratch, "[-1.5, 1.5]", fine, finer);
    let words = ["line 179 of the DBC: Fd_Estimate.Sigma reaches to 0.003277 m", "is 0.005"];
    check(&config).failed(2, &words);

    for (from, to, words) in [
        (
            "32|16@1+ (0.0001",
            "32|15@1+ (0.0001",
            "line 178 of the DBC: Fd_Estimate.Position is not",
        ),
        (
            "32|16@1+ (0.0001",
            "32|16@1- (0.0001",
            "line 178 of the DBC: Fd_Estimate.Position is not",
        ),
        (
            "32|16@1+ (0.0001",
            "39|16@0+ (0.0001",
            "line 178 of the DBC: Fd_Estimate.Position is not",
        ),
        ("Sigma : 48|16@1+", "Sigma : 49|15@1+", "line 179 of the DBC: Fd_Estimate.Sigma is not"),
        ("BO_ 977 Fd_Estimate: 8", "BO_ 977 Fd_Estimate: 9", "has 9 bytes, expected 8"),
    ] {
        let config = estimating(&scratch, "[-1.5, 1.5]", from, to);
        refused(&scratch, &config, 1, "\"e-type.dbc\"", &[words]);
        // Who sends none does not care.
        let silent = fs::read_to_string(&config).expect("it was written");
        let silent = scratch.write("silent.toml", silent.replace("send = true", "send = false"));
        check(&silent).ok();
    }
}

#[test]
fn a_model_or_a_table_of_another_sample_time() {
    const OWN: &str = "[model]\ntheta = [-0.01, -0.12, -1.7e-5, -10.7, -0.0023]\n\
                       gamma = [0.0926, 6.5427]\n";
    let scratch = Scratch::new();
    let config = scratch.config(&[("sample_time = 0.02", "sample_time = 0.007")]);
    let words = [
        "`machine.sample_time` is 0.007, but the default model, Table 4-1, of cylinder 1 is for a \
         sample time of 0.02 s",
        "`tertius commission`, or `tertius identify`, takes this",
    ];
    replay(&[&recording("hanging-load.log.gz")], &config, &[]).failed(2, &words);
    // What commissioning makes is no mistake before it.
    let text = check(&config).ok().stdout;
    let first = "e-type.toml: sound, but `tertius commission` has to learn its model before it can be used\n";
    assert!(text.contains(first), "{text}");
    assert!(
        text.contains("is for a sample time of 0.02 s, not 0.007 s, so that `replay`"),
        "{text}"
    );
    // The command that mends it takes it, and gets as far as the recording.
    let log = recording("hanging-load.log.gz");
    let run = tertius(&["identify", &log, "--config", &config], b"");
    assert!(!run.stderr.contains("Table 4-1"), "{}", run.stderr);

    let with = |time: &str, model: &str| {
        let model = format!("{model}\n[plausibility]");
        let changes = [("sample_time = 0.02", time), ("[plausibility]", model.as_str())];
        scratch.config(&changes)
    };
    check(&with("sample_time = 0.007", OWN)).ok();
    check(&with("sample_time = 0.007", &format!("{OWN}sample_time = 0.007\n"))).ok();
    check(&with("sample_time = 0.02", "[observer]\nsample_time = 0.0200000000001\n")).ok();
    let config = with("sample_time = 0.007", &format!("{OWN}sample_time = 0.021\n"));
    let words = ["the model (4-1) of cylinder 1 is for a sample time of 0.021 s"];
    refused(&scratch, &config, 1, "0.021", &words);
    let config = with("sample_time = 0.02", "[observer]\nsample_time = 0.004\n");
    let words = ["the table [observer] is for a sample time of 0.004 s", "tertius tune"];
    refused(&scratch, &config, 1, "0.004", &words);

    let table = "tests/recordings/e-type-sequential.toml";
    let text = fs::read_to_string(top().join(table)).expect("the configuration is there");
    let text = text.replace("../../dbc/e-type.dbc", "e-type.dbc").replacen(
        "[cylinder.sequential]\n",
        "[cylinder.sequential]\nsample_time = 0.005\n",
        1,
    );
    let config = scratch.write("sequential.toml", text);
    let words = ["the table [cylinder.sequential] of cylinder 1 is for a sample time of 0.005 s"];
    refused(&scratch, &config, 1, "0.005\n", &words);
}

/// One of 50 Hz at 100 Hz: the detectors would look back half as far as they were taught.
#[test]
fn a_table_that_does_not_say_its_sample_time_is_of_50_hz() {
    const OWN: &str = "[model]\ntheta = [-0.01, -0.12, -1.7e-5, -10.7, -0.0023]\n\
                       gamma = [0.0926, 6.5427]\n\n[[cylinder]]\n";
    let scratch = Scratch::new();
    let read = |name: &str| fs::read_to_string(top().join(recording(name))).expect("it is kept");
    scratch.write("hanging-load.dbc", read("hanging-load.dbc"));
    let text = read("hanging-load-sequential.toml");
    assert!(!text.contains("[cylinder.sequential]\nsample_time"), "it says it");
    let at = |time: &str| {
        let time = format!("sample_time = {time}");
        let changes = [("sample_time = 0.02", time.as_str()), ("[[cylinder]]\n", OWN)];
        scratch.write("machine.toml", changed(&text, &changes))
    };
    check(&at("0.02")).ok();
    let words = [
        "`machine.sample_time` is 0.01, but the table [cylinder.sequential] of cylinder 1, which has none of \
         its own, is for a sample time of 0.02 s",
        "`tertius calibrate` takes this configuration as it is",
    ];
    refused(&scratch, &at("0.01"), 1, "sequential]", &words);
}

#[test]
fn a_machine_that_is_faster_than_the_rings_is_worth_a_look() {
    const OWN: &str = "[model]\ntheta = [-0.01, -0.12, -1.7e-5, -10.7, -0.0023]\n\
                       gamma = [0.0926, 6.5427]\n[plausibility]";
    let scratch = Scratch::new();
    let at = |time: &str| {
        let time = format!("sample_time = {time}");
        let changes = [("sample_time = 0.02", time.as_str()), ("[plausibility]", OWN)];
        check(&scratch.config(&changes)).ok().stdout
    };
    let words = "above 100 Hz the kind of a fault and whose it is are told from less time: at 0.007 s the \
                 newest 128 samples are 0.90 s, not 1.28 s";
    assert!(at("0.007").contains(words), "{}", at("0.007"));
    assert!(!at("0.01").contains("100 Hz"), "{}", at("0.01"));
}

/// How well each node is known: of every one, or, in a table of an earlier version, of none.
#[test]
fn deviations_of_nodes_that_are_not_there() {
    let scratch = Scratch::new();
    let table = "tests/recordings/e-type-sequential.toml";
    let text = fs::read_to_string(top().join(table)).expect("the configuration is there");
    let text = text.replace("../../dbc/e-type.dbc", "e-type.dbc");
    scratch.write("e-type.dbc", fs::read(top().join("dbc/e-type.dbc")).expect("it is kept"));
    let with = |deviations: &str| {
        let table = format!("[cylinder.sequential]\nnode_deviations = {deviations}\n");
        scratch.write("nodes.toml", text.replacen("[cylinder.sequential]\n", &table, 1))
    };
    tertius(&["check", &scratch.write("nodes.toml", &text)], b"").ok();
    let words = ["`cylinder[0].sequential.node_deviations` has 2 values, but there are"];
    refused(&scratch, &with("[1e-5, 2e-5]"), 1, "[1e-5, 2e-5]", &words);
    tertius(&["check", &with("[1e-5, -2e-5]")], b"").failed(2, &["node_deviations"]);
}

/// Errors that are alike from one cycle to the next cannot be opposite two cycles apart.
#[test]
fn a_correlation_that_no_errors_have() {
    let scratch = Scratch::new();
    let table = "tests/recordings/e-type-sequential.toml";
    let text = fs::read_to_string(top().join(table)).expect("the configuration is there");
    let text = text.replace("../../dbc/e-type.dbc", "e-type.dbc");
    scratch.write("e-type.dbc", fs::read(top().join("dbc/e-type.dbc")).expect("it is kept"));
    let with = |correlation: &str| {
        let table = format!("[cylinder.sequential]\nprediction_correlation = {correlation}\n");
        scratch.write("machine.toml", text.replacen("[cylinder.sequential]\n", &table, 1))
    };
    check(&with("[0.4, 0.1, -0.2, -0.4, -0.3, -0.1]")).ok();
    let words = "no errors have the prediction_correlation of cylinder 1";
    check(&with("[0.9, -0.9, 0.0, 0.0, 0.0, 0.0]")).failed(2, &[words]);
    check(&with("[0.4, 0.1]")).failed(2, &["prediction_correlation"]);
    check(&with("[1.5, 0.0, 0.0, 0.0, 0.0, 0.0]")).failed(2, &["prediction_correlation"]);
}

/// What cannot be: six cylinders' frames within a millisecond at 500 kbit/s.
#[test]
fn a_cycle_that_the_bus_cannot_carry() {
    let scratch = Scratch::new();
    let model = "[model]\ntheta = [-0.01, -0.12, -1.7e-5, -10.7, -0.0023]\n\n[plausibility]";
    let changes = [("sample_time = 0.02", "sample_time = 0.001"), ("[plausibility]", model)];
    let config = scratch.config(&changes);
    let words =
        ["at 500000 bit/s the 19 frames of a cycle take at least 0.001140 s", "bus.bitrate"];
    refused(&scratch, &config, 1, "0.001\n", &words);
}

/// Whoever is not told cannot be told: that is no reason to end otherwise.
#[test]
fn standard_error_that_cannot_be_written_changes_nothing() {
    let full = || std::fs::File::create("/dev/full").expect("every Linux has it");
    let code = |arguments: &[&str]| {
        let mut command = support::command(arguments);
        command.stdout(std::process::Stdio::null()).stderr(full());
        command.status().expect("it starts").code()
    };
    assert_eq!(code(&["check", "dbc/e-type.dbc"]), Some(2));
    assert_eq!(code(&["check", "no/such/file.toml"]), Some(2));
    let log = recording("hanging-load.log.gz");
    let fault = ["--fault", "step,cylinder=1,size=0.01"];
    assert_eq!(code(&[&["inject", &log, "--config", HANGING_LOAD][..], &fault].concat()), Some(0));
}

#[test]
fn a_pipe_is_no_configuration_and_no_dbc() {
    let scratch = Scratch::new();
    let config = scratch.config(&[]);
    let dbc = scratch.path("e-type.dbc");
    fs::remove_file(&dbc).expect("it is there");
    let pipe = |path: &str| {
        let made = std::process::Command::new("mkfifo").arg(path).status().expect("it starts");
        assert!(made.success());
    };
    pipe(&dbc);
    check(&config).failed(2, &["the DBC", "it is a pipe or a device, expected a file"]);
    let pipe_of_toml = scratch.path("pipe.toml");
    pipe(&pipe_of_toml);
    check(&pipe_of_toml).failed(2, &[&pipe_of_toml, "it is a pipe or a device"]);
    check("/dev/zero").failed(2, &["/dev/zero", "it is a pipe or a device"]);
}

/// A file that cannot be read is told alike, whether it is a configuration or a recording.
#[test]
fn a_file_that_does_not_exist_is_told_in_one_form() {
    let scratch = Scratch::new();
    let missing = scratch.path("nope.toml");
    let told = format!(
        "tertius: {missing}: cannot be read: No such file or directory (os error 2); give the path of a \
         configuration, for example config/e-type.toml\n"
    );
    assert_eq!(check(&missing).failed(2, &[]).stderr, told);
    assert_eq!(replay(&["nope.log"], &missing, &[]).failed(2, &[]).stderr, told);
    let log = scratch.path("nope.log");
    let run = replay(&[&log], "config/e-type.toml", &[]).failed(2, &["tertius: ", &log]);
    assert_eq!(run.stderr.lines().count(), 1, "{}", run.stderr);
    let run = tertius(&["check", "config/e-type.toml", "--set", "fde.high=no"], b"");
    assert!(run.failed(2, &["tertius: --set fde.high"]).stderr.lines().count() == 1);
}

#[test]
fn a_file_that_is_no_configuration_is_one_problem() {
    let run = check("dbc/e-type.dbc").failed(2, &["tertius: ", "this is a DBC", "bus.dbc"]);
    assert!(!run.stderr.contains("not TOML"), "{}", run.stderr);
    // In the usual encoding of a DBC a degree sign is not UTF-8.
    let latin = fs::read_to_string(top().join("dbc/e-type.dbc")).expect("the DBC");
    let mut latin = latin.replace(|letter: char| !letter.is_ascii(), "?").into_bytes();
    latin.extend(b"\nCM_ \"\xB0\";\n");
    let scratch = Scratch::new();
    let latin = scratch.write("latin.dbc", latin);
    let run = check(&latin).failed(2, &["tertius: ", "this is a DBC", "bus.dbc"]);
    assert!(!run.stderr.contains("UTF-8"), "{}", run.stderr);
    check("README.md").failed(2, &["1 problem", "this is not a configuration", "[machine]"]);
    check("tests/recordings/hanging-load.faults.csv").failed(2, &["1 problem"]);
    // Of a configuration the first places are told where it breaks.
    let rubbish = "this is no line\n".repeat(50);
    let config = scratch.config(&[("[plausibility]", &format!("{rubbish}[plausibility]"))]);
    let run = check(&config).failed(2, &["not TOML"]);
    let told = run.stderr.matches(&format!("[{config}:")).count();
    assert!((1..=5).contains(&told), "{told}: {}", run.stderr);
}

/// 32767 is the overflow of an S7 analogue input. A reading of 24 bits passes it.
#[test]
fn the_code_of_a_broken_wire_belongs_to_a_signal_of_16_bits() {
    let scratch = Scratch::new();
    let dbc = fs::read_to_string(top().join("tests/recordings/hanging-load.dbc")).expect("the DBC");
    let wide = dbc
        .replace("Rig_Transducers: 4", "Rig_Transducers: 6")
        .replace("C1 : 7|16@0+ (0.000108506944444444,-1.5)", "C1 : 7|24@0+ (0.000001,-1.5)")
        .replace("C2 : 23|16@0+ (0.000108506944444444,-1.5)", "C2 : 31|24@0+ (0.000001,-1.5)");
    scratch.write("hanging-load.dbc", wide);
    let config = fs::read_to_string(top().join(HANGING_LOAD)).expect("the configuration");
    let file = scratch.write("wide.toml", &config);
    assert!(!check(&file).ok().stdout.contains("broken_wire"));
    // The rod goes out, through 32767 counts, under a command that moves it.
    let frames: String = (0..400_i64)
        .map(|k| {
            let at = 1_700_000_000_000 + 20 * k;
            let raw = 32767 + 1000 * (k - 200).max(-30);
            let readings =
                format!("({}.{:03}000) can0 201#{raw:06X}{raw:06X}", at / 1000, at % 1000);
            format!("{readings}\n({}.{:03}000) can0 211#00002710\n", at / 1000, at % 1000 + 1)
        })
        .collect();
    let log = scratch.write("wide.log", frames);
    let broken = |config: &str| {
        let warnings = replay(&[&log], config, &[]).ok().warnings();
        warnings.iter().filter(|warning| warning["fault"] == "broken_wire").count()
    };
    assert_eq!(broken(&file), 0);

    // Who asks for it gets it, and is told what it means.
    let asked =
        changed(&config, &[("[plausibility]", "[plausibility]\nbroken_wire_codes = [32767]")]);
    let asked = scratch.write("asked.toml", asked);
    assert!(broken(&asked) > 0);
    let text = check(&asked).ok().stdout;
    let doubt =
        "32767 is -1.4672 m of Rig_Transducers.C1, within its range of -1.49989149305556 to 1.5 m";
    assert!(text.contains("asked.toml: worth a look") && text.contains(doubt), "{text}");
    assert!(text.contains("Rig_Transducers.C2"), "{text}");
}

/// With such an a or b the machine's own rule does not hold on a healthy cylinder.
#[test]
fn readings_that_are_apart_when_they_agree() {
    let scratch = Scratch::new();
    let dbc = fs::read(top().join("tests/recordings/hanging-load.dbc")).expect("the DBC");
    scratch.write("hanging-load.dbc", dbc);
    let config = fs::read_to_string(top().join(HANGING_LOAD)).expect("the configuration");
    let apart = changed(&config, &[("c2_offset = 0.0034", "c2_offset = 0.06")]);
    let text = check(&scratch.write("apart.toml", apart)).ok().stdout;
    assert!(
        text.contains("comparator.critical: C1 − C2 of a healthy cylinder 1 is 0.06"),
        "{text}"
    );
    assert!(
        !check(&scratch.write("near.toml", config)).ok().stdout.contains("comparator.critical")
    );
}

/// As a calibration before it knew the noise by its speed has left it: to be made anew, not by hand.
#[test]
fn a_sequential_table_of_an_earlier_version_is_refused() {
    let scratch = Scratch::new();
    let config = "tests/recordings/hanging-load-sequential.toml";
    let text = fs::read_to_string(top().join(config)).expect("it is there");
    let (before, rest) = text.split_once("\nnoise = ").expect("it has a noise");
    let (_, rest) = rest.split_once("\ntiming = ").expect("it has a timing");
    let (_, after) = rest.split_once('\n').expect("more follows");
    let dbc = format!("dbc = {:?}", top().join("tests/recordings/hanging-load.dbc"));
    let old = format!("{before}\n{after}").replace("dbc = \"hanging-load.dbc\"", &dbc);
    let path = scratch.write("old.toml", old);
    let words = ["[cylinder[0].sequential] lacks `noise`", "a table without it is of an earlier"];
    check(&path).failed(2, &words);
}

#[test]
fn what_wrong_tokens_lead_to_is_told_and_a_token_that_everybody_tries_is_refused() {
    let scratch = Scratch::new();
    let config = scratch.config(&[]);
    let text = fs::read_to_string(&config).expect("it was written");
    let with = |digest: &str| format!("{text}\n[http]\ntoken = \"{digest}\"\nlockout = 60.0\n");
    let random = "8d1d2c4c9f6a1b1be0a6e4a77c6f9b0d5a0fbf2f5e0c4f4f7f0f4a3b2a7d6c19";
    let told = check(&scratch.write("random.toml", with(random))).ok().stdout;
    assert!(
        told.contains(
            "an address waits after each wrong token, and is locked out for 60 s after 10"
        ),
        "{told}"
    );
    // As `printf %s test | sha256sum` has it.
    let test = "9f86d081884c7d659a2feaa0c55ad015a3bf4f1b2b0b822cd15d6c15b0f00a08";
    let words = ["that of \"test\"", "`tertius token` makes a token of 128 random bits"];
    check(&scratch.write("test.toml", with(test))).failed(2, &words);
}
