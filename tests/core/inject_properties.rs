//! The injector on random DBCs and frames, and its shapes against plain formulas.

use crate::dbc_support::{Dice, random_dbc};
use proptest::prelude::*;
use tertius::dbc::{Database, Message, Signal};
use tertius::decode::{Decoded, Raw, SignalPlan};
use tertius::frame::{BusNumber, Frame, Id, Kind, MAX_DATA};
use tertius::inject::{Code, Injector, Placed, Shape, Tally, Window};
use tertius::time::{Span, Timestamp};

const ALWAYS: Window = Window { from: Span::ZERO, until: None };

fn placed(message: &Message, signal: &Signal, shape: Shape, window: Window) -> Placed {
    Placed { bus: BusNumber::First, id: message.id, plan: signal.plan.clone(), shape, window }
}

fn random_frame(dice: &mut Dice, message: &Message, t: i64) -> Frame {
    let kind = if message.length > 8 { Kind::Fd { flags: 1 } } else { Kind::Data };
    let mut frame = Frame::new(Timestamp::from_nanos(t), message.id, kind, &[]);
    frame.buffer_mut().fill_with(|| dice.roll() as u8);
    let short = dice.below(6) == 0;
    frame.set_length(if short {
        dice.below(message.length as u64 + 1) as usize
    } else {
        message.length
    });
    frame
}

/// The bits that belong to a signal, found by writing ones and zeros.
fn bits_of(plan: &SignalPlan) -> [u8; MAX_DATA] {
    let all = Raw::Unsigned(u64::MAX);
    let none = if plan.is_float() { Raw::Float(0.0) } else { Raw::Unsigned(0) };
    let (mut ones, mut zeros) = ([0; MAX_DATA], [0xFF; MAX_DATA]);
    let extremes = match plan.raw_limits() {
        Some((low, high)) if low < 0 => [Raw::Signed(-1), Raw::Signed(high as i64)],
        Some(_) => [all, none],
        None => [Raw::Float(-f64::NAN), Raw::Float(f64::from(f32::MAX))],
    };
    for raw in extremes {
        let mut payload = [0; MAX_DATA];
        _ = plan.insert(raw, &mut payload);
        ones.iter_mut().zip(payload).for_each(|(bits, byte)| *bits |= byte);
        payload = [0xFF; MAX_DATA];
        _ = plan.insert(raw, &mut payload);
        zeros.iter_mut().zip(payload).for_each(|(bits, byte)| *bits &= byte);
    }
    std::array::from_fn(|i| ones[i] | !zeros[i])
}

