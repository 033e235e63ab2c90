//! Data that are not what they are taken for: each kind is refused, and named in words.

use crate::identify_support::{Simulated, TS};
use tertius::identify::{Census, Expectations};
use tertius::sample::Quality;
use tertius::survey::{Row, Surveyor};

/// A machine of three cylinders, changed by `change`, and what is said of cylinder `n`.
fn verdict(n: usize, change: impl FnMut(&mut [Row; 3])) -> Result<(), String> {
    census(change).judge(n - 1).map_err(|refusal| refusal.to_string())
}

fn census(mut change: impl FnMut(&mut [Row; 3])) -> Census {
    let expected = Expectations {
        seconds: vec![true; 3],
        sample_time: TS,
        area_ratio: 0.5,
        velocity: true,
        pressure: true,
        calibrations: vec![Some((1.002, 0.003)); 3],
    };
    let mut census = Census::new(3, expected);
    let [one, two, three] = [1, 2, 3].map(|n| Simulated::new(n, 2000).noisy().rows());
    for ((one, two), three) in one.into_iter().zip(two).zip(three) {
        let mut rows = [one, two, three];
        change(&mut rows);
        // A cylinder number of zero stands for one that is not there.
        rows.iter().filter(|row| row.cylinder > 0).for_each(|row| census.row(row));
    }
    census
}

#[track_caller]
fn refused(n: usize, words: &[&str], change: impl FnMut(&mut [Row; 3])) {
    let said = verdict(n, change).expect_err("it is refused");
    for word in words {
        assert!(said.contains(word), "{word:?} is not in: {said}");
    }
}

#[test]
fn sound_data_pass() {
    for n in 1..=3 {
        assert_eq!(verdict(n, |_| ()), Ok(()));
    }
    let census = census(|_| ());
    assert!(census.sources(0).velocity && census.sources(0).pressure);
    assert_eq!(census.remarks(0), Vec::<String>::new());
}

#[test]
fn a_constant_signal_is_named() {
    refused(1, &["the command is constant at 0.2 m/s"], |rows| rows[0].u = Some(0.2));
    refused(2, &["the position C1 is constant"], |rows| rows[1].c1 = Some(0.1));
    refused(3, &["the velocity of C1 is constant at 0 m/s"], |rows| rows[2].v1 = Some(0.0));
    refused(1, &["the load pressure is constant at 20 bar"], |rows| {
        (rows[0].pressure_bottom, rows[0].pressure_rod) = (Some(60.0), Some(80.0));
    });
    let still = |rows: &mut [Row; 3]| {
        rows[0].c1 = rows[0].c1.map(|l| 1e-3 * l);
        rows[0].v1 = rows[0].v1.map(|v| 1e-3 * v);
        rows[0].u = rows[0].u.map(|u| 1e-3 * u);
    };
    refused(1, &["it moves over only", "mm, and at least", "record it in motion"], still);
}

#[test]
fn a_missing_cylinder_is_named_and_the_others_pass() {
    let without_two = |rows: &mut [Row; 3]| rows[1].cylinder = 0;
    refused(2, &["no frame of it is in the recording"], without_two);
    assert_eq!(verdict(1, without_two), Ok(()));
    assert_eq!(verdict(3, without_two), Ok(()));
}

#[test]
fn what_never_came_or_was_no_number_is_named() {
    refused(1, &["the command is missing in 2000 of 2000"], |rows| rows[0].u = None);
    refused(1, &["the position C1 is missing", "2000 with a broken wire"], |rows| {
        rows[0].c1 = None;
        rows[0].qualities[0] = Quality::BrokenWire;
    });
    // A position that is not a number comes as one out of range.
    refused(1, &["the position C1 is missing", "2000 out of range"], |rows| {
        rows[0].c1 = None;
        rows[0].raw[0] = Some(f64::NAN);
        rows[0].qualities[0] = Quality::OutOfRange;
    });
    let census = census(|rows| rows[0].v1 = Some(f64::NAN));
    assert_eq!(census.judge(0), Ok(()));
    assert!(!census.sources(0).velocity && census.sources(1).velocity);
    assert!(census.remarks(0)[0].contains("its velocity is configured, but hardly ever came"));
    refused(1, &["none of its 2000 cycles is in a monitored state"], |rows| {
        rows[0].monitored = false;
    });
}

