//! `tertius inject --from vcan0 --to vcan1` on a real SocketCAN: canplayer plays on the one, candump
//! hears the other, and what it hears is what `tertius inject` makes of candump's log of the first.

use std::path::Path;
use std::process::Command;
use tertius::frame::Frame;
use tertius_testing::process::{
    Running, configuration, excerpt, read, said, wait_for, wire, write,
};
use tertius_testing::program;

/// One that depends on the time, one on the frames before, one on both.
const FAULTS: [&str; 6] = [
    "--fault",
    "step,cylinder=1,at=0.305,size=0.00175,until=1.205",
    "--fault",
    "noise,cylinder=2,sensor=c2,size=0.002",
    "--fault",
    "loss,cylinder=3,at=0.505,probability=0.3",
];

/// The identifier by which a listener shows that it listens.
const HELLO: &str = "7FF";

fn run(program: &str, arguments: &[&str]) {
    let status = Command::new(program).args(arguments).status();
    let status = status.unwrap_or_else(|error| panic!("{program}: {error}"));
    assert!(status.success(), "{program} {arguments:?}");
}

/// A candump of `interface` that is known to listen.
fn listen(interface: &str, log: &Path) -> Running {
    let dump = Running::start("candump", &["-L", "-r", "4000000", interface], log);
    wait_for("candump's start", || {
        run("cansend", &[interface, &format!("{HELLO}#")]);
        said(log, HELLO)
    });
    dump
}

/// What a listener heard but for the greetings.
fn heard(log: &Path) -> Vec<Frame> {
    let mut frames = read(log);
    frames.retain(|frame| frame.id.to_string() != HELLO);
    frames
}

fn plain(path: &Path) -> &str {
    path.to_str().expect("temporary folders have plain names")
}

#[test]
fn between_interfaces_it_does_what_it_does_to_a_recording() {
    let folder = tempfile::tempdir().expect("there is room");
    let path = |name: &str| folder.path().join(name);
    let [machine, bus0, bus1, said_by, other, expected] =
        ["machine.log", "bus0.log", "bus1.log", "proxy.log", "other.log", "expected.log"].map(path);
    let config = configuration(folder.path(), "vcan0");
    let frames = excerpt(59.0, 60.5);
    write(&machine, "vcan0", &frames);
    let _dumps = [listen("vcan0", &bus0), listen("vcan1", &bus1)];
    let proxied = ["inject", "--from", "vcan0", "--to", "vcan1", "--config", plain(&config)];
    // However busy the machine that tests, nothing is to be dropped.
    let arguments = [&proxied[..], &["--max-age", "30"], &FAULTS[..]].concat();
    let mut proxy = Running::start(program(), &arguments, &said_by);
    wait_for("the proxy's start", || said(&said_by, "to vcan1"));

    // A second one would pass the first one's frames back.
    let mut second = Running::start(program(), &arguments, &other);
    assert_eq!(second.end().code(), Some(2));
    assert!(said(&other, "another `tertius inject` uses the interface vcan0"));

    run("canplayer", &["-I", plain(&machine)]);
    run("cansend", &["vcan1", "1D1#0102030405060708"]);
    run("cansend", &["vcan0", "123#FF"]);
    wait_for("the last frame there", || said(&bus1, "123#FF"));
    wait_for("the answer back", || said(&bus0, "1D1#0102030405060708"));
    proxy.signal("TERM");
    assert!(proxy.end().success());

    let (on_bus0, on_bus1) = (heard(&bus0), heard(&bus1));
    let to_machine = on_bus0.iter().filter(|frame| frame.id.value() == 0x1D1).count();
    assert_eq!((on_bus0.len(), to_machine), (frames.len() + 2, 1), "nothing came round");
    // The machine's frames by candump's clock, which is that of the proxy's time stamps.
    write(&machine, "vcan0", on_bus0.iter().filter(|frame| frame.id.value() != 0x1D1));
    let recorded = ["inject", plain(&machine), "--config", plain(&config)];
    run(program(), &[&recorded[..], &["--output", plain(&expected)], &FAULTS[..]].concat());
    let mut on_bus1 = wire(&on_bus1);
    on_bus1.retain(|(id, _)| id.value() != 0x1D1);
    let expected = wire(&read(&expected));
    assert!(expected.len() < frames.len(), "some are lost to a fault");
    let report = std::fs::read_to_string(&said_by).expect("it was written");
    assert!(on_bus1 == expected, "{} of {} frames: {report}", on_bus1.len(), expected.len());
    let (received, sent) = (frames.len() + 1, expected.len());
    assert!(report.contains(&format!("{received} frames received, {sent} sent")), "{report}");
    assert!(report.contains("vcan1 to vcan0: 1 frame received, 1 sent, 0 changed"), "{report}");
    assert!(report.contains("frames changed or lost"), "{report}");
}

#[test]
fn an_interface_that_goes_is_waited_for() {
    let folder = tempfile::tempdir().expect("there is room");
    let path = |name: &str| folder.path().join(name);
    let (bus, log) = (path("bus.log"), path("proxy.log"));
    let config = configuration(folder.path(), "vcan0");
    let count =
        |text: &str| std::fs::read_to_string(&log).map_or(0, |log| log.matches(text).count());
    let ip = |arguments: &str| run("ip", &arguments.split(' ').collect::<Vec<_>>());
    ip("link add dev vcan8 type vcan");
    ip("link set up vcan8");
    let arguments = ["inject", "--from", "vcan8", "--to", "vcan9", "--config", plain(&config)];
    let stale = ["--fault", "stale,cylinder=1", "--for", "60"];
    let mut proxy = Running::start(program(), &[&arguments[..], &stale[..]].concat(), &log);
    wait_for("it to miss the interface", || count("no vcan9: there is no interface vcan9") == 1);
    ip("link add dev vcan9 type vcan");
    ip("link set up vcan9");
    wait_for("it to open the interface", || count("to vcan9 (SocketCAN") == 1);
    for side in ["from vcan8", "to vcan9"] {
        let name = &side[side.len() - 5..];
        ip(&format!("link set down {name}"));
        wait_for("it to lose the interface", || {
            count(&format!("no {name}: the interface is down")) == 1
        });
        ip(&format!("link set up {name}"));
        wait_for("it to open the interface again", || count(&format!("{side} (SocketCAN")) == 2);
    }
    let _dump = listen("vcan9", &bus);
    run("cansend", &["vcan8", "181#010203040506"]);
    wait_for("a frame", || said(&bus, "181#010203040506"));
    proxy.signal("INT");
    assert!(proxy.end().success());
    ip("link delete vcan8");
    ip("link delete vcan9");
}
