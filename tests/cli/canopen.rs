//! Signals that are objects of CANopen devices: where `check` finds them, what it says of mistakes, and the same
//! verdicts as with a DBC.

use std::fs;
use tertius_testing::support::{Run, Scratch, changed, replay, tertius, top};

const CONFIG: &str = "config/e-type-canopen.toml";

pub fn shipped(name: &str) -> String {
    fs::read_to_string(top().join(name)).expect("it ships")
}

/// The shipped configuration with `changes`, beside its DBC and the EDS files.
pub fn config(scratch: &Scratch, changes: &[(&str, &str)]) -> String {
    for name in ["e-type-canopen.dbc", "encoder.eds", "valve.eds"] {
        scratch.write(name, shipped(&format!("dbc/{name}")));
    }
    let text = shipped(CONFIG).replace("../dbc/", "");
    scratch.write("machine.toml", changed(&text, changes))
}

fn check(config: &str) -> Run {
    tertius(&["check", config], b"")
}

/// `check` refuses the configuration with these changes, in `words`, and names its place.
#[track_caller]
fn refused(changes: &[(&str, &str)], place: &str, words: &[&str]) {
    let scratch = Scratch::new();
    let config = config(&scratch, changes);
    let run = check(&config).failed(2, words);
    let text = fs::read_to_string(&config).expect("it was written");
    let line = text.split(place).next().expect("a part").lines().count();
    let lines = [line, line + 1].map(|line| run.stderr.contains(&format!("[{config}:{line}:")));
    assert!(lines.contains(&true), "{place:?} is in line {line}:\n{}", run.stderr);
}

#[test]
fn each_object_is_told_with_its_pdo_byte_and_scale() {
    let text = check(CONFIG).ok().stdout;
    for line in [
        "7 messages and 24 of CANopen devices, of which 20 are used",
        "  frames    0x186 0x196 0x526\n",
        "  object    c1 = 0x6020:01 (Position value channel 1; byte 0, 32 bits): TPDO1 of node 6, \
         0x186, 0.000001 m each\n",
        "  object    c2_velocity = 0x6030:01 (Speed value channel 1; byte 4, 16 bits): TPDO1 of node 22, \
         0x196, 0.0001 m/s each\n",
        "  object    c2_status = 0x6400:01 (Work area state channel 1; byte 6, 8 bits): TPDO1 of node 22, \
         0x196, as it is\n",
        "  object    control_speed = 0x6300:01 (Spool position set point: Value; byte 2, 16 bits): RPDO4 of \
         node 38, 0x526, 0.0001220703125 m/s each\n",
    ] {
        assert!(text.contains(line), "{line:?} is not in\n{text}");
    }
    let (_, doubts) = text.split_once("worth a look\n").expect("it is not calibrated");
    assert!(doubts.trim().lines().count() == 1 && doubts.contains("not calibrated"), "{doubts}");
}

/// By which frames the devices of cylinder 3 tell of themselves, with changes of the encoder's EDS.
fn devices_told(changes: &[(&str, &str)], sheet: &[(&str, &str)]) -> Vec<String> {
    let scratch = Scratch::new();
    let config = config(&scratch, changes);
    scratch.write("encoder.eds", changed(&shipped("dbc/encoder.eds"), sheet));
    let text = check(&config).ok().stdout;
    let of_third = text.split("\ncylinder ").nth(3).expect("it has three");
    let lines = of_third.lines().filter_map(|line| line.strip_prefix("  device    "));
    lines.map(str::to_owned).collect()
}

#[test]
fn each_device_is_told_with_the_frames_by_which_it_tells_of_itself() {
    let c1 = |lost: &str| format!("c1 = node 3: emergencies 0x083, heartbeats 0x703, {lost}");
    let told = devices_told(&[], &[]);
    assert_eq!(told.len(), 3, "{told:?}");
    assert_eq!(told[0], c1("which may stop"));
    assert!(
        told[2].starts_with("valve = node 35: emergencies 0x0A3, heartbeats 0x723, "),
        "{told:?}"
    );
    // 1.5 times as long as the EDS says, in whole cycles.
    let heartbeat = "ParameterName=Producer heartbeat time\nObjectType=0x7\nDataType=0x0006\n\
                     AccessType=rw\nPDOMapping=0\nDefaultValue=";
    let beats = (format!("{heartbeat}0"), format!("{heartbeat}250"));
    let beats = [(beats.0.as_str(), beats.1.as_str())];
    assert_eq!(devices_told(&[], &beats)[0], c1("lost after 0.38 s without one"));
    let node = "node = 3\nkind = \"transducer\"";
    for (key, lost) in [("2.0", "lost after 2.00 s without one"), ("0", "which may stop")] {
        let own = format!("heartbeat = {key}\n{node}");
        assert_eq!(devices_told(&[(node, &own)], &beats)[0], c1(lost));
    }
    let none =
        devices_told(&[], &[("DefaultValue=$NODEID+0x80\n", "DefaultValue=$NODEID+0x80000080\n")]);
    assert_eq!(none[0], "c1 = node 3: emergencies none, heartbeats 0x703, which may stop");
}

