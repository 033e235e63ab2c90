//! What is learnt from a recording is what the monitor would have seen of it.

use tertius::frame::{Frame, Id, Kind};
use tertius::monitor::Monitor;
use tertius::sample::Quality;
use tertius::survey::{Row, Survey, Surveyor, Window};
use tertius::time::Timestamp;
use tertius_testing::machine::{self, Collected, Cycle, MS, START, resting_at_50, surveying};

#[derive(Debug, Default)]
struct Seen {
    rows: Vec<Row>,
    /// Of cylinder 1, as the number of its rows before.
    gaps: Vec<usize>,
}

impl Surveyor for Seen {
    fn row(&mut self, row: &Row) {
        if row.cylinder == 1 {
            self.rows.push(*row);
        }
    }

    fn gap(&mut self, cylinder: u8) {
        if cylinder == 1 {
            self.gaps.push(self.rows.len());
        }
    }
}

fn survey(frames: impl IntoIterator<Item = Frame>, window: Window) -> (Seen, Monitor) {
    let mut monitor = surveying();
    let mut survey = Survey::new(Timestamp::from_nanos(START), window, Seen::default());
    for frame in frames {
        monitor.take(&frame, &mut survey);
    }
    monitor.finish(&mut survey);
    (survey.into_surveyor(), monitor)
}

fn cycles(range: std::ops::Range<i64>) -> impl Iterator<Item = Frame> {
    range.flat_map(|k| Cycle::new(k).frames())
}

/// The valve frame of cylinder 1 with 120.00 bar in the bottom and 80.00 bar in the rod chamber.
fn with_pressures(mut frame: Frame) -> Frame {
    if frame.id.value() == 0x1A1 {
        let data = [0xE8, 3, 0, 0, 0xE0, 0x2E, 0x40, 0x1F];
        frame = Frame::new(frame.timestamp, frame.id, Kind::Data, &data);
    }
    frame
}

#[test]
fn a_row_holds_what_came_and_what_it_is_worth() {
    let (seen, _) = survey(cycles(0..3).map(with_pressures), Window::ALL);
    assert_eq!(seen.rows.len(), 3);
    let row = seen.rows[1];
    assert_eq!((row.t, row.cylinder), (0.02, 1));
    assert_eq!((row.c1, row.c2, row.v1, row.v2), (Some(0.0), Some(0.0), Some(0.0), Some(0.0)));
    assert_eq!(row.u, Some(0.1));
    let close = |found: Option<f64>, bar: f64| (found.expect("it came") - bar).abs() < 1e-9;
    assert!(close(row.pressure_bottom, 120.0) && close(row.pressure_rod, 80.0), "{row:?}");
    assert!(close(row.load_pressure(0.5), 80.0) && row.pressure_load.is_none());
    // The state comes after the readings but before the valves, with which a cycle is done.
    assert!(row.monitored);
    assert_eq!(row.cycle, seen.rows[0].cycle + 1);
    assert!(seen.gaps.is_empty());
}

#[test]
fn an_implausible_reading_is_none_but_can_be_seen() {
    let broken = |frame: Frame| {
        let data = [0xFF, 0x7F, 0, 0, 0, frame.data().last().copied().unwrap_or(0)];
        let id = Id::standard(0x181).expect("11 bits");
        if frame.id == id { Frame::new(frame.timestamp, id, Kind::Data, &data) } else { frame }
    };
    let (seen, _) = survey(cycles(0..3).map(broken), Window::ALL);
    let row = seen.rows[2];
    assert_eq!((row.c1, row.v1, row.c2), (None, None, Some(0.0)));
    assert_eq!(row.qualities, [Quality::BrokenWire, Quality::Good]);
    assert!(row.raw[0].expect("it came") > 1.5);
}

#[test]
fn cycles_that_are_missing_are_a_gap() {
    for missing in [1, 3, 50] {
        let (seen, _) =
            survey(cycles(0..10).chain(cycles(10 + missing..20 + missing)), Window::ALL);
        assert_eq!((seen.rows.len(), &seen.gaps[..]), (20, &[10][..]), "{missing} missing");
    }
}

/// The numbers of the cycles go on over it, but what is behind is no neighbour of what is before.
#[test]
fn a_lost_bus_is_a_gap() {
    let bus_off = Frame::new(
        Timestamp::from_nanos(START + 10 * 20 * MS - 5 * MS),
        Id::extended(0x40).expect("29 bits"),
        Kind::Error,
        &[0; 8],
    );
    let (seen, monitor) = survey(cycles(0..10).chain([bus_off]).chain(cycles(10..20)), Window::ALL);
    assert_eq!(monitor.counts().interruptions, 1);
    assert_eq!((seen.rows.len(), &seen.gaps[..]), (20, &[10][..]));
}

#[test]
fn a_clock_that_was_set_is_a_gap() {
    let earlier = |mut frame: Frame| {
        frame.timestamp = Timestamp::from_nanos(frame.timestamp.as_nanos() - 3_600_000 * MS);
        frame
    };
    let (seen, _) = survey(cycles(0..10).chain(cycles(10..20).map(earlier)), Window::ALL);
    // The window has no end towards the past, so that all rows are there.
    assert_eq!((seen.rows.len(), &seen.gaps[..]), (20, &[10][..]));
}

