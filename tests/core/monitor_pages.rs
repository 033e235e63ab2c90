//! Multiplexed messages: each page arrives for itself.

use std::path::Path;
use tertius::config;
use tertius::config::design;
use tertius::dbc::{Database, text};
use tertius::frame::{Frame, Id, Kind};
use tertius::monitor::Monitor;
use tertius::time::Timestamp;
use tertius_testing::machine::{Collected, Cycle, MS};

const CYCLES: i64 = 300;
const METRES: &str = "(0.00010850694444444444,-1.5) [-1.5|1.5] \"m\" Gateway";

/// C2 of six cylinders in six pages, with one counter for all; one page that nobody reads.
fn six_pages() -> String {
    let mut message = format!(
        "BO_ 704 Six: 8 Plc\n SG_ Page M : 0|8@1+ (1,0) [0|7] \"\" Gateway\n \
         SG_ Counter : 8|8@1+ (1,0) [0|255] \"\" Gateway\n \
         SG_ Spare m7 : 16|16@1+ {METRES}\n"
    );
    for n in 1..=6 {
        message += &format!(" SG_ Position{n} m{} : 16|16@1+ {METRES}\n", n - 1);
    }
    message
}

/// The default machine with another message in its DBC and other lines in its configuration.
fn monitor(message: &str, multiplexing: &str, lines: &[(&str, &str)]) -> Result<Monitor, String> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let read = |path: &str| std::fs::read(root.join(path)).map_err(|error| error.to_string());
    let toml = String::from_utf8(read("config/e-type.toml")?).map_err(|error| error.to_string())?;
    let replaced = toml.lines().map(|line| {
        let key = line.split(" = ").next().unwrap_or_default();
        lines.iter().find(|(known, _)| *known == key).map_or(line, |(_, other)| other).to_owned()
    });
    let replaced = replaced.collect::<Vec<_>>().join("\n");
    let (settings, _) = config::parse("pages.toml", &replaced).map_err(|e| e.to_string())?;
    let dbc = text::from_bytes(&read("dbc/e-type.dbc")?).into_owned();
    let dbc = dbc.replacen("\nBO_ 385 ", &format!("\n{message}\nBO_ 385 "), 1) + multiplexing;
    let database = Database::parse(&dbc).map_err(|error| error.to_string())?;
    let design = design::judging(&settings, &database).map_err(|flaws| format!("{flaws:?}"))?;
    Ok(Monitor::new(design))
}

const SHARED: [(&str, &str); 4] = [
    ("c2", "c2 = \"Six.Position{n}\""),
    ("c2_counter", "c2_counter = \"Six.Counter\""),
    ("c2_velocity", ""),
    ("c2_status", ""),
];

const fn count(k: i64, n: u32) -> u16 {
    12_000 + k as u16 + 100 * n as u16
}

fn is_c2(frame: &Frame) -> bool {
    (0x191..=0x196).contains(&frame.id.value())
}

/// The frames of a cycle with what `page` makes of those of C2 of each cylinder.
fn with_pages(k: i64, page: impl Fn(u32, &Frame) -> Vec<Frame>) -> Vec<Frame> {
    let mut frames = Vec::new();
    for frame in Cycle::new(k).frames() {
        match is_c2(&frame) {
            true => frames.extend(page(frame.id.value() - 0x190, &frame)),
            false => frames.push(frame),
        }
    }
    frames
}

fn page_of(frame: &Frame, k: i64, n: u32, counter: i64) -> Frame {
    let [low, high] = count(k, n).to_le_bytes();
    let id = Id::standard(704).expect("it has 11 bits");
    let data = [n as u8 - 1, counter as u8, low, high, 0, 0, 0, 0];
    Frame::new(frame.timestamp, id, Kind::Data, &data)
}

fn play(mut monitor: Monitor, frames: impl IntoIterator<Item = Frame>) -> (Monitor, Collected) {
    let mut seen = Collected::default();
    for frame in frames {
        monitor.take(&frame, &mut seen);
    }
    monitor.finish(&mut seen);
    (monitor, seen)
}

fn c2(seen: &Collected, k: i64, n: u8) -> Option<u16> {
    seen.record(k, n).c2.map(|c2| ((c2 + 1.5) * 9216.0).round() as u16)
}