#[test]
fn an_identifier_of_two_inputs_is_refused() {
    for (id, words) in [
        ("0x1C1", "0x1C1 is the identifier of node 1's emergency messages and of another input"),
        ("0x181", "0x181 is the identifier of node 1's emergency messages and of another input"),
        ("0x703", "0x703 is the identifier of node 17's emergency messages and of another"),
        ("0x1D1", "identifier 0x1D1 is the gateway's own and also an input"),
    ] {
        let scratch = Scratch::new();
        let config = config(&scratch, &[]);
        let text = changed(&shipped("dbc/encoder.eds"), &[("$NODEID+0x80\n", &format!("{id}\n"))]);
        scratch.write("encoder.eds", text);
        check(&config).failed(2, &[words]);
    }
}

#[test]
fn a_transducer_has_no_full_speed() {
    let eds = "role = \"c1\"\neds = \"encoder.eds\"\n\n[[canopen.device]]\nnode = 17";
    let with = eds.replacen("\n\n", "\nfull_speed = 2.0\n\n", 1);
    let words = ["number 1 is a transducer with `full_speed`", "a valve's full set point"];
    refused(&[(eds, &with)], "full_speed", &words);
}

/// The shipped configuration, calibrated, whose transducers have a heartbeat of 100 ms.
fn beating(scratch: &Scratch) -> String {
    let config = config(scratch, &[]);
    let simulated = shipped("config/e-type-simulated.toml");
    let corrections = simulated.find("[[cylinder]]").expect("it has them");
    let text = scratch.read("machine.toml") + &simulated[corrections..];
    scratch.write("machine.toml", text);
    let time = |value: &str| {
        format!(
            "heartbeat time\nObjectType=0x7\nDataType=0x0006\nAccessType=rw\nPDOMapping=0\nDefaultValue={value}\n"
        )
    };
    let sheet = changed(&shipped("dbc/encoder.eds"), &[(&time("0"), &time("100"))]);
    scratch.write("encoder.eds", sheet);
    config
}

