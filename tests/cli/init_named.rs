//! `tertius init` on a machine whose cylinders have names, and on one that measures in millimetres.

use std::fmt::Write as _;
use std::fs;
use tertius::config::{self, Settings};
use tertius_testing::support::{Run, Scratch, changed, replay, tertius, top};

const DBC: &str = "dbc/e-type.dbc";
const NAMES: [&str; 6] = ["FwdPort", "FwdStbd", "MidPort", "MidStbd", "AftPort", "AftStbd"];

fn settings(text: &str) -> Settings {
    config::parse("proposed.toml", text).unwrap_or_else(|error| panic!("{error}\n{text}")).0
}

fn init(dbc: &str, log: &str) -> Run {
    tertius(&["init", dbc, log], b"").ok()
}

/// The machine's DBC with these names of its cylinders. The command travels alone; spool and pressures are in a message
/// of their own, which has the valve's identifier and 0x100.
fn renamed(names: [&str; 6]) -> String {
    let text = fs::read_to_string(top().join(DBC)).expect("it is there");
    let mut lines = String::new();
    let mut servo = None;
    for line in text.lines() {
        let keyword = line.split_whitespace().next().unwrap_or_default();
        if ["CM_", "BA_"].contains(&keyword) || keyword == "VAL_" && !line.starts_with("VAL_ 449") {
            continue;
        }
        if keyword == "BO_" {
            servo = (1..=6).find(|n| line.contains(&format!("Cyl{n}_Valve")));
        }
        let mut line = line.replace("SupplyPressure", "AccuPress");
        line = line.replace("PressureBottom", "CapPress").replace("PressureRod", "RodPress");
        for (n, name) in (1..).zip(names) {
            line = line.replace(&format!(" Cyl{n}_C1:"), &format!(" {name}_Main:"));
            line = line.replace(&format!(" Cyl{n}_C2:"), &format!(" {name}_Back:"));
            line = line.replace(&format!(" Cyl{n}_Valve:"), &format!(" {name}_Servo:"));
        }
        lines += &(line.clone() + "\n");
        if let Some(n) = servo.filter(|_| line.contains(" ControlSpeed ")) {
            let name = names[n - 1];
            _ = writeln!(lines, "\nBO_ {} {name}_Hyd: 8 Valve{n}", 416 + 256 + n);
        }
    }
    lines
}

/// Half a minute of the machine, with the messages of [`renamed`].
fn recorded(scratch: &Scratch) -> String {
    let log = scratch.path("machine.log");
    let config = "config/e-type-simulated.toml";
    let call =
        ["simulate", "--config", config, "--duration", "30", "--seed", "1", "--output", &log];
    tertius(&call, b"").ok();
    let mut lines = String::new();
    for line in scratch.read("machine.log").lines() {
        _ = writeln!(lines, "{line}");
        if let Some((before, valve)) = line.split_once(" 1A") {
            _ = writeln!(lines, "{before} 2A{valve}");
        }
    }
    scratch.write("renamed.log", lines)
}

#[test]
fn spool_pressures_and_supply_of_cylinders_with_names_are_found() {
    let scratch = Scratch::new();
    let log = recorded(&scratch);
    for (file, names) in
        [("named.dbc", NAMES), ("numbered.dbc", ["Ram1", "Ram2", "Ram3", "Ram4", "Ram5", "Ram6"])]
    {
        let run = init(&scratch.write(file, renamed(names)), &log);
        let found = settings(&run.stdout);
        let signals = &found.signals.cylinder;
        let of = |pattern: &str, n: u8| config::settings::CylinderSignals::of_cylinder(pattern, n);
        for (n, name) in (1..).zip(names) {
            assert_eq!(of(&signals.c1, n), format!("{name}_Main.Position"));
            assert_eq!(of(&signals.control_speed, n), format!("{name}_Servo.ControlSpeed"));
            for (key, signal) in [
                (&signals.spool, "SpoolPosition"),
                (&signals.pressure_bottom, "CapPress"),
                (&signals.pressure_rod, "RodPress"),
            ] {
                let found = key.as_ref().unwrap_or_else(|| panic!("no {signal}: {}", run.stderr));
                assert_eq!(of(found, n), format!("{name}_Hyd.{signal}"));
            }
        }
        assert_eq!(found.signals.supply.as_deref(), Some("Plc_State.AccuPress"));
        // Names that differ by numbers say no more than the numbers.
        let is_named = names == NAMES;
        for (n, name) in (1_u8..).zip(names) {
            assert_eq!(found.names().of_cylinder(n), Some(name).filter(|_| is_named));
        }
        assert_eq!(run.stderr.contains("cylinder.name"), is_named, "{}", run.stderr);
    }
}