#[test]
fn six_pages_of_one_message_are_six_readings() {
    let monitor = monitor(&six_pages(), "", &SHARED).expect("it is sound");
    let frames = (0..CYCLES)
        .flat_map(|k| with_pages(k, |n, frame| vec![page_of(frame, k, n, 6 * k + i64::from(n))]));
    let (monitor, seen) = play(monitor, frames);
    let counts = monitor.counts();
    assert_eq!((counts.cycles, counts.incomplete), (CYCLES as u64, 0), "{counts:?}");
    assert_eq!((counts.repeated, counts.late), (0, 0));
    assert!(monitor.counter_jumps().all(|jumps| jumps == [0, 0]));
    for k in 0..CYCLES {
        for n in 1..=6 {
            assert_eq!(c2(&seen, k, n), Some(count(k, n.into())), "cylinder {n}, cycle {k}");
        }
    }
}

#[test]
fn a_page_that_is_late_by_a_cycle_is_late() {
    let monitor = monitor(&six_pages(), "", &SHARED).expect("it is sound");
    let mut frames: Vec<Frame> = (0..CYCLES)
        .flat_map(|k| {
            with_pages(k, |n, frame| {
                let mut page = page_of(frame, k, n, 6 * k + i64::from(n));
                if (k, n) == (100, 3) {
                    let late = page.timestamp.as_nanos() + 20 * MS - MS / 20;
                    page.timestamp = Timestamp::from_nanos(late);
                }
                vec![page]
            })
        })
        .collect();
    frames.sort_by_key(|frame| frame.timestamp);
    let (monitor, seen) = play(monitor, frames);
    assert_eq!((c2(&seen, 100, 3), c2(&seen, 101, 3)), (None, Some(count(101, 3))));
    assert_eq!((monitor.counts().late, monitor.counts().incomplete), (1, 1));
}

/// Cylinder n's page comes in each sixth cycle only: not complete, but neither late nor repeated.
#[test]
fn one_page_a_cycle() {
    let monitor = monitor(&six_pages(), "", &SHARED).expect("it is sound");
    let frames = (0..CYCLES).flat_map(|k| {
        with_pages(k, |n, frame| {
            let its_turn = k % 6 == i64::from(n) - 1;
            if its_turn { vec![page_of(frame, k, n, k)] } else { vec![] }
        })
    });
    let (monitor, seen) = play(monitor, frames);
    for k in 30..CYCLES {
        for n in 1..=6_u8 {
            let own = (k % 6 == i64::from(n) - 1).then(|| count(k, n.into()));
            assert_eq!(c2(&seen, k, n), own, "cylinder {n}, cycle {k}");
        }
    }
    let counts = monitor.counts();
    assert!(counts.late <= 6 && counts.repeated == 0, "{counts:?}");
}

/// A page with something else comes before that with the reading.
#[test]
fn a_page_that_nobody_reads_does_not_drop_the_one_that_is_read() {
    for lines in [&SHARED[..], &[SHARED[0], ("c2_counter", ""), SHARED[2], SHARED[3]]] {
        let monitor = monitor(&six_pages(), "", lines).expect("it is sound");
        let frames = (0..CYCLES).flat_map(|k| {
            with_pages(k, |n, frame| {
                let own = page_of(frame, k, n, 12 * k + 2 * i64::from(n) + 1);
                let mut spare = page_of(frame, k, n, 12 * k + 2 * i64::from(n));
                spare.buffer_mut()[0] = 7;
                vec![spare, own]
            })
        });
        let (monitor, seen) = play(monitor, frames);
        let counts = monitor.counts();
        // That the counter counts them, too, takes three cycles to learn.
        assert!(counts.incomplete <= 3 && counts.repeated == 0, "{counts:?}");
        assert!((5..CYCLES).all(|k| c2(&seen, k, 4) == Some(count(k, 4))));
    }
}

