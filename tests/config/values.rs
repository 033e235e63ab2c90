//! Values that are out of range or contradict each other.

use crate::common::{self, EXAMPLE, broken, refusal, refused};
use tertius::appliance::http::TokenDigest;
use tertius::config::settings::CylinderSignals;

#[test]
fn values_out_of_range_say_why() {
    for (from, to, start, help) in [
        (
            "cylinders = 6",
            "cylinders = 7",
            "3:13: `machine.cylinders` is 7, but must be 1 to 6",
            "Fd_Status",
        ),
        (
            "cylinders = 6",
            "cylinders = -1",
            "3:13: `machine.cylinders` is -1, but must be 1 to 6",
            "Fd_Status",
        ),
        (
            "sample_time = 0.02",
            "sample_time = 0",
            "4:15: `machine.sample_time` is 0, but must be at least 0.001 and at most 1",
            "SYNC",
        ),
        (
            "sample_time = 0.02",
            "sample_time = nan",
            "4:15: `machine.sample_time` is nan, but must be at least 0.001 and at most 1",
            "SYNC",
        ),
        (
            "sample_time = 0.02",
            "sample_time = 1.001",
            "4:15: `machine.sample_time` is 1.001, but",
            "SYNC",
        ),
        (
            "sample_time = 0.02",
            "sample_time = 1e-6",
            "4:15: `machine.sample_time` is 1e-6, but must be at least 0.001",
            "one that waits is in the next cycle",
        ),
        (
            "stroke = [-1.5, 1.5]",
            "stroke = [-1.5, inf]",
            "5:17: `machine.stroke[1]` is inf, but must be a finite number",
            "reach",
        ),
        (
            "stroke = [-1.5, 1.5]",
            "stroke = [1e400, 1.5]",
            "5:11: `machine.stroke[0]` is 1e400, but must be a finite number",
            "reach",
        ),
        (
            "stroke = [-1.5, 1.5]",
            "stroke = [-1.5, 99999999999999999999]",
            "5:17: `machine.stroke[1]` is 99999999999999999999, but",
            "reach",
        ),
        (
            "[\"engaged\"]",
            "[\" \"]",
            "6:21: `machine.monitored_states[0]` is \" \", but must be not empty",
            "people",
        ),
        (
            "[bus]",
            "max_gap = 60.5\n[bus]",
            "8:11: `machine.max_gap` is 60.5, but must be at least 0 and at most 60",
            "guessing",
        ),
        ("[bus]", "max_gap = -1e-9\n[bus]", "8:11: `machine.max_gap` is -1e-9, but", "guessing"),
        ("\"Ampelmann E-type\"", "\"\"", "2:8: `machine.name` is \"\", but must be not empty", ""),
        ("\"can0\"", "\"\"", "9:13: `bus.interface` is \"\", but must be not empty", "ip link"),
        (
            "\"can0\"",
            "\"sixteen-bytes-00\"",
            "9:13: `bus.interface` is \"sixteen-bytes-00\", but must be at most 15 bytes long",
            "ip link",
        ),
        (
            "\"can0\"",
            "\"can 0\"",
            "9:13: `bus.interface` is \"can 0\", but must be without spaces",
            "ip link",
        ),
        (
            "\"../dbc/e-type.dbc\"",
            "\"\"",
            "10:7: `bus.dbc` is \"\", but must be not empty",
            "relative",
        ),
        (
            "\"Sync\"",
            "\"Sync.Counter\"",
            "13:8: `signals.sync` is \"Sync.Counter\", but must be the bare name of a message",
            "without a signal",
        ),
        (
            "Plc_State.PlatformState",
            "PlatformState",
            "14:9: `signals.state` is \"PlatformState\", but must be of the form MESSAGE.SIGNAL",
            "DBC",
        ),
        (
            "Plc_State.PlatformState",
            "Plc{n}.State",
            "14:9: `signals.state` is \"Plc{n}.State\", but must be one signal for the whole machine",
            "DBC",
        ),
        (
            "Cyl{n}_C1.Position",
            "Cyl{n}_C1.Position.x",
            "17:6: `signals.cylinder.c1` is \"Cyl{n}_C1.Position.x\", but must be of the form",
            "{n} is replaced",
        ),
        (
            "Cyl{n}_C1.Position",
            "Cyl{m}_C1.Position",
            "17:6: `signals.cylinder.c1` is \"Cyl{m}_C1.Position\", but must be of the form",
            "{n} is replaced",
        ),
        (
            "Cyl{n}_C1.Position",
            ".Position",
            "17:6: `signals.cylinder.c1` is \".Position\", but must be of the form",
            "{n} is replaced",
        ),
        (
            "gamma = [0.0926, 6.5427]",
            "gamma = [0.0926, -inf]",
            "27:18: `model.gamma[1]` is -inf, but must be a finite number",
            "computed",
        ),
        (
            "[1e-8, 1e-3, 100.0]",
            "[1e-8, -1e-3, 100.0]",
            "30:12: `observer.q[1]` is -1e-3, but must be at least 0 and finite",
            "variance",
        ),
        (
            "[1e-8, 1e-2]",
            "[0, 1e-2]",
            "31:6: `observer.r[0]` is 0, but must be above 0 and finite",
            "noise",
        ),
        (
            "[1e-8, 1e-2]",
            "[1e-8, 1e-2]\nsettle = 601",
            "32:10: `observer.settle` is 601, but must be at least 0 and at most 600",
            "seconds",
        ),
        ("low = 7.5e-4", "low = 0.0", "34:7: `fde.low` is 0.0, but must be above 0", "metres"),
        ("high = 1.0e-3", "high = -inf", "35:8: `fde.high` is -inf, but must be above 0", "metres"),
        (
            "bound = 1.5e-3",
            "bound = 0.0",
            "38:9: `comparator.bound` is 0.0, but must be above 0",
            "metres",
        ),
        (
            "critical = 0.05",
            "critical = inf",
            "39:12: `comparator.critical` is inf, but must be above 0 and finite",
            "metres",
        ),
        (
            "[model]",
            "[plausibility]\nstale = 0\n[model]",
            "26:9: `plausibility.stale` is 0, but must be above 0",
            "seconds",
        ),
        (
            "[model]",
            "[plausibility]\nfrozen_speed = -0.02\n[model]",
            "26:16: `plausibility.frozen_speed` is -0.02, but must be at least 0",
            "metres per second",
        ),
        (
            "[model]",
            "[plausibility]\nstatus_mask = -1\n[model]",
            "26:15: `plausibility.status_mask` is -1, but must be 0 to 18446744073709551615",
            "bits",
        ),
        (
            "[model]",
            "[plausibility]\nbroken_wire_codes = [9223372036854775808]\n[model]",
            "26:22: `plausibility.broken_wire_codes[0]` is 9223372036854775808, but must be",
            "raw",
        ),
        (
            "[model]",
            "[alarm]\nclear = -1\n[model]",
            "26:9: `alarm.clear` is -1, but must be at least 0",
            "seconds",
        ),
        (
            "[model]",
            "[alarm]\ncoincidence = nan\n[model]",
            "26:15: `alarm.coincidence` is nan, but must be at least 0",
            "seconds",
        ),
        (
            "[model]",
            "[alarm.levels]\nboth = \"Rd\"\n[model]",
            "26:8: `alarm.levels.both` is \"Rd\", but must be one of none, yellow, orange, red, black",
            "the nearest is red",
        ),
        (
            "[model]",
            "[alarm.levels]\nboth = \"amber\"\n[model]",
            "26:8: `alarm.levels.both` is \"amber\", but must be one of none, yellow, orange, red, black",
            "neither transducer can be relied on; for example both = ",
        ),
        (
            "[model]",
            "[gateway]\nnode = 0\n[model]",
            "26:8: `gateway.node` is 0, but must be 1 to 127",
            "CANopen",
        ),
        (
            "[model]",
            "[gateway]\nnode = 128\n[model]",
            "26:8: `gateway.node` is 128, but must be 1 to 127",
            "CANopen",
        ),
        (
            "\nn = 1\n",
            "\nn = 0\n",
            "42:5: `cylinder[0].n` is 0, but must be 1 to 6",
            "machine.cylinders",
        ),
        (
            "c2_gain = 1.0 ",
            "c2_gain = 0 ",
            "43:11: `cylinder[0].c2_gain` is 0, but must be at least 0.5 and at most 2",
            "same stroke",
        ),
        (
            "c2_offset = 0.0 ",
            "c2_offset = nan ",
            "44:13: `cylinder[0].c2_offset` is nan, but must be a finite number",
            "nan",
        ),
        (
            "c2_offset = 0.0 ",
            "theta = [1, 2, 3, 4, nan] ",
            "44:22: `cylinder[0].theta[4]` is nan, but must be a finite number",
            "nan",
        ),
    ] {
        refused(from, to, start, help);
    }
}

