//! What the overview says of a machine besides the lamps of transducers that are judged: why one is to be checked.

use crate::metrics_support::Bench;
use crate::page::{DELAY, json};
use tertius::appliance::telemetry::clock::Clock;
use tertius::appliance::telemetry::lamp::Lamp;
use tertius::frame::Frame;
use tertius_testing::machine::Cycle;

/// Their last byte is the counter. Whole frames beside them are judged, and still something sends the short ones.
#[test]
fn frames_that_lack_what_is_configured_are_to_be_checked_and_never_good() {
    const C1_OF_1: u32 = 0x181;
    let cut = |frame: &Frame| Frame::new(frame.timestamp, frame.id, frame.kind, &frame.data()[..5]);
    for has_whole_ones in [false, true] {
        let mut bench = Bench::new();
        bench.witness.recorder.opened();
        let sent = |k: i64, frame: Frame| match (100..200).contains(&k) {
            true if frame.id.value() != C1_OF_1 => vec![frame],
            true if has_whole_ones => vec![cut(&frame), frame],
            true => vec![cut(&frame)],
            false => vec![frame],
        };
        let frames = |cycles: std::ops::Range<i64>| -> Vec<Frame> {
            let of = |k| Cycle::new(k).frames().into_iter().flat_map(move |it| sent(k, it));
            cycles.flat_map(of).collect()
        };
        let told = |bench: &Bench, which: usize| {
            let overview = json(&bench.ask("/api/overview"));
            let state = &overview["cylinders"][0]["transducers"][which];
            let telemetry = bench.witness.recorder.telemetry();
            let number = telemetry.snapshot(bench.hands.uptime()).cylinders[0].lamps[which];
            (state["words"].as_str().expect("words").to_owned(), number)
        };
        let good = || ("good".to_owned(), Lamp::Good);
        bench.run(&frames(0..100), DELAY);
        assert_eq!(told(&bench, 0), good());
        bench.run(&frames(100..200), DELAY);
        let words = "check function: its frames are too short for the configuration".to_owned();
        assert_eq!(told(&bench, 0), (words, Lamp::CheckFunction), "{has_whole_ones}");
        assert_eq!(told(&bench, 1), good(), "{has_whole_ones}");
        bench.run(&frames(200..400), DELAY);
        assert_eq!(told(&bench, 0), good(), "{has_whole_ones}");
    }
}
