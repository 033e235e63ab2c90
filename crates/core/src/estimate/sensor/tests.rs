use super::*;
use crate::compare::Comparator;
use crate::estimate::Drive;
use crate::sequential::drive::FEATURES;

const TS: f64 = 0.02;
const SETTLE: u32 = 50;

/// A rod that moves slightly faster than its command: 2 mm/s more, which no drive knows.
fn rod(cycle: u64) -> f64 {
    let t = TS * cycle as f64;
    -0.3 * (0.5 * t).cos() + 2e-3 * t.sin()
}

fn command(cycle: u64) -> f64 {
    0.15 * (0.5 * TS * cycle as f64).sin()
}

/// Half a count of noise, the same in every run.
fn noise(cycle: u64, which: u64) -> f64 {
    let mixed = (cycle * 2 + which).wrapping_mul(0x9E37_79B9_7F4A_7C15).rotate_left(29);
    1e-4 * ((mixed % 1000) as f64 / 1000.0 - 0.5)
}

fn sensor() -> VirtualSensor {
    let mut coefficients = [0.0; FEATURES];
    coefficients[0] = 1.0;
    VirtualSensor::new(SensorDesign {
        dynamics: Dynamics::fitted(Drive(coefficients), TS, 5e-5, &EstimateParameters::DEFAULT),
        scale: LengthScale { comparator: Comparator { gain: 1.0, offset: 4e-3 }, reference: None },
        sample_time: TS,
        settle: SETTLE,
        max_gap: 5,
        difference: 1.5e-3,
        bound: 5e-3,
        lengths: (-1.0, 1.0),
        accommodation: None,
        parameters: &EstimateParameters::DEFAULT,
    })
}

/// A sound cycle; C2 is 4 mm short, as the comparator knows.
fn sound(cycle: u64) -> SensorInput {
    SensorInput {
        cycle,
        lengths: [Some(rod(cycle) + noise(cycle, 0)), Some(rod(cycle) + noise(cycle, 1) - 4e-3)],
        velocity: Some(0.0),
        command: Some(command(cycle)),
        follows: true,
        trusted: [true; 2],
        undecided: false,
        resolved: false,
        displaced: [false; 2],
        beyond: [false; 2],
        doubted: false,
        process: false,
        departs: 0.0,
        unseen: 0.0,
    }
}

const LEARNT: u64 = 3000;

/// A sensor that has followed sound readings for a minute.
fn learnt() -> VirtualSensor {
    let mut sensor = sensor();
    for cycle in 1..LEARNT {
        sensor.step(&sound(cycle));
    }
    sensor
}

fn told(sensor: &mut VirtualSensor, input: SensorInput) -> Estimate {
    sensor.step(&input).expect("something is known")
}

fn is_close(estimate: &Estimate, cycle: u64) -> bool {
    (estimate.position - rod(cycle)).abs() < 2.0 * estimate.sigma
}

#[test]
fn nothing_is_valid_before_the_transducers_have_been_followed() {
    let mut sensor = sensor();
    for cycle in 1..400 {
        let estimate = sensor.step(&sound(cycle));
        let valid = estimate.is_some_and(|estimate| estimate.valid);
        assert_eq!(valid, cycle >= u64::from(SETTLE), "{cycle}");
    }
    let lost = SensorInput { lengths: [None; 2], ..sound(400) };
    assert!(told(&mut sensor, lost).valid, "it has followed the command, too");
    sensor.interrupt();
    assert_eq!(sensor.step(&SensorInput { lengths: [None; 2], ..sound(401) }), None);
}

#[test]
fn a_cycle_that_was_not_seen_is_an_interruption() {
    let mut sensor = learnt();
    assert!(told(&mut sensor, sound(LEARNT)).valid);
    for cycle in LEARNT + 2..LEARNT + 1 + u64::from(SETTLE) {
        assert_eq!(sensor.step(&sound(cycle)), None);
    }
    assert!(told(&mut sensor, sound(LEARNT + 1 + u64::from(SETTLE))).valid);
}

