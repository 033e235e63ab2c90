//! Configurations, sound and broken: what is read, and how problems are reported.

use crate::common::{EXAMPLE, broken, refusal};
use tertius::alarm::Level;
use tertius::config::settings::{
    Alarm, Canopen, Comparator, Fde, Gateway, Http, Model, Observer, Plausibility, Realtime,
};
use tertius::config::{MAX_PROBLEMS, MAX_SIZE, parse};

#[test]
fn the_documented_example_is_read_as_it_stands() {
    let (settings, document) = parse("example.toml", EXAMPLE).expect("the example is sound");
    assert_eq!(settings.machine.cylinders, 6);
    assert_eq!(settings.machine.monitored_states.as_deref(), Some(&["engaged".to_owned()][..]));
    assert_eq!(settings.signals.cylinder.control_speed, "Cyl{n}_Valve.ControlSpeed");
    assert_eq!(settings.signals.cylinder.c1_counter, None);
    assert_eq!(settings.cylinder.len(), 1);
    assert!(document.has("fde.low") && !document.has("gateway.node"));
}

#[test]
fn absent_tables_have_the_values_of_the_thesis() {
    let (start, _) = EXAMPLE.split_once("[model]").expect("the example has a model");
    let (settings, _) = parse("short.toml", start).expect("all that is required is there");
    assert_eq!(settings.model.theta, [-0.0101, -0.1231, -1.6891e-5, -10.7104, -0.0023]);
    assert_eq!(settings.model.gamma, [0.0926, 6.5427]);
    assert_eq!(
        settings.observer,
        Observer { q: [5e-9, 2e-4, 1e4], r: [1e-8, 5.0], settle: 1.0, sample_time: None }
    );
    let fde = Fde {
        enabled: true,
        low: 7.5e-4,
        high: 1e-3,
        joint: None,
        command: None,
        command_change: None,
    };
    assert_eq!(settings.fde, fde);
    assert_eq!(
        settings.comparator,
        Comparator { enabled: true, bound: 1.5e-3, low: None, critical: 0.05 }
    );
    assert_eq!(settings.comparator_low(), 0.75 * 1.5e-3);
    assert_eq!(settings.cycle_deadline(), 0.016);
    assert_eq!(settings.machine.max_gap, 0.1);
    assert_eq!(settings.gateway, Gateway { node: 81, bus_share: 0.05, max_age: 0.2, guard: 0.01 });
    assert_eq!(settings.http.address(), Some("127.0.0.1:9481".parse().expect("an address")));
    assert_eq!(settings.realtime, Realtime { priority: 0, lock_memory: false });
    assert_eq!(settings.plausibility, Plausibility::default());
    assert_eq!(settings.plausibility.broken_wire_codes, None);
    assert_eq!((settings.alarm.clear, settings.alarm.coincidence), (1.0, 0.2));
    assert_eq!(settings.alarm.levels.both, Level::Black);
}

#[test]
fn the_shipped_machine_is_the_defaults_written_out() {
    let text = include_str!("../../config/e-type.toml");
    let (settings, document) = parse("e-type.toml", text).expect("the shipped file is sound");
    let cylinder = &settings.signals.cylinder;
    assert_eq!(cylinder.c1_status.as_deref(), Some("Cyl{n}_C1.Status"));
    assert_eq!(cylinder.c2_counter.as_deref(), Some("Cyl{n}_C2.Counter"));
    assert_eq!(cylinder.named().count(), 12);
    assert_eq!(cylinder.spool.as_deref(), Some("Cyl{n}_Valve.SpoolPosition"));
    assert_eq!(settings.signals.supply.as_deref(), Some("Plc_State.SupplyPressure"));
    assert_eq!(settings.model, Model::default());
    assert_eq!(settings.observer, Observer::default());
    assert_eq!(settings.fde, Fde::default());
    assert_eq!(settings.comparator, Comparator::default());
    assert_eq!(settings.alarm, Alarm::default());
    assert_eq!(settings.gateway, Gateway::default());
    assert_eq!(settings.http, Http::default());
    assert_eq!(settings.realtime, Realtime::default());
    let plausibility = Plausibility {
        broken_wire_codes: Some(vec![32767]),
        status_mask: 3,
        valid_raw: Some([1, 27648]),
        ..Plausibility::default()
    };
    assert_eq!(settings.plausibility, plausibility);
    assert!(document.has("alarm.levels.critical"));
}

