//! A machine that visits its mechanical stops, as frames made by hand.

use tertius::frame::{Frame, Id, Kind};
use tertius::time::Timestamp;

/// Of a machine that is calibrated.
pub const CONFIG: &str = "tests/recordings/e-type-sequential.toml";

/// What it is called there.
pub const NAME: &str = "Ampelmann E-type, simulated";

/// C1 of this cylinder drifts.
pub const DRIFTING: u16 = 3;

/// One count, m.
pub const COUNT: f64 = 3.0 / 27_648.0;

/// Counts by which it reads more each time.
pub const STEP: u16 = 3;

/// Visits before anything drifts.
const HEALTHY: u16 = 6;

/// Counts by which C2 of each cylinder reads more than C1 there, as it was calibrated.
const C2_LESS_C1: [i16; 6] = [4, 19, 24, 16, 32, 27];

/// From 0 to as many counts as the cylinder's number, each as often.
fn noise(day: u16, k: i64, id: u32) -> u16 {
    let mixed = (u64::from(day) << 40 ^ (k as u64) << 16 ^ u64::from(id))
        .wrapping_mul(0x9E37_79B9_7F4A_7C15)
        .rotate_left(31)
        .wrapping_mul(0xBF58_476D_1CE4_E5B9);
    ((mixed >> 33) % (u64::from(id & 0xF) + 1)) as u16
}

/// The frames of visits to the stops, one a day: in safe for 3.5 s, in which the rods are read once.
/// From the seventh visit on C1 of cylinder 3 reads [`STEP`] more counts each time.
pub fn visits(days: std::ops::Range<u16>) -> Vec<Frame> {
    days.flat_map(|day| (0..175).flat_map(move |k| cycle(day, k))).collect()
}

fn cycle(day: u16, k: i64) -> Vec<Frame> {
    let mut messages = vec![(0x080, vec![k as u8])];
    for n in 1..=6 {
        let drift = if n == DRIFTING { STEP * (day + 1).saturating_sub(HEALTHY) } else { 0 };
        let stop = 922 + 10 * n;
        let other = stop.wrapping_add_signed(C2_LESS_C1[usize::from(n) - 1]);
        for (id, count) in [(0x180, stop + drift), (0x190, other)] {
            let [low, high] = (count + noise(day, k, id + u32::from(n))).to_le_bytes();
            messages.push((id + u32::from(n), vec![low, high, 0, 0, 0, k as u8]));
        }
    }
    messages.push((0x1C1, vec![0, 0, 0, k as u8]));
    messages.extend((1..=6).map(|n| (0x1A0 + n, vec![0; 8])));
    let opening = 1_700_000_000_000_000_000 + i64::from(day) * 86_400_000_000_000 + k * 20_000_000;
    let frame = |(place, (id, data)): (usize, (u32, Vec<u8>))| {
        let at = Timestamp::from_nanos(opening + place as i64 * 100_000);
        Frame::new(at, Id::standard(id).expect("eleven bits"), Kind::Data, &data)
    };
    messages.into_iter().enumerate().map(frame).collect()
}