#[test]
fn values_that_contradict_each_other_are_refused() {
    for (from, to, start, help) in [
        (
            "stroke = [-1.5, 1.5]",
            "stroke = [1.5, -1.5]",
            "5:10: `machine.stroke` runs from 1.5 to -1.5",
            "retracted",
        ),
        (
            "stroke = [-1.5, 1.5]",
            "stroke = [1.5, 1.5]",
            "5:10: `machine.stroke` runs from 1.5 to 1.5",
            "retracted",
        ),
        (
            "[bus]",
            "cycle_deadline = 0.02\n[bus]",
            "8:18: `machine.cycle_deadline` is 0.02, but",
            "late",
        ),
        (
            "[bus]",
            "cycle_deadline = 0.0099\n[bus]",
            "8:18: `machine.cycle_deadline` is 0.0099, but",
            "late",
        ),
        (
            "low = 7.5e-4",
            "low = 1.1e-3",
            "34:7: `fde.low` is 0.0011, but must not be above `fde.high`, 0.001",
            "clears",
        ),
        (
            "low = 7.5e-4\nhigh = 1.0e-3",
            "high = 5e-4",
            "34:8: `fde.low` is 0.00075 (the default), but must not be above `fde.high`, 0.0005",
            "clears",
        ),
        (
            "critical = 0.05",
            "critical = 0.05\nlow = 1.6e-3",
            "40:7: `comparator.low` is 0.0016, but must not be above `comparator.bound`, 0.0015",
            "clears",
        ),
        (
            "bound = 1.5e-3",
            "bound = 0.05",
            "38:9: `comparator.bound` is 0.05, but must be below `comparator.critical`, 0.05",
            "trips",
        ),
        (
            "critical = 0.05\n",
            "critical = 0.05\n[sequential]\nmaintenance = 0.05\n",
            "41:15: `sequential.maintenance` is 0.05, but must be below `comparator.critical`, 0.05",
            "without the key",
        ),
        (
            "bound = 1.5e-3\ncritical = 0.05",
            "critical = 1e-3",
            "38:12: `comparator.bound` is 0.0015 (the default), but",
            "trips",
        ),
        (
            "[model]",
            "[plausibility]\nstale = 0.019\n[model]",
            "26:9: `plausibility.stale` is 0.019, but must be at least the sample time 0.02",
            "sample",
        ),
        (
            "[model]",
            "[plausibility]\nfrozen = 0.019\n[model]",
            "26:10: `plausibility.frozen` is 0.019, but must be at least the sample time 0.02",
            "sample",
        ),
        (
            "[model]",
            "[plausibility]\nvalid_raw = [27648, 1]\n[model]",
            "26:13: `plausibility.valid_raw` runs from 27648 to 1",
            "lowest",
        ),
        (
            "\"Cyl{n}_C2.Velocity\"",
            "\"Cyl1_C2.Velocity\"",
            "20:15: `signals.cylinder.c2_velocity` is \"Cyl1_C2.Velocity\" for all 6 cylinders: {n} is missing",
            "stands for",
        ),
        (
            "\"Cyl{n}_C2.Position\"",
            "\"Cyl{n}_C1.Position\"",
            "19:6: `signals.cylinder.c2` is the same signal as that of C1",
            "never shows a fault",
        ),
        (
            "cylinders = 6",
            "cylinders = 2",
            "42:5: `cylinder[0].n` is 3, but the machine has 2 cylinders",
            "numbered",
        ),
        (
            "c2_offset = 0.0 ",
            "[[cylinder]]\nn = 3 ",
            "45:5: `cylinder[1].n` is 3, which has a [[cylinder]] table above",
            "one table",
        ),
    ] {
        let text = broken(from, to).replace("\nn = 1\n", "\nn = 3\n");
        let lines = refusal(&text);
        assert_eq!(lines.len(), 1, "{lines:#?}");
        assert!(lines[0].starts_with(&format!("machine.toml:{start}")), "\n{}\n{start}", lines[0]);
        assert!(lines[0].contains(help), "\n{}\n{help}", lines[0]);
    }
}