#[test]
fn sound_transducers_are_both_used_and_c2_on_the_scale_of_c1() {
    let mut sensor = learnt();
    for cycle in LEARNT..LEARNT + 500 {
        let estimate = told(&mut sensor, sound(cycle));
        assert!(estimate.valid && estimate.source == Source::Both && estimate.sigma < 2e-4);
        assert!(is_close(&estimate, cycle));
    }
    let c1_lost =
        SensorInput { lengths: [None, sound(LEARNT + 500).lengths[1]], ..sound(LEARNT + 500) };
    let c1_blamed = SensorInput { trusted: [false, true], ..c1_lost };
    let estimate = told(&mut sensor, c1_blamed);
    assert!(estimate.valid && estimate.source == Source::C2 && is_close(&estimate, LEARNT + 500));
}

/// Readings of C1 in the half second before it was blamed leave no trace, to the last bit.
#[test]
fn what_a_transducer_did_before_it_was_blamed_is_dropped() {
    let (mut one, mut twin) = (learnt(), learnt());
    for cycle in LEARNT..LEARNT + 25 {
        let mut drifts = sound(cycle);
        drifts.lengths[0] = drifts.lengths[0].map(|c1| c1 + 1e-4 * (cycle - LEARNT) as f64);
        let estimate = told(&mut one, drifts);
        assert!(is_close(&estimate, cycle), "half of the difference is in σ");
        told(&mut twin, sound(cycle));
    }
    for cycle in LEARNT + 25..LEARNT + 100 {
        let blamed = SensorInput { trusted: [false, true], ..sound(cycle) };
        let mut drifts = blamed;
        drifts.lengths[0] = drifts.lengths[0].map(|c1| c1 + 0.05);
        let (estimate, expected) = (told(&mut one, drifts), told(&mut twin, blamed));
        assert_eq!(estimate.position.to_bits(), expected.position.to_bits());
        assert!(estimate.valid && estimate.source == Source::C2);
    }
}

#[test]
fn undecided_is_half_of_the_difference_and_too_much_of_it_is_invalid() {
    for (apart, valid) in [(6e-3, true), (12e-3, false)] {
        let mut sensor = learnt();
        for cycle in LEARNT..LEARNT + 100 {
            let mut undecided = SensorInput { undecided: true, ..sound(cycle) };
            undecided.lengths[0] = undecided.lengths[0].map(|c1| c1 + apart);
            let estimate = told(&mut sensor, undecided);
            if cycle > LEARNT + 50 {
                assert!((estimate.sigma / (0.5 * apart) - 1.0).abs() < 0.1, "{estimate:?}");
                assert!(is_close(&estimate, cycle) && estimate.valid == valid, "{estimate:?}");
            }
        }
    }
}

/// A noise is not trusted at the moment in which it crosses zero.
#[test]
fn while_it_is_undecided_the_largest_difference_of_a_second_counts() {
    let mut sensor = learnt();
    for cycle in LEARNT..LEARNT + 100 {
        let mut undecided = SensorInput { undecided: true, ..sound(cycle) };
        let swing = 8e-3 * (0.3 * (cycle - LEARNT) as f64).sin();
        undecided.lengths[0] = undecided.lengths[0].map(|c1| c1 + swing);
        let estimate = told(&mut sensor, undecided);
        if cycle > LEARNT + 20 {
            assert!(estimate.sigma > 2e-3, "{cycle}: {estimate:?}");
        }
    }
}

#[test]
fn one_alone_needs_a_model_that_is_not_in_doubt() {
    let blamed = |cycle| SensorInput { trusted: [false, true], ..sound(cycle) };
    for (input, valid) in [
        (blamed(LEARNT), true),
        (SensorInput { undecided: true, ..blamed(LEARNT) }, false),
        (SensorInput { process: true, ..blamed(LEARNT) }, false),
        (SensorInput { process: true, ..sound(LEARNT) }, true),
        (SensorInput { process: true, departs: 0.01, ..sound(LEARNT) }, false),
    ] {
        assert_eq!(told(&mut learnt(), input).valid, valid, "{input:?}");
    }
}

