//! What belongs to one cycle, what is missing, and what time alone brings: the monitor fed with
//! frames made by hand.

use tertius::alarm::{Detector, Warning};
use tertius::frame::Frame;
use tertius::monitor::{Monitor, Notice};
use tertius::time::Timestamp;
use tertius::verdict::{Fault, Suspect};
use tertius_testing::machine::{self, Collected, Cycle, MS, monitor, play};

#[test]
fn whole_cycles_are_counted_and_quiet() {
    let (monitor, seen) = play((0..100).flat_map(|k| Cycle::new(k).frames()));
    assert_eq!(monitor.counts().cycles, 100);
    assert_eq!(monitor.counts().incomplete, 0);
    assert_eq!(monitor.counts().missing, 0);
    assert_eq!(seen.records.len(), 600);
    assert!(seen.warnings.is_empty(), "{:?}", seen.warnings);
    let judged = seen.records.iter().filter(|record| !record.gated).count();
    assert_eq!(judged, 300, "the observers settle for 50 cycles");
}

/// Only the commands of a machine, whose transducers are dead from the beginning.
fn commands(cycles: std::ops::Range<i64>) -> impl Iterator<Item = Frame> {
    let is_command = |it: &Frame| (0x1A1..=0x1A6).contains(&it.id.value());
    cycles.flat_map(|k| Cycle::new(k).frames()).filter(is_command)
}

#[test]
fn transducers_that_are_dead_from_the_beginning_are_told() {
    for left_out in [&["sync = "][..], &[]] {
        let mut monitor = machine::without(left_out);
        let mut seen = Collected::default();
        commands(0..9).for_each(|it| monitor.take(&it, &mut seen));
        assert!(seen.warnings.is_empty(), "so much may be missing at a start");
        commands(9..50).for_each(|it| monitor.take(&it, &mut seen));
        for cylinder in 1..=6 {
            let of = |suspect| {
                let is = |it: &&Warning| {
                    (it.cylinder, it.finding.fault, it.finding.suspect)
                        == (cylinder, Fault::Stale, suspect)
                };
                seen.warnings.iter().filter(is).count()
            };
            let found = [Suspect::C1, Suspect::C2, Suspect::Process].map(of);
            assert!(found[0] >= 1 && found[1] >= 1, "{left_out:?} {cylinder}: {:?}", seen.warnings);
        }
        assert_eq!(monitor.counts().cycles, 0);
        // The readings come after all.
        (50..250).flat_map(|k| Cycle::new(k).frames()).for_each(|it| {
            if left_out.is_empty() || it.id.value() != 0x080 {
                monitor.take(&it, &mut seen);
            }
        });
        assert_eq!(
            (monitor.counts().cycles, monitor.counts().incomplete),
            (200, 0),
            "{left_out:?}"
        );
        assert!(!seen.record(249, 1).gated, "they are judged");
    }
}

/// A bus on which only somebody else's frames are is not known to be this machine's.
#[test]
fn without_commands_nothing_is_told_of_transducers_that_never_came() {
    let mut monitor = machine::without_sync();
    let mut seen = Collected::default();
    for k in 0..100 {
        let frames = Cycle::new(k).frames();
        frames
            .iter()
            .filter(|it| it.id.value() == 0x1C1)
            .for_each(|it| monitor.take(it, &mut seen));
    }
    assert!(seen.warnings.is_empty(), "{:?}", seen.warnings);
}

#[test]
fn a_lost_reading_is_predicted_over_and_the_cycle_counted() {
    let lost = Cycle::new(60).frames().into_iter().filter(|frame| frame.id.value() != 0x183);
    let before = (0..60).flat_map(|k| Cycle::new(k).frames());
    let after = (61..100).flat_map(|k| Cycle::new(k).frames());
    let (monitor, seen) = play(before.chain(lost).chain(after));
    assert_eq!(monitor.counts().incomplete, 1);
    let record = seen.record(60, 3);
    assert_eq!((record.c1, record.residuals[0], record.residuals[2]), (None, None, None));
    assert!(record.c2.is_some() && record.residuals[1].is_some());
    assert!(seen.record(61, 3).residuals[0].is_some_and(|r1| r1.abs() < 1e-6));
    assert!(!seen.record(61, 3).gated, "one lost reading does not make the observer start anew");
    assert!(seen.warnings.is_empty() && seen.notices.is_empty());
}

