//! Figures of an independent computation of the same limits, and what holds for all healthy transducers.

use super::law::{Atom, Law};
use super::limits::{HealthyCylinder, LimitLevels, LimitTable, SmallestStep};
use super::noise::CoreNoise;
use super::renewal::log_moments;
use super::runs::{RunLimits, boxes};
use super::sums::{SumLimits, clips};
use super::survival::Survival;
use tertius_core::sequential::excursions::BOXES;
use tertius_core::sequential::windows::WIDTHS;

/// Levels of the figures, nats.
const LEVELS: LimitLevels = LimitLevels { sums: 20.0, wide_clips: 24.5, runs: 24.0 };

/// Deviation of the noise, m.
const NOISE: f64 = 0.0838e-3;

/// A normal core in bins of 0.01 mm up to 8 deviations.
fn core() -> CoreNoise {
    let density = |i: u32| (-0.5 * ((f64::from(i) + 0.5) * 1e-5 / NOISE).powi(2)).exp();
    let total: f64 = (0..67).map(density).sum();
    CoreNoise { bin: 1e-5, shares: (0..67).map(|i| density(i) / total).collect() }
}

fn law(chance: f64, atoms: &[(f64, u32, f64)]) -> Law {
    let atom = |(size, length, weight): &(f64, u32, f64)| Atom {
        size: *size,
        length: *length,
        weight: *weight,
    };
    Law { chance, atoms: atoms.iter().map(atom).collect() }
}

fn one_size() -> Law {
    law(3e-4, &[(0.44e-3, 10, 1.0)])
}

fn none() -> Law {
    law(0.0, &[])
}

fn healthy(law: Law) -> HealthyCylinder {
    HealthyCylinder {
        law,
        sizes_95: 0.44e-3,
        weighted: core(),
        fastest: core(),
        rest: NOISE,
        timing: 0.0,
        mean_square_velocity: 0.0,
        wild_share: 0.0,
    }
}

/// Whether these agree to `digits` decimals.
fn agree(computed: &[f64], expected: &[f64], digits: i32) {
    assert_eq!(computed.len(), expected.len());
    for (computed, expected) in computed.iter().zip(expected) {
        let half = 0.500_001 * 10_f64.powi(-digits);
        assert!((computed - expected).abs() < half, "{computed} is not {expected}");
    }
}

/// Means over each of `widths`, mm, of limits in m.
fn means(limits: &[f64], widths: &[usize]) -> Vec<f64> {
    limits.iter().zip(widths).map(|(limit, width)| 1e3 * limit / *width as f64).collect()
}

#[test]
fn moments_are_those_of_an_independent_computation() {
    let law = law(3e-4, &[(1e-3, 10, 1.0)]);
    let survival = Survival::of(&law, 64).expect("there are excursions");
    let moments = log_moments(&survival, 3e-4, &[2_f64.ln()], &[1, 5, 10, 20, 64]);
    agree(&moments[..1], &[0.003_284_73], 8);
    agree(&moments[1..2], &[0.077_394_1], 7);
    agree(&moments[2..3], &[0.797_082], 6);
    agree(&moments[3..], &[1.824_66, 6.638_09], 5);
}

/// An excursion whose law is written as two atoms has the moments of one atom.
#[test]
fn moments_do_not_depend_on_how_the_law_is_written() {
    let atoms = [(1e-3, 10, 0.25), (2e-3, 3, 0.5), (1e-3, 10, 0.25), (1e-3, 2000, 0.0)];
    let split = Survival::of(&law(1e-3, &atoms), 64).expect("there are excursions");
    let joint = Survival::of(&law(1e-3, &[(2e-3, 3, 0.5), (1e-3, 10, 0.5)]), 64);
    assert_eq!(Some(split), joint);
}

