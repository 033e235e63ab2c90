//! Which frame belongs to which cycle: late, early, doubled and lost ones, with an alive counter and
//! without, with Sync, without, and of senders that keep no cycle.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use tertius::frame::Frame;
use tertius::time::Timestamp;
use tertius_testing::machine::{Collected, Cycle, MS, START, without};

const CYCLES: i64 = 300;
const C1: u32 = 0x181;
/// Something happens in this cycle.
const EVENT: i64 = 150;
const US: i64 = 1000;

/// What becomes of the frame of C1 of cylinder 1 in each cycle.
#[derive(Clone, Copy, Debug)]
enum Case {
    /// The one of [`EVENT`] is late by so many µs.
    Late(i64),
    /// And the next one is lost.
    LateAndLost(i64),
    /// Each is late by up to so many µs.
    Jitter(i64),
    /// Each is early or late by up to so many µs.
    Shuffle(i64),
    /// Each comes once more so many µs later.
    Doubled(i64),
    Lost,
    /// Its counter begins anew.
    Restart,
    /// It sends the same for 50 cycles.
    Repeats,
}

/// The position of cycle `k`, as a count: no two cycles have the same.
const fn position(k: i64) -> u16 {
    10_000 + 7 * k as u16
}

fn frames(case: Case, counted: bool) -> Vec<Frame> {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let mut frames = Vec::new();
    for k in 0..CYCLES {
        for mut frame in Cycle::new(k).frames() {
            if frame.id.value() != C1 {
                frames.push(frame);
                continue;
            }
            let (mut sent, mut count) = (k, k);
            let mut delays = vec![0];
            match case {
                Case::Late(by) | Case::LateAndLost(by) if k == EVENT => delays[0] = by,
                Case::LateAndLost(_) if k == EVENT + 1 => delays.clear(),
                Case::Lost if k == EVENT => delays.clear(),
                Case::Jitter(by) => delays[0] = rng.random_range(0..=by),
                Case::Shuffle(by) => delays[0] = rng.random_range(-by..=by),
                Case::Doubled(by) => delays.push(by),
                Case::Restart if k >= EVENT => count = k - EVENT,
                Case::Repeats if (EVENT..EVENT + 50).contains(&k) => {
                    (sent, count) = (EVENT - 1, EVENT - 1);
                }
                _ => {}
            }
            let [low, high] = position(sent).to_le_bytes();
            let count = if counted { count as u8 } else { 0 };
            frame.buffer_mut()[..6].copy_from_slice(&[low, high, 0, 0, 0, count]);
            frames.extend(delays.into_iter().map(|us| delayed(&frame, us)));
        }
    }
    frames.sort_by_key(|frame| frame.timestamp);
    frames
}

fn delayed(frame: &Frame, us: i64) -> Frame {
    let mut frame = frame.clone();
    frame.timestamp = Timestamp::from_nanos(frame.timestamp.as_nanos() + us * US);
    frame
}

/// Cycles, of those from 20 on, without a reading of C1, and with that of another cycle.
fn missing_and_wrong(seen: &Collected) -> (usize, usize) {
    let (mut missing, mut wrong) = (0, 0);
    for k in 20..CYCLES - 2 {
        match seen.record(k, 1).c1 {
            None => missing += 1,
            Some(c1) => {
                let count = ((c1 + 1.5) * 9216.0).round() as u16;
                wrong += usize::from(count != position(k));
            }
        }
    }
    (missing, wrong)
}

fn tried(case: Case, counted: bool, synchronised: bool) -> (usize, usize) {
    let counters: &[&str] = if counted { &[] } else { &["c1_counter", "c2_counter"] };
    let sync: &[&str] = if synchronised { &[] } else { &["sync = "] };
    let mut monitor = without(&[counters, sync].concat());
    let mut seen = Collected::default();
    for frame in frames(case, counted) {
        if synchronised || frame.id.value() != 0x080 {
            monitor.take(&frame, &mut seen);
        }
    }
    monitor.finish(&mut seen);
    missing_and_wrong(&seen)
}

