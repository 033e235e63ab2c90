//! Recordings of several buses, from one file or each from its own, and what is asked of their configuration.

use tertius_testing::support::{Scratch, Seeded, tertius};
use tertius_testing::top;

const CONFIG: &str = "config/e-type-two-buses.toml";
const FAULT: &str = "step,cylinder=2,sensor=c2,at=12,size=0.004";

/// A recording of the machine with two buses, with a step of a C2 that is on the second.
fn simulated(scratch: &Scratch, config: &str, name: &str) -> String {
    let path = scratch.path(name);
    let call = ["simulate", "--config", config, "--duration", "20", "--seed", "3"];
    tertius(&[&call[..], &["--fault", FAULT, "--output", &path]].concat(), b"").ok();
    scratch.read(name)
}

/// The table of residuals of a replay.
fn residuals(scratch: &Scratch, config: &str, logs: &[&str], options: &[&str]) -> String {
    let table = scratch.path("residuals.csv");
    let logs: Vec<String> = logs.iter().map(|log| scratch.path(log)).collect();
    let logs: Vec<&str> = logs.iter().map(String::as_str).collect();
    let call = ["replay", "--config", config, "--residuals", &table];
    tertius(&[&call[..], options, &logs].concat(), b"").ok();
    scratch.read("residuals.csv")
}

/// The configuration with one bus, otherwise alike.
fn one_bus(scratch: &Scratch) -> String {
    let text = std::fs::read_to_string(top().join(CONFIG)).expect("it ships");
    let text = text.replace("[bus.second]", "").replace("interface = \"can1\"", "");
    let dbc = top().join("dbc/e-type.dbc");
    let text =
        text.replace("second:", "").replace("../dbc/e-type.dbc", dbc.to_str().expect("a path"));
    scratch.write("one.toml", &text)
}

#[test]
fn a_recording_of_two_buses_is_read_from_one_file_or_two_in_any_order() {
    let scratch = Scratch::new();
    let log = simulated(&scratch, CONFIG, "both.log");
    let one = one_bus(&scratch);
    let alike = simulated(&scratch, &one, "one.log");
    assert_eq!(log.replace("can1", "can0"), alike);
    let expected = residuals(&scratch, &one, &["one.log"], &[]);
    assert!(expected.lines().count() > 5000);
    assert_eq!(residuals(&scratch, CONFIG, &["both.log"], &[]), expected);
    let of = |bus: &str| -> String {
        log.split_inclusive('\n').filter(|line| line.contains(bus)).collect()
    };
    scratch.write("can0.log", of(" can0 "));
    scratch.write("can1.log", of(" can1 "));
    for logs in [["can0.log", "can1.log"], ["can1.log", "can0.log"]] {
        assert_eq!(residuals(&scratch, CONFIG, &logs, &[]), expected, "{logs:?}");
    }
    // A recorder that empties one queue after the other writes them out of order.
    let mut lines: Vec<&str> = log.lines().collect();
    let mut seeded = Seeded(7);
    let mut at = 0;
    while at < lines.len() {
        let end = (at + 1 + seeded.below(10) as usize).min(lines.len());
        lines[at..end].sort_by_key(|line| line.contains(" can1 "));
        at = end;
    }
    scratch.write("late.log", &(lines.join("\n") + "\n"));
    assert_eq!(residuals(&scratch, CONFIG, &["late.log"], &[]), expected);
}