#[test]
fn a_cylinder_has_its_own_values_or_those_of_the_machine() {
    let text = broken(
        "n = 1\nc2_gain = 1.0                 # a of (5-20)\nc2_offset = 0.0 ",
        "n = 4\nc2_gain = 1.0031\nc2_offset = 0.0034\ngamma = [1, 2.5]",
    );
    let (settings, _) = parse("own.toml", &text).expect("it is sound");
    assert_eq!(settings.comparator_of(4), (1.0031, 0.0034));
    assert_eq!(settings.comparator_of(1), (1.0, 0.0));
    assert_eq!(settings.model_of(4), (Model::default().theta, [1.0, 2.5]));
    assert_eq!(settings.model_of(3), (Model::default().theta, Model::default().gamma));
    let given = broken("[model]", "[model]\ncommand_offset = 0.02");
    let given = given.replace("n = 1\n", "n = 2\ncommand_offset = -0.1\n");
    let (settings, _) = parse("own.toml", &given).expect("it is sound");
    assert_eq!((settings.command_offset_of(1), settings.command_offset_of(2)), (0.02, -0.1));
    assert_eq!(settings.machine.area_ratio, 0.5);
    let given = broken("[bus]", "cycle_deadline = 0.012\n[bus]");
    let (settings, _) = parse("own.toml", &given).expect("it is sound");
    assert_eq!(settings.cycle_deadline(), 0.012);
    let given = broken("critical = 0.05", "critical = 0.05\nlow = 1e-3");
    let (settings, _) = parse("own.toml", &given).expect("it is sound");
    assert_eq!(settings.comparator_low(), 1e-3);
}

#[test]
fn http_listens_where_it_is_told_or_nowhere() {
    let with = |listen| format!("{EXAMPLE}[http]\nlisten = \"{listen}\"\n");
    for (listen, address) in
        [("0.0.0.0:80", Some("0.0.0.0:80")), ("[::1]:9000", Some("[::1]:9000")), ("off", None)]
    {
        let (settings, _) = parse("http.toml", &with(listen)).expect("it is sound");
        assert_eq!(settings.http.address().map(|found| found.to_string()).as_deref(), address);
    }
    for listen in ["", "9481", "localhost:9481", "127.0.0.1", "127.0.0.1:99999", "Off", "::1:80"] {
        let lines = refusal(&with(listen));
        let expected = format!("`http.listen` is \"{listen}\", but must be ADDRESS:PORT or off");
        assert!(lines.len() == 1 && lines[0].contains(&expected), "{lines:#?}");
        assert!(lines[0].contains("127.0.0.1:9481"), "{lines:#?}");
    }
}

#[test]
fn the_gateway_is_a_node_only_where_it_is_asked_to_be() {
    let node = |table: &str| {
        let (settings, _) = parse("node.toml", &format!("{EXAMPLE}{table}")).expect("it is sound");
        let frames = settings.periodic_frames();
        (settings.canopen_node().cloned(), frames)
    };
    assert_eq!(node(""), (None, 10.0));
    assert_eq!(node("[canopen]\n"), (None, 10.0));
    let default = Canopen { node: true, ..Canopen::default() };
    assert_eq!((default.heartbeat, default.autostart), (1.0, true));
    assert_eq!(node("[canopen]\nnode = true\n"), (Some(default.clone()), 11.0));
    let silent = Canopen { heartbeat: 0.0, autostart: false, ..default };
    let table = "[canopen]\nnode = true\nheartbeat = 0\nautostart = false\n";
    assert_eq!(node(table), (Some(silent), 10.0));
    let lines = refusal(&format!("{EXAMPLE}[canopen]\nautostart = true\n"));
    let expected = "`canopen.autostart` is of no effect, since the gateway is no CANopen node";
    assert!(lines.len() == 1 && lines[0].contains(expected), "{lines:#?}");
    for heartbeat in ["0.049", "1e-9", "65.536", "-1"] {
        let lines = refusal(&format!("{EXAMPLE}[canopen]\nnode = true\nheartbeat = {heartbeat}\n"));
        let expected = format!("`canopen.heartbeat` is {heartbeat}, but must be at least 0");
        assert!(lines.len() == 1 && lines[0].contains(&expected), "{lines:#?}");
    }
}