/// The machine's DBC in millimetres, and its valves' pressures in MPa.
fn in_millimetres() -> String {
    let text = fs::read_to_string(top().join(DBC)).expect("it is there");
    let mut lines = String::new();
    for line in text.lines() {
        let own =
            line.contains("Fd_") || line.contains("Position : 32|16") || line.contains("Sigma");
        let of = [
            ("Position : ", "\"m\"", "\"mm\"", 1e3),
            ("Velocity : ", "\"m/s\"", "\"mm/s\"", 1e3),
            ("ControlSpeed : ", "\"m/s\"", "\"mm/s\"", 1e3),
            ("Pressure", "\"bar\"", "\"MPa\"", 0.1),
        ];
        let found = of.iter().find(|(name, unit, ..)| line.contains(name) && line.contains(unit));
        let Some((_, from, to, times)) = found.filter(|_| !own) else {
            lines += &(line.to_owned() + "\n");
            continue;
        };
        let (before, rest) = line.split_once('(').expect("a factor");
        let (factor, rest) = rest.split_once(',').expect("an offset");
        let (offset, rest) = rest.split_once(") [").expect("a range");
        let (low, rest) = rest.split_once('|').expect("two ends");
        let (high, rest) = rest.split_once(']').expect("its end");
        let [factor, offset, low, high] =
            [factor, offset, low, high].map(|it| it.parse::<f64>().expect("a number") * times);
        let rest = rest.replace(from, to);
        _ = writeln!(lines, "{before}({factor:?},{offset:?}) [{low:?}|{high:?}]{rest}");
    }
    lines
}

#[test]
fn millimetres_are_read_as_metres_with_the_maker_s_dbc() {
    let scratch = Scratch::new();
    let log = scratch.path("machine.log");
    let config = "config/e-type-simulated.toml";
    let fault = "drift,cylinder=2,sensor=c1,rate=0.002,at=10";
    let call = ["simulate", "--config", config, "--duration", "30", "--seed", "1"];
    tertius(&[&call[..], &["--fault", fault, "--output", &log]].concat(), b"").ok();

    let dbc = scratch.write("mm.dbc", in_millimetres());
    let text = fs::read_to_string(top().join(config)).expect("it ships");
    let maker = scratch.write("mm.toml", changed(&text, &[("../dbc/e-type.dbc", "mm.dbc")]));
    let told = tertius(&["check", &maker], b"").ok().stdout;
    for line in [
        "Cyl1_C1.Position and 11 more in \"mm\" are read in \"m\"\n",
        "Cyl1_C1.Velocity and 17 more in \"mm/s\" are read in \"m/s\"\n",
        "Cyl1_Valve.PressureBottom and 12 more in \"MPa\" are read in \"bar\"\n",
    ] {
        assert!(told.contains(line), "{line:?} is not in\n{told}");
    }
    let [ours, theirs] = [config, &maker].map(|config| replay(&[&log], config, &[]).ok());
    assert_eq!(ours.incidents(), theirs.incidents());
    assert!(!ours.incidents().is_empty());
    // Frames are written in its units, too.
    let again = scratch.path("again.log");
    let call = ["simulate", "--config", &maker, "--duration", "30", "--seed", "1"];
    tertius(&[&call[..], &["--fault", fault, "--output", &again]].concat(), b"").ok();
    assert_eq!(scratch.read("machine.log"), scratch.read("again.log"));

    let run = init(&dbc, &log);
    let found = settings(&run.stdout);
    assert_eq!(found.machine.stroke, [-1.5, 1.5]);
    assert_eq!(found.signals.cylinder.c1, "Cyl{n}_C1.Position");
    assert!(!run.stderr.contains("scale factor"), "{}", run.stderr);
}
