//! `tertius doctor`: what facts of a box lead to, and what the program says on this one.

mod facts;
mod wear;

use facts::{hear, machine, set, sound};
use serde_json::Value;
use std::fs;
use std::net::TcpListener;
use tertius::appliance::doctor::facts::{Bus, Facts, InterfaceFacts, Logins};
use tertius::appliance::doctor::{Finding, Verdict, examine};
use tertius::bus::Stamps;
use tertius::bus::socket::ControllerState;
use tertius::frame::{Frame, Id, Kind};
use tertius::time::Span;
use tertius_testing::support::{self, Scratch, tertius};

/// The only finding of `subject` that is not ok, or the first that is.
#[track_caller]
fn find(facts: &Facts, subject: &str) -> Finding {
    let findings = examine(facts);
    let of = |finding: &&Finding| finding.subject == subject;
    let worst = findings.iter().filter(of).max_by_key(|finding| finding.verdict);
    worst.unwrap_or_else(|| panic!("nothing of {subject} in {findings:#?}")).clone()
}

/// Judged so, with each of `words` in what was found or what is to be done.
#[track_caller]
fn judged(facts: &Facts, subject: &str, verdict: Verdict, words: &[&str]) {
    let finding = find(facts, subject);
    assert_eq!(finding.verdict, verdict, "{finding}");
    assert_eq!(finding.advice.is_some(), verdict != Verdict::Ok, "{finding}");
    for word in words {
        assert!(finding.to_string().contains(word), "{word:?} is not in {finding}");
    }
}

fn changed(change: impl FnOnce(&mut InterfaceFacts)) -> Facts {
    let mut facts = sound();
    let Bus::Socket(interface) = &mut facts.bus else { unreachable!("it is a socket") };
    change(interface);
    facts
}

fn linked(change: impl FnOnce(&mut tertius::bus::socket::LinkState)) -> Facts {
    changed(|interface| change(interface.link.as_mut().expect("there is one")))
}

#[test]
fn a_sound_box_is_right_in_every_line() {
    let findings = examine(&sound());
    let wrong: Vec<_> = findings.iter().filter(|it| it.verdict != Verdict::Ok).collect();
    assert!(wrong.is_empty(), "{wrong:#?}");
    let subjects: Vec<&str> = findings.iter().map(|finding| finding.subject).collect();
    assert_eq!(
        subjects,
        [
            "configuration",
            "dbc",
            "can",
            "interface",
            "controller",
            "bit rate",
            "restart",
            "send queue",
            "frame size",
            "receive buffer",
            "time stamps",
            "overload",
            "frames",
            "cycle",
            "bus load",
            "error frames",
            "node",
            "rights",
            "real time",
            "locked memory",
            "clock",
            "http",
            "service",
            "program",
            "disk",
            "disk",
        ]
    );
    for finding in &findings {
        assert_eq!(finding.to_string().lines().count(), 1, "{finding}");
    }
}

#[test]
fn without_can_in_the_kernel_the_rest_is_still_looked_at() {
    let facts = changed(|interface| {
        interface.no_can = Some("Address family not supported".to_owned());
        interface.link = Err("there is no interface can0".to_owned());
        interface.port = Err("no CAN".to_owned());
        interface.hearing = None;
    });
    judged(&facts, "can", Verdict::Fail, &["no CAN sockets: Address family", "modprobe can-raw"]);
    judged(&facts, "interface", Verdict::Fail, &["no interface can0", "bus.interface"]);
    judged(&facts, "clock", Verdict::Ok, &["synchronised"]);
    judged(&facts, "service", Verdict::Ok, &["WatchdogSec=2"]);
}

#[test]
fn an_interface_that_does_not_do() {
    let facts = changed(|interface| interface.is_can = Some(false));
    judged(&facts, "interface", Verdict::Fail, &["can0 is not a CAN interface"]);
    assert!(examine(&facts).iter().all(|finding| finding.subject != "bit rate"));
    let facts = linked(|link| link.up = false);
    judged(&facts, "interface", Verdict::Fail, &["is down", "ip link set can0 up"]);
    let facts = changed(|interface| interface.port = Err("cannot listen".to_owned()));
    judged(&facts, "interface", Verdict::Fail, &["no socket can be opened on it: cannot listen"]);
}