#[test]
fn a_lost_cycle_is_predicted_over_and_a_longer_gap_starts_anew() {
    let without = |from: i64, to: i64| {
        let cycles = (0..200).filter(move |k| !(from..to).contains(k));
        play(cycles.flat_map(|k| Cycle::new(k).frames()))
    };
    let (monitor, seen) = without(100, 105);
    assert_eq!((monitor.counts().cycles, monitor.counts().missing), (195, 5));
    assert!(seen.notices.is_empty(), "five cycles are predicted over: {:?}", seen.notices);
    assert!(!seen.record(105, 1).gated);

    let (monitor, seen) = without(100, 106);
    assert_eq!(monitor.counts().missing, 6);
    let restarts = |detector| {
        let of = |notice: &&Notice| matches!(notice, Notice::Restart { detector: found, .. } if *found == detector);
        seen.notices.iter().filter(of).count()
    };
    assert_eq!((restarts(Detector::Fde1), restarts(Detector::Fde2)), (6, 6), "and it says so");
    assert!(seen.notices.iter().any(|notice| matches!(notice, Notice::Gap { .. })));
    assert!(seen.record(106, 1).gated, "an observer settles before it judges");
    assert!(seen.warnings.is_empty(), "a quiet bus is not a transducer's fault");
}

#[test]
fn in_silence_nothing_is_healthy() {
    let before = (0..100).flat_map(|k| Cycle::new(k).frames());
    let (mut monitor, mut seen) = play(before);
    assert_eq!(seen.status().transducers(), [1; 12], "all healthy while there is evidence");
    monitor.advance(Timestamp::from_nanos(machine::START + 2_700 * MS), &mut seen);
    assert_eq!(seen.status().transducers(), [0; 12], "all unknown in silence");
    assert_eq!(seen.status().mode(), 3, "degraded");
}

#[test]
fn a_reading_stands_in_for_a_lost_sync() {
    let frames = (0..100).flat_map(|k| {
        let sync_lost = k == 50;
        Cycle::new(k).frames().into_iter().filter(move |f| !(sync_lost && f.id.value() == 0x80))
    });
    let (monitor, seen) = play(frames);
    assert_eq!(monitor.counts().cycles, 100);
    assert_eq!((monitor.counts().incomplete, monitor.counts().missing), (0, 0));
    assert!(seen.record(50, 6).residuals.iter().all(Option::is_some));
}

#[test]
fn a_command_after_the_deadline_does_not_slip_into_the_next_cycle() {
    let frames = (0..100).flat_map(|k| {
        let mut frames = Cycle::new(k).frames();
        if k == 50 {
            for frame in frames.iter_mut().filter(|frame| frame.id.value() == 0x1A2) {
                frame.timestamp = Timestamp::from_nanos(machine::START + k * 20 * MS + 17 * MS);
            }
            frames.sort_by_key(|frame| frame.timestamp);
        }
        frames
    });
    let (monitor, seen) = play(frames);
    assert_eq!((monitor.counts().late, monitor.counts().incomplete), (1, 1));
    assert_eq!(seen.record(50, 2).command, None);
    assert!(seen.record(50, 2).residuals[0].is_some(), "the readings were in time");
    assert_eq!(seen.record(51, 2).command, Some(0.0));
}

#[test]
fn a_bus_recorded_on_two_interfaces_is_one_bus() {
    let frames = (0..100).flat_map(|k| Cycle::new(k).frames());
    let (monitor, seen) = play(frames.flat_map(|frame| [frame.clone(), frame]));
    assert_eq!((monitor.counts().cycles, monitor.counts().incomplete), (100, 0));
    // All but the platform's state, which belongs to no cycle.
    assert_eq!(monitor.counts().repeated, 19 * 100);
    let (_, once) = play((0..100).flat_map(|k| Cycle::new(k).frames()));
    assert_eq!(seen.records, once.records);
    assert_eq!(seen.frames, once.frames);
}