#[test]
fn a_factor_of_a_thousand_is_named() {
    let times = |value: Option<f64>, factor: f64| value.map(|value| factor * value);
    for (factor, guess) in [(1000.0, "a factor of 1000"), (1e-3, "a factor of 1/1000")] {
        let velocity = ["the velocity of C1 is", "the position's slope", guess];
        refused(1, &velocity, |rows| rows[0].v1 = times(rows[0].v1, factor));
        let command = ["the command is", "the motion that follows it", guess];
        refused(1, &command, |rows| rows[0].u = times(rows[0].u, factor));
    }
    refused(1, &["the velocity of C1 is 1", "a factor of 1000"], |rows| {
        rows[0].c1 = times(rows[0].c1, 1e-3);
    });
    refused(1, &["out of range", "millimetres, a factor of 1000"], |rows| {
        (rows[0].raw[0], rows[0].c1) = (times(rows[0].c1, 1000.0), None);
        rows[0].qualities[0] = Quality::OutOfRange;
    });
    refused(1, &["bar, beyond any hydraulics"], |rows| {
        rows[0].pressure_bottom = times(rows[0].pressure_bottom, 1000.0);
        rows[0].pressure_rod = times(rows[0].pressure_rod, 1000.0);
    });
    refused(1, &["its sign is the other way round"], |rows| rows[0].v1 = times(rows[0].v1, -1.0));
}

#[test]
fn swapped_transducers_are_named() {
    refused(1, &["C1 and C2 look swapped"], |rows| {
        let row = &mut rows[0];
        std::mem::swap(&mut row.c1, &mut row.c2);
        std::mem::swap(&mut row.v1, &mut row.v2);
    });
}

#[test]
fn swapped_cylinders_are_named() {
    let swap = |rows: &mut [Row; 3]| {
        let [one, _, three] = rows;
        std::mem::swap(&mut one.u, &mut three.u);
    };
    refused(1, &["follows the command of cylinder 3", "look swapped"], swap);
    refused(3, &["follows the command of cylinder 1", "look swapped"], swap);
    assert_eq!(verdict(2, swap), Ok(()));
}

#[test]
fn commands_that_went_round_are_named() {
    let round = |rows: &mut [Row; 3]| {
        let [one, two, three] = rows.each_ref().map(|row| row.u);
        (rows[0].u, rows[1].u, rows[2].u) = (two, three, one);
    };
    refused(1, &["follows the command of cylinder 3", "look swapped"], round);
    refused(2, &["follows the command of cylinder 1", "look swapped"], round);
    refused(3, &["follows the command of cylinder 2", "look swapped"], round);
}

/// Neighbours on a wave move alike, one behind the other, and a motion follows its command with a lag:
/// so it may be nearest to the command of the cylinder behind. That is no swap.
#[test]
fn neighbours_that_follow_each_other_are_not_swapped() {
    // Of a motion behind its command, on a wave of 8 s; in cycles.
    const LAG: f64 = 8.0;
    let wave = |k: f64| 0.3 * (k * std::f64::consts::TAU / 400.0).sin();
    let mut cycle = 0.0;
    let follow = |rows: &mut [Row; 3]| {
        for (row, behind) in rows.iter_mut().zip([0.0, LAG, 200.0]) {
            row.u = Some(wave(cycle - behind));
            // The position is the integral of a command that the motion follows late.
            let phase = (cycle - behind - LAG) * std::f64::consts::TAU / 400.0;
            row.c1 = Some(-0.3 * 400.0 * TS / std::f64::consts::TAU * phase.cos());
            row.v1 = Some(wave(cycle - behind - LAG));
            row.c2 = row.c1.map(|c1| (c1 - 0.003) / 1.002);
        }
        cycle += 1.0;
    };
    let census = census(follow);
    for index in 0..3 {
        assert_eq!(census.judge(index).map_err(|refusal| refusal.to_string()), Ok(()));
    }
}
