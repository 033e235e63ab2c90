//! Frames decoded per second, four signals each: `cargo bench --bench decode`.

use std::hint::black_box;
use std::time::Instant;

use tertius::dbc::Database;
use tertius::decode::{Decoded, SignalPlan};
use tertius::frame::{Frame, Id, Kind};
use tertius::time::Timestamp;

const CASES: [(&str, &str); 4] = [
    (
        "Intel, as the default machine",
        "BO_ 1 M: 8 A\n SG_ S0 : 0|16@1+ (0.0001085,-1.5) [0|0] \"\" A\n SG_ S1 : 16|16@1- (0.0001,0) [0|0] \"\" A\n SG_ S2 : 32|8@1+ (1,0) [0|0] \"\" A\n SG_ S3 : 40|8@1+ (1,0) [0|0] \"\" A\n",
    ),
    (
        "Motorola, unaligned",
        "BO_ 1 M: 8 A\n SG_ S0 : 6|13@0+ (0.1,-1.5) [0|0] \"\" A\n SG_ S1 : 9|17@0- (0.1,0) [0|0] \"\" A\n SG_ S2 : 39|11@0+ (1,0) [0|0] \"\" A\n SG_ S3 : 55|16@0- (1,0) [0|0] \"\" A\n",
    ),
    (
        "multiplexed",
        "BO_ 1 M: 8 A\n SG_ S0 M : 0|1@1+ (1,0) [0|0] \"\" A\n SG_ S1 m0 : 8|16@1- (0.1,0) [0|0] \"\" A\n SG_ S2 m1 : 8|16@1- (1,0) [0|0] \"\" A\n SG_ S3 : 24|16@1- (1,0) [0|0] \"\" A\n",
    ),
    (
        "32-bit floats and 64 bits over nine bytes",
        "BO_ 1 M: 64 A\n SG_ S0 : 0|32@1- (1,0) [0|0] \"\" A\n SG_ S1 : 39|32@0- (0.1,0) [0|0] \"\" A\n SG_ S2 : 67|64@1- (1,0) [0|0] \"\" A\n SG_ S3 : 200|64@1+ (1,0) [0|0] \"\" A\nSIG_VALTYPE_ 1 S0 : 1;\nSIG_VALTYPE_ 1 S1 : 1;\n",
    ),
];

/// Frames of a working set that stays in the processor's cache.
const FRAMES: usize = 256;
/// Over all frames, a measurement; the best measurement counts, since other work can only slow it.
const ROUNDS: usize = 2000;
const MEASUREMENTS: usize = 40;

fn frames(length: usize) -> Vec<Frame> {
    (0..FRAMES)
        .map(|number| {
            let data: Vec<u8> =
                (0..length).map(|i| (number * 31 + i * 97 + number / 7) as u8).collect();
            Frame::new(Timestamp::default(), Id::standard(1).unwrap(), Kind::Data, &data)
        })
        .collect()
}

fn sum(plans: &[&SignalPlan; 4], frames: &[Frame]) -> f64 {
    let mut sums = [0.0; 4];
    for frame in frames {
        for (plan, sum) in plans.iter().zip(&mut sums) {
            if let Decoded::Value(value) = plan.decode(frame) {
                *sum += value.physical;
            }
        }
    }
    sums.iter().sum()
}

fn main() {
    for (name, text) in CASES {
        let database = Database::parse(text).unwrap();
        let message = database.message("M").unwrap();
        let plans = [0, 1, 2, 3].map(|i| &message.signals[i].plan);
        let frames = frames(message.length);
        let mut best = f64::INFINITY;
        for _ in 0..MEASUREMENTS {
            let start = Instant::now();
            for _ in 0..ROUNDS {
                black_box(sum(black_box(&plans), black_box(&frames)));
            }
            best = best.min(start.elapsed().as_secs_f64());
        }
        let rate = (ROUNDS * FRAMES) as f64 / best / 1e6;
        println!("{rate:7.1} M frames/s of 4 signals: {name}");
    }
}
