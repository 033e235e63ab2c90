//! Lines per second of the candump reader from memory, beside counting newlines in the same bytes.
//!
//! `cargo bench --bench candump [-- FILE]`: FILE is an uncompressed recording, repeated to five
//! million lines; without it one in the default layout is made.

use std::hint::black_box;
use std::io::{self, Cursor, Read};
use std::sync::Arc;
use std::time::Instant;

use tertius::bus::{Options, Recording, Source, append_log_line};
use tertius::frame::{Frame, Id, Kind};
use tertius::time::Timestamp;

const LINES: usize = 5_500_000;
const ROUNDS: usize = 7;

fn main() {
    let path = std::env::args().skip(1).find(|argument| !argument.starts_with("--"));
    let text: Arc<[u8]> = path.map_or_else(made, |path| repeated(&path)).into();
    let lines = count_lines(&text);
    println!("{lines} lines, {} MB", text.len() / 1_000_000);
    let newlines = best(|| assert_eq!(count_lines(black_box(&text)), lines));
    let reading = best(|| assert_eq!(read(&text), lines));
    let rate = |seconds: f64| lines as f64 / seconds / 1e6;
    println!("newlines {:.1} M lines/s", rate(newlines));
    println!(
        "frames   {:.1} M lines/s, {:.1} ns a line",
        rate(reading),
        reading / lines as f64 * 1e9
    );
    println!("reading takes {:.1} times as long as counting newlines", reading / newlines);
}

/// The shortest of some runs, s.
fn best(mut run: impl FnMut()) -> f64 {
    let times = (0..ROUNDS).map(|_| {
        let start = Instant::now();
        run();
        start.elapsed().as_secs_f64()
    });
    times.fold(f64::INFINITY, f64::min)
}

fn count_lines(text: &[u8]) -> usize {
    memchr::memchr_iter(b'\n', text).count()
}

fn read(text: &Arc<[u8]>) -> usize {
    let reader: Box<dyn Read + Send> = Box::new(Cursor::new(Arc::clone(text)));
    let mut recording = Recording::from_reader("memory", reader, Options::default());
    let (mut frames, mut sum) = (0, 0u64);
    while let Some(frame) = recording.next_frame().expect("memory can be read") {
        frames += 1;
        sum = sum.wrapping_add(u64::from(frame.id.to_dbc()) + u64::from(frame.buffer()[0]));
    }
    black_box(sum);
    assert_eq!(recording.statistics().bad_lines, 0);
    frames
}

fn repeated(path: &str) -> Vec<u8> {
    let text = std::fs::read(path).unwrap_or_else(|error: io::Error| panic!("{path}: {error}"));
    text.repeat(LINES.div_ceil(count_lines(&text).max(1)))
}

/// Cycles of 22 frames at 50 Hz: Sync, two readings of six cylinders, attitude and translation,
/// state, six valves.
fn made() -> Vec<u8> {
    let ids = (0x181..=0x186).chain(0x191..=0x196).chain([0x1B1, 0x2B1]).map(|id| (id, 6));
    let rest = [(0x1C1, 4)].into_iter().chain((0x1A1..=0x1A6).map(|id| (id, 8)));
    let layout: Vec<(u32, usize)> = [(0x080, 1)].into_iter().chain(ids).chain(rest).collect();
    let mut text = Vec::with_capacity(LINES * 44);
    let mut noise = 1u64;
    for line in 0..LINES {
        let (cycle, place) = (line / layout.len(), line % layout.len());
        noise =
            noise.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let nanos = 1_700_000_000_000_000_000 + cycle as i64 * 20_000_000 + place as i64 * 130_000;
        let (id, length) = layout[place];
        let id = Id::standard(id).expect("the layout has 11-bit identifiers");
        let data = &noise.to_be_bytes()[..length];
        let frame = Frame::new(Timestamp::from_nanos(nanos), id, Kind::Data, data);
        append_log_line(&mut text, "can0", &frame);
    }
    text
}
