//! What the overview says of a machine besides the lamps of transducers that are judged: why one is to be checked, how large
//! an incident is now, and that nobody has calibrated the machine.

use crate::metrics_support::Bench;
use crate::page::{DELAY, Watcher, json};
use tertius::appliance::telemetry::MachineFacts;
use tertius::appliance::telemetry::clock::Clock;
use tertius::appliance::telemetry::lamp::Lamp;
use tertius::frame::Frame;
use tertius_testing::machine::Cycle;

/// C1 of cylinder 2 drifts away by 1.4 mm/s, and back: its incident stands meanwhile. Its growth is news after five seconds.
#[test]
fn an_open_incident_has_its_size_now_and_the_largest_so_far() {
    let mut bench = Bench::new();
    bench.witness.recorder.opened();
    let mut told = Vec::new();
    for cycles in [0..200, 200..500, 500..600] {
        let offset = |k: i64| ((k.min(1000 - k) - 100).max(0) / 4) as u16;
        let of = |k| Cycle { offset: offset(k), ..Cycle::new(k) }.frames();
        bench.run(&cycles.flat_map(of).collect::<Vec<Frame>>(), DELAY);
        let overview = json(&bench.ask("/api/overview"));
        let incident = &overview["incidents"][0];
        let size = |name: &str| incident[name].as_f64().expect("it is known");
        let place = ["r1", "r2", "r3"].iter().position(|it| incident["quantity"] == *it);
        let newest = bench.witness.records.iter().rfind(|it| it.cylinder == 2).expect("a record");
        let newest = newest.residuals[place.expect("a residual")].expect("it is judged");
        assert!((size("now_m") - newest.abs()).abs() < 1e-12, "{incident}, not {newest}");
        let event = Watcher::new(&bench, 2).event("overview");
        assert_eq!(event["incidents"][0]["now_m"], incident["now_m"]);
        told.push((incident["number"].clone(), size("now_m"), size("peak_m")));
    }
    let [(first, small, peak), (second, large, higher), (third, less, last)] = &told[..] else {
        panic!("{told:?}")
    };
    assert!(first == second && second == third, "one incident: {told:?}");
    assert!(large > small && less < large, "{told:?}");
    assert!(told.iter().all(|(_, now, peak)| peak >= now), "{told:?}");
    assert!(told.iter().all(|(_, now, peak)| peak >= now), "{told:?}");
    assert!(*higher > 2.0 * peak && last >= higher, "{told:?}");
}

/// Warnings of differences that nobody has calibrated are of no incident: without a reason nothing would explain them.
#[test]
fn the_overview_says_that_a_machine_is_not_calibrated() {
    let mut bench = Bench::new();
    bench.witness.recorder.opened();
    let off = |k| Cycle { offset: 30, ..Cycle::new(k) }.frames();
    bench.run(&(0..300).flat_map(off).collect::<Vec<Frame>>(), DELAY);
    let told = |not_calibrated: Vec<u8>| {
        let facts = MachineFacts { not_calibrated, ..MachineFacts::default() };
        bench.witness.recorder.telemetry().describe(facts);
        let overview = json(&bench.ask("/api/overview"));
        assert_eq!(overview["incidents"], serde_json::json!([]), "{overview}");
        assert!(overview["warnings_standing"].as_u64().is_some_and(|it| it > 0), "{overview}");
        (overview["status"].clone(), overview["reason"].as_str().expect("words").to_owned())
    };
    let words = "not calibrated: run `tertius commission`; C1 and C2 have differed from the start";
    assert_eq!(told(vec![2]), ("unknown".into(), words.to_owned()));
    let (status, reason) = told(Vec::new());
    assert!(status == "degraded" && reason.starts_with("a warning of level "), "{reason}");
}

/// What the overview says of a transducer of cylinder 1, and its lamp for all who read numbers.
fn told(bench: &Bench, which: usize) -> (String, Lamp) {
    let overview = json(&bench.ask("/api/overview"));
    let state = &overview["cylinders"][0]["transducers"][which];
    let telemetry = bench.witness.recorder.telemetry();
    let lamp = telemetry.snapshot(bench.hands.uptime()).cylinders[0].lamps[which];
    assert_eq!(state["lamp"], serde_json::json!(lamp), "{overview}");
    (state["words"].as_str().expect("words").to_owned(), lamp)
}

fn good() -> (String, Lamp) {
    ("good".to_owned(), Lamp::Good)
}

const C1_OF_1: u32 = 0x181;

/// Their last byte is the counter. Whole frames beside them are judged, and still something sends the short ones.
#[test]
fn frames_that_lack_what_is_configured_are_to_be_checked_and_never_good() {
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

/// Its readings are judged by their times, and still nothing proves that they are new.
#[test]
fn a_counter_that_does_not_count_is_to_be_checked_and_never_good() {
    let mut bench = Bench::new();
    bench.witness.recorder.opened();
    let frames = |cycles: std::ops::Range<i64>| -> Vec<Frame> {
        let sent = |k: i64, frame: Frame| {
            let mut data = frame.data().to_vec();
            if frame.id.value() == C1_OF_1 && (100..300).contains(&k) {
                data[5] = ((k * k * k * 7_919) >> 7) as u8;
            }
            Frame::new(frame.timestamp, frame.id, frame.kind, &data)
        };
        let of = |k| Cycle::new(k).frames().into_iter().map(move |frame| sent(k, frame));
        cycles.flat_map(of).collect()
    };
    bench.run(&frames(0..100), DELAY);
    assert_eq!(told(&bench, 0), good());
    bench.run(&frames(100..300), DELAY);
    let words = "check function: the alive counter of its frames does not count".to_owned();
    assert_eq!(told(&bench, 0), (words, Lamp::CheckFunction));
    assert_eq!(told(&bench, 1), good());
    bench.run(&frames(300..500), DELAY);
    assert_eq!(told(&bench, 0), good());
}