/// Missing and wrong readings: with a counter, without one.
type Figures = [(usize, usize); 2];

const CASES: [(&str, Case, Figures); 14] = [
    ("19.95 ms late, then its successor", Case::Late(19_950), [(1, 0), (1, 0)]),
    ("19.9 ms late: when Sync comes", Case::Late(19_900), [(1, 0), (1, 0)]),
    ("25 ms late, after its successor", Case::Late(25_000), [(1, 0), (1, 0)]),
    ("late, successor lost", Case::LateAndLost(19_950), [(2, 0), (1, 1)]),
    ("17 ms late, successor lost", Case::LateAndLost(17_000), [(2, 0), (1, 1)]),
    ("10 ms late", Case::Late(10_000), [(0, 0), (0, 0)]),
    ("0 to 10 ms of jitter", Case::Jitter(10_000), [(0, 0), (0, 0)]),
    ("shuffled by 5 ms", Case::Shuffle(5_000), [(0, 0), (0, 0)]),
    ("doubled 0.3 ms later", Case::Doubled(300), [(0, 0), (0, 0)]),
    ("doubled 12 ms later", Case::Doubled(12_000), [(0, 0), (0, 0)]),
    ("doubled 20.1 ms later", Case::Doubled(20_100), [(0, 0), (0, 0)]),
    ("one lost", Case::Lost, [(1, 0), (1, 0)]),
    ("sender restarts", Case::Restart, [(1, 0), (0, 0)]),
    ("sender repeats itself", Case::Repeats, [(50, 0), (0, 50)]),
];

fn table(synchronised: bool) {
    let mut worse = Vec::new();
    for (name, case, allowed) in CASES {
        for (counted, allowed) in [true, false].into_iter().zip(allowed) {
            let found = tried(case, counted, synchronised);
            println!("{name:<36} {:<8} {found:?}", if counted { "counted" } else { "" });
            if found.0 + found.1 > allowed.0 + allowed.1 || found.1 > allowed.1 {
                worse.push(format!("{name}, counter {counted}: {found:?}, allowed {allowed:?}"));
            }
        }
    }
    assert!(worse.is_empty(), "missing and wrong: {worse:#?}");
}

#[test]
fn with_sync() {
    table(true);
}

#[test]
fn without_sync() {
    table(false);
}

/// A rod at rest sends the same again and again, and that is no repetition.
#[test]
fn a_rod_at_rest_that_nobody_counts_is_read_in_every_cycle() {
    for sync in [&["c1_counter", "c2_counter"][..], &["c1_counter", "c2_counter", "sync = "]] {
        let mut monitor = without(sync);
        let mut seen = Collected::default();
        for mut frame in (0..CYCLES).flat_map(|k| Cycle::new(k).frames()) {
            let id = frame.id.value();
            if id == 0x080 && sync.len() == 3 {
                continue;
            }
            if (0x181..0x1A0).contains(&id) {
                frame.buffer_mut()[5] = 0;
            }
            monitor.take(&frame, &mut seen);
        }
        monitor.finish(&mut seen);
        let counts = monitor.counts();
        assert_eq!((counts.cycles, counts.incomplete), (CYCLES as u64, 0), "{sync:?}");
    }
}