#[test]
fn the_controllers_state_with_its_counters() {
    for (state, verdict) in [
        (ControllerState::ErrorActive, Verdict::Ok),
        (ControllerState::Warning, Verdict::Warn),
        (ControllerState::Passive, Verdict::Fail),
        (ControllerState::BusOff, Verdict::Fail),
    ] {
        let facts = linked(|link| {
            link.state = Some(state);
            (link.transmit_errors, link.receive_errors) = (Some(96), Some(3));
        });
        judged(&facts, "controller", verdict, &[state.name(), "counters 96 (sent) and 3"]);
    }
    let facts = linked(|link| link.state = Some(ControllerState::BusOff));
    judged(&facts, "controller", Verdict::Fail, &["`ip link set can0 type can restart`"]);
}

#[test]
fn a_bit_rate_that_is_another() {
    judged(&sound(), "bit rate", Verdict::Ok, &["500000 bit/s, sample point 87.5 %"]);
    let facts = linked(|link| link.bit_rate = Some(250_000));
    let words = ["250000 bit/s", "bus.bitrate is 500000", "type can bitrate 500000"];
    judged(&facts, "bit rate", Verdict::Fail, &words);
    judged(&linked(|link| link.bit_rate = None), "bit rate", Verdict::Fail, &["none is set"]);
    // A virtual interface has neither rate nor controller, which is right.
    let facts = linked(|link| {
        (link.bit_rate, link.sample_point, link.state, link.restart_ms) = (None, None, None, None);
    });
    judged(&facts, "bit rate", Verdict::Ok, &["virtual"]);
    assert!(examine(&facts).iter().all(|it| !["controller", "restart"].contains(&it.subject)));
}

#[test]
fn what_happens_after_bus_off_and_to_what_waits() {
    for time in [Some(0), None] {
        let facts = linked(|link| link.restart_ms = time);
        judged(&facts, "restart", Verdict::Warn, &["stays off", "restart-ms 100"]);
    }
    judged(&linked(|link| link.queue_length = Some(50)), "send queue", Verdict::Ok, &["50"]);
    let facts = linked(|link| link.queue_length = Some(51));
    judged(&facts, "send queue", Verdict::Warn, &["51 frames", "txqueuelen 16"]);
}

#[test]
fn frames_too_long_for_the_interface() {
    let mut facts = sound();
    facts.wanted.messages[3].needs = 12;
    let name = facts.wanted.messages[3].name.clone();
    judged(&facts, "frame size", Verdict::Fail, &[&format!("{name} has 12 bytes"), "fd on"]);
    let Bus::Socket(interface) = &mut facts.bus else { unreachable!("it is a socket") };
    interface.link.as_mut().expect("there is one").mtu = Some(72);
    judged(&facts, "frame size", Verdict::Ok, &["MTU 72"]);
}

#[test]
fn room_for_a_second_of_a_full_bus() {
    let buffer = |bytes: u64, lasts: f64, rmem_max: u64, admin: bool| {
        let mut facts = changed(|interface| {
            let port = interface.port.as_mut().expect("there is one");
            (port.buffer, port.lasts) = (bytes, lasts);
            interface.rmem_max = Some(rmem_max);
        });
        facts.host.rights.net_admin = admin;
        facts
    };
    // 10,639 frames of 1280 bytes; the kernel doubles what it is asked for.
    let second = 13_617_920;
    let facts = buffer(second / 8, 0.125, second / 16, false);
    let words = ["1662 KiB, 0.12 s", "net.core.rmem_max = 6808960", "CAP_NET_ADMIN"];
    judged(&facts, "receive buffer", Verdict::Warn, &words);
    judged(&buffer(second, 1.0, second / 2, false), "receive buffer", Verdict::Ok, &["1.00 s"]);
    // Root gets it, the service would not.
    let facts = buffer(second, 1.0, second / 8, true);
    judged(&facts, "receive buffer", Verdict::Warn, &["a service without it gets 0.25 s"]);
}

#[test]
fn whose_clock_stamps() {
    judged(&sound(), "time stamps", Verdict::Ok, &["the controller's (hardware)"]);
    let facts = changed(|interface| {
        let port = interface.port.as_mut().expect("there is one");
        port.stamps = Stamps::SoftwareAsHardwareDiffers(Span::from_nanos(5_000_000));
    });
    judged(&facts, "time stamps", Verdict::Ok, &["(software)", "+5.000 ms off"]);
}