fn shapes(dice: &mut Dice) -> Shape {
    let size = (dice.below(2000) as f64 - 1000.0) * 10_f64.powi(dice.below(9) as i32 - 4);
    let code = dice.roll() as i64 >> dice.below(64);
    match dice.below(9) {
        0 => Shape::Step { size },
        1 => Shape::Noise { size },
        2 => Shape::Incipient { size, b: 1.0 },
        3 => Shape::Drift { rate: size },
        4 => Shape::Scale { gain: size },
        5 => Shape::Freeze,
        6 => Shape::Spike { size, probability: 0.5 },
        7 => Shape::Constant(Code::Raw(code)),
        _ => Shape::Constant(Code::Physical(size)),
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]

    /// Only the bits of the signal change, only in its window, and only in frames that carry it.
    #[test]
    fn only_the_bits_of_the_signal_change(seed: u64) {
        let mut dice = Dice(seed);
        let database = Database::parse(&random_dbc(&mut dice, 4)).unwrap();
        for message in database.messages() {
            for signal in &message.signals {
                let window = Window {
                    from: Span::from_nanos(3),
                    until: Some(Span::from_nanos(9)),
                };
                let shape = shapes(&mut dice);
                let mut injector =
                    Injector::new(&[placed(message, signal, shape, window)], seed);
                let bits = bits_of(&signal.plan);
                let mut carried = 0;
                for t in 0..12 {
                    let frame = random_frame(&mut dice, message, t);
                    let out = injector.take(&frame).expect("no frame is lost").clone();
                    let there = (3..9).contains(&t);
                    let decoded = signal.plan.decode(&frame);
                    prop_assert_eq!(
                        (out.timestamp, out.id, out.kind, out.length()),
                        (frame.timestamp, frame.id, frame.kind, frame.length())
                    );
                    if !there || decoded.value().is_none() {
                        prop_assert_eq!(&out, &frame);
                        continue;
                    }
                    carried += 1;
                    let bytes = out.buffer().iter().zip(frame.buffer()).zip(bits);
                    for (i, ((new, old), own)) in bytes.enumerate() {
                        prop_assert_eq!((new ^ old) & !own, 0, "byte {} by {:?}", i, shape);
                    }
                }
                let tally = injector.tallies()[0];
                prop_assert_eq!(tally.frames, carried);
                prop_assert!(tally.altered <= tally.frames && tally.clamped <= tally.frames);
                prop_assert_eq!(tally.frames + tally.absent, 6);
            }
        }
    }

    /// A step reads back within half a count of the sum, or is the nearest that the bits hold and
    /// counted as clamped.
    #[test]
    fn a_step_is_added_within_half_a_count(seed: u64, counts in -3000_i32..3000) {
        let mut dice = Dice(seed);
        let database = Database::parse(&random_dbc(&mut dice, 4)).unwrap();
        for message in database.messages() {
            for signal in message.signals.iter().filter(|signal| signal.plan.bits() <= 48) {
                let Some((low, high)) = signal.plan.raw_limits() else { continue };
                let size = f64::from(counts) / 7.0 * signal.plan.factor();
                let shape = Shape::Step { size };
                let mut injector = Injector::new(&[placed(message, signal, shape, ALWAYS)], 0);
                let frame = random_frame(&mut dice, message, 0);
                let out = injector.take(&frame).unwrap().clone();
                let (Decoded::Value(before), Decoded::Value(after)) =
                    (signal.plan.decode(&frame), signal.plan.decode(&out)) else { continue };
                let wanted = before.raw.as_f64() + f64::from(counts) / 7.0;
                let nearest = wanted.clamp(low as f64, high as f64);
                prop_assert!((after.raw.as_f64() - nearest).abs() <= 0.5 + 1e-3);
                let beyond = wanted < low as f64 - 0.51 || wanted > high as f64 + 0.51;
                let clamped = injector.tallies()[0].clamped == 1;
                prop_assert!(!beyond || clamped, "{} beyond {} to {}", wanted, low, high);
            }
        }
    }
}

const DBC: &str = "VERSION \"\"\n\nBU_: A\n\nBO_ 5 M: 8 A\n \
    SG_ Length : 0|16@1+ (0.001,-10) [0|0] \"m\" A\n SG_ Other : 16|16@1+ (1,0) [0|0] \"\" A\n \
    SG_ Small : 32|8@1+ (1,0) [0|0] \"\" A\n SG_ Counter : 40|8@1+ (1,0) [0|0] \"\" A\n";

/// Frames of `DBC`, one each 20 ms, with these raw lengths.
fn frames(lengths: &[u16]) -> Vec<Frame> {
    let frame = |(k, length): (usize, &u16)| {
        let [low, high] = length.to_le_bytes();
        let at = Timestamp::from_nanos(1_700_000_000_000_000_000 + 20_000_000 * k as i64);
        let id = Id::standard(5).unwrap();
        Frame::new(at, id, Kind::Data, &[low, high, 7, 0, 50, k as u8])
    };
    lengths.iter().enumerate().map(frame).collect()
}

/// What comes out for `faults` (signal, shape, from, until): the frames, `None` where one is lost.
fn play(
    faults: &[(&str, Shape, f64, Option<f64>)],
    frames: &[Frame],
) -> (Vec<Option<Frame>>, Vec<Tally>) {
    let database = Database::parse(DBC).unwrap();
    let faults: Vec<Placed> = faults
        .iter()
        .map(|(signal, shape, from, until)| {
            let (message, signal) = database.signal(&format!("M.{signal}")).unwrap();
            let window =
                Window { from: Span::from_seconds(*from), until: until.map(Span::from_seconds) };
            placed(message, signal, *shape, window)
        })
        .collect();
    let mut injector = Injector::new(&faults, 42);
    let out = frames.iter().map(|frame| injector.take(frame).cloned()).collect();
    (out, injector.tallies().to_vec())
}

fn lengths(frames: &[Option<Frame>]) -> Vec<Option<u16>> {
    let length = |frame: &Frame| u16::from_le_bytes([frame.data()[0], frame.data()[1]]);
    frames.iter().map(|frame| frame.as_ref().map(length)).collect()
}