/// Senders that keep no cycle: each about every `period` µs, with the time since the start in ms as
/// the position. How many cycles lack a reading of C1, and the furthest that one is from its
/// opening, ms.
fn free_running(period: i64, counted: bool, synchronised: bool) -> (usize, i64) {
    let counters: &[&str] = if counted { &[] } else { &["c1_counter", "c2_counter"] };
    let sync: &[&str] = if synchronised { &[] } else { &["sync = "] };
    let mut monitor = without(&[counters, sync].concat());
    let mut rng = ChaCha8Rng::seed_from_u64(11);
    let mut frames: Vec<Frame> = (0..CYCLES)
        .flat_map(|k| Cycle::new(k).frames())
        .filter(|frame| frame.id.value() != C1 && (synchronised || frame.id.value() != 0x080))
        .collect();
    let model = Cycle::new(0).frames().into_iter().find(|frame| frame.id.value() == C1);
    let model = model.expect("C1 is sent");
    let (mut us, mut count) = (130, 0_u8);
    while us < CYCLES * 20_000 {
        let [low, high] = ((us / 1000) as u16 + 5000).to_le_bytes();
        let counter = if counted { count } else { 0 };
        let mut frame = delayed(&model, us);
        frame.buffer_mut()[..6].copy_from_slice(&[low, high, 0, 0, 0, counter]);
        frames.push(frame);
        count = count.wrapping_add(1);
        us += period + rng.random_range(-period / 20..=period / 20);
    }
    frames.sort_by_key(|frame| frame.timestamp);
    let mut seen = Collected::default();
    for frame in frames {
        monitor.take(&frame, &mut seen);
    }
    monitor.finish(&mut seen);
    let (mut missing, mut furthest) = (0, 0);
    for k in 20..CYCLES - 2 {
        let record = seen.record(k, 1);
        match record.c1 {
            None => missing += 1,
            Some(c1) => {
                let sampled = ((c1 + 1.5) * 9216.0).round() as i64 - 5000;
                let opened = (record.timestamp.as_nanos() - START) / MS;
                furthest = furthest.max((sampled - opened).abs());
            }
        }
    }
    (missing, furthest)
}

#[test]
fn event_driven_senders_are_read_near_the_opening_of_each_cycle() {
    for counted in [true, false] {
        for synchronised in [true, false] {
            let (missing, furthest) = free_running(1000, counted, synchronised);
            println!("1 ms, counter {counted}, Sync {synchronised}: {missing}, {furthest} ms");
            // Of whole ms; and a count that has come round since looks like a repetition. Without Sync
            // a cycle may open once the one before it has closed, 4 ms before its time.
            let allowed = if synchronised { 2 } else { 5 };
            assert!(missing == 0 && furthest <= allowed, "{missing} missing, {furthest} ms off");
        }
    }
}

/// Whoever sends more than is needed is counted to the last frame.
#[test]
fn every_frame_of_a_free_sender_is_taken_or_counted() {
    let mut monitor = without(&["c1_counter", "c2_counter"]);
    let mut seen = Collected::default();
    let mut sent = 0;
    for k in 0..CYCLES {
        let mut frames = Cycle::new(k).frames();
        let model = frames.iter().find(|frame| frame.id.value() == C1).expect("it is sent").clone();
        frames.retain(|frame| frame.id.value() != C1);
        for i in 0..19 {
            let mut frame = delayed(&model, i * 1_050);
            frame.buffer_mut()[..2].copy_from_slice(&(5_000 + 20 * k + i).to_le_bytes()[..2]);
            frame.buffer_mut()[5] = 0;
            frames.push(frame);
            sent += 1;
        }
        frames.sort_by_key(|frame| frame.timestamp);
        frames.iter().for_each(|frame| monitor.take(frame, &mut seen));
    }
    monitor.finish(&mut seen);
    let taken = seen.records.iter().filter(|it| it.cylinder == 1 && it.c1.is_some()).count();
    let counts = monitor.counts();
    assert_eq!(taken as u64, counts.cycles);
    // The last one may wait for a cycle that never opens.
    let left = sent - taken as u64 - counts.repeated - counts.late;
    assert!(left <= 1, "{left} of {sent}: {counts:?}");
}

/// A sender with a clock of its own: its frames come at every phase in turn.
#[test]
fn a_sender_whose_phase_wanders_is_never_locked_out() {
    for counted in [true, false] {
        for period in [19_900, 20_100, 10_000, 13_000] {
            let (missing, furthest) = free_running(period, counted, true);
            println!("{period} µs, counter {counted}: {missing} missing, {furthest} ms");
            assert!(missing <= 30, "{period} µs, counter {counted}: {missing} missing");
        }
    }
}

