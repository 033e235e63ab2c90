//! Recordings that are simulated once and then read from memory.

use crate::plan::{Mishap, Task};
use std::convert::Infallible;
use tertius::config::Settings;
use tertius::controller::State;
use tertius::dbc::Database;
use tertius::frame::{Frame, Id, Kind};
use tertius::inject::Placed;
use tertius::simulator::{EPOCH, Options, Simulator, SimulatorError, Tables};
use tertius::survey::{Frames, Timeline, Window};
use tertius::time::{Span, Timestamp};

/// Significant wave height, m, and peak period, s.
const CALM: [f64; 2] = [1.2, 6.5];
const ROUGH: [f64; 2] = [2.5, 8.0];

/// Pause between the two files, s.
const PAUSE: f64 = 30.0;

/// Start of the rest within the second half of the file of the calm sea, as a part, and its duration, s.
const REST: [f64; 2] = [0.6, 60.0];

/// Probability that a cycle is lost.
const LOST: f64 = 0.005;

/// A frame stored in 24 bytes.
#[derive(Clone, Copy, Debug)]
struct Kept {
    at: Timestamp,
    id: Id,
    length: u8,
    data: [u8; 8],
}

impl Kept {
    fn frame(&self) -> Frame {
        Frame::new(self.at, self.id, Kind::Data, &self.data[..usize::from(self.length)])
    }
}

#[derive(Clone, Debug, Default)]
pub struct Memory {
    frames: Vec<Kept>,
}

impl Memory {
    /// Two files, one of each sea, in the order of `task`; the first contains `faults`.
    pub fn record(
        task: &Task,
        tables: &Tables,
        settings: &Settings,
        database: &Database,
        faults: &[Placed],
    ) -> Result<Self, SimulatorError> {
        let mut memory = Self::default();
        let seas = if task.calm_first { [CALM, ROUGH] } else { [ROUGH, CALM] };
        let half = task.length / 2.0;
        for (file, sea) in seas.into_iter().enumerate() {
            // The same file in either order.
            let seed =
                task.seed.wrapping_mul(1_000_003) + 2 * task.pair as u64 + u64::from(sea == CALM);
            let epoch = EPOCH.after(Span::from_seconds(file as f64 * (half + PAUSE)));
            let faults = if file == 0 { faults.to_vec() } else { Vec::new() };
            let options = Options { seed, sea: Some(sea), epoch, faults, ..Options::default() };
            let mut simulator = Simulator::new(tables, settings, database, &options)?;
            let cycles = (half / settings.machine.sample_time) as u64;
            let begin = (REST[0] * cycles as f64) as u64;
            let end = begin + (REST[1] / settings.machine.sample_time) as u64;
            let rests = task.mishap == Mishap::Stop && sea == CALM;
            for cycle in 0..cycles {
                match cycle {
                    _ if !rests => {}
                    at if at == begin => simulator.request(State::Settled),
                    at if at == end => simulator.request(State::Engaged),
                    _ => {}
                }
                let lost = task.mishap == Mishap::Losses && is_lost(seed, cycle);
                simulator.step(&mut |frame| {
                    if !lost {
                        memory.keep(frame);
                    }
                });
            }
        }
        Ok(memory)
    }

    fn keep(&mut self, frame: &Frame) {
        let mut data = [0; 8];
        data[..frame.length()].copy_from_slice(frame.data());
        let (at, id, length) = (frame.timestamp, frame.id, frame.length() as u8);
        self.frames.push(Kept { at, id, length, data });
    }

    /// Times of the frames.
    pub fn timeline(&self) -> Timeline {
        let mut timeline = Timeline::default();
        self.frames.iter().for_each(|kept| {
            timeline.take(kept.at);
            timeline.read(&kept.frame());
        });
        timeline
    }
}

/// Whether a cycle is lost: at random, but the same cycles in either order.
fn is_lost(seed: u64, cycle: u64) -> bool {
    let mut z = seed.wrapping_add(cycle).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    ((z ^ (z >> 31)) >> 11) as f64 / ((1_u64 << 53) as f64) < LOST
}

impl Frames for Memory {
    type Error = Infallible;

    fn frames(&self, window: Window, mut take: impl FnMut(&Frame)) -> Result<(), Infallible> {
        let first = self.frames.first().map_or(EPOCH, |kept| kept.at);
        for kept in &self.frames {
            if window.holds(kept.at.since(first).as_seconds()) {
                take(&kept.frame());
            }
        }
        Ok(())
    }
}