/// Of a machine whose threshold is 1.5 mm, a step of 1.2 mm is never found.
#[test]
fn a_step_of_the_last_one_that_nothing_finds_is_within_three_sigma() {
    let stepped = |cycle, unseen| {
        let input = sound(cycle);
        let lengths = [None, input.lengths[1].map(|it| it + 1.2e-3)];
        SensorInput { trusted: [false, true], lengths, unseen, ..input }
    };
    for (unseen, is_covered) in [(0.0, false), (1.5e-3, true)] {
        let mut sensor = learnt();
        let error = |at: u64| {
            let it = told(&mut sensor, stepped(at, unseen));
            assert!(it.valid, "{it:?}");
            (it.position - rod(at)).abs() / it.sigma
        };
        let largest = (LEARNT..LEARNT + 500).map(error).fold(0.0, f64::max);
        assert_eq!(largest <= 3.0, is_covered, "{unseen}: {largest} σ");
    }
}

/// The two differed for half a minute when C2 was lost: it may have been C1 that was wrong.
#[test]
fn what_is_left_of_a_dispute_is_not_believed() {
    let differing = |cycle| SensorInput { undecided: true, ..sound(cycle) };
    let lost = |cycle| {
        let input = sound(cycle);
        SensorInput { trusted: [true, false], lengths: [input.lengths[0], None], ..input }
    };
    let after = |seconds: u64| {
        let mut sensor = learnt();
        let end = LEARNT + 50 * seconds;
        (LEARNT..end).for_each(|cycle| _ = sensor.step(&differing(cycle)));
        (sensor, end)
    };
    let (mut sensor, end) = after(30);
    assert!(!told(&mut sensor, lost(end)).valid);
    assert!(!told(&mut sensor, lost(end + 1)).valid, "nothing has shown who was wrong");
    // A reading that freezes differs before it is found, and one that is named has been the one.
    let (mut short, at) = after(5);
    assert!(told(&mut short, lost(at)).valid);
    let named = SensorInput { resolved: true, ..lost(end + 2) };
    assert!(told(&mut sensor, named).valid);
}

#[test]
fn where_the_rod_does_not_follow_only_both_together_are_believed() {
    let mut sensor = learnt();
    for cycle in LEARNT..LEARNT + 200 {
        let still = SensorInput { follows: false, ..sound(cycle) };
        let estimate = told(&mut sensor, still);
        assert!(estimate.valid && is_close(&estimate, cycle), "{cycle}: {estimate:?}");
    }
    let still = SensorInput { follows: false, ..sound(LEARNT + 200) };
    let alone = SensorInput { trusted: [true, false], ..still };
    assert!(!told(&mut sensor.clone(), alone).valid);
    let lost = SensorInput { lengths: [None; 2], ..still };
    assert_eq!(sensor.step(&lost), None, "the rod may have gone anywhere");
}

#[test]
fn the_command_alone_carries_on_until_its_measured_error_is_too_large() {
    let mut sensor = learnt();
    let (mut before, mut valid) = (0.0, 0);
    for cycle in LEARNT..LEARNT + 2000 {
        let lost =
            SensorInput { lengths: [None; 2], trusted: [cycle < LEARNT + 5; 2], ..sound(cycle) };
        let estimate = told(&mut sensor, lost);
        assert!(estimate.source == Source::Model && estimate.sigma >= before, "{estimate:?}");
        before = estimate.sigma;
        if estimate.valid {
            valid += 1;
            assert!(is_close(&estimate, cycle), "{cycle}: {estimate:?}");
        }
        assert_eq!(estimate.valid, estimate.sigma <= 5e-3);
    }
    assert!((30..1500).contains(&valid), "{valid}");
    let process = |cycle| SensorInput { lengths: [None; 2], process: true, ..sound(cycle) };
    assert!(!told(&mut learnt(), process(LEARNT)).valid, "the model itself is in doubt");
}

