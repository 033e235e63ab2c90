//! Frames that cannot all be their sender's: what they carry is unknown, which is told, and no transducer is blamed.

use tertius::frame::{Frame, Id, Kind};
use tertius::monitor::Notice;
use tertius::sample::Transducer;
use tertius::sample::dispute::Doubt;
use tertius::time::Span;
use tertius_testing::machine::{Collected, Cycle, monitor};

const C1_OF_1: u32 = 0x181;

/// States in Fd_Status.
const UNKNOWN: u64 = 0;
const HEALTHY: u64 = 1;
const FAULTY: u64 = 3;

/// The frames of so many cycles, in which each frame of C1 of cylinder 1 becomes what `attack` makes of it.
fn attacked(
    cycles: std::ops::Range<i64>,
    attack: impl Fn(i64, &Frame) -> Vec<Frame>,
) -> (tertius::monitor::Monitor, Collected) {
    let (mut monitor, mut seen) = (monitor(), Collected::default());
    let mut frames: Vec<Frame> = Vec::new();
    for k in 0..cycles.end {
        for frame in Cycle::new(k).frames() {
            let is_attacked = cycles.contains(&k) && frame.id.value() == C1_OF_1;
            frames.extend(if is_attacked { attack(k, &frame) } else { vec![frame] });
        }
    }
    frames.sort_by_key(|frame| frame.timestamp);
    frames.iter().for_each(|frame| monitor.take(frame, &mut seen));
    (monitor, seen)
}

/// The frame `later`, µs, with another payload.
fn copy(frame: &Frame, later: i64, change: impl Fn(&mut Vec<u8>)) -> Frame {
    let mut data = frame.data().to_vec();
    change(&mut data);
    let at = frame.timestamp.after(Span::from_nanos(1000 * later));
    Frame::new(at, Id::standard(C1_OF_1).expect("11 bits"), Kind::Data, &data)
}

/// What was told of doubts.
fn told(seen: &Collected) -> Vec<(u32, Doubt, bool)> {
    let doubt = |notice: &Notice| match *notice {
        Notice::Doubt { id, doubt, is_over, .. } => Some((id.value(), doubt, is_over)),
        _ => None,
    };
    seen.notices.iter().filter_map(doubt).collect()
}

#[track_caller]
fn is_unknown(seen: &Collected, what: &str, why: Doubt) {
    let [c1, others @ ..] = seen.status().transducers();
    assert_eq!(c1, UNKNOWN, "{what}");
    assert_eq!(others, [HEALTHY; 11], "{what}: the others are what they were");
    assert!(seen.warnings.is_empty(), "{what}: {:?}", seen.warnings);
    assert_eq!(told(seen), [(C1_OF_1, why, false)], "{what}");
}

/// The true reading is 30 mm off, or the wire is broken, and a twin says that all is well; or the other way round.
#[test]
fn frames_that_contradict_each_other_are_unknown_and_blame_nobody() {
    let far = |data: &mut Vec<u8>| data[1] ^= 1;
    let broken = |data: &mut Vec<u8>| data[4] = 3;
    let longer = |data: &mut Vec<u8>| data.extend([7, 7]);
    // Time of the twin: before, behind, and 7 ms early.
    for later in [-50, 50, -7_000] {
        for (what, change) in [
            ("30 mm off", &far as &dyn Fn(&mut Vec<u8>)),
            ("broken wire", &broken),
            ("longer", &longer),
        ] {
            let (monitor, seen) = attacked(100..160, |_, frame| {
                vec![copy(frame, later, |_| ()), copy(frame, 0, change)]
            });
            is_unknown(&seen, &format!("{what}, {later}"), Doubt::Contradiction);
            assert!(monitor.counts().contradicting >= 55, "{:?}", monitor.counts());
        }
    }
    // What comes 12 ms early is of no cycle, so that the step of the other one is seen before they contradict each other.
    let (_, seen) =
        attacked(100..160, |_, frame| vec![copy(frame, -12_000, |_| ()), copy(frame, 0, far)]);
    assert_ne!(seen.status().transducers()[0], HEALTHY, "12 ms early");
    assert_eq!(told(&seen), [(C1_OF_1, Doubt::Contradiction, false)], "12 ms early");
    // Frames of 10 s before, with their counters.
    for later in [-50, 50] {
        let (_, seen) = attacked(100..160, |k, frame| {
            let before = copy(frame, later, |data| {
                data[0] ^= 1;
                data[5] = (k + 13) as u8;
            });
            vec![before, frame.clone()]
        });
        is_unknown(&seen, &format!("of 10 s before, {later}"), Doubt::Contradiction);
    }
}