/// The same as [`log_moments`], from the chain of Markov whose states are the samples that are left of an excursion.
#[test]
fn moments_are_those_of_a_markov_chain() {
    let lengths = [(3_usize, 0.3, 0.7), (8, 0.05, 0.3)];
    let chance = 0.02;
    let atoms = lengths.map(|(length, gain, share)| (gain, length as u32, share));
    let survival = Survival::of(&law(chance, &atoms), 40).expect("there are excursions");
    // The sizes in ascending order are 0.05 and 0.3: their gains are themselves.
    let computed = log_moments(&survival, chance, &[0.05, 0.3], &[1, 2, 3, 7, 40]);
    let mean: f64 = lengths.iter().map(|(length, _, share)| share * *length as f64).sum();
    let free = 1.0 / (1.0 + chance * mean);
    for (width, computed) in [1, 2, 3, 7, 40].into_iter().zip(computed) {
        // The state before the first sample, where an excursion may have as many samples left as it is long.
        let mut idle = free;
        let mut left = lengths.map(|(length, _, share)| vec![free * chance * share; length + 1]);
        for left in &mut left {
            left[0] = 0.0;
        }
        for _ in 0..width {
            // Excursions with no sample left have ended.
            let ended = idle + left.iter().map(|left| left[0]).sum::<f64>();
            for (left, (_, gain, share)) in left.iter_mut().zip(&lengths) {
                left[0] = 0.0;
                if let Some(longest) = left.last_mut() {
                    *longest += ended * chance * share;
                }
                left.rotate_left(1);
                for moment in left {
                    *moment *= f64::exp(*gain);
                }
            }
            idle = ended * (1.0 - chance);
        }
        let total = idle + left.iter().flatten().sum::<f64>();
        assert!((total.ln() - computed).abs() < 1e-12, "{width}: {} {computed}", total.ln());
    }
}

#[test]
fn runs_are_those_of_an_independent_computation() {
    let boxes = boxes(NOISE, true);
    agree(&[1e3 * boxes[0][0], 1e3 * boxes[1][0]], &[0.287, 0.412], 3);
    let runs = RunLimits::new(&one_size(), &core(), 0.0);
    let limits = boxes.map(|ends| runs.limits(ends, 24.0));
    let expected: [[u16; 7]; 3] =
        [[31, 21, 12, 12, 12, 11, 5], [41, 28, 14, 13, 12, 11, 5], [42, 31, 18, 20, 18, 11, 5]];
    for (strays, expected) in expected.iter().enumerate() {
        let computed: Vec<_> = limits[..7].iter().map(|limits| limits[strays]).collect();
        assert_eq!(computed, expected.map(Some), "{strays} strays");
    }
}

#[test]
fn sums_are_those_of_an_independent_computation() {
    let core = core();
    let clips = clips(NOISE, Some(0.44e-3));
    agree(&clips.iter().map(|clip| 1e3 * clip).collect::<Vec<_>>(), &[0.277, 0.608, 1.25], 3);
    let sums = SumLimits::new(&core, Survival::of(&one_size(), 1024), 0.0);
    let widths = [1, 4, 8, 12, 24, 64, 256, 1024];
    let expected = [
        [0.381, 0.324, 0.316, 0.306, 0.303, 0.216, 0.152, 0.122],
        [0.736, 0.621, 0.610, 0.604, 0.593, 0.421, 0.235, 0.152],
        [1.378, 1.256, 0.938, 0.802, 0.649, 0.430, 0.243, 0.157],
    ];
    for ((clip, level), expected) in clips.into_iter().zip([20.0, 24.5, 24.5]).zip(&expected) {
        agree(&means(&sums.clipped(clip, level, &widths), &widths), expected, 3);
    }
    let counts = sums.elsewhere(NOISE, 20.0, &[8, 12, 16, 24, 40, 64]);
    agree(&counts, &[6.47, 7.22, 7.82, 8.78, 10.31, 12.12], 2);
}

#[test]
fn without_excursions_limits_are_those_of_an_independent_computation() {
    let widths = [1, 4, 8, 12, 24, 64, 256, 1024];
    let limits = LimitTable::of(&healthy(none()), &LEVELS, &widths);
    assert_eq!(limits.runs, [[Some(5); 3]; BOXES]);
    assert!(limits.boxes.iter().all(|[_, high]| high.is_infinite()));
    agree(&limits.clips.iter().map(|clip| 1e3 * clip).collect::<Vec<_>>(), &[0.277, 1.25], 3);
    let expected = [0.376, 0.276, 0.210, 0.181, 0.134, 0.118, 0.132, 0.115];
    agree(&means(&limits.sums[0], &widths), &expected, 3);
}