/// Shapes with t from the time stamps, on 20 ms, against the formula written out.
#[test]
fn shapes_follow_their_formulas_in_seconds() {
    let input: Vec<u16> = (0..200).map(|k| 20_000 + 3 * k).collect();
    type Formula = fn(f64, f64) -> f64;
    let formulas: [(Shape, Formula); 4] = [
        (Shape::Step { size: 0.5 }, |_, _| 0.5),
        (Shape::Incipient { size: 7.0, b: 1.0 }, |t, _| 7.0 * (1.0 - 2_f64.powf(-t))),
        (Shape::Drift { rate: -2.0 }, |t, _| -2.0 * t),
        (Shape::Scale { gain: 0.25 }, |_, length| 0.25 * length),
    ];
    for (shape, formula) in formulas {
        let (out, tallies) = play(&[("Length", shape, 1.0, Some(3.0))], &frames(&input));
        for (k, (found, length)) in lengths(&out).into_iter().zip(&input).enumerate() {
            let there = (50..150).contains(&k);
            let metres = f64::from(*length) * 0.001 - 10.0;
            let fault = if there { formula(0.02 * (k as f64 - 50.0), metres) } else { 0.0 };
            let expected = ((metres + fault + 10.0) / 0.001).round() as u16;
            assert!(found.unwrap().abs_diff(expected) <= u16::from(there), "{shape:?} at {k}");
        }
        assert_eq!((tallies[0].frames, tallies[0].clamped), (100, 0), "{shape:?}");
    }
}

#[test]
fn a_freeze_holds_the_last_reading_and_leaves_the_rest_of_the_frame() {
    let input = [100, 110, 120, 130, 140, 150];
    let (out, tallies) = play(&[("Length", Shape::Freeze, 0.05, Some(0.09))], &frames(&input));
    assert_eq!(lengths(&out), [100, 110, 120, 120, 120, 150].map(Some));
    let counters: Vec<u8> = out.iter().flatten().map(|frame| frame.data()[5]).collect();
    assert_eq!(counters, [0, 1, 2, 3, 4, 5]);
    assert_eq!((tallies[0].frames, tallies[0].altered), (2, 2));
    // Without a reading before it, the first one is held.
    let (out, _) = play(&[("Length", Shape::Freeze, 0.0, None)], &frames(&input));
    assert_eq!(lengths(&out), [Some(100); 6]);
}

#[test]
fn stale_repeats_the_payload_with_its_counter_at_new_times() {
    let input = frames(&[100, 110, 120, 130]);
    let (out, tallies) = play(&[("Length", Shape::Stale, 0.03, Some(0.05))], &input);
    let out: Vec<Frame> = out.into_iter().flatten().collect();
    assert_eq!(out[2].data(), input[1].data());
    assert_eq!(out[2].timestamp, input[2].timestamp);
    assert_eq!([&out[0], &out[1], &out[3]], [&input[0], &input[1], &input[3]]);
    assert_eq!((tallies[0].frames, tallies[0].altered), (1, 1));
}

#[test]
fn loss_drops_all_or_its_share() {
    let input = frames(&[100; 1000]);
    let all = Shape::Loss { probability: 1.0 };
    let (out, tallies) = play(&[("Length", all, 0.1, Some(0.2))], &input);
    let lost: Vec<usize> = (0..out.len()).filter(|&k| out[k].is_none()).collect();
    assert_eq!(lost, [5, 6, 7, 8, 9]);
    assert_eq!((tallies[0].frames, tallies[0].altered), (5, 5));
    let some = Shape::Loss { probability: 0.25 };
    let (out, _) = play(&[("Length", some, 0.0, None)], &input);
    let lost = out.iter().filter(|frame| frame.is_none()).count();
    assert!((200..300).contains(&lost), "{lost} of 1000 with probability 0.25");
}

#[test]
fn codes_stand_in_the_frame_or_the_largest_that_fits() {
    let input = frames(&[100, 200]);
    let code = |raw| Shape::Constant(Code::Raw(raw));
    let (out, tallies) = play(&[("Length", code(32767), 0.0, None)], &input);
    assert_eq!((lengths(&out), tallies[0].clamped), (vec![Some(32767); 2], 0));
    let (out, tallies) = play(&[("Small", code(32767), 0.0, None)], &input);
    assert_eq!(out[1].as_ref().unwrap().data()[4], 255);
    assert_eq!(tallies[0].clamped, 2);
}

