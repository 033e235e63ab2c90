use super::*;
use crate::sample::motion::ReadingMotion;

fn limits() -> PlausibilityLimits {
    PlausibilityLimits {
        stale: 3,
        broken_wire_codes: vec![32767],
        status_mask: 0b01,
        codes: Some((1, 27648)),
        lengths: (-1.5, 1.5),
        frozen: 4,
        travel: 1e-3,
        driven: 10e-3,
    }
}

fn reading(position: f64) -> Reading {
    Reading { position, code: Some(100), status: Some(0), ..Reading::default() }
}

const MOVING: Moment =
    Moment { live: true, push: Some(Push::Positive), way: 2e-3, been: NOWHERE, other: None };
const STILL: Moment = Moment { push: None, way: 0.0, ..MOVING };

/// The other transducer in motion, at `position`.
fn passing(position: f64) -> Moment {
    Moment { other: Some(Other { position, goes_on: true }), ..MOVING }
}

#[test]
fn the_order_is_stale_broken_wire_out_of_range_frozen() {
    let mut checks = Plausibility::new(limits());
    let worst = Reading { code: Some(32767), position: 2.0, status: Some(1), ..reading(2.0) };
    for _ in 0..6 {
        assert_eq!(checks.judge(Some(&worst), MOVING), Quality::BrokenWire);
    }
    assert_eq!(checks.judge(Some(&reading(2.0)), MOVING), Quality::OutOfRange);
    let zero = Reading { code: Some(0), ..reading(2.0) };
    assert_eq!(checks.judge(Some(&zero), MOVING), Quality::OutOfRange);
    assert_eq!(checks.judge(Some(&reading(1.0)), MOVING), Quality::Good);
}

#[test]
fn only_the_codes_of_a_broken_wire_are_one() {
    let broken_wire_codes = vec![32767, 0, 500];
    let limits = PlausibilityLimits { broken_wire_codes, ..limits() };
    let mut checks = Plausibility::new(limits);
    let broken = [0, 100, 500, 501, 32767].map(|code| {
        let reading = Reading { code: Some(code), ..reading(0.0) };
        checks.judge(Some(&reading), STILL) == Quality::BrokenWire
    });
    assert_eq!(broken, [true, false, true, false, true]);
}

#[test]
fn a_status_bit_outside_the_mask_is_no_fault() {
    let mut checks = Plausibility::new(limits());
    let other_bit = Reading { status: Some(0b10), ..reading(0.0) };
    assert_eq!(checks.judge(Some(&other_bit), MOVING), Quality::Good);
    let masked = Reading { status: Some(0b11), ..reading(0.0) };
    assert_eq!(checks.judge(Some(&masked), MOVING), Quality::BrokenWire);
}

#[test]
fn a_status_bit_without_a_meaning_is_told_once() {
    let mut checks = Plausibility::new(limits());
    for (position, status, told) in [
        (0.1, 0b0000, None),
        (0.2, 0b0110, Some(0b0110)),
        (0.3, 0b0110, None),
        (0.4, 0b0000, None),
        (0.5, 0b0100, None),
        (0.6, 0b1101, Some(0b1000)),
        (0.7, 0b1111, None),
    ] {
        let reading = Reading { status: Some(status), ..reading(position) };
        let is_broken = status & 1 != 0;
        let is_plain = checks.take_plain(Some(&reading), None);
        assert_eq!(is_plain, !is_broken && told.is_none(), "{status:#b}: each of them only once");
        let quality = if is_plain { Quality::Good } else { checks.judge(Some(&reading), STILL) };
        assert_eq!(quality == Quality::BrokenWire, is_broken, "{status:#b}");
        assert_eq!(checks.unnamed.take_news(), told, "{status:#b}");
        assert_eq!(checks.unnamed.take_news(), None, "{status:#b}");
    }
}

#[test]
fn frozen_needs_a_moving_command_and_ends_with_a_change() {
    let mut checks = Plausibility::new(limits());
    for _ in 0..50 {
        assert_eq!(checks.judge(Some(&reading(0.5)), STILL), Quality::Good);
    }
    checks.judge(Some(&reading(0.4)), passing(0.0));
    for cycle in 0..4 {
        let moment = passing(1e-3 * f64::from(cycle));
        assert_eq!(checks.judge(Some(&reading(0.5)), moment), Quality::Good);
    }
    assert_eq!(checks.judge(Some(&reading(0.5)), passing(5e-3)), Quality::Frozen);
    assert_eq!(checks.judge(Some(&reading(0.5)), STILL), Quality::Frozen, "it did not thaw");
    assert_eq!(checks.judge(Some(&reading(0.500_1)), STILL), Quality::Good);
}