#[test]
fn frames_that_no_longer_contradict_each_other_are_judged_again() {
    let twice = |k: i64, frame: &Frame| match k {
        100..110 => vec![frame.clone(), copy(frame, 50, |data| data[0] ^= 1)],
        _ => vec![frame.clone()],
    };
    let (monitor, seen) = attacked(100..300, twice);
    assert_eq!(monitor.counts().contradicting, 10);
    let doubt = (C1_OF_1, Doubt::Contradiction);
    assert_eq!(told(&seen), [(doubt.0, doubt.1, false), (doubt.0, doubt.1, true)]);
    assert_eq!(seen.status().transducers(), [HEALTHY; 12]);
    assert!(seen.warnings.is_empty(), "{:?}", seen.warnings);
}

#[test]
fn a_frame_that_comes_twice_is_no_contradiction() {
    let (monitor, seen) =
        attacked(100..160, |_, frame| vec![frame.clone(), copy(frame, 50, |_| ())]);
    assert_eq!((monitor.counts().repeated, monitor.counts().contradicting), (60, 0));
    assert!(told(&seen).is_empty());
    assert_eq!(seen.status().transducers(), [HEALTHY; 12]);
}

/// Its last byte is the alive counter: without it nothing says that the reading is new.
#[test]
fn a_frame_that_is_cut_off_proves_nothing() {
    let cut = |length: usize| move |data: &mut Vec<u8>| data.truncate(length);
    let (monitor, seen) = attacked(100..160, |_, frame| vec![copy(frame, 0, cut(5))]);
    is_unknown(&seen, "cut off", Doubt::TooShort);
    assert_eq!(monitor.counts().short, 60);
    // A twin that is too short takes nothing from the true one.
    for later in [-50, 50] {
        let (_, seen) =
            attacked(100..160, |_, frame| vec![copy(frame, later, cut(2)), frame.clone()]);
        assert_eq!(seen.status().transducers(), [HEALTHY; 12], "{later}");
        assert!(seen.warnings.is_empty(), "{:?}", seen.warnings);
        assert_eq!(told(&seen), [(C1_OF_1, Doubt::TooShort, false)], "{later}");
    }
}

/// What is unknown is no witness: the other transducer is judged as the last one.
#[test]
fn a_step_of_the_other_transducer_is_its_own() {
    let (mut monitor, mut seen) = (monitor(), Collected::default());
    let c2_of_1 = C1_OF_1 + 0x10;
    for k in 0..300 {
        for frame in Cycle::new(k).frames() {
            let id = frame.id.value();
            if k >= 100 && id == C1_OF_1 {
                let twin = copy(&frame, 50, |data| data[0] ^= 1);
                [frame, twin].iter().for_each(|it| monitor.take(it, &mut seen));
            } else if k >= 200 && id == c2_of_1 {
                let mut data = frame.data().to_vec();
                data[0] = data[0].wrapping_add(90);
                monitor.take(&Frame::new(frame.timestamp, frame.id, Kind::Data, &data), &mut seen);
            } else {
                monitor.take(&frame, &mut seen);
            }
        }
    }
    assert_eq!(seen.status().transducers()[..2], [UNKNOWN, FAULTY], "{:?}", seen.warnings);
}

/// What the monitor makes of a healthy minute of cycles with these Syncs, µs after each cycle's begin.
fn synchronised(syncs: impl Fn(i64) -> Vec<i64>) -> (tertius::monitor::Monitor, Collected) {
    let (mut monitor, mut seen) = (monitor(), Collected::default());
    let mut frames: Vec<Frame> = Vec::new();
    for k in 0..1000 {
        let (sync, others): (Vec<Frame>, Vec<Frame>) =
            Cycle::new(k).frames().into_iter().partition(|frame| frame.id.value() == SYNC);
        let at = sync[0].timestamp;
        frames.extend(others);
        let later = |later| at.after(Span::from_nanos(1000 * later));
        let sync = |at| Frame::new(at, sync[0].id, Kind::Data, sync[0].data());
        frames.extend(syncs(k).into_iter().map(later).map(sync));
    }
    frames.sort_by_key(|frame| frame.timestamp);
    frames.iter().for_each(|frame| monitor.take(frame, &mut seen));
    (monitor, seen)
}

const SYNC: u32 = 0x080;

/// Readings open the cycles, each transducer is judged in each of them, and it is told.
#[test]
fn a_flood_of_sync_is_told_and_moves_no_cycle() {
    for (what, extra) in [
        (
            "18 in a cycle",
            &(|_: i64| (1..19).map(|i: i64| 1_050 * i).collect()) as &dyn Fn(i64) -> Vec<i64>,
        ),
        ("three in a cycle", &|_| vec![6_700, 13_400]),
        ("four in a cycle", &|_| vec![5_000, 10_000, 15_000]),
        ("at random", &|k: i64| (1..6).map(|i: i64| (k * 7_919 + i * 104_729) % 20_000).collect()),
    ] {
        let (monitor, seen) = synchronised(|k| {
            let extra = if (300..700).contains(&k) { extra(k) } else { Vec::new() };
            [vec![0], extra].concat()
        });
        let doubts = told(&seen);
        assert_eq!(doubts, [(SYNC, Doubt::Flood, false), (SYNC, Doubt::Flood, true)], "{what}");
        assert!(seen.warnings.is_empty(), "{what}: {:?}", seen.warnings);
        assert_eq!(seen.status().transducers(), [HEALTHY; 12], "{what}");
        let counts = monitor.counts();
        assert!((995..=1005).contains(&counts.cycles), "{what}: {counts:?}");
        assert!((7..=10).contains(&counts.sync_doubted), "{what}: {counts:?}");
    }
}