/// The second bus is 1.25 ms behind the first, so that its Sync comes among the readings.
#[test]
fn a_sync_that_comes_again_after_other_frames_opens_nothing() {
    let shifted = |frame: &Frame| {
        let mut frame = frame.clone();
        frame.timestamp = Timestamp::from_nanos(frame.timestamp.as_nanos() + MS + MS / 4);
        frame
    };
    let once = (0..100).flat_map(|k| Cycle::new(k).frames());
    let mut twice: Vec<Frame> = once.clone().flat_map(|frame| [shifted(&frame), frame]).collect();
    twice.sort_by_key(|frame| frame.timestamp);
    let (monitor, seen) = play(twice);
    assert_eq!((monitor.counts().cycles, monitor.counts().incomplete), (100, 0));
    assert_eq!((monitor.counts().repeated, monitor.counts().late), (19 * 100, 0));
    let (_, once) = play(once);
    assert_eq!(seen.records, once.records);
    assert_eq!(seen.warnings, once.warnings);
}

/// A command that is stamped before the newest Sync and comes after it is not of that Sync's cycle.
#[test]
fn a_frame_out_of_order_is_of_the_cycle_of_its_stamp() {
    let mut frames: Vec<Frame> = Vec::new();
    for k in 0..100 {
        let mut cycle = Cycle { command: k as i16, ..Cycle::new(k) }.frames();
        if k == 51 {
            let place = frames.iter().rposition(|frame| frame.id.value() == 0x1A2);
            let command = frames.remove(place.expect("cycle 50 has it"));
            cycle.insert(1, command);
        }
        frames.extend(cycle);
    }
    for frame in &mut frames {
        // 12 ms after the opening, where 8 ms later the next one follows.
        if (0x1A1..0x1B0).contains(&frame.id.value()) {
            let at = frame.timestamp.as_nanos() + 12 * MS;
            frame.timestamp = Timestamp::from_nanos(at);
        }
    }
    let (monitor, seen) = play(frames);
    assert_eq!(monitor.counts().late, 1);
    assert_eq!(seen.record(50, 2).command, None);
    assert_eq!(seen.record(51, 2).command, Some(51.0 * 1e-4));
}

#[test]
fn a_late_reading_does_not_stand_in_for_a_sync_that_is_still_to_come() {
    let frames = (0..100).flat_map(|k| {
        let mut frames = Cycle::new(k).frames();
        if k == 70 {
            for frame in frames.iter_mut().filter(|frame| frame.id.value() == 0x181) {
                frame.timestamp = Timestamp::from_nanos(machine::START + k * 20 * MS + 18 * MS);
            }
            frames.sort_by_key(|frame| frame.timestamp);
        }
        frames
    });
    let (monitor, seen) = play(frames);
    assert_eq!((monitor.counts().late, monitor.counts().repeated), (1, 0));
    assert_eq!((monitor.counts().cycles, monitor.counts().incomplete), (100, 1));
    assert_eq!(seen.record(70, 1).c1, None);
    assert!(seen.record(71, 1).c1.is_some() && seen.warnings.is_empty());
}

#[test]
fn a_silent_transducer_on_a_living_bus_is_stale() {
    let frames = (0..120).flat_map(|k| {
        let silent = k >= 80;
        Cycle::new(k).frames().into_iter().filter(move |f| !(silent && f.id.value() == 0x194))
    });
    let (_, seen) = play(frames);
    let [warning] = &seen.warnings[..] else { panic!("{:?}", seen.warnings) };
    assert_eq!(
        (warning.cylinder, warning.detector.name(), warning.finding.fault.name()),
        (4, "plausibility", "stale")
    );
    assert_eq!(warning.finding.suspect.name(), "c2");
    let after = warning.timestamp.as_nanos() - (machine::START + 80 * 20 * MS);
    assert_eq!(after, 4 * 20 * MS + 16 * MS, "at the deadline of the fifth cycle without it");
}

/// A clock that is set forward in the middle of a cycle: every frame has come, though for no cycle that is still open.
/// Nobody waits for what was dead when the gateway came.
#[test]
fn with_a_transducer_that_is_silent_from_the_start_it_does_not_start_for_ever() {
    let frames = |cycles| (0..cycles).flat_map(|k| Cycle::new(k).frames());
    let (_, seen) = play(frames(30));
    assert_eq!(seen.status().mode(), 0, "the observers settle");
    let (_, seen) = play(frames(200).filter(|frame| frame.id.value() != 0x183));
    assert_eq!(seen.warnings.len(), 1, "{:?}", seen.warnings);
    assert_eq!(seen.status().mode(), 3, "degraded");
}

