//! Tests of the bank.

use super::*;
use crate::time::Span;

fn bank() -> Bank {
    bank_with(1e-3, f64::INFINITY)
}

fn bank_with(high: f64, joint: f64) -> Bank {
    let clear = Span::from_seconds(1.0);
    let thresholds = |high: f64| Thresholds { low: 0.75 * high, high, clear };
    let design = || crate::observe::observer::ObserverDesign {
        a: nalgebra::Matrix3::identity(),
        b: nalgebra::Vector3::zeros(),
        l: nalgebra::Matrix3x2::zeros(),
        settle: 0,
        max_gap: 0,
    };
    Bank::new(&BankDesign {
        observer: thresholds(high),
        joint,
        difference: thresholds(1.5e-3),
        lasting: VerdictParameters::DEFAULT.lasting,
        calibrated: true,
        signatures: [design(), design()].map(|design| Signatures::of_innovation(&design)),
        parameters: &VerdictParameters::DEFAULT,
        sample_time: 0.02,
    })
}

/// Returns whether FDE3 has found anything then.
fn run(bank: &mut Bank, cycles: std::ops::Range<i64>, r: [f64; 3]) -> bool {
    for cycle in cycles {
        let at = Timestamp::from_nanos(cycle * 20_000_000);
        bank.judge(at, &Residuals { r: r.map(Some) }, [None; 2], Some(0.0), None);
    }
    bank.detections()[FDE3].is_some()
}

/// δ_h is 4 mm, as fluctuations teach it, and a transducer steps by 1.2 mm.
#[test]
fn one_observer_and_the_difference_find_together_what_neither_does_alone() {
    let jump = Jump { apart: 1.2e-3, change: 1.25e-3 };
    for (r, jump, observer) in [
        ([1.2e-3, 0.1e-3, 1.2e-3], jump, Some(0)),
        ([0.1e-3, -1.2e-3, 1.2e-3], jump, Some(1)),
        ([0.1e-3, -1.2e-3, -1.2e-3], jump.reversed(), None),
        ([0.1e-3, 1.2e-3, -1.2e-3], jump.reversed(), Some(1)),
        ([1.2e-3, 0.4e-3, 1.2e-3], jump, None),
    ] {
        let mut bank = bank_with(4e-3, 1e-3);
        let residuals = Residuals { r: r.map(Some) };
        for cycle in -2..1 {
            assert_eq!(bank.detections(), [None; 3], "it has to last");
            let at = Timestamp::from_nanos(cycle * 20_000_000);
            bank.judge(at, &residuals, [None; 2], Some(0.0), Some(jump));
        }
        let found = bank.detections().map(|it| it.map(|it| (it.residual, it.threshold)));
        let expected = [0, 1, 2].map(|i| (observer == Some(i)).then_some((r[i], 1e-3)));
        assert_eq!(found, expected, "{r:?}");
        // The difference stays, and is no jump any more: it ends as any other.
        for cycle in 1..60 {
            let at = Timestamp::from_nanos(cycle * 20_000_000);
            let quiet = Residuals { r: [Some(0.1e-3), Some(0.1e-3), Some(1.2e-3)] };
            bank.judge(at, &quiet, [None; 2], Some(0.0), Some(Jump { apart: 1.2e-3, change: 0.0 }));
        }
        assert_eq!(bank.detections(), [None; 3]);
    }
}

/// Threshold that C1's residual `own`, m, is reported with after a sample or three, where C1 − C2 is as large and has moved by
/// `change`.
fn threshold_of_c1(bank: &mut Bank, cycle: i64, own: f64, change: f64) -> Option<f64> {
    let residuals = Residuals { r: [own, 0.1e-3, own].map(Some) };
    let jump = Some(Jump { apart: own, change });
    let samples = if bank.any_found() { 1 } else { 3 };
    for sample in 0..samples {
        let at = Timestamp::from_nanos((3 * cycle + sample) * 20_000_000);
        bank.judge(at, &residuals, [None; 2], Some(0.0), jump);
    }
    bank.detections()[0].map(|it| it.threshold)
}

#[test]
fn a_residual_beyond_its_own_threshold_is_reported_with_that() {
    let mut bank = bank_with(4e-3, 1e-3);
    let mut judge = |cycle: i64, own: f64| threshold_of_c1(&mut bank, cycle, own, own);
    assert_eq!([judge(0, 0.5e-3), judge(1, 1.2e-3)], [None, Some(1e-3)]);
    assert_eq!([judge(2, 5e-3), judge(3, 1.2e-3)], [Some(4e-3); 2]);
}

#[test]
fn the_next_fault_is_not_reported_with_the_threshold_of_joint_evidence() {
    let mut bank = bank_with(4e-3, 1e-3);
    let mut judge = |cycle, own, change| threshold_of_c1(&mut bank, cycle, own, change);
    assert_eq!(judge(0, 1.2e-3, 1.2e-3), Some(1e-3));
    let cleared = (1..100).filter(|cycle| judge(*cycle, 0.1e-3, 0.0).is_none()).count();
    assert!(cleared > 0, "it stands for ever");
    // A growing error has no jump.
    assert_eq!(judge(100, 5e-3, 0.0), Some(4e-3));
}