#[test]
fn faults_compose_in_order_and_are_rounded_once() {
    let input = frames(&[10_100; 3]);
    let step = |size| Shape::Step { size };
    // 0.4 counts three times are one count and not none.
    let thrice = [("Length", step(0.000_4), 0.0, None); 3];
    assert_eq!(lengths(&play(&thrice, &input).0), [Some(10_101); 3]);
    let constant = Shape::Constant(Code::Physical(1.0));
    let step_last = [("Length", constant, 0.0, None), ("Length", step(0.5), 0.0, None)];
    assert_eq!(lengths(&play(&step_last, &input).0), [Some(11_500); 3]);
    let step_first = [step_last[1], step_last[0]];
    assert_eq!(lengths(&play(&step_first, &input).0), [Some(11_000); 3]);
    // What is stale is the frame as the faults before it left it, and those after it go on.
    let around = [
        ("Length", step(0.001), 0.0, None),
        ("Length", Shape::Stale, 0.02, None),
        ("Length", step(0.01), 0.04, None),
    ];
    assert_eq!(lengths(&play(&around, &frames(&[1, 2, 3])).0), [Some(2), Some(2), Some(12)]);
    // Two signals of one message do not disturb each other.
    let both = [("Length", step(1.0), 0.0, None), ("Other", step(2.0), 0.0, None)];
    let (out, _) = play(&both, &input);
    assert_eq!(out[0].as_ref().unwrap().data(), [0x5C, 0x2B, 9, 0, 50, 0]);
}

#[test]
fn another_fault_does_not_change_what_chance_gives_the_first() {
    let input = frames(&[10_000; 300]);
    let noise = ("Length", Shape::Noise { size: 0.1 }, 0.0, None);
    let (alone, _) = play(&[noise], &input);
    let (together, tallies) =
        play(&[noise, ("Other", Shape::Noise { size: 1.0 }, 0.0, None)], &input);
    assert_eq!(lengths(&alone), lengths(&together));
    let others: Vec<u8> = together.iter().flatten().map(|frame| frame.data()[2]).collect();
    let same = |k: usize| lengths(&alone)[k] == Some(10_000);
    assert!((0..300).any(|k| same(k) != (others[k] == 7)) || tallies[0] != tallies[1]);
    for draw in [9_900, 10_000, 10_100] {
        let count = lengths(&alone).iter().filter(|length| **length == Some(draw)).count();
        assert!((70..130).contains(&count), "{draw}: {count} of 300");
    }
}

#[test]
fn remote_frames_errors_and_other_messages_pass_untouched() {
    let id = Id::standard(5).unwrap();
    let at = Timestamp::default();
    let input = [
        Frame::new(at, id, Kind::Remote { length: 8 }, &[]),
        Frame::new(at, id, Kind::Error, &[0; 8]),
        Frame::new(at, Id::extended(5).unwrap(), Kind::Data, &[9; 8]),
        Frame::new(at, Id::standard(6).unwrap(), Kind::Data, &[9; 8]),
        Frame::new(at, id, Kind::Data, &[9]),
    ];
    let step = ("Length", Shape::Step { size: 1.0 }, 0.0, None);
    let (out, tallies) = play(&[step], &input);
    assert_eq!(out.into_iter().flatten().collect::<Vec<_>>(), input);
    assert_eq!(tallies, [Tally { absent: 1, ..Tally::default() }]);
}

/// 0x7FA00000 is a signalling NaN, which becomes another one by a mere conversion.
#[test]
fn a_float_that_is_not_a_number_keeps_its_bits_where_no_fault_acts() {
    let dbc = "VERSION \"\"\n\nBU_: A\n\nBO_ 5 M: 4 A\n SG_ F : 0|32@1- (1,0) [0|0] \"m\" A\n\n\
        SIG_VALTYPE_ 5 F : 1;\n";
    let database = Database::parse(dbc).unwrap();
    let (message, signal) = database.signal("M.F").unwrap();
    let window = Window { from: Span::from_nanos(1), until: None };
    let data = 0x7FA0_0000_u32.to_le_bytes();
    for (shape, t) in [(Shape::Step { size: 1.0 }, 0), (Shape::Step { size: 0.0 }, 1)] {
        let mut injector = Injector::new(&[placed(message, signal, shape, window)], 0);
        for t in [0, t] {
            let frame = Frame::new(Timestamp::from_nanos(t), message.id, Kind::Data, &data);
            assert_eq!(injector.take(&frame), Some(&frame), "{shape:?} at {t}");
        }
    }
}