#[test]
fn frames_that_find_no_cycle_for_a_while_are_not_missing() {
    for by in [30, 40, 100, 300, 500] {
        for within in [0.5, 1.8, 5.0, 12.0] {
            let step = machine::START + 80 * 20 * MS + (within * MS as f64) as i64;
            let mut frames: Vec<Frame> =
                (0..160).flat_map(|k| Cycle { command: 300, ..Cycle::new(k) }.frames()).collect();
            for frame in &mut frames {
                let nanos = frame.timestamp.as_nanos();
                let late = if nanos >= step { by * MS } else { 0 };
                frame.timestamp = Timestamp::from_nanos(nanos + late);
            }
            let (_, seen) = play(frames);
            assert!(seen.warnings.is_empty(), "{by} ms, {within} ms: {:?}", seen.warnings);
            let last = seen.records.last().expect("there are many");
            assert!(last.c1.is_some() && last.c2.is_some(), "{by} ms, {within} ms");
        }
    }
}

#[test]
fn frames_out_of_order_are_taken_and_a_set_clock_starts_anew() {
    let (monitor, seen) = play((0..100).flat_map(|k| {
        let mut frames = Cycle::new(k).frames();
        frames.swap(3, 4);
        frames
    }));
    assert_eq!(monitor.counts().backwards, 100);
    assert_eq!((monitor.counts().time_jumps, monitor.counts().incomplete), (0, 0));
    assert!(seen.notices.is_empty());

    for leap in [-3_600_000, 7_200_000] {
        let shifted = |k: i64| {
            let mut frames = Cycle::new(k).frames();
            let shift = if k < 100 { 0 } else { leap * MS };
            for frame in &mut frames {
                let nanos = frame.timestamp.as_nanos() + shift;
                frame.timestamp = Timestamp::from_nanos(nanos);
            }
            frames
        };
        let (monitor, seen) = play((0..200).flat_map(shifted));
        assert_eq!(monitor.counts().time_jumps, 1);
        assert!(seen.notices.iter().any(|notice| matches!(notice, Notice::TimeJump { .. })));
        assert_eq!(monitor.counts().cycles, 200);
        assert!(seen.warnings.is_empty(), "{:?}", seen.warnings);
    }
}

#[test]
fn without_sync_a_recording_that_begins_in_the_middle_pairs_what_belongs_together() {
    let mut monitor = machine::without_sync();
    let mut seen = Collected::default();
    let frames = (0..100).flat_map(|k| Cycle { command: k as i16, ..Cycle::new(k) }.frames());
    // From the second valve frame of cycle 0 on.
    for frame in frames.skip(15) {
        monitor.take(&frame, &mut seen);
    }
    monitor.finish(&mut seen);
    assert_eq!(monitor.counts().late, 5, "the valve frames of cycle 0 belong to nothing");
    assert_eq!((monitor.counts().cycles, monitor.counts().incomplete), (99, 0));
    for k in 1..100 {
        assert_eq!(seen.record(k, 6).command, Some(k as f64 * 1e-4), "cycle {k}");
    }
}