/// The cycle in which a reading that stops in cycle 0 is frozen, with the other one at `other`
/// and the command moving as `push` tells.
fn frozen_in(
    other: impl Fn(u64) -> Option<f64>,
    push: impl Fn(u64) -> Option<Push>,
) -> Option<u64> {
    let mut checks = Plausibility::new(limits());
    let mut motion = ReadingMotion::default();
    let judge = |cycle: &u64| {
        motion.follow(other(*cycle));
        let other = other(*cycle).map(|position| Other::new(position, &motion));
        let push = push(*cycle);
        let way = push.map_or(0.0, |push| [2e-3, -2e-3][push as usize]);
        let moment = Moment { other, push, way, ..MOVING };
        checks.judge(Some(&reading(0.5)), moment) == Quality::Frozen
    };
    (0..100).find(judge)
}

#[test]
fn a_reading_that_stands_while_the_other_goes_on_is_frozen() {
    let out = |_| Some(Push::Positive);
    let ramp = |cycle: u64| Some(3e-4 * cycle as f64);
    assert_eq!(frozen_in(ramp, out), Some(6), "it moves slowly");
    let later = |cycle: u64| Some(3e-4 * cycle.saturating_sub(6) as f64);
    assert_eq!(frozen_in(later, out), Some(11), "it moves later");
    let lost = |cycle| ramp(cycle).filter(|_| cycle < 9);
    assert_eq!(frozen_in(lost, out), Some(6), "it has moved before it was lost");
    let fast = |cycle: u64| Some(6e-4 * cycle as f64);
    assert_eq!(frozen_in(fast, out), Some(4), "the time of it is what it takes");
}

/// A rod that hardly moves while its command turns, and one reading of the other transducer that is off by 1.1 mm.
#[test]
fn a_witness_with_one_wild_reading_has_not_moved() {
    let out = |_| Some(Push::Positive);
    for (wild, spike) in (0..24).flat_map(|wild| [(wild, 1.1e-3), (wild, -1.1e-3)]) {
        let spiky = |cycle: u64| {
            let off = if cycle == wild { spike } else { 0.0 };
            (cycle < 24).then_some(3e-4 * (cycle / 6) as f64 + off)
        };
        assert_eq!(frozen_in(spiky, out), None, "{spike} m in cycle {wild}");
    }
}

/// Movements of the other transducer while the rod stands on its stop, pushed against it.
#[test]
fn at_rest_is_not_frozen() {
    let out = |_| Some(Push::Positive);
    assert_eq!(frozen_in(|_| None, out), None, "it is lost, or frozen itself");
    assert_eq!(frozen_in(|_| Some(0.2), out), None, "it stands, too");
    assert_eq!(frozen_in(|cycle| Some(4.34e-4 * (cycle % 3) as f64), out), None, "it flickers");
    assert_eq!(frozen_in(|cycle| Some(if cycle < 9 { 0.1 } else { 0.2 }), out), None, "it jumps");
    let flickers =
        |cycle: u64| Some(if cycle < 9 { 0.1 } else { 0.2 + 1e-4 * (cycle.min(12) - 9) as f64 });
    assert_eq!(frozen_in(flickers, out), None, "it jumps, and flickers on");
    let noise = |cycle: u64| Some(1e-3 * [0.0, 1.0, -1.0, -1.0, 0.0, 1.0][(cycle % 6) as usize]);
    assert_eq!(frozen_in(noise, out), None, "it is noisy");
}

/// A sea of this command, m/s in a cycle, around a dead band of 1 mm in each cycle.
fn at_sea(amplitude: f64, period: f64) -> impl FnMut(u32) -> (Option<Push>, f64) {
    move |cycle| {
        let way = amplitude * libm::sin(f64::from(cycle) * core::f64::consts::TAU / period);
        (Push::of(way, 1e-3), way)
    }
}

/// The cycle in which a reading that stands from cycle 0 on, without a witness, is frozen.
fn frozen_alone(
    mut command: impl FnMut(u32) -> (Option<Push>, f64),
    been: [f64; 2],
) -> Option<u32> {
    let mut checks = Plausibility::new(limits());
    (0..5000).find(|cycle| {
        let (push, way) = command(*cycle);
        let moment = Moment { push, way: if push.is_some() { way } else { 0.0 }, been, ..MOVING };
        checks.judge(Some(&reading(0.5)), moment) == Quality::Frozen
    })
}