/// A box that stalls for `stall` µs at a time, somewhere in each 200 ms, and then hears all that has
/// waited at once.
fn stall_box(stall: i64, counted: bool, synchronised: bool) -> Collected {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let stalls: Vec<i64> =
        (1..CYCLES / 10).map(|i| i * 200_000 + rng.random_range(0..100_000)).collect();
    let counters: &[&str] = if counted { &[] } else { &["c1_counter", "c2_counter"] };
    let sync: &[&str] = if synchronised { &[] } else { &["sync = "] };
    let mut monitor = without(&[counters, sync].concat());
    let mut seen = Collected::default();
    let mut last = 0;
    for k in 0..CYCLES {
        for mut frame in Cycle::new(k).frames() {
            if [C1, C1 + 0x10].contains(&frame.id.value()) {
                frame.buffer_mut()[..2].copy_from_slice(&position(k).to_le_bytes());
            }
            let at = (frame.timestamp.as_nanos() - START) / US;
            let waits = stalls.iter().find(|from| (**from..**from + stall).contains(&at));
            let heard = waits.map_or(at, |from| from + stall).max(last + 20);
            last = heard;
            monitor.take(&delayed(&frame, heard - at), &mut seen);
        }
    }
    monitor.finish(&mut seen);
    seen
}

/// Readings of a [box that stalls](stall_box) that are missing, and those of another cycle.
fn stalled(stall: i64, counted: bool) -> (usize, usize) {
    let seen = stall_box(stall, counted, true);
    let of_1 = seen.records.iter().filter(|record| record.cylinder == 1);
    let (mut missing, mut wrong) = (0, 0);
    for record in of_1 {
        // A Sync is late by less than three quarters of a cycle, or that of the next one.
        let k = (record.timestamp.as_nanos() - START + 5 * MS) / (20 * MS);
        for reading in [record.c1, record.c2] {
            let count = reading.map(|metres| ((metres + 1.5) * 9216.0).round() as u16);
            missing += usize::from(count.is_none());
            wrong += usize::from(count.is_some_and(|count| count != position(k)));
        }
    }
    (missing, wrong)
}

#[test]
fn what_a_stalled_box_hears_at_once_is_of_the_cycles_it_was_sent_in() {
    for counted in [true, false] {
        for stall in [1_000, 4_000, 8_000, 12_000, 14_000] {
            let found = stalled(stall, counted);
            assert_eq!(found, (0, 0), "{stall} µs, counter {counted}: missing and wrong");
        }
        for stall in [18_000, 30_000, 60_000, 80_000] {
            let (missing, wrong) = stalled(stall, counted);
            println!("{stall} µs, counter {counted}: {missing} missing, {wrong} wrong");
            // Those of 29 stalls whose deadline has passed, of two transducers.
            let most = 2 * 29 * (stall / 20_000 + 1) as usize;
            assert!(missing <= most, "{stall} µs, counter {counted}: {missing} missing");
            assert_eq!(wrong, 0, "{stall} µs, counter {counted}");
        }
    }
    for stall in [95_000, 130_000, 170_000] {
        let (_, wrong) = stalled(stall, true);
        assert_eq!(wrong, 0, "{stall} µs: so many cycles at once take a counter");
    }
}

/// What [`sequence`] finds of a machine whose clock is set by `by` µs at frame `at` of cycle [`EVENT`].
fn set_clock(by: i64, at: usize, counted: bool, synchronised: bool) -> (usize, usize) {
    let counters: &[&str] = if counted { &[] } else { &["c1_counter", "c2_counter"] };
    let sync: &[&str] = if synchronised { &[] } else { &["sync = "] };
    let mut monitor = without(&[counters, sync].concat());
    let mut seen = Collected::default();
    for k in 0..CYCLES {
        for (index, mut frame) in Cycle::new(k).frames().into_iter().enumerate() {
            if [C1, C1 + 0x10].contains(&frame.id.value()) {
                frame.buffer_mut()[..2].copy_from_slice(&position(k).to_le_bytes());
                frame.buffer_mut()[5] = if counted { k as u8 } else { 0 };
            }
            let is_set = (k, index) >= (EVENT, at);
            monitor.take(&delayed(&frame, if is_set { by } else { 0 }), &mut seen);
        }
    }
    monitor.finish(&mut seen);
    // Whatever is waited for in between, nobody is to blame for a clock.
    assert_eq!(seen.warnings, [], "{by} µs at frame {at}");
    sequence(&seen)
}

