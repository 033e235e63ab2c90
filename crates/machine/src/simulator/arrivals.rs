//! Times at which frames are on the bus.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use tertius_core::time::{Span, Timestamp};

/// Time stamps of a cycle's frames, which follow each other at the rate of the bus.
#[derive(Clone, Debug)]
pub struct Arrivals {
    bit: f64,
    latency: Span,
    rng: ChaCha8Rng,
    opening: Timestamp,
    /// Time at which the bus is free again.
    free: Timestamp,
}

/// Largest delay of Sync, ns.
const SYNC_JITTER: u32 = 60_000;
/// Largest delay of a receiver's time stamp, ns.
const STAMP_JITTER: u32 = 8_000;

/// Stream of the seed for the jitter.
const STREAM: u64 = u64::MAX - 2;

impl Arrivals {
    /// Arrivals on a bus of `bitrate`, bit/s; the controller answers after `latency`, s.
    pub fn new(bitrate: u32, latency: f64, seed: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(STREAM);
        Self {
            bit: 1e9 / f64::from(bitrate.max(1)),
            latency: Span::from_seconds(latency),
            rng,
            opening: Timestamp::default(),
            free: Timestamp::default(),
        }
    }

    /// Opens a cycle at `at`.
    pub fn open(&mut self, at: Timestamp) {
        let late = self.rng.random_range(0..SYNC_JITTER);
        self.opening = at.after(Span::from_nanos(i64::from(late)));
        self.free = self.opening.max(self.free);
    }

    /// Advances to the controller's answer.
    pub fn answer(&mut self) {
        self.free = self.opening.after(self.latency).max(self.free);
    }

    /// Advances to `at`, unless the bus is busy for longer.
    pub fn wait_until(&mut self, at: Timestamp) {
        self.free = self.free.max(at);
    }

    /// Time at which the bus is free.
    pub fn free(&self) -> Timestamp {
        self.free
    }

    /// Time at which the next frame, of `length` bytes, has been received; in whole microseconds,
    /// as candump prints it.
    pub fn next(&mut self, length: usize) -> Timestamp {
        // Frame and pause have 47 bits beside the data; of those that can be stuffed about one in
        // ten is followed by a stuff bit.
        let bits = 47.0 + 8.0 * length as f64 + (34.0 + 8.0 * length as f64) / 10.0;
        self.free = self.free.after(Span::from_nanos((bits * self.bit) as i64));
        let stamp = self.free.as_nanos() + i64::from(self.rng.random_range(0..STAMP_JITTER));
        Timestamp::from_nanos(stamp - stamp.rem_euclid(1000))
    }
}