/// As if none were configured; the readings are what they were.
#[test]
fn a_sync_that_no_longer_comes_is_told() {
    let every = |of: i64| {
        move |k: i64| if (300..700).contains(&k) && k % of != 0 { vec![] } else { vec![0] }
    };
    for (what, syncs) in [
        ("none", Box::new(every(i64::MAX)) as Box<dyn Fn(i64) -> Vec<i64>>),
        ("every third", Box::new(every(3))),
    ] {
        let (monitor, seen) = synchronised(syncs);
        assert_eq!(
            told(&seen),
            [(SYNC, Doubt::Absent, false), (SYNC, Doubt::Absent, true)],
            "{what}"
        );
        assert!(seen.warnings.is_empty(), "{what}: {:?}", seen.warnings);
        assert_eq!(seen.status().transducers(), [HEALTHY; 12], "{what}");
        assert!((995..=1005).contains(&monitor.counts().cycles), "{what}: {:?}", monitor.counts());
    }
}

/// A Sync lost now and then, two recorders of one bus, and a computer that stalls are no doubt.
#[test]
fn an_odd_sync_now_and_then_is_not_told() {
    for (what, syncs) in [
        (
            "one in ten lost",
            &(|k: i64| if k % 10 == 3 { vec![] } else { vec![0_i64] }) as &dyn Fn(i64) -> Vec<i64>,
        ),
        ("two interfaces", &|_| vec![0, 20]),
    ] {
        let (monitor, seen) = synchronised(syncs);
        assert_eq!(told(&seen), [], "{what}");
        assert_eq!(monitor.counts().sync_doubted, 0, "{what}");
    }
}

/// It is told, and what comes is taken by its time, as without a counter.
#[test]
fn a_counter_that_does_not_count_is_told() {
    let counted = |frame: &Frame, value: i64| vec![copy(frame, 0, |data| data[5] = value as u8)];
    let (_, seen) = attacked(100..400, |k, frame| counted(frame, (k * k * k * 7_919) >> 7));
    assert_eq!(told(&seen), [(C1_OF_1, Doubt::Uncounted, false)]);
    assert_eq!(seen.status().transducers(), [HEALTHY; 12]);
    assert!(seen.warnings.is_empty(), "{:?}", seen.warnings);
    // One that counts down tells the cycles as well.
    let (_, seen) = attacked(100..400, |k, frame| counted(frame, -k));
    assert_eq!(told(&seen), []);
    // A sender that starts anew counts on.
    let (_, seen) = attacked(100..400, |k, frame| counted(frame, k - k / 130 * 100));
    assert_eq!(told(&seen), []);
}

/// The mask has bits 0 and 1. Others are no fault, are told once, and hide none that is one.
#[test]
fn a_status_without_a_meaning_is_told_once_and_is_no_fault() {
    let status = |k: i64| match k {
        100..130 => 0x04,
        130..160 => 0x24,
        _ => 0x00,
    };
    let (mut monitor, mut seen) =
        attacked(100..200, |k, frame| vec![copy(frame, 0, |data| data[4] = status(k))]);
    let unnamed = |seen: &Collected| -> Vec<(u8, Transducer, u64)> {
        let of = |notice: &Notice| match *notice {
            Notice::UnnamedStatus { cylinder, transducer, bits, .. } => {
                Some((cylinder, transducer, bits))
            }
            _ => None,
        };
        seen.notices.iter().filter_map(of).collect()
    };
    assert_eq!(unnamed(&seen), [(1, Transducer::C1, 0x04), (1, Transducer::C1, 0x20)]);
    assert_eq!(monitor.counts().unnamed_status_bits, 2);
    assert_eq!(seen.status().transducers(), [HEALTHY; 12]);
    assert!(seen.warnings.is_empty(), "{:?}", seen.warnings);
    for k in 200..260 {
        for frame in Cycle::new(k).frames() {
            let is_attacked = frame.id.value() == C1_OF_1;
            let broken = || copy(&frame, 0, |data| data[4] = 0x24 | 1);
            monitor.take(&if is_attacked { broken() } else { frame.clone() }, &mut seen);
        }
    }
    assert_eq!(seen.status().transducers()[0], FAULTY, "a broken wire is one beside them");
    assert_eq!(monitor.counts().unnamed_status_bits, 2);
}