/// The readings of cylinder 1, C1 and C2, of positions by [`position`]: cycles in which they are of different ones, or not
/// the next ones, and cycles that lack one.
fn sequence(seen: &Collected) -> (usize, usize) {
    let count = |metres: Option<f64>| metres.map(|it| ((it + 1.5) * 9216.0).round() as i64);
    let of_1 = seen.records.iter().filter(|record| record.cylinder == 1);
    let read: Vec<_> = of_1.map(|record| (count(record.c1), count(record.c2))).collect();
    let is_next = |pair: &[(Option<i64>, Option<i64>)]| {
        let next = pair[0].0.map(|it| it + 7);
        pair[1] == (next, next)
    };
    let lacks = read.iter().filter(|(c1, c2)| c1.is_none() || c2.is_none()).count();
    let mixed = read
        .windows(2)
        .filter(|pair| pair.iter().all(|(c1, c2)| c1.is_some() && c2.is_some()) && !is_next(pair));
    (mixed.count(), lacks + (CYCLES as usize).abs_diff(read.len()))
}

/// The clock behind the stamps is set back, or a delay ends: a Sync then comes too soon for the next cycle, and is it
/// all the same.
#[test]
fn a_clock_set_back_within_a_cycle_takes_no_cycle_away() {
    let frames = Cycle::new(0).frames().len();
    for counted in [true, false] {
        for by in [-3_000, -6_000, -8_000, -12_000, -15_000, -18_000] {
            for at in 0..frames {
                let found = set_clock(by, at, counted, true);
                // By its stamp alone a reading after the Sync is of the cycle before, and may be late.
                let untold = !counted && by < -10_000 && (1..=2).contains(&at);
                let most = if untold { (1, 1) } else { (0, 0) };
                let holds = found.0 <= most.0 && found.1 <= most.1;
                assert!(holds, "{by} µs at frame {at}, counter {counted}: {found:?}");
            }
        }
    }
}

/// It counts as a repetition once it is known to be one, wherever a recording is cut.
#[test]
fn a_sync_that_opens_a_cycle_after_all_is_no_repetition_wherever_it_is_counted_anew() {
    let mut monitor = without(&[]);
    let mut seen = Collected::default();
    let frames: Vec<Frame> = (0..30).flat_map(|k| Cycle::new(k).frames()).collect();
    for (index, frame) in frames.iter().enumerate() {
        let is_set = frame.timestamp.as_nanos() >= START + 20 * 20 * MS;
        monitor.take(&delayed(frame, if is_set { -8_000 } else { 0 }), &mut seen);
        if frame.id.value() == 0x080 && index > 0 {
            assert_eq!(monitor.counts().repeated, 0, "frame {index}");
            monitor.count_anew();
        }
    }
    monitor.finish(&mut seen);
    assert_eq!((monitor.counts().repeated, seen.records.len()), (0, 30 * 6));
}

/// What a stalled box without Sync hears at once is put in order by the counter, and what it says is of one cycle.
#[test]
fn without_sync_what_a_stalled_box_hears_at_once_is_not_mixed() {
    for (stall, most) in [(8_000, 0), (14_000, 0), (18_000, 6), (30_000, 40), (80_000, 200)] {
        let seen = stall_box(stall, true, false);
        let (mixed, _) = sequence(&seen);
        let of_1 = seen.records.iter().filter(|record| record.cylinder == 1);
        let missing: usize =
            of_1.map(|it| [it.c1, it.c2].iter().filter(|it| it.is_none()).count()).sum();
        assert!(mixed == 0 && missing <= most, "{stall} µs: {mixed} mixed, {missing} missing");
    }
}