#[test]
fn whole_numbers_of_64_bits_and_other_bases_are_read() {
    let text = format!("{EXAMPLE}[plausibility]\nstatus_mask = 18446744073709551615\n");
    let (settings, _) = parse("mask.toml", &text).expect("it is sound");
    assert_eq!(settings.plausibility.status_mask, u64::MAX);
    let text = format!("{EXAMPLE}[plausibility]\nstatus_mask = 0xFF\nbroken_wire_codes = []\n");
    let (settings, _) = parse("mask.toml", &text).expect("it is sound");
    assert_eq!(settings.plausibility.status_mask, 255);
    assert_eq!(settings.plausibility.broken_wire_codes, Some(Vec::new()));
}

#[test]
fn one_cylinder_needs_no_number_in_its_names() {
    let text = EXAMPLE.replace("cylinders = 6", "cylinders = 1").replace("Cyl{n}_", "");
    assert!(parse("one.toml", &text).is_ok());
}

#[test]
fn real_time_is_asked_for_within_what_the_kernel_has() {
    let with = |table: &str| broken("[bus]", &format!("[realtime]\n{table}\n[bus]"));
    let (settings, _) =
        parse("own.toml", &with("priority = 99\nlock_memory = true")).expect("sound");
    assert_eq!(settings.realtime, Realtime { priority: 99, lock_memory: true });
    for (table, words) in [
        ("priority = 100", "`realtime.priority` is 100, but must be 0 to 99"),
        ("priority = true", "`realtime.priority` is true or false, but must be a whole number"),
        ("lock_memory = 1", "`realtime.lock_memory` is a whole number, but must be true or false"),
    ] {
        let lines = refusal(&with(table));
        assert!(lines.len() == 1 && lines[0].contains(words), "{lines:?}");
    }
}

#[test]
fn all_mistakes_are_reported_at_once_in_the_order_of_the_file() {
    let text = EXAMPLE
        .replace("cylinders = 6", "cylindrs = 6")
        .replace("\"can0\"", "0")
        .replace("r = [1e-8, 1e-2]", "r = [1e-8, 0]")
        .replace("low = 7.5e-4", "low = 7.5")
        .replace("c2_gain = 1.0 ", "gain = 1.0 ");
    let places: Vec<_> = refusal(&text)
        .iter()
        .map(|line| line.split(':').nth(1).expect("a line number").parse::<u32>().expect("one"))
        .collect();
    // The threshold in line 34 contradicts another value: said once every key has a sound type.
    assert_eq!(places, [3, 9, 31, 43]);
    let lines = refusal(
        &text
            .replace("\nr = [1e-8, 0]", "")
            .replace("\ninterface = 0", "\ninterface = \"can0\"")
            .replace("cylindrs", "cylinders"),
    );
    assert_eq!(lines.len(), 2, "{lines:#?}");
    assert!(lines[0].contains("`fde.low` is 7.5") && lines[1].contains("`gain`"), "{lines:#?}");
}

#[test]
fn a_report_is_bounded_and_counts_the_rest() {
    let many: String = (0..50).map(|i| format!("unheard_of_{i} = 1\n")).collect();
    let text = format!("{many}{EXAMPLE}");
    let error = parse("many.toml", &text).expect_err("unknown keys are refused");
    assert_eq!((error.problems().len(), error.more()), (MAX_PROBLEMS, 30));
    assert!(error.to_string().ends_with("many.toml: and 30 more problems"), "{error}");
    let long = format!("{} = 1\n{EXAMPLE}", "k".repeat(100_000));
    let error = parse("long.toml", &long).expect_err("unknown keys are refused");
    assert!(error.to_string().len() < 500);
    assert!(format!("{:?}", error.report()).len() < 2000);
}

#[test]
fn text_that_is_not_toml_is_refused_where_it_breaks() {
    for (from, to, start) in [
        ("[bus]", "[bus", "8:5: not TOML: "),
        ("low = 7.5e-4", "low = ", "34:7: not TOML: "),
        ("cylinders = 6", "cylinders = 6\ncylinders = 5", "4:1: not TOML: duplicate key"),
        ("[model]", "[bus]", "25:2: not TOML: duplicate key"),
    ] {
        let lines = refusal(&broken(from, to));
        assert!(lines[0].starts_with(&format!("machine.toml:{start}")), "{lines:#?}");
    }
    let lines = refusal(&"#".repeat(MAX_SIZE + 1));
    assert!(lines[0].starts_with("machine.toml: longer than 1048576 bytes"), "{lines:#?}");
}