#[test]
fn messages_that_do_not_come_are_named() {
    let facts = machine(|frame| ![0x183, 0x193, 0x1A3].contains(&frame.id.value()));
    let words = ["3 of 20 messages", "Cyl3_C1 (183), Cyl3_C2 (193), Cyl3_Valve (1A3)"];
    judged(&facts, "frames", Verdict::Fail, &words);
    let text = find(&facts, "frames").to_string();
    assert!(!text.contains("Cyl2") && !text.contains("Sync"), "{text}");
    let facts = machine(|_| false);
    judged(&facts, "frames", Verdict::Fail, &["none in 2.0 s, of the 20 messages", "bit rate"]);
    judged(&machine(|_| true), "frames", Verdict::Ok, &["all 20 messages", "2 other identifiers"]);
}

#[test]
fn messages_that_come_too_seldom_or_too_often_or_too_short() {
    let mut count = 0;
    let facts = machine(|frame| {
        count += u32::from(frame.id.value() == 0x1A2);
        frame.id.value() != 0x1A2 || count % 2 == 0
    });
    judged(&facts, "frames", Verdict::Warn, &["not once each 20 ms: Cyl2_Valve (1A2)"]);
    let facts = hear(|hearing, frame| {
        hearing.take(frame);
        if frame.id.value() == 0x186 {
            hearing.take(frame);
        }
    });
    judged(&facts, "frames", Verdict::Warn, &["not once each 20 ms: Cyl6_C1 (186)", "two nodes"]);
    let facts = hear(|hearing, frame| {
        let mut frame = frame.clone();
        if frame.id.value() == 0x181 {
            frame.set_length(1);
        }
        hearing.take(&frame);
    });
    judged(&facts, "frames", Verdict::Fail, &["too short", ": Cyl1_C1 (181)"]);
}

#[test]
fn a_cycle_that_is_another() {
    let cycle = |time: f64| {
        let mut facts = sound();
        facts.wanted.sample_time = time;
        facts
    };
    judged(&sound(), "cycle", Verdict::Ok, &["Sync each 20.000 ms, jitter 0.000 ms"]);
    judged(&cycle(0.0203), "cycle", Verdict::Ok, &[]);
    judged(&cycle(0.0206), "cycle", Verdict::Warn, &["machine.sample_time is 20.6 ms"]);
    judged(&cycle(0.01), "cycle", Verdict::Fail, &["machine.sample_time is 10 ms"]);
    // Each second opening 3 (5) ms late.
    for (late, verdict) in [(3_000_000, Verdict::Ok), (5_000_000, Verdict::Warn)] {
        let mut count = 0;
        let facts = hear(|hearing, frame| {
            let mut frame = frame.clone();
            count += i64::from(frame.id.value() == 0x80);
            if frame.id.value() == 0x80 {
                frame.timestamp = frame.timestamp.after(Span::from_nanos(count % 2 * late));
            }
            hearing.take(&frame);
        });
        let jitter = format!("jitter {:.3} ms", late as f64 / 1e6);
        judged(&facts, "cycle", verdict, &[&jitter]);
    }
}

#[test]
fn how_busy_and_how_disturbed_the_bus_is() {
    // 50 times a second: Sync of 1 byte, 6 × (6 + 6 + 8) and two of 6, one of 4: 55 + 10 n each.
    let bits = 50.0 * (65.0 + 6.0 * (115.0 + 115.0 + 135.0) + 2.0 * 115.0 + 95.0);
    let text = format!("{:.1} % at most", bits / 500_000.0 * 100.0);
    judged(&sound(), "bus load", Verdict::Ok, &[&text]);
    let facts = changed(|it| it.hearing.as_mut().expect("it was listened").occupied = 1.42);
    judged(&facts, "bus load", Verdict::Warn, &["71.0 %"]);
    judged(&sound(), "error frames", Verdict::Ok, &["none"]);
    let facts = hear(|hearing, frame| {
        hearing.take(frame);
        if frame.id.value() == 0x80 && hearing.errors.frames < 3 {
            hearing.take(&facts::error_frame(0x040 | 0x008));
        }
    });
    judged(&facts, "error frames", Verdict::Fail, &["3, 3 frames that were wrong", "bus-off"]);
    let facts = changed(|it| it.hearing.as_mut().expect("it was listened").dropped = 17);
    judged(&facts, "lost", Verdict::Warn, &["17 frames"]);
    let facts = changed(|it| {
        it.hearing.as_mut().expect("it was listened").ended = Some("the interface is down".into());
    });
    judged(&facts, "frames", Verdict::Fail, &["ended after 2.0 s: the interface is down"]);
}