#[test]
fn a_recording_of_two_buses_may_be_cut_anywhere() {
    let scratch = Scratch::new();
    let log = simulated(&scratch, CONFIG, "both.log");
    // Both buses write at the same times, a recorder writes one of them late, and the clock is set back once.
    let first = |line: &str| line[1..11].parse::<i64>().expect("seconds");
    let start = first(&log);
    let lines: Vec<String> = { log.split_inclusive('\n') }
        .map(|line| {
            let micros = line[12..18].parse::<i64>().expect("microseconds") / 1000 * 1000;
            let back = if first(line) - start < 15 { 0 } else { 5 };
            format!("({}.{micros:06}){}", first(line) - back, &line[19..])
        })
        .collect();
    let mut lines: Vec<&str> = lines.iter().map(String::as_str).collect();
    lines.chunks_mut(7).for_each(|chunk| chunk.sort_by_key(|line| line.contains(" can0 ")));
    scratch.write("whole.log", lines.concat());
    let expected = residuals(&scratch, CONFIG, &["whole.log"], &[]);
    let mut seeded = Seeded(5);
    let cut = |at: &[usize]| {
        let ends = at.iter().copied().chain([lines.len()]);
        let mut begin = 0;
        let pieces = ends.enumerate().map(|(n, end)| {
            let piece = format!("{n}.log");
            scratch.write(&piece, lines[begin..end].concat());
            begin = end;
            piece
        });
        let pieces: Vec<String> = pieces.collect();
        let pieces: Vec<&str> = pieces.iter().map(String::as_str).collect();
        assert!(residuals(&scratch, CONFIG, &pieces, &[]) == expected, "cut at {at:?}");
    };
    let begins_with = |interface: &str, from: usize| {
        from + lines[from..].iter().position(|line| line.contains(interface)).expect("it is there")
    };
    // The last piece begins before the clock's step back in the piece before it.
    for order in [[" can0 ", " can1 "], [" can1 ", " can0 "]] {
        cut(&[begins_with(order[0], 9000), begins_with(order[1], 18_000)]);
    }
    // In several pieces, one of few frames.
    for _ in 0..4 {
        let mut places: Vec<usize> = (0..3).map(|_| seeded.below(9000) as usize + 1).collect();
        places.extend([places[0] + 1 + seeded.below(7) as usize, 17_500]);
        places.sort_unstable();
        places.dedup();
        cut(&places);
    }
}

#[test]
fn several_files_of_each_bus_are_merged() {
    let scratch = Scratch::new();
    let log = simulated(&scratch, CONFIG, "both.log");
    let expected = residuals(&scratch, CONFIG, &["both.log"], &[]);
    for bus in ["can0", "can1"] {
        let of: Vec<&str> = log.split_inclusive('\n').filter(|line| line.contains(bus)).collect();
        // Not both at the same time.
        let (ahead, behind) = of.split_at(if bus == "can0" { 4000 } else { 2500 });
        scratch.write(&format!("{bus}-1.log"), ahead.concat());
        scratch.write(&format!("{bus}-2.log"), behind.concat());
    }
    for logs in [
        ["can0-1.log", "can0-2.log", "can1-1.log", "can1-2.log"],
        ["can1-1.log", "can0-1.log", "can0-2.log", "can1-2.log"],
    ] {
        assert!(residuals(&scratch, CONFIG, &logs, &[]) == expected, "{logs:?}");
    }
}

#[test]
fn interfaces_of_other_names_are_mapped_to_the_buses() {
    let scratch = Scratch::new();
    let log = simulated(&scratch, CONFIG, "both.log");
    let expected = residuals(&scratch, CONFIG, &["both.log"], &[]);
    scratch.write("renamed.log", log.replace("can0", "vcan7").replace("can1", "vcan3"));
    let mapped = ["--interface", "first=vcan7,second=vcan3"];
    assert_eq!(residuals(&scratch, CONFIG, &["renamed.log"], &mapped), expected);
    let renamed = scratch.path("renamed.log");
    let call = ["replay", &renamed, "--config", CONFIG];
    tertius(&call, b"").failed(1, &["no frame is from can0 or can1"]);
    let call = [&call[..], &["--interface", "vcan7"]].concat();
    tertius(&call, b"").failed(2, &["found \"vcan7\", expected a bus", "first=can0"]);
}

#[test]
fn a_fault_is_put_into_the_frames_of_its_bus() {
    let scratch = Scratch::new();
    // Two transducers of one kind, with the same identifiers on two buses.
    let text = std::fs::read_to_string(top().join(CONFIG)).expect("it ships");
    let dbc = top().join("dbc/e-type.dbc");
    let text = text.replace("second:Cyl{n}_C2", "second:Cyl{n}_C1");
    let config = scratch
        .write("alike.toml", text.replace("../dbc/e-type.dbc", dbc.to_str().expect("a path")));
    let healthy = scratch.path("healthy.log");
    let call = ["simulate", "--config", &config, "--duration", "20", "--output", &healthy];
    tertius(&call, b"").ok();
    let faulty = scratch.path("faulty.log");
    let call = ["inject", &healthy, "--config", &config, "--fault", FAULT, "--output", &faulty];
    tertius(&call, b"").ok();
    let (before, after) = (scratch.read("healthy.log"), scratch.read("faulty.log"));
    let changed = before.lines().zip(after.lines()).filter(|(one, other)| one != other);
    let changed: Vec<&str> = changed.map(|(_, other)| other).collect();
    assert!(changed.len() > 300, "{}", changed.len());
    assert!(changed.iter().all(|line| line.contains(" can1 182#")), "{:?}", changed.first());
}