#[test]
fn a_spike_is_neither_a_fault_nor_healthy_and_the_difference_has_to_last_too() {
    let mut bank = bank();
    for cycle in 0..40 {
        let wild = if cycle % 8 < 2 { 40e-3 } else { 0.1e-3 };
        assert!(!run(&mut bank, cycle..cycle + 1, [wild, 0.0, wild]), "{cycle}");
        let seen = if cycle % 8 < 2 { Verdict::Unknown } else { Verdict::Healthy };
        assert_eq!(bank.verdicts(), [seen, Verdict::Healthy, seen], "{cycle}");
    }
    assert!(run(&mut bank, 42..45, [2e-3, 0.0, 2e-3]));
    assert_eq!(bank.verdicts(), [Verdict::Faulty, Verdict::Healthy, Verdict::Faulty]);
}

/// Three wild readings in a row have raised FDE1. It stood for an hour, since each further one was beyond the threshold.
#[test]
fn single_wild_readings_keep_nothing_raised() {
    let raised_for = |every: i64| {
        let mut bank = bank();
        run(&mut bank, 0..50, [0.0; 3]);
        run(&mut bank, 50..53, [5e-3, 0.0, 0.0]);
        let goes_on = |k: &i64| {
            let r1 = if k % every == 0 { 5e-3 } else { 0.0 };
            run(&mut bank, *k..k + 1, [r1, 0.0, 0.0]);
            bank.detections()[0].is_some()
        };
        (53..3000).take_while(goes_on).count()
    };
    assert!((45..60).contains(&raised_for(25)), "{}", raised_for(25));
    assert!(raised_for(4) > 2900, "noise goes on");
}

/// Residuals of a long time, calm and not, with cycles in which some are absent or no number.
#[test]
fn a_calm_cycle_is_judged_as_any_other() {
    let mut state = 1_u64;
    let mut draw = move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (state >> 40) as f64 / (1_u64 << 24) as f64
    };
    for joint in [f64::INFINITY, 1e-3] {
        let (mut asked, mut quick) = (bank_with(4e-3, joint), bank_with(4e-3, joint));
        let (mut calm, mut found) = (0, 0);
        for cycle in 0..20_000 {
            let size = match cycle / 500 % 2 {
                0 => 0.2,
                _ if draw() < 0.01 => 3.0,
                // Now and then it lasts.
                _ if cycle % 100 < 10 => 1.6,
                _ => 0.9,
            };
            let is_up = size == 1.6;
            let mut one = |high: f64| match draw() {
                it if it < 0.02 => None,
                it if it < 0.03 => Some(f64::NAN),
                _ if is_up => Some((1.0 + draw()) * 0.5 * size * high),
                _ => Some((2.0 * draw() - 1.0) * size * high),
            };
            let residuals = Residuals { r: [one(4e-3), one(4e-3), one(1.5e-3)] };
            let jump = residuals.r[2].map(|apart| Jump { apart, change: apart });
            let at = Timestamp::from_nanos(cycle * 20_000_000);
            asked.judge(at, &residuals, [None; 2], Some(0.0), jump);
            if quick.take_calm(&residuals) {
                calm += 1;
            } else {
                quick.judge(at, &residuals, [None; 2], Some(0.0), jump);
            }
            if cycle % 5_000 == 4_999 {
                asked.interrupt();
                quick.interrupt();
            }
            // Formatted, as no number is not equal to itself.
            let all = |bank: &Bank| format!("{bank:?}");
            assert_eq!(all(&asked), all(&quick), "{cycle}: {residuals:?}");
            found += u32::from(asked.any_found());
        }
        assert!(calm > 1_000 && found > 1_000, "{calm} calm, {found} with a finding");
    }
}

/// A step of 4 mm, which an observer follows: in the third sample only two thirds of it are left.
#[test]
fn a_fault_is_as_old_and_as_large_as_the_first_sample_of_it() {
    let mut bank = bank();
    for (cycle, residual) in [(0, 4e-3), (1, 3.2e-3), (2, 2.6e-3)] {
        assert_eq!(bank.detections(), [None; 3], "it has to last");
        run(&mut bank, cycle..cycle + 1, [0.0, 0.0, residual]);
    }
    assert_eq!(bank.difference_age(), Some(2));
    assert_eq!(bank.detections()[FDE3].map(|it| it.residual), Some(4e-3));
    run(&mut bank, 3..4, [0.0, 0.0, 2.5e-3]);
    assert_eq!(bank.difference_age(), Some(3));
    assert_eq!(bank.detections()[FDE3].map(|it| it.residual), Some(2.5e-3));
}