#[test]
fn simulated_devices_tell_of_themselves_as_their_eds_has_it() {
    let scratch = Scratch::new();
    let config = beating(&scratch);
    let log = scratch.path("machine.log");
    let mut arguments = vec!["simulate", "--config", &config, "--duration", "15", "--seed", "3"];
    let faults = [
        "broken_wire,cylinder=3,sensor=c1_emergency,at=4,until=5",
        "broken_wire,cylinder=6,sensor=valve_emergency,at=8,until=8.5,code=16912",
        "loss,cylinder=2,sensor=c2_heartbeat,at=6,until=7",
        "loss,cylinder=5,sensor=c1,at=9,until=11",
        "out_of_range,cylinder=5,sensor=c1_heartbeat,at=9,until=11",
    ];
    arguments.extend(faults.iter().flat_map(|fault| ["--fault", fault]));
    arguments.extend(["--output", &log]);
    tertius(&arguments, b"").ok();
    let text = scratch.read("machine.log");
    let count = |wire: &str| text.lines().filter(|line| line.contains(wire)).count();
    assert!((149..=150).contains(&count(" 701#05")), "{}", count(" 701#05"));
    assert!((139..=140).contains(&count(" 712#05")), "{}", count(" 712#05"));
    assert_eq!((count(" 721#"), count(" 705#7F")), (0, 20), "the valves' EDS has none");
    assert_eq!([count(" 083#0050"), count(" 083#0000"), count(" 0A6#1042")], [1, 1, 1]);
    let lines = replay(&[&log], &config, &[]).ok().lines();
    let told =
        lines.iter().filter(|line| line["type"] == "warning" || line["notice"] == "device_state");
    let told = told.map(|line| {
        let word = |key: &str| line[key].as_str().unwrap_or_default().to_owned();
        let device = &line["device"];
        let said = device.get("words").or(device.get("reason")).or(line.get("state"));
        let said = said.and_then(|said| said.as_str()).unwrap_or_default();
        (
            line["cylinder"].as_u64().expect("a number"),
            word("state"),
            word("suspect"),
            said.to_owned(),
        )
    });
    let told: Vec<_> = told.collect();
    let line = |cylinder, state: &str, suspect: &str, said: &str| {
        (cylinder, state.to_owned(), suspect.to_owned(), said.to_owned())
    };
    let expected = [
        line(3, "raised", "c1", "device hardware"),
        line(3, "cleared", "c1", "device hardware"),
        line(2, "raised", "c2", "heartbeat_lost"),
        line(6, "raised", "process", "device temperature"),
        line(2, "cleared", "c2", "heartbeat_lost"),
        line(5, "pre-operational", "", "pre-operational"),
        line(6, "cleared", "process", "device temperature"),
        line(5, "operational", "", "operational"),
    ];
    assert_eq!(told, expected);
    let page = tertius(&["replay", &log, "--config", &config], b"").ok().stdout;
    let page = page.split_whitespace().collect::<Vec<_>>().join(" ");
    for words in [
        "C1's device: node 3 says EMCY 0x5000: device hardware",
        "C2's device: node 18 has lost its heartbeat",
        "cylinder 5: node 5 (C1) is pre-operational, not operational: it sends no readings",
    ] {
        assert!(page.contains(words), "{words:?} is not in\n{page}");
    }
}

#[test]
fn what_no_device_says_cannot_be_wrong() {
    let spec = "loss,cylinder=1,sensor=c1_heartbeat";
    let call = ["simulate", "--config", "config/e-type.toml", "--duration", "1", "--fault", spec];
    let words = ["no device of cylinder 1 has a c1_heartbeat", "[[canopen.device]]"];
    tertius(&call, b"").failed(2, &words);
}

/// Faults of each kind on four cylinders.
const FAULTS: [&str; 5] = [
    "step,cylinder=3,sensor=c1,at=30,size=0.0025",
    "incipient,cylinder=5,sensor=c2,at=40,size=0.004",
    "loss,cylinder=2,sensor=c1,at=50",
    "freeze,cylinder=1,sensor=c2,at=35",
    "noise,cylinder=6,sensor=c2,at=20,size=0.0015",
];

/// A warning as it is told, in its cycle: cycle, cylinder, detector, fault, suspect, level, state.
type Told = (u64, u64, [String; 5]);

fn story(scratch: &Scratch, config: &str) -> Vec<Told> {
    let log = scratch.path("story.log");
    let mut arguments = vec!["simulate", "--config", config, "--duration", "60", "--seed", "1"];
    arguments.extend(FAULTS.iter().flat_map(|fault| ["--fault", fault]));
    arguments.extend(["--output", &log, "--force"]);
    tertius(&arguments, b"").ok();
    let told = replay(&[&log], config, &[]).ok().warnings().into_iter().map(|warning| {
        let cycle = warning["t"].as_f64().expect("a time") / 0.02;
        let word = |key: &str| warning[key].as_str().expect("a word").to_owned();
        let words = ["detector", "fault", "suspect", "level", "state"].map(word);
        (cycle as u64, warning["cylinder"].as_u64().expect("a number"), words)
    });
    let mut told: Vec<Told> = told.collect();
    told.sort();
    told
}

#[test]
fn the_same_faults_lead_to_the_same_verdicts_as_with_a_dbc() {
    let scratch = Scratch::new();
    let simulated = shipped("config/e-type-simulated.toml");
    let corrections = simulated.find("[[cylinder]]").expect("it has them");
    let canopen = config(&scratch, &[]);
    let text = scratch.read("machine.toml") + &simulated[corrections..];
    scratch.write("machine.toml", text);
    let objects = story(&scratch, &canopen);
    let signals = story(&scratch, "config/e-type-simulated.toml");
    assert_eq!(objects, signals);
    assert!(objects.len() >= 12, "{objects:?}");
}