/// Without Sync it is the counter that tells; and where it was set forward, that no cycle is missing.
#[test]
fn without_sync_a_clock_that_is_set_takes_few_cycles_away_and_mixes_none() {
    let frames = Cycle::new(0).frames().len();
    for by in [-18_000, -15_000, -13_000, -8_000, -3_000, 3_000, 8_000, 12_000, 18_000, 38_000] {
        for at in 0..frames {
            let (mixed, lacks) = set_clock(by, at, true, false);
            // Where whole cycles seem to have passed, five are waited for before the counter is no longer trusted.
            let most = if by > 12_000 { 10 } else { 0 };
            // Set back to just behind the newest frame, it leaves no trace.
            let untold = by < -12_000 && at < 2;
            let most = if untold { (1, 1) } else { (0, most) };
            let holds = mixed <= most.0 && lacks <= most.1;
            assert!(holds, "{by} µs at frame {at}: {mixed} and {lacks}");
        }
    }
}

/// Sync is configured and does not come, and the machine is not as fast as it says.
#[test]
fn without_the_sync_that_is_configured_a_fast_machine_loses_no_cycle() {
    for counted in [true, false] {
        for per_mille in [-10, -5, 5, 10] {
            let mut monitor = without(if counted { &[] } else { &["c1_counter", "c2_counter"] });
            let mut seen = Collected::default();
            for frame in (0..CYCLES).flat_map(|k| Cycle::new(k).frames()) {
                let since = frame.timestamp.as_nanos() - START;
                if frame.id.value() != 0x080 {
                    monitor.take(&delayed(&frame, -since / 1000 * per_mille / 1000), &mut seen);
                }
            }
            monitor.finish(&mut seen);
            let counts = monitor.counts();
            let found = (counts.cycles, counts.missing, counts.incomplete, counts.late);
            assert_eq!(found, (CYCLES as u64, 0, 0, 0), "{per_mille} ‰ fast, counter {counted}");
        }
    }
}

/// Cycles that open where all frames of cycle [`EVENT`], Sync included, come once more 3 ms later if `doubled`, or Sync alone
/// `again` µs after itself; and C1 of cylinder 1 of the next cycle comes `early`, µs after that Sync.
fn cycles_with(
    (again, doubled, early): (i64, bool, Option<i64>),
    counted: bool,
    synchronised: bool,
) -> u64 {
    let counters: &[&str] = if counted { &[] } else { &["c1_counter", "c2_counter"] };
    let sync: &[&str] = if synchronised { &[] } else { &["sync = "] };
    let mut monitor = without(&[counters, sync].concat());
    let mut frames = Vec::new();
    for k in 0..CYCLES {
        for mut frame in Cycle::new(k).frames() {
            if [C1, C1 + 0x10].contains(&frame.id.value()) {
                frame.buffer_mut()[..2].copy_from_slice(&position(k).to_le_bytes());
                frame.buffer_mut()[5] = if counted { k as u8 } else { 0 };
            }
            let is_sync = frame.id.value() == 0x080;
            if k == EVENT && (doubled || is_sync) {
                frames.push(delayed(&frame, again));
            }
            let is_early = k == EVENT + 1 && frame.id.value() == C1;
            let early = early.filter(|_| is_early).map_or(0, |us| us - 20_000);
            frames.push(delayed(&frame, early));
        }
    }
    frames.sort_by_key(|frame| frame.timestamp);
    let mut seen = Collected::default();
    frames.iter().for_each(|frame| monitor.take(frame, &mut seen));
    monitor.finish(&mut seen);
    monitor.counts().cycles
}

/// What comes once more is nothing new, and what is early does not make it so.
#[test]
fn a_repeated_sync_opens_no_cycle_for_copies_and_early_readings() {
    let cases = [
        ("all twice", (3_000, true, None)),
        ("early, after a Sync that came twice at once", (50, false, Some(6_000))),
        ("early, long after a Sync that came again", (3_000, false, Some(18_000))),
    ];
    for (counted, synchronised) in [(true, true), (true, false), (false, true), (false, false)] {
        for (what, case) in cases {
            let cycles = cycles_with(case, counted, synchronised);
            assert_eq!(cycles, CYCLES as u64, "{what}, {counted}, Sync {synchronised}");
        }
    }
}
