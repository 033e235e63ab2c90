//! What is no fault of a transducer, and what the sequential detectors say of it: nothing.

#[path = "sequential_support/mod.rs"]
mod support;

use support::{Heard, SAMPLE_TIME, fine, setup};
use tertius::controller::State;
use tertius::simulator::{EPOCH, Options};

/// As `tune` writes it from half an hour of a good machine, nats.
const LOW_LEVEL: f64 = 12.0;

#[track_caller]
fn nothing(heard: &Heard, what: &str) {
    assert!(heard.warnings.is_empty(), "{what}\n{}", heard.told());
}

/// Single samples, seconds apart, on either transducer, also at a low level.
#[test]
fn spikes() {
    let of = |size: f64| -> Vec<String> {
        let one = |n: u8| {
            let sensor = if n % 2 == 1 { "c1" } else { "c2" };
            format!("spike,size={size},probability=0.005,cylinder={n},sensor={sensor},at=2")
        };
        (1..=6).map(one).collect()
    };
    for size in [0.001, 0.005, -0.005, 0.3] {
        nothing(&setup().run(300.0, false, &of(size)), &format!("{size} m"));
        let low = setup().at_level(LOW_LEVEL).run(300.0, false, &of(size));
        nothing(&low, &format!("{size} m at a low level"));
    }
}