#[test]
fn a_dbc_and_objects_may_be_mixed() {
    let scratch = Scratch::new();
    let config = config(
        &scratch,
        &[
            ("\"object 0x6300:01\"", "\"Cyl{n}_Valve.ControlSpeed\""),
            ("spool = \"object 0x6301:01\"", "spool = \"Cyl{n}_Valve.SpoolPosition\""),
        ],
    );
    let text = scratch.read("machine.toml");
    // Without the valves, whose frames the DBC has.
    let devices: Vec<&str> = text.split("\n[[canopen.device]]\n").collect();
    let kept = devices.into_iter().filter(|it| !it.contains("kind = \"valve\""));
    scratch.write("machine.toml", kept.collect::<Vec<_>>().join("\n[[canopen.device]]\n"));
    let whole = shipped("dbc/e-type.dbc");
    let valves: Vec<&str> = whole.split("\n\n").filter(|it| it.contains("_Valve: 8")).collect();
    assert_eq!(valves.len(), 6);
    let dbc = changed(
        &scratch.read("e-type-canopen.dbc"),
        &[("BO_ 449 Plc_State", &format!("{}\n\nBO_ 449 Plc_State", valves.join("\n\n")))],
    );
    scratch.write("e-type-canopen.dbc", dbc);
    let text = check(&config).ok().stdout;
    assert!(text.contains("13 messages and 12 of CANopen devices, of which 20"), "{text}");
    assert!(text.contains("  frames    0x181 0x191 0x1A1\n"), "{text}");
}

/// One node with two sensors is both transducers of its cylinder.
#[test]
fn one_node_may_be_two_transducers() {
    let scratch = Scratch::new();
    let config = config(
        &scratch,
        &[
            ("c2 = \"object 0x6020:01\"", "c2 = \"object 0x6020:02\""),
            ("c1_velocity", "# "),
            ("c2_velocity", "# "),
        ],
    );
    let text = scratch.read("machine.toml").replace("c1_status", "# ").replace("c2_status", "# ");
    let text = (17..23).fold(text, |text, node| {
        changed(&text, &[(&format!("node = {node}\n"), &format!("node = {}\n", node - 16))])
    });
    scratch.write("machine.toml", text);
    let eds = scratch.read("encoder.eds");
    let second =
        eds.find("[6020sub1]").map(|at| &eds[at..]).and_then(|rest| rest.split("\n\n").next());
    let second = second.expect("it has one").replace("[6020sub1]", "[6020sub2]");
    let eds =
        eds.replace("0x60300110", "0x60200220").replace("DefaultValue=3\n", "DefaultValue=2\n");
    scratch.write("encoder.eds", format!("{eds}\n{second}\n"));
    let text = check(&config).ok().stdout;
    assert!(text.contains("  frames    0x181 0x521\n"), "{text}");
    assert!(
        text.contains(
            "c1 = 0x6020:01 (Position value channel 1; byte 0, 32 bits): TPDO1 of node 1,"
        ),
        "{text}"
    );
    assert!(
        text.contains(
            "c2 = 0x6020:02 (Position value channel 1; byte 4, 32 bits): TPDO1 of node 1,"
        ),
        "{text}"
    );
}

#[test]
fn objects_that_no_device_has() {
    refused(
        &[("c1 = \"object 0x6020:01\" ", "c1 = \"object 0x6021:01\" ")],
        "0x6021",
        &[
            "no PDO of c1 of cylinder 1 carries object 0x6021:01",
            "they carry 0x6020:01, 0x6030:01, 0x6400:01",
        ],
    );
    refused(
        &[("c1 = \"object 0x6020:01\" ", "c1 = \"object 6020sub1\" ")],
        "6020sub1",
        &["of the form object 0xINDEX:SUB", "for example object 0x6020:01"],
    );
    refused(
        &[
            ("c1 = \"object 0x6020:01\" ", "c1 = \"object 0x6400:01\" "),
            ("c1_status = \"object 0x6400:01\"", "#"),
        ],
        "0x6400",
        &["is in \"bits\", expected \"m\""],
    );
    // A speed where a length is expected.
    refused(
        &[
            ("c1 = \"object 0x6020:01\" ", "c1 = \"object 0x6030:01\" "),
            ("c1_velocity = \"object 0x6030:01\"", "#"),
        ],
        "0x6030",
        &["is in \"m/s\", expected \"m\""],
    );
}

