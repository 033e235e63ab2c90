//! Frames that lack a signal, or have no number in it: counted, and never taken for a value.

use tertius::frame::{Frame, Kind};
use tertius::monitor::Monitor;
use tertius_testing::machine::{Collected, Cycle, monitor};

const CYCLES: i64 = 300;
/// When what is tried begins, and how many cycles there are of it.
const BEGIN: i64 = 100;
const TRIED: u64 = (CYCLES - BEGIN) as u64;

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
fn an_alive_counter_that_is_cut_off_is_counted_once_a_frame() {
    let mut monitor = monitor();
    let cut = |k, id, data: &[u8]| {
        let cut = usize::from(id == 0x182 && k >= BEGIN);
        data[..data.len() - cut].to_vec()
    };
    play(&mut monitor, cut, |k, monitor| {
        assert_eq!(monitor.counts().bad_signals, (k - BEGIN + 1).max(0) as u64);
    });
    assert_eq!(monitor.counts().bad_signals, TRIED);
}