/// The gateway advances by its clock, a replay by the frames alone: both must say the same.
/// In one step or cycle by cycle: an hour of silence says the same, and costs what is said in it.
#[test]
fn silence_costs_what_is_said_in_it() {
    let mut monitor = machine::hasty();
    let mut seen = Collected::default();
    let frames = Cycle::new(0).frames();
    let again = Frame::new(
        Timestamp::from_nanos(machine::START + 3_599_000 * MS),
        frames[0].id,
        frames[0].kind,
        frames[0].data(),
    );
    frames.iter().chain([&again]).for_each(|frame| monitor.take(frame, &mut seen));
    let counts = monitor.counts();
    assert_eq!(counts.cycles + counts.missing, 3_599_000_001, "every microsecond is a cycle");
    let statuses = seen.frames.iter().filter(|frame| frame.id.value() == 0x1D1).count();
    assert!(counts.missing > 3_598_000_000, "{}", counts.missing);
    assert_eq!(statuses, 35_989, "each at its time");

    for valves in [false, true] {
        // A transducer that is off leaves warnings which are repeated in the silence.
        let mut frames: Vec<Frame> =
            (0..100).flat_map(|k| Cycle { offset: 50, ..Cycle::new(k) }.frames()).collect();
        if valves {
            let lone = (0..3_000).map(|i| 100 + 9 * i / 2).filter(|k| *k < 13_000);
            frames.extend(lone.map(|k| Cycle::new(k).frames().remove(14)));
        }
        frames.extend((13_100..13_200).flat_map(|k| Cycle::new(k).frames()));
        let (at_once, expected) = play(frames.iter().cloned());
        assert!(at_once.counts().missing > 12_000 && !expected.warnings.is_empty());

        let mut walked = Collected::default();
        let mut walker = machine::monitor();
        let mut now = frames[0].timestamp.as_nanos();
        for frame in &frames {
            while now < frame.timestamp.as_nanos() {
                walker.advance(Timestamp::from_nanos(now), &mut walked);
                now += 7 * MS;
            }
            walker.take(frame, &mut walked);
        }
        walker.finish(&mut walked);
        assert_eq!(walker.counts(), at_once.counts());
        assert_eq!(walked.warnings, expected.warnings);
        assert_eq!(walked.frames, expected.frames);
        assert_eq!(walked.notices, expected.notices);
        assert_eq!(walked.records, expected.records);
    }
}

/// A notice's time.
fn told_at(notice: &Notice) -> Timestamp {
    match *notice {
        Notice::Gap { at, .. }
        | Notice::TimeJump { at, .. }
        | Notice::Interruption { at, .. }
        | Notice::Silence { at, .. }
        | Notice::Doubt { at, .. }
        | Notice::Restart { at, .. }
        | Notice::Timing { at, .. }
        | Notice::UnnamedStatus { at, .. }
        | Notice::Device { at, .. } => at,
    }
}

/// Only a clock that was set takes the notices back in time, and what follows it is of the new time.
#[test]
fn an_interruption_after_a_clock_was_set_is_of_the_new_time() {
    for back in [1_500, 3_600_000, -7_200_000] {
        let (mut monitor, mut seen) = play((0..100).flat_map(|k| Cycle::new(k).frames()));
        let lost = machine::START + (2_000 - back) * MS;
        monitor.interrupt(Timestamp::from_nanos(lost), &mut seen);
        for frame in (101..200).flat_map(|k| Cycle::new(k).frames()) {
            let at = Timestamp::from_nanos(frame.timestamp.as_nanos() - back * MS);
            monitor.take(&Frame::new(at, frame.id, frame.kind, frame.data()), &mut seen);
        }
        assert!(matches!(seen.notices[0], Notice::TimeJump { .. }), "{:?}", seen.notices);
        assert!(matches!(seen.notices[1], Notice::Interruption { .. }), "{:?}", seen.notices);
        let times: Vec<Timestamp> = seen.notices.iter().map(told_at).collect();
        assert_eq!(times[1].as_nanos(), lost);
        assert!(times.len() > 12 && times.is_sorted(), "{times:?}");
    }
}

#[test]
fn advancing_between_frames_changes_nothing() {
    let frames: Vec<Frame> = (0..400)
        .filter(|k| !(150..160).contains(k) && k % 37 != 0)
        .flat_map(|k| {
            let offset = if (200..230).contains(&k) { 30 } else { 0 };
            Cycle { offset, ..Cycle::new(k) }.frames()
        })
        .enumerate()
        .filter(|(index, _)| index % 101 != 0)
        .map(|(_, frame)| frame)
        .collect();
    let (_, replayed) = play(frames.iter().cloned());
    assert!(replayed.warnings.len() >= 4 && replayed.notices.len() > 4);

    let mut live = Collected::default();
    let mut monitor: Monitor = monitor();
    let mut last = frames[0].timestamp.as_nanos();
    for (index, frame) in frames.iter().enumerate() {
        let next = frame.timestamp.as_nanos();
        for step in 0..index as i64 % 4 {
            let now = last + (next - last) * step / 3;
            monitor.advance(Timestamp::from_nanos(now), &mut live);
        }
        monitor.take(frame, &mut live);
        last = next;
    }
    monitor.finish(&mut live);
    assert_eq!(live.warnings, replayed.warnings);
    assert_eq!(live.frames, replayed.frames);
    assert_eq!(live.notices, replayed.notices);
    assert_eq!(live.records, replayed.records);
}