#[test]
fn line_ends_of_windows_and_a_byte_order_mark_are_read() {
    let text = format!("\u{feff}{}", EXAMPLE.replace('\n', "\r\n"));
    assert!(parse("windows.toml", &text).is_ok());
    let lines = refusal(&text.replace("low = 7.5e-4", "low = 0"));
    assert!(lines[0].starts_with("machine.toml:34:7: `fde.low` is 0,"), "{lines:#?}");
}

#[test]
fn later_stages_point_at_the_key_they_mean() {
    let (_, document) = parse("later.toml", EXAMPLE).expect("the example is sound");
    for (key, place) in [
        ("signals.cylinder.c1", "17:6"),
        ("cylinder[0].c2_offset", "44:13"),
        ("observer.q[2]", "30:18"),
        ("signals.cylinder", "16:10"),
        // What the file does not have is reported at the table that would hold it.
        ("cylinder[0].theta[3]", "41:1"),
        ("signals.cylinder.c1_status", "16:10"),
        ("gateway.node", "1:1"),
    ] {
        let problem = document.problem(key, "the DBC has no such signal", "the nearest is X");
        let line = format!("later.toml:{place}: the DBC has no such signal (the nearest is X)");
        assert_eq!(problem.to_string(), line);
    }
    assert!(document.refuse([]).is_none());
    let problems = ["fde.high", "bus.dbc"].map(|key| document.problem(key, "wrong", ""));
    let error = document.refuse(problems).expect("there are problems");
    assert_eq!(error.to_string(), "later.toml:10:7: wrong\nlater.toml:35:8: wrong");
}

#[test]
fn the_report_shows_the_line_and_the_help() {
    let text = broken("sample_time =", "sampletime =");
    let error = parse("machine.toml", &text).expect_err("unknown keys are refused");
    let report = format!("{:?}", error.report());
    for part in [
        "machine.toml: 1 problem",
        "[machine] has an unknown key, `sampletime`",
        "machine.toml:4:1",
        "4 │ sampletime = 0.02 ",
        "the nearest known key is `sample_time`",
    ] {
        assert!(report.contains(part), "{part}\n{report}");
    }
}

#[test]
fn mqtt_goes_to_a_broker_under_a_topic_or_nowhere() {
    let with = |lines: &str| format!("{EXAMPLE}[mqtt]\n{lines}\n");
    for (broker, address) in [
        ("mqtt.ship.lan:8883", Some(("mqtt.ship.lan", 8883))),
        ("192.168.1.5:1883", Some(("192.168.1.5", 1883))),
        ("[fd00::5]:1883", Some(("fd00::5", 1883))),
        ("off", None),
    ] {
        let (settings, _) =
            parse("mqtt.toml", &with(&format!("broker = \"{broker}\""))).expect("it is sound");
        assert_eq!(settings.mqtt.address(), address);
    }
    for broker in [
        "",
        "mqtt.ship.lan",
        ":1883",
        "ship:0",
        "ship:65536",
        "mqtt://ship:1883",
        "fd00::5:1",
        "a b:1",
    ] {
        let lines = refusal(&with(&format!("broker = \"{broker}\"")));
        let expected = format!("`mqtt.broker` is \"{broker}\", but must be HOST:PORT or off");
        assert!(lines.len() == 1 && lines[0].contains(&expected), "{lines:#?}");
    }
    for topic in ["", "/ship", "ship/", "a//b", "ship/#", "+/a", "$SYS/a"] {
        let lines = refusal(&with(&format!("topic = \"{topic}\"")));
        assert!(lines.len() == 1 && lines[0].contains("the first levels of a topic"), "{lines:#?}");
    }
    for edge in ["", "gangway", "ship/", "/gangway", "ship/a/b", "ship/+", "a b/#"] {
        let lines = refusal(&with(&format!("sparkplug = \"{edge}\"")));
        assert!(lines.len() == 1 && lines[0].contains("of the form GROUP/NODE"), "{lines:#?}");
    }
    let sound = with("sparkplug = \"Ship 1/gangway\"");
    let (settings, _) = parse("mqtt.toml", &sound).expect("it is sound");
    assert_eq!(settings.mqtt.edge(), Some(("Ship 1", "gangway")));
    let lines = refusal(&with("user = \"gateway\""));
    assert!(lines.len() == 1 && lines[0].contains("`mqtt.password` belong together"), "{lines:#?}");
}
