//! `tertius monitor` on a bus: it hears everything, and says nothing.

use std::sync::atomic::{AtomicBool, Ordering};
use tertius_testing::bench::{Bench, excerpt, wire};
use tertius_testing::{oracle, program};

#[test]
fn it_judges_what_it_hears_and_sends_nothing() {
    let bench = Bench::up("t-monitor");
    let dump = bench.candump();
    let frames = excerpt(20.0, 50.0);
    let config = bench.name("machine.toml");
    let over = AtomicBool::new(false);
    let told = std::thread::scope(|scope| {
        let person = scope.spawn(|| {
            let told = oracle::run("terminal.py", &["bus", program(), &config], "");
            over.store(true, Ordering::Relaxed);
            told
        });
        bench.play_until(&frames, "all to be judged", || over.load(Ordering::Relaxed));
        person.join().expect("nobody complains")
    });
    assert!(told.contains("bus open"), "{told}");
    drop(dump);
    let heard = std::fs::read_to_string(bench.path("bus.log")).expect("candump wrote it");
    let heard: Vec<String> = heard.lines().map(str::to_owned).collect();
    // candump's start is shown by frames of 7FF.
    let mut known: Vec<u32> = frames.iter().map(|frame| frame.id.value()).chain([0x7FF]).collect();
    known.sort_unstable();
    let id = |frame: &str| frame.split('#').next().and_then(|id| u32::from_str_radix(id, 16).ok());
    let is_strange = |frame: &&str| id(frame).is_none_or(|id| known.binary_search(&id).is_err());
    let strangers: Vec<&str> = wire(&heard).into_iter().filter(is_strange).collect();
    assert_eq!(strangers, [] as [&str; 0], "of {}", heard.len());
    assert!(heard.len() > 1000, "the machine was on the bus: {}", heard.len());
}
