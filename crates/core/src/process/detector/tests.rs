use super::*;
use crate::process::Curve;

const SAMPLE_TIME: f64 = 0.02;

fn process() -> Process {
    let scatter =
        core::array::from_fn(|i| core::array::from_fn(|j| if i == j { 1e-10 } else { 0.0 }));
    let flow = FlowDesign {
        limit: 50.0,
        curve: Curve::new(50.0, alloc::vec![-0.5, 0.5]),
        taught: alloc::vec![true],
        between: 0.5,
        leakage: 0.0,
        compression: 0.0,
        area_ratio: 0.5,
        scatter: [scatter; 2],
    };
    Process::new(ProcessDesign {
        spool: None,
        chambers: None,
        flow: Some(flow),
        friction: None,
        level: 25.0,
        sample_time: SAMPLE_TIME,
        clear: 50,
        parameters: &ProcessParameters::DEFAULT,
    })
}

/// What is said of a rod that moves as its oil does, the readings of which drift from the second minute on by `drifts`,
/// m/s. A second later somebody is suspected, and the oil `asked`.
fn said(drifts: [f64; 2], asked: bool) -> Option<f64> {
    let (mut process, mut length, mut last, mut newest) = (process(), 0.0, 0.0, None);
    for k in 0..80 * 50 {
        let time = SAMPLE_TIME * f64::from(k);
        let spool = 20.0 * libm::sin(0.05 * f64::from(k));
        length += SAMPLE_TIME * 0.5 * (last + spool) / 100.0;
        last = spool;
        let [c1, c2] = drifts.map(|drift| length + drift * (time - 60.0).max(0.0));
        let held = time > 61.0;
        let said = process.step(&ProcessInput {
            command: None,
            spool: Some(spool),
            chambers: [None; 2],
            load: Some(0.0),
            supply: Some(210.0),
            lengths: [Some(c1), Some(c2)],
            apart: Some(c1 - c2),
            monitored: true,
            held,
            asked: held && asked,
            at: Timestamp::default(),
        });
        assert!(held || said.is_none(), "nobody has asked");
        newest = said.or(newest);
        assert_eq!(process.alarm(), None);
    }
    newest
}

#[test]
fn the_oil_tells_whose_reading_drifts_where_it_is_asked() {
    for rate in [2e-3, -2e-3] {
        assert!(said([rate, 0.0], true).is_some_and(|nats| nats > 8.0));
        assert!(said([0.0, rate], true).is_some_and(|nats| nats < -8.0));
        assert_eq!(said([rate, 0.0], false), None);
    }
}