/// Both transducers stood still, unnoticed for half a second, and were then blamed for it: the last
/// estimate of the rod is as wrong as they are.
#[test]
fn blame_that_leaves_nobody_goes_back_to_before_it() {
    let mut sensor = learnt();
    let stuck = sound(LEARNT).lengths;
    for cycle in LEARNT..LEARNT + 25 {
        told(&mut sensor, SensorInput { lengths: stuck, ..sound(cycle) });
    }
    for cycle in LEARNT + 25..LEARNT + 50 {
        let blamed = SensorInput { lengths: stuck, trusted: [false; 2], ..sound(cycle) };
        let estimate = told(&mut sensor, blamed);
        assert!((stuck[0].expect("it is") - rod(cycle)).abs() > 0.02, "it went on");
        assert!(estimate.source == Source::Model && is_close(&estimate, cycle), "{estimate:?}");
    }
}

/// C1 stands 10 mm off, and then C2 is lost.
#[test]
fn a_step_that_stood_still_is_subtracted_once_nothing_else_is_left() {
    const STOOD: u64 = 1000;
    let displaced = |cycle| {
        let mut input =
            SensorInput { trusted: [false, true], displaced: [true, false], ..sound(cycle) };
        input.lengths[0] = input.lengths[0].map(|c1| c1 + 0.01);
        input
    };
    let alone = |cycle| {
        let input = SensorInput { trusted: [false; 2], doubted: true, ..displaced(cycle) };
        SensorInput { lengths: [input.lengths[0], None], ..input }
    };
    let stood = |for_cycles: u64, accommodation: Option<AccommodationDesign>| {
        let mut sensor = sensor();
        sensor.design.accommodation = accommodation;
        let mut sensor = VirtualSensor::new(sensor.design);
        for cycle in 1..LEARNT {
            sensor.step(&sound(cycle));
        }
        for cycle in LEARNT..LEARNT + for_cycles {
            assert_eq!(told(&mut sensor, displaced(cycle)).source, Source::C2);
        }
        sensor
    };
    let design = AccommodationDesign { settle: SETTLE, after: 800, most: 500 };
    let mut sensor = stood(STOOD, Some(design));
    for cycle in LEARNT + STOOD..LEARNT + STOOD + 500 {
        let estimate = told(&mut sensor, alone(cycle));
        assert!(estimate.valid && estimate.source == Source::C1Corrected, "{estimate:?}");
        assert!(is_close(&estimate, cycle) && estimate.without > 0.0, "{cycle}: {estimate:?}");
    }
    let end = LEARNT + STOOD + 500;
    let estimate = told(&mut sensor.clone(), alone(end));
    assert!(estimate.source == Source::Model && !estimate.valid, "too old: {estimate:?}");
    // Another step, or another fault, and a step that did not stand for long enough or is not to be subtracted.
    let mut again = stood(STOOD, Some(design));
    let now = LEARNT + STOOD;
    for input in [
        SensorInput { beyond: [true, false], ..alone(now) },
        SensorInput { displaced: [false; 2], ..alone(now) },
    ] {
        let mut sensor = again.clone();
        assert_ne!(told(&mut sensor, input).source, Source::C1Corrected);
        assert_ne!(told(&mut sensor, alone(now + 1)).source, Source::C1Corrected);
    }
    assert_eq!(told(&mut again, alone(now)).source, Source::C1Corrected);
    assert_ne!(
        told(&mut stood(700, Some(design)), alone(LEARNT + 700)).source,
        Source::C1Corrected
    );
    assert_ne!(told(&mut stood(STOOD, None), alone(now)).source, Source::C1Corrected);
}

#[test]
fn a_length_beyond_the_stroke_is_not_valid() {
    let mut sensor = sensor();
    let beyond = |cycle| SensorInput {
        lengths: [Some(1.01), Some(1.006)],
        command: Some(0.0),
        ..sound(cycle)
    };
    for cycle in 1..300 {
        let estimate = sensor.step(&beyond(cycle));
        assert!(estimate.is_none_or(|estimate| !estimate.valid), "{estimate:?}");
    }
}