#[test]
fn somebody_else_with_the_gateways_identifiers() {
    let status = |senders: u8| {
        let mut counter = 0_u8;
        hear(move |hearing, frame| {
            hearing.take(frame);
            if frame.id.value() == 0x80 {
                counter = counter.wrapping_add(1);
                // Two gateways that were started at different times.
                (0..senders).for_each(|n| hearing.take(&facts::status(counter + 100 * n)));
            }
        })
    };
    let words = ["1D1 of node 81 come, but no gateway", "gateway.node"];
    judged(&status(1), "node", Verdict::Fail, &words);
    let mut facts = status(1);
    facts.host.rights.gateway = Some(4711);
    judged(&facts, "node", Verdict::Ok, &["one sender", "process 4711"]);
    let mut facts = status(2);
    facts.host.rights.gateway = Some(4711);
    judged(&facts, "node", Verdict::Fail, &["more than one device sends as node 81"]);
    judged(&sound(), "node", Verdict::Ok, &["no other device"]);
    // Another device of that number, which says so in its heartbeat.
    let heartbeat = hear(|hearing, frame| {
        hearing.take(frame);
        if frame.id.value() == 0x80 {
            let id = Id::standard(0x751).expect("11 bits");
            hearing.take(&Frame::new(frame.timestamp, id, Kind::Data, &[5]));
        }
    });
    judged(&heartbeat, "node", Verdict::Fail, &["751 of node 81 come, but no gateway"]);
}

#[test]
fn rights_that_real_time_needs() {
    judged(&sound(), "real time", Verdict::Ok, &["this call may have priority 20"]);
    let facts = set(|facts| facts.host.rights.priority = Some(19));
    judged(&facts, "real time", Verdict::Warn, &["its limit is 19", "LimitRTPRIO"]);
    let facts = set(|facts| {
        (facts.host.rights.priority, facts.host.rights.sys_nice) = (Some(0), true);
    });
    judged(&facts, "real time", Verdict::Ok, &[]);
    let facts = set(|facts| facts.host.rights.locked_memory = Some(8 << 20));
    judged(&facts, "locked memory", Verdict::Warn, &["8192 KiB", "LimitMEMLOCK"]);
    let facts = set(|facts| facts.wanted.realtime = Default::default());
    let asked = ["real time", "locked memory"];
    assert!(examine(&facts).iter().all(|finding| !asked.contains(&finding.subject)));
}

#[test]
fn a_clock_that_nobody_keeps_or_somebody_sets() {
    let facts = set(|facts| facts.host.clock.synchronised = Some(false));
    judged(&facts, "clock", Verdict::Warn, &["not synchronised", "chrony"]);
    let facts = set(|facts| facts.host.clock.synchronised = None);
    judged(&facts, "clock", Verdict::Warn, &["not known"]);
    for (step, verdict) in [(2_900_000, Verdict::Ok), (-3_100_000, Verdict::Warn)] {
        let facts = set(|facts| facts.host.clock.step = Span::from_nanos(step));
        judged(&facts, "clock", verdict, &[]);
    }
    let facts = set(|facts| facts.host.clock.step = Span::from_nanos(-3_600_000_000_000));
    judged(&facts, "clock", Verdict::Warn, &["was set by -3600.000 s"]);
}

#[test]
fn a_port_that_is_taken_and_a_gateway_that_nobody_watches() {
    let taken = |facts: &mut Facts| {
        let (_, trouble) = facts.host.http.as_mut().expect("it is on");
        *trouble = Some("Address already in use".to_owned());
    };
    judged(
        &set(taken),
        "http",
        Verdict::Fail,
        &["127.0.0.1:9481", "already in use", "http.listen"],
    );
    let facts = set(|facts| {
        taken(facts);
        facts.host.rights.gateway = Some(4711);
    });
    judged(&facts, "http", Verdict::Ok, &["process 4711"]);
    judged(&set(|facts| facts.host.http = None), "http", Verdict::Ok, &["off"]);
    for none in [None, Some("0"), Some("infinity")] {
        let facts = set(|facts| facts.host.service.watchdog = none.map(str::to_owned));
        judged(&facts, "service", Verdict::Warn, &["no watchdog", "WatchdogSec=2"]);
    }
    let facts = set(|facts| facts.host.service.unit = None);
    judged(&facts, "service", Verdict::Warn, &["no tertius.service"]);
    let facts = set(|facts| facts.host.service.systemd = false);
    judged(&facts, "service", Verdict::Warn, &["no systemd"]);
}