/// Its command is at rest for some cycles at each turn, and goes one way for 60 cycles or more.
#[test]
fn without_a_witness_a_reading_that_stands_in_a_smooth_sea_is_frozen() {
    let found = frozen_alone(at_sea(5e-3, 160.0), NOWHERE).expect("both ways");
    assert!((80..100).contains(&found), "{found}");
    let found = frozen_alone(at_sea(5e-3, 160.0), [-1.0, 1.0]).expect("no stop holds it");
    assert!((20..30).contains(&found), "{found}");
    let found = frozen_alone(at_sea(1.5e-3, 160.0), [-1.0, 1.0]).expect("a calm sea");
    assert!((30..60).contains(&found), "{found}");
}

/// On its stop the rod is pushed against it; in the middle a command that dithers moves nothing.
#[test]
fn without_a_witness_a_rod_that_stands_is_not_frozen() {
    let against = |_| (Some(Push::Positive), 5e-3);
    assert_eq!(frozen_alone(against, [-1.0, 0.505]), None, "it has not been beyond");
    let from_below = |_| (Some(Push::Negative), -5e-3);
    assert_eq!(frozen_alone(from_below, [0.495, 1.0]), None);
    let dither = |cycle: u32| {
        let way = if cycle.is_multiple_of(2) { 2e-3 } else { -2e-3 };
        (Push::of(way, 1e-6), way)
    };
    assert_eq!(frozen_alone(dither, [-1.0, 1.0]), None);
    assert_eq!(frozen_alone(|_| (None, 0.0), [-1.0, 1.0]), None, "no command");
}

/// A stop holds the rod against one direction only.
#[test]
fn without_a_witness_the_command_has_to_move_either_way() {
    let turning = |cycle| Some(if cycle % 40 < 20 { Push::Positive } else { Push::Negative });
    assert_eq!(frozen_in(|_| None, turning), Some(24));
    assert_eq!(frozen_in(|_| Some(0.2), turning), Some(24), "the cylinder does not follow");
    assert_eq!(frozen_in(|cycle| Some(4.34e-4 * (cycle % 2) as f64), turning), None);
}

#[test]
fn who_stands_alone_is_known_before_it_is_frozen() {
    let mut checks = Plausibility::new(limits());
    checks.judge(Some(&reading(0.5)), passing(0.0));
    assert!(!checks.stands_alone());
    let resting = Moment { push: None, ..passing(6e-4) };
    assert_eq!(checks.judge(Some(&reading(0.5)), resting), Quality::Good);
    assert!(checks.stands_alone() && !checks.is_witnessed());
    checks.judge(Some(&reading(0.6)), passing(7e-4));
    assert!(!checks.stands_alone());
}

#[test]
fn stale_after_the_configured_cycles_but_not_in_silence() {
    let mut checks = Plausibility::new(limits());
    assert_eq!(checks.judge(Some(&reading(0.0)), MOVING), Quality::Good);
    for _ in 0..100 {
        let silence = Moment { live: false, ..MOVING };
        assert_eq!(checks.judge(None, silence), Quality::Missing);
    }
    assert_eq!(checks.judge(None, MOVING), Quality::Missing);
    assert_eq!(checks.judge(None, MOVING), Quality::Missing);
    assert_eq!(checks.judge(None, MOVING), Quality::Stale);
    assert_eq!(checks.judge(Some(&reading(0.0)), MOVING), Quality::Good);
}

#[test]
fn what_the_device_says_comes_first() {
    let mut checks = Plausibility::new(limits());
    let mut judge = |reading: Option<&Reading>, word| {
        checks.judge(reading, MOVING);
        assert_eq!(checks.overrule(word, reading.is_some()), checks.quality());
        checks.quality()
    };
    let (good, wild) = (reading(0.0), reading(2.0));
    for reading in [None, Some(&good), Some(&wild)] {
        assert_eq!(judge(reading, DeviceWord::Failed), Quality::Failed);
        assert_eq!(judge(reading, DeviceWord::Lost), Quality::Stale);
    }
    let came = judge(Some(&wild), DeviceWord::NotOperational);
    assert_eq!(came, Quality::OutOfRange, "it has come all the same");
    assert_eq!(judge(None, DeviceWord::Nothing), Quality::Missing);
    for _ in 0..100 {
        assert_eq!(judge(None, DeviceWord::NotOperational), Quality::NotOperational);
    }
    let then = [(); 3].map(|()| judge(None, DeviceWord::Nothing));
    assert_eq!(then, [Quality::Missing, Quality::Missing, Quality::Stale], "its time begins");
}