#[test]
fn devices_that_do_not_fit() {
    let (first, valve) = ("node = 1\nkind = \"transducer\"\ncylinder = 1\n", "node = 33\n");
    let transducer = |node: u8, cylinder: u8| {
        format!("node = {node}\nkind = \"transducer\"\ncylinder = {cylinder}\n")
    };
    for (from, to, place, words) in [
        (
            first,
            transducer(81, 1),
            "81\nkind",
            &["`canopen.device[0].node` is 81, which is the gateway's own"][..],
        ),
        (
            first,
            transducer(1, 2),
            "\"object 0x6020:01\"  ",
            &["no [[canopen.device]] is role = \"c1\" of cylinder 1"],
        ),
        (
            first,
            transducer(1, 2),
            "2\nrole = \"c1\"\neds = \"encoder.eds\"\n\n[[canopen.device]]\nnode = 18",
            &["[[canopen.device]] number 4 is c1 of cylinder 2, as is number 1"],
        ),
        (first, transducer(128, 1), "128", &["128", "CANopen has the node-IDs 1 to 127"]),
        (
            first,
            first.replace("transducer", "pump"),
            "\"pump\"",
            &["\"pump\"", "transducer", "valve"],
        ),
        (
            valve,
            "node = 17\n".to_owned(),
            "17\nkind = \"valve\"",
            &["`canopen.device[2].node` is 17, as is another device's"],
        ),
        (
            valve,
            "node = 33\nrole = \"c2\"\n".to_owned(),
            "\"c2\"\nkind = \"valve\"",
            &["[[canopen.device]] number 3 is a valve with `role`"],
        ),
    ] {
        refused(&[(from, &to)], place, words);
    }
}

#[test]
fn files_that_do_not_fit() {
    let eds = "role = \"c1\"\neds = \"encoder.eds\"";
    let first = |name: &str| {
        let text = shipped(CONFIG).replace("../dbc/", "");
        text.replacen(eds, &format!("role = \"c1\"\neds = \"{name}\""), 1)
    };
    let refused = |name: &str, content: Option<String>, words: &[&str]| {
        let scratch = Scratch::new();
        let config = config(&scratch, &[]);
        scratch.write("machine.toml", first(name));
        if let Some(content) = content {
            scratch.write(name, content);
        }
        let run = check(&config).failed(2, words);
        assert!(run.stderr.contains(&format!("[{config}:")), "{}", run.stderr);
    };
    let encoder = shipped("dbc/encoder.eds");
    let with = |from: &str, to: &str| Some(changed(&encoder, &[(from, to)]));
    refused("none.eds", None, &["none.eds cannot be read", "`eds` is relative to the folder"]);
    refused("other.eds", Some("[DeviceInfo]\n".to_owned()), &["there is no object"]);
    refused("valve.eds", None, &["valve.eds is of a device of profile 408", "profile CiA 406"]);
    refused(
        "off.eds",
        with("$NODEID+0x180", "$NODEID+0x80000180"),
        &["no PDO of c1 of cylinder 1 carries object 0x6020:01", "TPDO1: it is off: bit 31"],
    );
    refused(
        "taken.eds",
        with("$NODEID+0x180", "0x1C1"),
        &["TPDO1 of node 1 has the identifier 0x1C1, as has Plc_State"],
    );
    refused(
        "stepless.eds",
        Some(encoder.replace("DefaultValue=1000\n", "")),
        &["0x6020:01 cannot be used: its scale, object 0x6005:01, has no value above 0"],
    );
    refused(
        "placed.dcf",
        with("[MandatoryObjects]", "[DeviceComissioning]\nNodeID=9\n\n[MandatoryObjects]"),
        &["`node` is 1, but placed.dcf is the DCF of node 9"],
    );
}

#[test]
fn findings_of_an_eds_are_told() {
    let scratch = Scratch::new();
    let config = config(&scratch, &[]);
    let eds = scratch.read("encoder.eds").replace("SubNumber=0x5", "SubNumber=0x6");
    scratch.write("encoder.eds", eds);
    let text = check(&config).ok().stdout;
    assert!(text.contains("encoder.eds: worth a look\n  line "), "{text}");
    assert!(text.contains("SubNumber is 6, and 5 sub-objects follow"), "{text}");
}