#[test]
fn a_window_leaves_out_what_is_before_and_after() {
    let (seen, _) = survey(cycles(0..50), Window { from: 0.2, to: 0.4 });
    assert_eq!((seen.rows.len(), &seen.gaps[..]), (10, &[10][..]));
    assert_eq!((seen.rows[0].t, seen.rows[9].t), (0.2, 0.38));
    let [first, second] = Window { from: 1.0, to: 3.0 }.split(0.25);
    assert_eq!((first.to, second.from, second.length()), (1.5, 1.5, 1.5));
}

/// Without its pressures a valve frame ends after the spool position.
#[test]
fn a_missing_pressure_makes_no_cycle_incomplete() {
    let short = |frame: Frame| match frame.id.value() {
        0x1A1..=0x1A6 => Frame::new(frame.timestamp, frame.id, Kind::Data, &[0, 0, 0, 0]),
        _ => frame,
    };
    let (seen, monitor) = survey(cycles(0..10).map(short), Window::ALL);
    assert_eq!((monitor.counts().cycles, monitor.counts().incomplete), (10, 0));
    assert!(monitor.tallies().all(|tally| tally.incomplete == 0));
    assert_eq!(seen.rows.len(), 10);
    let row = seen.rows[5];
    assert_eq!((row.pressure_bottom, row.load_pressure(0.5), row.u), (None, None, Some(0.0)));
}

/// Reading the pressures changes nothing else of what the monitor says.
#[test]
fn a_monitor_that_surveys_records_what_the_other_does() {
    let without_pressures = |mut seen: Collected| {
        for record in &mut seen.records {
            (record.pressures, record.supply, record.spool) = ([None; 3], None, None);
        }
        (seen.records, seen.warnings, seen.frames)
    };
    let (_, plain) = machine::play(cycles(0..200));
    assert!(plain.records.iter().all(|record| record.pressures == [None; 3]));
    assert!(plain.records.iter().all(|record| record.spool.is_none() && record.supply.is_none()));
    let (mut monitor, mut seen) = (surveying(), Collected::default());
    cycles(0..200).for_each(|frame| monitor.take(&frame, &mut seen));
    monitor.finish(&mut seen);
    assert!(seen.records.iter().all(|record| record.pressures[0] == Some(0.0)));
    assert!(seen.records.iter().all(|record| record.spool == Some(0.0)));
    assert_eq!(without_pressures(seen), without_pressures(plain));
}

/// A cylinder that a command only holds is still for its observer, and does not count as frozen.
#[test]
fn the_command_at_which_a_cylinder_rests_is_taken_off() {
    let holding = |k| Cycle { command: 500, ..Cycle::new(k) }.frames();
    let seen_by = |mut monitor: Monitor| {
        let mut seen = Collected::default();
        (0..100).flat_map(holding).for_each(|frame| monitor.take(&frame, &mut seen));
        seen
    };
    let rest = seen_by(resting_at_50());
    assert_eq!(rest.record(90, 1).command, Some(0.05), "it is recorded as it was sent");
    assert_eq!(rest.record(90, 1).residuals[0], Some(0.0));
    assert!(rest.warnings.is_empty(), "{:?}", rest.warnings);
    let moving = seen_by(machine::monitor());
    // Before it counts as frozen, its observer expects it to move.
    assert!(moving.record(4, 1).residuals[0].expect("there is a reading").abs() > 1e-5);
    let either_way = |k: i64| {
        let command = if k % 80 < 40 { 500 } else { -500 };
        Cycle { command, ..Cycle::new(k) }.frames()
    };
    let (mut monitor, mut seen) = (machine::monitor(), Collected::default());
    (0..100).flat_map(either_way).for_each(|frame| monitor.take(&frame, &mut seen));
    assert!(!seen.warnings.is_empty(), "readings that follow no command are frozen");
}

/// The pressures of cylinder 1 come in one of five cycles. Without the rule each cycle waits for them until its deadline.
#[test]
fn a_signal_slower_than_the_cycles_delays_none_and_is_used_when_it_comes() {
    let (mut monitor, mut seen) = (surveying(), Collected::default());
    let mut waited = 0;
    for k in 0..100 {
        for frame in Cycle::new(k).frames() {
            let frame = with_pressures(frame);
            let is_short = frame.id.value() == 0x1A1 && k % 5 != 0;
            let data = if is_short { &frame.data()[..2] } else { frame.data() };
            monitor.take(&Frame::new(frame.timestamp, frame.id, frame.kind, data), &mut seen);
        }
        let is_judged = |cylinder| seen.records.iter().filter(|it| it.cylinder == cylinder).count();
        assert_eq!(is_judged(2), k as usize + 1, "its pressures come in each cycle");
        waited += usize::from(is_judged(1) != k as usize + 1);
    }
    assert!(waited <= 4, "{waited} of 100 cycles were held open");
    let read = seen.records.iter().filter(|it| it.cylinder == 1 && it.pressures[0].is_some());
    assert_eq!(read.count(), 20);
}