/// All limits in one order; a run that has none is longer than all.
fn all(limits: &LimitTable) -> Vec<f64> {
    let runs = limits.runs.iter().flatten().map(|run| run.map_or(f64::INFINITY, f64::from));
    let sums = limits.sums.iter().flatten().chain(&limits.squares).chain(&limits.elsewhere);
    runs.chain(sums.copied()).collect()
}

fn rises(lower: &LimitTable, upper: &LimitTable) {
    let pairs = all(lower).into_iter().zip(all(upper));
    for (lower, upper) in pairs {
        assert!(lower <= upper * (1.0 + 1e-12), "{lower} {upper}");
    }
}

/// Sizes and lengths as they are learnt, with tails.
fn mixed(chance: f64) -> Law {
    law(
        chance,
        &[
            (0.36e-3, 9, 0.3),
            (0.44e-3, 10, 0.4),
            (0.48e-3, 11, 0.28),
            (0.55e-3, 12, 0.015),
            (0.44e-3, 25, 0.005),
        ],
    )
}

#[test]
fn more_excursions_make_no_limit_smaller() {
    let widths = [1, 4, 12, 48, 256];
    for overlaps in [false, true] {
        let of =
            |chance: f64| LimitTable::compute(&healthy(mixed(chance)), &LEVELS, &widths, overlaps);
        let limits = [1e-6, 1e-4, 5e-4, 3e-3].map(of);
        limits.windows(2).for_each(|pair| rises(&pair[0], &pair[1]));
    }
}

#[test]
fn a_higher_level_makes_no_limit_smaller() {
    let (usual, widths) = (LEVELS, [1, 4, 12, 48, 256]);
    let lower = |nats: f64| LimitLevels {
        sums: usual.sums - nats,
        wide_clips: usual.wide_clips - nats,
        runs: usual.runs - nats,
    };
    let of = |nats: f64| LimitTable::of(&healthy(mixed(5e-4)), &lower(nats), &widths);
    let limits = [8.0, 4.0, 0.0, -4.0].map(of);
    limits.windows(2).for_each(|pair| rises(&pair[0], &pair[1]));
}

#[test]
fn overlaps_make_no_limit_smaller_and_matter_between_one_size_and_two() {
    let healthy = healthy(one_size());
    let product = LimitTable::compute(&healthy, &LEVELS, &WIDTHS, false);
    let overlaps = LimitTable::of(&healthy, &LEVELS, &WIDTHS);
    rises(&product, &overlaps);
    assert_eq!((&product.runs, &product.elsewhere), (&overlaps.runs, &overlaps.elsewhere));
    // Of eight samples in an overlap the mean is 0.88 mm and deviates by 0.03 mm: 0.94 mm is not rare.
    let wide = |limits: &LimitTable| 1e3 * limits.sums[2][5] / 8.0;
    assert!(wide(&product) < 0.94 && wide(&overlaps) > 1.0, "{}", wide(&overlaps));
}

/// Overlaps of two that last ten samples: nineteen ways to begin, of which one lasts ten.
#[test]
fn overlaps_are_counted() {
    let overlaps = Survival::of(&one_size(), 64).expect("there are excursions").overlaps();
    agree(&[1e3 * overlaps.sizes()[0], overlaps.chance() / 9e-8], &[0.9, 19.0], 9);
    agree(overlaps.ending(10), &[1.0 / 19.0], 9);
    // 100 pairs of samples, whichever way the lengths are rounded up: at 9 the next is 10.
    assert!((overlaps.mean_length() - 100.0 / 19.0).abs() < 2.0 / 19.0 + 1e-9);
}