/// Two multiplexors, one within the other, an extended identifier, 64 bytes, one counter a page.
#[test]
fn extended_multiplexing_in_a_long_frame() {
    let mut message = "BO_ 2566844672 Six: 64 Plc\n \
        SG_ Bank M : 0|4@1+ (1,0) [0|15] \"\" Gateway\n \
        SG_ Row m2M : 4|4@1+ (1,0) [0|15] \"\" Gateway\n"
        .to_owned();
    let mut multiplexing = "SG_MUL_VAL_ 2566844672 Row Bank 2-3;\n".to_owned();
    for n in 1..=6 {
        message += &format!(" SG_ Position{n} m{n} : 480|16@1+ {METRES}\n");
        message += &format!(" SG_ Counter{n} m{n} : 40|4@1+ (1,0) [0|15] \"\" Gateway\n");
        for signal in ["Position", "Counter"] {
            multiplexing += &format!("SG_MUL_VAL_ 2566844672 {signal}{n} Row {n}-{n};\n");
        }
    }
    let lines =
        [SHARED[0], ("c2_counter", "c2_counter = \"Six.Counter{n}\""), SHARED[2], SHARED[3]];
    let monitor = monitor(&message, &multiplexing, &lines).expect("it is sound");
    let id = Id::extended(2_566_844_672 & 0x1FFF_FFFF).expect("it has 29 bits");
    let frames = (0..CYCLES).flat_map(|k| {
        with_pages(k, |n, frame| {
            let mut data = [0; 64];
            (data[0], data[5]) = (2 | (n as u8) << 4, k as u8 & 0xF);
            data[60..62].copy_from_slice(&count(k, n).to_le_bytes());
            let own = Frame::new(frame.timestamp, id, Kind::Fd { flags: 0 }, &data);
            data[0] = 5 | (n as u8) << 4;
            let other = Frame::new(frame.timestamp, id, Kind::Fd { flags: 0 }, &data);
            vec![other, own.clone(), own]
        })
    });
    let (monitor, seen) = play(monitor, frames);
    let counts = monitor.counts();
    assert_eq!((counts.cycles, counts.incomplete), (CYCLES as u64, 0), "{counts:?}");
    assert_eq!(counts.repeated, 6 * CYCLES as u64, "each page came twice");
    assert!((0..CYCLES).all(|k| (1..=6).all(|n| c2(&seen, k, n) == Some(count(k, n.into())))));
}

/// The position is in every frame, the status in each second.
#[test]
fn what_every_frame_carries_is_taken_whatever_the_page() {
    let message = format!(
        "BO_ 704 One: 8 Plc\n SG_ Page M : 0|8@1+ (1,0) [0|7] \"\" Gateway\n \
         SG_ Counter : 8|8@1+ (1,0) [0|255] \"\" Gateway\n \
         SG_ Position : 16|16@1+ {METRES}\n SG_ Speed m0 : 32|16@1- (0.0001,0) [-3|3] \"m/s\" Gateway\n \
         SG_ Heat m1 : 32|16@1- (0.0001,0) [-3|3] \"\" Gateway\n"
    );
    let lines = [
        ("cylinders", "cylinders = 1"),
        ("c2", "c2 = \"One.Position\""),
        ("c2_counter", "c2_counter = \"One.Counter\""),
        ("c2_velocity", "c2_velocity = \"One.Speed\""),
        ("c2_status", ""),
    ];
    let monitor = monitor(&message, "", &lines).expect("it is sound");
    let frames = (0..CYCLES).flat_map(|k| {
        with_pages(k, |n, frame| {
            let mut page = page_of(frame, k, 1, k);
            page.buffer_mut()[0] = (k % 2) as u8;
            if n == 1 { vec![page] } else { vec![] }
        })
    });
    let (monitor, seen) = play(monitor, frames);
    assert!((0..CYCLES).all(|k| c2(&seen, k, 1) == Some(count(k, 1))));
    let speeds = (10..CYCLES).map(|k| seen.record(k, 1).velocities[1].is_some());
    assert!(speeds.eq((10..CYCLES).map(|k| k % 2 == 0)));
    assert_eq!((monitor.counts().late, monitor.counts().repeated), (0, 0));
}

#[test]
fn a_counter_of_another_message_is_not_shared() {
    let lines = [("c2_counter", "c2_counter = \"Cyl1_C2.Counter\"")];
    let refused = monitor("", "", &lines).expect_err("one counter counts one message");
    assert!(refused.contains("is used already for something else"), "{refused}");
}
