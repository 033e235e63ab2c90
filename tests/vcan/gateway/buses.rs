//! A gateway on two interfaces.

use std::fs;
use std::process::Command;
use tertius_testing::bench::{Bench, Running, ip, wait_for, wire};
use tertius_testing::program;

/// The second interface of a bench; the first is its own.
struct Second(&'static str);

impl Second {
    fn up(name: &'static str) -> Self {
        ip(&["link", "add", "dev", name, "type", "vcan"]);
        ip(&["link", "set", "up", name]);
        Self(name)
    }
}

impl Drop for Second {
    fn drop(&mut self) {
        _ = Command::new("ip").args(["link", "delete", self.0]).output();
    }
}

/// A bench with the machine that has its C2 on another bus, and a recording of it.
fn bench(first: &'static str, second: &'static str) -> (Bench, Second) {
    let bench = Bench::up(first);
    let other = Second::up(second);
    let top = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
    let text = fs::read_to_string(top.join("config/e-type-two-buses.toml")).expect("it ships");
    let text = text
        .replace("\"can0\"", &format!("{first:?}"))
        .replace("\"can1\"", &format!("{second:?}"))
        .replace("\"../dbc/e-type.dbc\"", &format!("{:?}", top.join("dbc/e-type.dbc")));
    // Not even on a busy box is a warning dropped for its age then, or a frame longer on its way
    // into the queue than the guard lasts.
    bench.configure(&(text + "\n[gateway]\nmax_age = 10.0\nguard = 0.5\n"));
    let log = bench.name("machine.log");
    let call = ["simulate", "--config", &bench.name("machine.toml"), "--duration", "8"];
    let output = Command::new(program())
        .args(call)
        .args(["--fault", "step,cylinder=3,sensor=c2,at=4,size=0.005", "--output", &log])
        .output()
        .expect("it runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    (bench, other)
}

impl Second {
    /// Starts candump of both interfaces.
    fn candump(&self, bench: &Bench) -> Running {
        let arguments = ["-r", "16777216", "-L", bench.interface, self.0];
        let dump = Running::start("candump", &arguments, &bench.path("both.log"));
        for interface in [bench.interface, self.0] {
            wait_for("candump's start", || {
                let sent = Command::new("cansend").args([interface, "7FF#"]).status();
                assert!(sent.expect("cansend runs").success());
                let log = fs::read_to_string(bench.path("both.log")).unwrap_or_default();
                log.lines().any(|line| line.contains(&format!(" {interface} 7FF")))
            });
        }
        dump
    }
}

fn warnings(log: &str) -> Vec<String> {
    let lines: Vec<String> = log.lines().map(str::to_owned).collect();
    wire(&lines).into_iter().filter(|it| it.starts_with("2D1#")).map(str::to_owned).collect()
}

#[test]
fn two_interfaces_have_the_warnings_of_the_replay_of_both() {
    let (bench, second) = bench("t-first", "t-second");
    let dump = second.candump(&bench);
    let gateway = bench.gateway();
    let player = ["-I", &bench.name("machine.log")];
    assert!(Command::new("canplayer").args(player).status().expect("it runs").success());
    gateway.signal("TERM");
    wait_for("the end", || bench.said("stopped") == 1);
    drop(dump);
    let both = fs::read_to_string(bench.path("both.log")).expect("candump wrote");
    assert!(!both.lines().any(|line| line.contains("t-second 2D1#")), "it sends on the first only");
    let config = bench.name("machine.toml");
    let replay = Command::new(program())
        .args(["replay", &bench.name("both.log"), "--config", &config])
        .args(["--warnings", &bench.name("replayed.log")])
        .output()
        .expect("it runs");
    assert!(replay.status.success(), "{}", String::from_utf8_lossy(&replay.stderr));
    let replayed = warnings(&fs::read_to_string(bench.path("replayed.log")).expect("it wrote"));
    let live = warnings(&both);
    assert!(!live.is_empty() && live.len() <= replayed.len(), "{} {}", live.len(), replayed.len());
    let same = live.iter().zip(&replayed).take_while(|(live, replayed)| live == replayed).count();
    assert_eq!(same, live.len(), "they differ from {:?} on", live.get(same));
}

#[test]
fn it_goes_on_without_the_second_interface_and_takes_it_back() {
    let (bench, second) = bench("t-stays", "t-leaves");
    let _gateway = bench.gateway();
    let _dump = bench.candump();
    // A player of both would stop where one is down.
    let play = |interface: &str| {
        let both = fs::read_to_string(bench.path("machine.log")).expect("it was written");
        let own = |line: &&str| line.contains(&format!(" {interface} "));
        let own: Vec<&str> = both.lines().filter(own).collect();
        fs::write(bench.path(interface), own.join("\n") + "\n").expect("the folder is ours");
        let arguments = ["-l", "i", "-I", &bench.name(interface)];
        Running::start("canplayer", &arguments, &bench.path("player.log"))
    };
    let _players = [play(bench.interface), play(second.0)];
    wait_for("it to speak", || !bench.own_lines().is_empty());
    ip(&["link", "set", "down", second.0]);
    wait_for("it to notice", || bench.said("the second bus was lost") == 1);
    wait_for("the silence to be told", || bench.said("the second bus is silent") == 1);
    ip(&["link", "set", "up", second.0]);
    let _returned = play(second.0);
    wait_for("it to hear it again", || bench.said("the second bus is heard again") == 1);
    assert_eq!(bench.said("open: "), 1, "the first one was never lost");
}