#[test]
fn smallest_steps_follow_from_the_limits() {
    let widths = WIDTHS;
    let of = |law: Law| {
        let limits = LimitTable::of(&healthy(law), &LEVELS, &widths);
        limits.smallest_step(&widths, 0.02).map(|SmallestStep { within, size }| {
            (within, size.map(|size| (size / 0.05e-3).round() as u32))
        })
    };
    assert_eq!(of(none()), [(0.1, Some(5)), (0.3, Some(4)), (1.0, Some(3))]);
    assert_eq!(of(one_size()), [(0.1, Some(21)), (0.3, Some(11)), (1.0, Some(6))]);
    let limits = LimitTable::of(&healthy(none()), &LEVELS, &widths);
    for sample_time in [0.0, -1.0, f64::MAX] {
        let sizes = limits.smallest_step(&widths, sample_time).map(|step| step.size);
        assert!(sample_time > 0.0 || sizes == [None; 3], "{sizes:?}");
    }
    assert!(limits.smallest_step(&[], f64::MIN_POSITIVE).iter().all(|step| step.size.is_some()));
}

#[test]
fn odd_input_gives_limits_that_are_numbers() {
    let single = CoreNoise { bin: 1e-5, shares: vec![1.0] };
    let laws = [
        none(),
        law(0.0, &[(0.44e-3, 10, 1.0)]),
        law(1e-3, &[]),
        law(1.0, &[(0.44e-3, 10, 1.0)]),
        law(1e-3, &[(0.44e-3, 5000, 1.0)]),
        law(1e-3, &[(0.44e-3, u32::MAX, 0.5), (5e-3, 0, 0.5)]),
        law(1e-3, &[(1e300, 7, 0.5), (-1.0, 7, 0.5)]),
    ];
    let usual = healthy(law(1e-3, &[(0.44e-3, 5000, 1.0)]));
    let odd = [
        HealthyCylinder { weighted: single.clone(), fastest: single, ..usual.clone() },
        HealthyCylinder { rest: 0.0, ..usual.clone() },
        HealthyCylinder {
            rest: 1e300,
            timing: 1e300,
            mean_square_velocity: 1e300,
            ..usual.clone()
        },
        HealthyCylinder { sizes_95: 1e300, wild_share: 2.0, ..usual.clone() },
        HealthyCylinder { rest: -1.0, sizes_95: 0.0, wild_share: -1.0, ..usual },
    ];
    let widths = [0, 1, 7, 100, usize::MAX];
    for healthy in laws.map(healthy).iter().chain(&odd) {
        for overlaps in [false, true] {
            let limits = LimitTable::compute(healthy, &LEVELS, &widths, overlaps);
            let sums = limits.sums.iter().flatten().chain(&limits.squares);
            let numbers = sums.chain(&limits.elsewhere).chain(&limits.clips);
            assert!(numbers.copied().all(|limit| limit.is_finite() && limit > 0.0), "{limits:?}");
            assert!(limits.boxes.iter().all(|[low, high]| low.is_finite() && high >= low));
            assert_eq!(limits.smallest_step(&widths, 0.02).len(), 3);
        }
    }
}

#[test]
fn a_core_is_made_of_counts() {
    assert_eq!(CoreNoise::of_counts(1e-5, &[]), None);
    assert_eq!(CoreNoise::of_counts(1e-5, &[0, 0]), None);
    assert_eq!(CoreNoise::of_counts(0.0, &[1]), None);
    let core = CoreNoise::of_counts(1e-5, &[3, 0, 1, 0]).expect("there are counts");
    assert_eq!(core.shares, [0.75, 0.0, 0.25]);
    agree(&[core.beyond(1e-5), core.beyond(3e-5)], &[0.25, 0.0], 12);
    agree(&[1e10 * core.expectation(|residual| residual * residual)], &[1.75], 9);
}

/// The polynomial over bins is the expectation that it stands for.
#[test]
fn clipped_exponentials_are_expectations() {
    let core = core();
    for rate in [20.0, 3e3, 1.5e5] {
        for shift in [0.0, 0.1e-3, 0.3e-3, 0.9e-3, 50e-3] {
            for clip in [0.25e-3, 1.25e-3] {
                let clipped = |residual: f64| (residual + shift).clamp(-clip, clip) - clip;
                let expected = core.expectation(|residual| (rate * clipped(residual)).exp());
                let computed = core.clipped_exponential(rate, shift, clip);
                assert!((computed / expected - 1.0).abs() < 1e-12, "{computed} {expected}");
            }
        }
    }
}