#[test]
fn not_a_number_is_out_of_range() {
    let mut checks = Plausibility::new(limits());
    let nan = Reading { code: None, ..reading(f64::NAN) };
    assert_eq!(checks.judge(Some(&nan), MOVING), Quality::OutOfRange);
}

/// C2 stands with the rod. C1 was elsewhere while it was out of range, and flickers.
#[test]
fn a_reading_that_comes_back_from_elsewhere_has_not_moved() {
    for (unseen, expected) in [(4, Quality::Frozen), (5, Quality::Good)] {
        let mut checks = Plausibility::new(limits());
        let mut judge = |moment| checks.judge(Some(&reading(0.5)), moment);
        (0..2).for_each(|_| _ = judge(passing(0.1)));
        (0..unseen).for_each(|_| _ = judge(MOVING));
        judge(passing(0.5));
        assert_eq!(judge(passing(0.500_1)), expected, "{unseen}");
    }
}

/// The other reading was lost in the cycle in which this one took its last value.
#[test]
fn the_way_of_one_that_was_lost_at_the_beginning_begins_when_it_comes() {
    let mut checks = Plausibility::new(limits());
    let mut judge = |moment| checks.judge(Some(&reading(0.5)), moment);
    judge(MOVING);
    (0..3).for_each(|_| assert_eq!(judge(passing(0.1)), Quality::Good));
    assert_eq!(judge(passing(0.100_9)), Quality::Good, "less than the distance");
    assert_eq!(judge(passing(0.101_1)), Quality::Good, "it may be wild");
    assert_eq!(judge(passing(0.101_2)), Quality::Frozen);
    assert!(checks.is_witnessed() && checks.stands_alone());
}

/// A stop holds a rod against one direction only.
#[test]
fn a_reading_is_driven_once_the_command_has_moved_both_ways_and_can_be_acquitted() {
    let mut checks = Plausibility::new(limits());
    let mut judge = |push, cycles: u32| {
        for cycle in 0..cycles {
            let moment = Moment { push: Some(push), ..passing(1e-3 * f64::from(cycle)) };
            checks.judge(Some(&reading(0.5)), moment);
        }
        (checks.quality(), checks.is_driven())
    };
    assert_eq!(judge(Push::Positive, 24), (Quality::Frozen, false));
    assert_eq!(judge(Push::Negative, 19), (Quality::Frozen, false));
    assert_eq!(judge(Push::Negative, 1), (Quality::Frozen, true));
    assert_eq!((checks.take_for_rest(), checks.quality()), (Quality::Good, Quality::Good));
    checks.judge(Some(&reading(0.6)), MOVING);
    assert!(!checks.is_driven());
}

/// All sequences of seven readings out of four kinds, each beside another one or none.
#[test]
fn a_plain_reading_is_judged_as_any_other() {
    let broken = Reading { code: Some(32767), ..reading(0.2) };
    let unnamed = Reading { status: Some(0b10), ..reading(0.2) };
    let kinds = [Some(reading(0.1)), Some(unnamed), Some(broken), None];
    let mut plain_ones = 0;
    for sequence in 0..4_usize.pow(7) {
        let mut fast = Plausibility::new(limits());
        let mut all = fast.clone();
        for cycle in 0..7 {
            let read = kinds[sequence >> (2 * cycle) & 3];
            let others = [None, Some(1e-3 * f64::from(cycle as u32 / 2))];
            let moment = Moment {
                other: others[(sequence + cycle) & 1]
                    .map(|position| Other { position, goes_on: true }),
                ..MOVING
            };
            let is_plain = fast.take_plain(read.as_ref(), moment.other.map(|it| it.position));
            if !is_plain {
                fast.judge(read.as_ref(), moment);
            }
            all.judge(read.as_ref(), moment);
            plain_ones += usize::from(is_plain);
            assert_eq!(format!("{fast:?}"), format!("{all:?}"), "{sequence:#x} in cycle {cycle}");
        }
    }
    assert!(plain_ones > 4_usize.pow(7));
}