#[test]
fn a_slow_machine_is_told_that_the_defaults_do_not_fit() {
    let lines = refusal(&broken("sample_time = 0.02", "sample_time = 0.5"));
    assert_eq!(lines.len(), 2);
    for (line, key) in lines.iter().zip(["stale", "frozen"]) {
        let start = format!(
            "machine.toml:4:15: `plausibility.{key}` is 0.1 (the default), but must be at least \
             the sample time 0.5 ("
        );
        assert!(line.starts_with(&start), "{line}");
    }
}

#[test]
fn the_share_of_the_bus_carries_at_least_the_statuses() {
    let with = |bus: &str, table: &str| {
        let text = broken("[signals]", &format!("{bus}\n[signals]"));
        tertius::config::parse("machine.toml", &format!("{text}\n{table}\n"))
    };
    for (bus, table, words) in [
        ("", "[gateway]\nbus_share = 1e-12", ["`gateway.bus_share` is 1e-12", "at least 0.003"]),
        ("", "[gateway]\nbus_share = 0.0026", ["500000 bit/s", "Fd_Status is sent every 100 ms"]),
        ("bitrate = 10000", "", ["`gateway.bus_share` is 0.05 (the default)", "at least 0.135"]),
        // Twenty heartbeats a second beside the statuses.
        (
            "",
            "[gateway]\nbus_share = 0.0028\n[canopen]\nnode = true\nheartbeat = 0.05",
            ["at least 0.009", "heartbeats"],
        ),
    ] {
        let error = with(bus, table).expect_err(table).to_string();
        let text = format!("{error:?} {error}");
        for word in words {
            assert!(text.contains(word), "{word}: {text}");
        }
    }
    assert!(with("", "[gateway]\nbus_share = 0.0028").is_ok());
    assert!(with("bitrate = 10000", "[gateway]\nbus_share = 0.2").is_ok());
}

