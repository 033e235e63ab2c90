//! What befalls an interface, a configuration, a process.

use std::path::Path;
use std::process::Command;
use tertius_testing::bench::{Bench, Status, excerpt, ip, run, wait_for, wire};

#[test]
fn it_survives_its_interface_going_down_and_away() {
    let bench = Bench::new("t-life");
    let gateway = bench.start_gateway();
    wait_for("it to miss its interface", || bench.said("no interface t-life") == 1);
    bench.create();
    wait_for("it to see the interface down", || bench.said("is down") == 1);
    ip(&["link", "set", "up", "t-life"]);
    wait_for("it to open the interface", || bench.said("open: t-life") == 1);
    ip(&["link", "set", "down", "t-life"]);
    ip(&["link", "set", "up", "t-life"]);
    wait_for("it to open it again", || bench.said("open: t-life") == 2);
    ip(&["link", "delete", "t-life"]);
    bench.create();
    ip(&["link", "set", "up", "t-life"]);
    wait_for("it to open the new one", || bench.said("open: t-life") == 3);
    gateway.signal("TERM");
    wait_for("the end", || bench.said("stopped") == 1);
}

#[test]
fn a_bad_configuration_is_refused_and_the_old_one_goes_on() {
    let bench = Bench::up("t-hup");
    let gateway = bench.gateway();
    let sound = bench.configuration();
    bench.configure(&sound.replace("cylinders = 6", "cylinders = 66"));
    gateway.signal("HUP");
    wait_for("the refusal", || bench.said("the old one stays in force") == 1);
    assert_eq!(bench.said("machine.cylinders"), 1, "with its reason");
    bench.configure(&sound);
    gateway.signal("HUP");
    wait_for("the new configuration", || bench.said("was read again") == 1);
    wait_for("it to open the interface again", || bench.said("open: t-hup") == 2);
}

#[test]
fn nothing_is_healthy_after_the_link_was_down_until_it_was_judged_again() {
    let bench = Bench::up("t-down");
    let _gateway = bench.gateway();
    let dump = bench.candump();
    let healthy = |lines: &[String]| -> Vec<usize> {
        wire(lines).iter().filter_map(|frame| Status::read(frame)).map(|it| it.healthy()).collect()
    };
    // On a box without a moment to spare the player is late, and its cycles are no evidence.
    let judged = || healthy(&bench.own_lines()).contains(&12);
    bench.play_until(&excerpt(20.0, 50.0), "all to be judged", judged);
    drop(dump);
    ip(&["link", "set", "down", "t-down"]);
    wait_for("it to notice", || bench.said("is down") >= 1);
    ip(&["link", "set", "up", "t-down"]);
    wait_for("it to return", || bench.said("open: t-down") == 2);
    std::fs::remove_file(bench.path("bus.log")).expect("candump wrote it");
    let _dump = bench.candump();
    bench.play(&excerpt(50.0, 52.0));
    let seen = healthy(&bench.own_lines());
    assert!(seen[..3].iter().all(|&healthy| healthy == 0), "{seen:?}");
}

#[test]
fn one_that_was_killed_starts_with_knowing_nothing() {
    let bench = Bench::up("t-kill");
    let _dump = bench.candump();
    let mut gateway = bench.gateway();
    bench.play(&excerpt(20.0, 23.0));
    gateway.kill();
    let before = bench.own_lines().len();
    let _gateway = bench.gateway();
    bench.play(&excerpt(23.0, 25.0));
    wait_for("a status", || bench.own_lines().len() > before);
    let lines = bench.own_lines();
    let first = Status::read(wire(&lines)[before]).expect("a status comes first");
    assert_eq!((first.healthy(), first.mode()), (0, 0), "unknown, starting");
}

#[test]
fn what_waits_on_a_jammed_bus_does_not_burst_out_when_it_moves_again() {
    let bench = Bench::up("t-jam");
    let _gateway = bench.gateway();
    let _dump = bench.candump();
    bench.play(&excerpt(20.0, 21.0));
    jam("t-jam");
    let before = bench.own_lines().len();
    wait_for("it to see that nothing goes out", || bench.said("has accepted no frame") == 1);
    run(
        "tc",
        &[
            "qdisc", "change", "dev", "t-jam", "root", "tbf", "rate", "1mbit", "burst", "1kb",
            "limit", "100000",
        ],
    );
    wait_for("the bus to move", || bench.own_lines().len() > before);
    let burst = bench.own_lines().len() - before;
    assert_eq!(bench.said("no bus"), 0, "a jam is no loss");
    assert!(burst <= 10, "{burst} frames came at once");
}

/// Gives the interface a queue that lets next to nothing through.
fn jam(interface: &str) {
    let arguments = [
        "qdisc", "add", "dev", interface, "root", "tbf", "rate", "8bit", "burst", "32", "limit",
        "100000",
    ];
    if Command::new("tc").args(arguments).output().is_ok_and(|output| output.status.success()) {
        return;
    }
    // User-mode Linux does not find its modules by itself.
    let release = std::fs::read_to_string("/proc/sys/kernel/osrelease").expect("it is Linux");
    let module = format!("/usr/lib/uml/modules/{}/kernel/net/sched/sch_tbf.ko", release.trim());
    if Path::new(&module).exists() {
        run("busybox", &["insmod", &module]);
    }
    run("tc", &arguments);
}
