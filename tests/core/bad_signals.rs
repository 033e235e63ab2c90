//! Frames that lack a signal, or have no number in it: counted, and never taken for a value.

use tertius::config;
use tertius::config::design;
use tertius::dbc::{Database, text};
use tertius::frame::{Frame, Kind};
use tertius::monitor::Monitor;
use tertius::sample::Quality;
use tertius_testing::machine::{Collected, Cycle, monitor};
use tertius_testing::top;

const CYCLES: i64 = 300;
/// When what is tried begins, and how many cycles there are of it.
const BEGIN: i64 = 100;
const TRIED: u64 = (CYCLES - BEGIN) as u64;

/// The default machine with what `change` makes of its DBC, and without the keys whose lines begin with `left_out`.
fn changed(change: impl Fn(&str) -> String, left_out: &str) -> Monitor {
    let read = |path: &str| std::fs::read_to_string(top().join(path)).expect("it ships");
    let toml = read("config/e-type.toml");
    let kept: Vec<&str> = toml.lines().filter(|line| !line.starts_with(left_out)).collect();
    let (settings, _) = config::parse("changed.toml", &kept.join("\n")).expect("it is sound");
    let dbc = change(&text::from_bytes(read("dbc/e-type.dbc").as_bytes()));
    let database = Database::parse(&dbc).expect("it is sound");
    Monitor::new(design::judging(&settings, &database).expect("it can be monitored"))
}

/// Takes the frames of all cycles with the data that `data` makes of those of a cycle and identifier, and lets `see`
/// look at the monitor after each cycle.
fn play(
    monitor: &mut Monitor,
    data: impl Fn(i64, u32, &[u8]) -> Vec<u8>,
    mut see: impl FnMut(i64, &Monitor),
) -> Collected {
    let mut seen = Collected::default();
    for k in 0..CYCLES {
        for frame in Cycle::new(k).frames() {
            let data = data(k, frame.id.value(), frame.data());
            monitor.take(&Frame::new(frame.timestamp, frame.id, Kind::Data, &data), &mut seen);
        }
        see(k, monitor);
    }
    monitor.finish(&mut seen);
    seen
}

#[test]
fn a_frame_whose_alive_counter_is_cut_off_is_counted_once() {
    let mut monitor = monitor();
    let cut = |k, id, data: &[u8]| {
        let cut = usize::from(id == 0x182 && k >= BEGIN);
        data[..data.len() - cut].to_vec()
    };
    play(&mut monitor, cut, |k, monitor| {
        assert_eq!(monitor.counts().short, (k - BEGIN + 1).max(0) as u64);
    });
    assert_eq!((monitor.counts().short, monitor.counts().bad_signals), (TRIED, 0));
}

#[test]
fn a_platform_state_that_is_no_number_is_no_state() {
    let of_float = |dbc: &str| {
        let dbc = dbc.replace("BO_ 449 Plc_State: 4", "BO_ 449 Plc_State: 8");
        let dbc = dbc.replace("PlatformState : 0|8@1+", "PlatformState : 0|32@1-");
        let dbc = dbc.replace("SupplyPressure : 8|16", "SupplyPressure : 32|16");
        let dbc = dbc.replace("Counter : 24|8@1+", "Counter : 48|8@1+");
        dbc + "\nSIG_VALTYPE_ 449 PlatformState : 1;\n"
    };
    for state in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let mut monitor = changed(of_float, "no such line");
        let data = |k, id, data: &[u8]| {
            if id != 0x1C1 {
                return data.to_vec();
            }
            let state = if k < BEGIN { f32::from(data[0]) } else { state };
            [&state.to_le_bytes()[..], &[0, 0, data[3], 0]].concat()
        };
        let seen = play(&mut monitor, data, |k, monitor| {
            // As if none had come: the state before holds for a second.
            let known = (k < BEGIN + 49).then_some(3);
            if !(BEGIN + 48..BEGIN + 51).contains(&k) {
                assert_eq!(monitor.platform(), known, "{state} in cycle {k}");
            }
        });
        assert_eq!(monitor.counts().bad_signals, TRIED, "{state}");
        assert_eq!(seen.record(CYCLES - 1, 1).judged, [false; 2], "{state}");
        assert_eq!(seen.status().mode(), 3, "degraded, and not gated");
    }
}

#[test]
fn a_status_that_is_no_number_leaves_the_reading_without_one() {
    let of_float = |dbc: &str| {
        let mut dbc = dbc.to_owned();
        for n in 1..=6 {
            let begin = dbc.find(&format!("BO_ {} Cyl{n}_C1: 6", 384 + n)).expect("it is there");
            let end = begin + dbc[begin..].find("\n\n").expect("others follow");
            let message = dbc[begin..end]
                .replacen(": 6 ", ": 8 ", 1)
                .replace("Velocity : 16|16@1-", "Velocity : 24|8@1-")
                .replace("Status : 32|8@1+", "Status : 32|32@1-")
                .replace("Counter : 40|8@1+", "Counter : 16|8@1+");
            dbc.replace_range(begin..end, &message);
            dbc += &format!("\nSIG_VALTYPE_ {} Status : 1;\n", 384 + n);
        }
        dbc
    };
    for (status, quality, bad) in [
        (0.0, Quality::Good, 0),
        (1.0, Quality::BrokenWire, 0),
        (f32::NAN, Quality::Missing, TRIED),
        (f32::INFINITY, Quality::Missing, TRIED),
    ] {
        let mut monitor = changed(of_float, "c1_velocity");
        let data = |k, id, data: &[u8]| {
            let status = if id == 0x182 && k >= BEGIN { status } else { 0.0 };
            match (0x181..=0x186).contains(&id) {
                true => [&data[..2], &[data[5], 0], &status.to_le_bytes()[..]].concat(),
                false => data.to_vec(),
            }
        };
        let seen = play(&mut monitor, data, |_, _| {});
        assert_eq!(seen.record(BEGIN - 1, 2).qualities[0], Quality::Good);
        assert_eq!(seen.record(BEGIN + 1, 2).qualities[0], quality, "{status}");
        assert_eq!(monitor.counts().bad_signals, bad, "{status}");
    }
}
