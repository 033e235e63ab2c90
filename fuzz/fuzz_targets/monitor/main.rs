//! The monitor of the shipped machine under any frames at any times, backwards and far ahead too:
//! no panic, nothing but the gateway's own identifiers sent, outputs bounded by the time that
//! passed and in its order, warnings that are raised before they change or clear, and the same
//! said by a monitor whose clock runs ahead of its frames.

#![no_main]

mod machine;
mod witness;

use arbitrary::Arbitrary;
use libfuzzer_sys::fuzz_target;
use machine::MACHINE;
use tertius::frame::{Frame, Id, Kind};
use tertius::monitor::Monitor;
use tertius::time::{Span, Timestamp};
use witness::Witness;

/// Longer inputs only repeat what shorter ones do.
const MOST_DEEDS: usize = 48;
/// Pauses are run through in steps of a cycle: no more than some seconds' worth of that an input.
const MOST_QUIET: i64 = 7_200_000_000_000;
/// As in the monitor: leaps beyond are taken as a clock that was set.
const LARGEST_PAUSE: i64 = 3_600_000_000_000;
const CYCLE: i64 = 20_000_000;

#[derive(Arbitrary, Debug)]
enum Deed {
    /// A frame of the machine's layout with any payload.
    Frame { line: u8, after: Step, length: u8, payload: [u8; 8], fd: bool },
    /// A frame that the machine does not know, or no data frame.
    Other { id: u32, after: Step, kind: u8 },
    /// Whole cycles, less the frames of `lost`, with readings that ramp.
    Cycles { count: u8, lost: u32, start: u16, slope: i8, differ: i8, command: i16, state: u8 },
}

#[derive(Arbitrary, Debug)]
enum Step {
    Nothing,
    Micros(u16),
    Cycles(u8),
    Back(u32),
    Seconds(u16),
    Any(i64),
}

impl Step {
    fn nanos(&self) -> i64 {
        match *self {
            Self::Nothing => 0,
            Self::Micros(micros) => i64::from(micros) * 1000,
            Self::Cycles(cycles) => i64::from(cycles) * CYCLE,
            Self::Back(nanos) => -i64::from(nanos),
            Self::Seconds(seconds) => i64::from(seconds) * 1_000_000_000,
            Self::Any(nanos) => nanos,
        }
    }
}

/// Two monitors of the same machine; the clock of the second runs ahead of its frames.
struct Bench {
    plain: (Monitor, Witness),
    ahead: (Monitor, Witness),
    now: Timestamp,
    last: Option<Timestamp>,
    quiet: i64,
}

impl Bench {
    fn new() -> Self {
        let pair = || (Monitor::new(MACHINE.clone()), Witness::default());
        let now = Timestamp::from_nanos(1_700_000_000_000_000_000);
        Self { plain: pair(), ahead: pair(), now, last: None, quiet: 0 }
    }

    fn take(&mut self, frame: &Frame) {
        let step = self.last.map_or(0, |last| frame.timestamp.since(last).as_nanos());
        if (CYCLE..=LARGEST_PAUSE).contains(&step) {
            self.quiet += step;
            if self.quiet > MOST_QUIET {
                return;
            }
        }
        let listens = MACHINE.subscriptions.find(frame.id).is_some()
            && matches!(frame.kind, Kind::Data | Kind::Fd { .. });
        if listens && (1..=LARGEST_PAUSE).contains(&step) {
            let between = frame.timestamp.after(Span::from_nanos(-(step / 3)));
            self.ahead.0.advance(between, &mut self.ahead.1);
        }
        self.plain.1.expect_after(step.clamp(0, LARGEST_PAUSE));
        self.plain.0.take(frame, &mut self.plain.1);
        self.plain.1.check_bounds(MACHINE.gap_cycles);
        self.ahead.0.take(frame, &mut self.ahead.1);
        if listens {
            self.last = Some(frame.timestamp);
        }
    }

    fn pass(&mut self, step: &Step) {
        self.now = self.now.after(Span::from_nanos(step.nanos()));
    }

    fn finish(mut self) {
        for (monitor, witness) in [&mut self.plain, &mut self.ahead] {
            monitor.finish(witness);
            witness.check_counts(monitor.counts());
        }
        assert_eq!(self.plain.1.said, self.ahead.1.said);
        assert_eq!(self.plain.0.counts(), self.ahead.0.counts());
    }
}

fn cycle(bench: &mut Bench, number: u8, deed: &Deed) {
    let Deed::Cycles { lost, start, slope, differ, command, state, .. } = *deed else { return };
    let opened = bench.now;
    let reading = start.wrapping_add_signed(i16::from(slope).wrapping_mul(i16::from(number)));
    let velocity = i16::from(slope) * 54;
    for (place, line) in MACHINE.subscriptions.all().iter().enumerate() {
        if lost & 1 << (place % 32) != 0 && number > 0 {
            continue;
        }
        let id = line.id.value();
        let mut payload = [0; 8];
        match id {
            0x181..=0x186 | 0x191..=0x196 => {
                let of_second = id >= 0x190;
                let position =
                    reading.wrapping_add_signed(if of_second { i16::from(differ) } else { 0 });
                payload[..2].copy_from_slice(&position.to_le_bytes());
                payload[2..4].copy_from_slice(&velocity.to_le_bytes());
                payload[5] = number;
            }
            0x1A1..=0x1A6 => payload[..2].copy_from_slice(&command.to_le_bytes()),
            0x1C1 => (payload[0], payload[3]) = (state, number),
            _ => payload[0] = number,
        }
        let at = opened.after(Span::from_nanos(150_000 * place as i64));
        bench.take(&Frame::new(at, line.id, Kind::Data, &payload));
    }
    bench.now = opened.after(Span::from_nanos(CYCLE));
}

fn other(id: u32, kind: u8, at: Timestamp) -> Frame {
    let id = Id::standard(id).or(Id::extended(id & Id::EXTENDED_MAX)).expect("it is in range");
    let kind = match kind % 3 {
        0 => Kind::Data,
        1 => Kind::Remote { length: kind % 9 },
        _ => Kind::Error,
    };
    Frame::new(at, id, kind, &[])
}

fuzz_target!(|deeds: Vec<Deed>| {
    let mut bench = Bench::new();
    for deed in deeds.iter().take(MOST_DEEDS) {
        match deed {
            Deed::Frame { line, after, length, payload, fd } => {
                bench.pass(after);
                let lines = MACHINE.subscriptions.all();
                let id = lines[usize::from(*line) % lines.len()].id;
                let kind = if *fd { Kind::Fd { flags: 0 } } else { Kind::Data };
                let payload = &payload[..usize::from(length % 9)];
                bench.take(&Frame::new(bench.now, id, kind, payload));
            }
            Deed::Other { id, after, kind } => {
                bench.pass(after);
                bench.take(&other(*id, *kind, bench.now));
            }
            Deed::Cycles { count, .. } => {
                (0..count % 64).for_each(|number| cycle(&mut bench, number, deed));
            }
        }
    }
    bench.finish();
});