fn doctor(config: &str, options: &[&str]) -> support::Run {
    let mut arguments = vec!["doctor", "--config", config];
    arguments.extend(options);
    tertius(&arguments, b"")
}

#[test]
fn wrong_tokens_are_worth_a_look_where_they_led_to_a_lockout() {
    let tried = |logins| set(|facts| facts.host.logins = Some(logins));
    let of = |failures, lockouts| tried(Ok(Logins { failures, lockouts }));
    judged(&of(0, 0), "logins", Verdict::Ok, &["0 wrong tokens since the gateway started"]);
    judged(&of(7, 0), "logins", Verdict::Ok, &["7 wrong tokens", "no lockout"]);
    judged(&of(31, 2), "logins", Verdict::Warn, &["31 wrong tokens", "2 lockouts", "journalctl"]);
    let silent = tried(Err("http://127.0.0.1:9481: it did not answer within 3 s".to_owned()));
    judged(&silent, "logins", Verdict::Warn, &["it did not answer within 3 s"]);
}

#[test]
fn an_interface_that_is_not_there_fails_and_the_rest_is_told() {
    let scratch = Scratch::new();
    let config = scratch.config(&[("\"can0\"", "\"t-none\"")]);
    let taken = TcpListener::bind("127.0.0.1:0").expect("there is a loopback");
    let address = taken.local_addr().expect("it has one");
    let text = fs::read_to_string(&config).expect("it was written");
    fs::write(&config, format!("{text}\n[http]\nlisten = \"{address}\"\n")).expect("as before");
    let run = doctor(&config, &[]).failed(1, &["failed"]);
    let line = |subject: &str| {
        let of = |line: &&str| line.split_whitespace().nth(1) == Some(subject);
        run.stdout.lines().find(of).unwrap_or_else(|| panic!("no {subject} in\n{}", run.stdout))
    };
    assert!(line("configuration").starts_with("ok"), "{}", run.stdout);
    assert!(line("interface").starts_with("FAIL"), "{}", run.stdout);
    assert!(line("interface").contains("there is no interface t-none"), "{}", run.stdout);
    assert!(line("http").starts_with("FAIL"), "{}", run.stdout);
    assert!(line("http").contains(&format!("cannot listen on {address}")), "{}", run.stdout);
    for subject in ["dbc", "can", "rights", "clock", "service"] {
        line(subject);
    }

    let json = doctor(&config, &["--format", "json"]).failed(1, &["failed"]).stdout;
    let report: Value = serde_json::from_str(&json).expect("JSON");
    let findings = report["findings"].as_array().expect("a list");
    assert_eq!(findings.len(), run.stdout.lines().count());
    let failed = findings.iter().filter(|finding| finding["verdict"] == "fail").count();
    assert_eq!(report["failed"], failed);
    let interface = findings.iter().find(|finding| finding["subject"] == "interface");
    assert!(interface.expect("it is there")["advice"].is_string());
}

#[test]
fn the_embedded_bus_has_nothing_that_could_fail() {
    let scratch = Scratch::new();
    // Without HTTP, whose port may be another's.
    let virtual_bus = [("\"can0\"", "\"virtual\""), ("[bus]", "[http]\nlisten = \"off\"\n[bus]")];
    let config = scratch.config(&virtual_bus);
    let text = doctor(&config, &[]).ok().stdout;
    assert!(text.contains("the embedded bus") && !text.contains("FAIL"), "{text}");
}

#[test]
fn a_wrong_call_or_configuration_is_refused() {
    let scratch = Scratch::new();
    let config = scratch.config(&[]);
    for time in ["-1", "x", "3601", "nan"] {
        doctor(&config, &[&format!("--listen={time}")]).failed(2, &["--listen"]);
    }
    doctor(&scratch.path("no.toml"), &[]).failed(2, &["no.toml"]);
    let config = scratch.config(&[("cylinders = 6", "cylinders = 7")]);
    assert_eq!(doctor(&config, &[]).failed(2, &["machine.cylinders"]).stdout, "");
}