#[test]
fn a_certificate_needs_its_key_and_a_key_its_certificate() {
    let with = |table: &str| format!("{}\n[http]\n{table}\n", common::EXAMPLE);
    for (table, key) in [("certificate = \"a.crt\"", "certificate"), ("key = \"a.key\"", "key")] {
        let lines = refusal(&with(table));
        assert_eq!(lines.len(), 1, "{lines:#?}");
        assert!(lines[0].contains("belong together") && lines[0].contains(key), "{}", lines[0]);
    }
    let both = with("certificate = \"a.crt\"\nkey = \"a.key\"");
    assert!(tertius::config::parse("machine.toml", &both).is_ok());
}

#[test]
fn estimates_need_their_share_of_the_bus_and_room_for_their_deviation() {
    let with = |table: &str| format!("{}\n[estimate]\n{table}\n", common::EXAMPLE);
    let lines = refusal(&with("send = true"));
    assert_eq!(lines.len(), 1, "{lines:#?}");
    for words in [
        "`gateway.bus_share` is 0.05",
        "at least 0.084",
        "310 frames a second",
        "or send no estimates",
    ] {
        assert!(lines[0].contains(words), "{words}: {}", lines[0]);
    }
    let lines = refusal(&with("bound = 0.07"));
    assert_eq!(lines.len(), 1, "{lines:#?}");
    assert!(lines[0].contains("`estimate.bound` is 0.07, but must be above 0 and at most 0.065"));
    assert!(tertius::config::parse("machine.toml", &with("bound = 0.01")).is_ok());
}

/// Names without a number in common are a list in braces, one name for each cylinder.
#[test]
fn a_list_in_braces_has_a_name_for_each_cylinder() {
    let of = |text: &str, n| CylinderSignals::of_cylinder(text, n);
    assert_eq!(of("Wheel.{Port,Starboard}", 2), "Wheel.Starboard");
    assert_eq!(of("{A.X,B.Y}", 1), "A.X");
    assert_eq!(of("M{n}.{P,Q}_{n}", 2), "M2.Q_2");
    refused(
        r#"c1 = "Cyl{n}_C1.Position""#,
        r#"c1 = "{A,B,C}.Position""#,
        "",
        "one name for each cylinder",
    );
    refused(r#"c1 = "Cyl{n}_C1.Position""#, r#"c1 = "{A,B.Position""#, "", "{Port,Starboard}");
}

/// Whose token is one that everybody tries first, is told at the start and not by whoever tries it.
#[test]
fn a_token_that_everybody_tries_first_is_refused() {
    let refused = |digest: &str| {
        let text = format!("{EXAMPLE}\n[http]\ntoken = \"{digest}\"\n");
        tertius::config::parse("machine.toml", &text).err().map(|error| error.to_string())
    };
    for (token, _) in tertius::config::WEAK_TOKENS {
        let digest = TokenDigest::of(token).to_string();
        for digest in [digest.clone(), digest.to_uppercase()] {
            let told = refused(&digest).unwrap_or_else(|| panic!("{token:?} is taken"));
            assert!(told.contains("`tertius token` makes"), "{told}");
        }
    }
    assert!(refused(&TokenDigest::of("test\n").to_string()).is_some(), "as `echo` makes it");
    let random = TokenDigest::of("6f1d9a0c2b7e4835a1c0d9e8f7b6a594").to_string();
    assert_eq!(refused(&random), None);
}
