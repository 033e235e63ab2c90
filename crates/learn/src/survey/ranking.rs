//! Places in a recording that do not depend on which of its files came first.

use std::sync::Arc;
use tertius_core::frame::Frame;
use tertius_core::time::{Span, Timestamp};

/// Time without frames that divides a recording, as between two files: long against the seconds of
/// which only the extremes count. Nothing that is learnt goes on from before it.
pub const PAUSE: Span = Span::from_nanos(10_000_000_000);

/// A part of a recording without a pause.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Stretch {
    /// The first time stamp and the latest.
    pub ends: [Timestamp; 2],
    /// Hash of the frames that the configuration reads, without their time stamps.
    pub content: u64,
}

impl Stretch {
    pub fn new(at: Timestamp) -> Self {
        Self { ends: [at; 2], content: 0 }
    }

    /// Adds a frame to the content.
    pub fn read(&mut self, frame: &Frame) {
        self.mix(u64::from(frame.id.to_dbc()) << 8 | frame.length() as u64);
        for bytes in frame.data().chunks(8) {
            let mut word = [0; 8];
            word[..bytes.len()].copy_from_slice(bytes);
            self.mix(u64::from_le_bytes(word));
        }
    }

    /// A step of a multiplicative hash, after which equal words differ by their places.
    const fn mix(&mut self, word: u64) {
        let mixed = (self.content ^ word).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        self.content = mixed ^ (mixed >> 29);
    }

    const fn length(&self) -> i64 {
        let [first, last] = self.ends;
        last.since(first).as_nanos()
    }
}

/// A time scale on which the stretches of a recording follow each other, without the pauses, in an
/// order that is that of their contents and not that of time.
///
/// What is divided by this scale, as into blocks that alternate, is divided in the same way
/// whichever file of a recording was made first. A recording without a pause is divided by its time.
#[derive(Clone, Debug, PartialEq)]
pub struct Ranking {
    /// In the order of time.
    stretches: Arc<[Ranked]>,
}

/// A part of a recording without a pause, with its place in a [`Ranking`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ranked {
    /// Beginning, s since the recording's first frame.
    pub from: f64,
    /// End, s since the recording's first frame.
    pub to: f64,
    /// Place of the beginning, ns.
    place: i64,
    rank: u64,
}

impl Ranked {
    /// The place of the time `t`, s, in seconds.
    pub fn place(&self, t: f64) -> f64 {
        // In whole nanoseconds, so that the same reading has the same place whenever it came.
        let within = ((t - self.from).max(0.0) * 1e9).round();
        (self.place as f64 + within) / 1e9
    }

    /// The time of a `place`, s; it may be beyond the ends.
    pub fn time(&self, place: f64) -> f64 {
        self.from + (place - self.place as f64 / 1e9)
    }
}

/// Rounding of a recording's end, s: the last row is within.
const END: f64 = 1e-9;

impl Default for Ranking {
    /// A recording without a pause, of any length.
    fn default() -> Self {
        let all = Ranked { from: 0.0, to: f64::INFINITY, place: 0, rank: 0 };
        Self { stretches: Arc::new([all]) }
    }
}

impl Ranking {
    /// A ranking of `stretches`, each of which begins at a time, s since the recording's first
    /// frame, in the order of time.
    pub(super) fn new(stretches: &[(f64, Stretch)]) -> Self {
        if stretches.is_empty() {
            return Self::default();
        }
        let mut order: Vec<usize> = (0..stretches.len()).collect();
        order.sort_by_key(|index| stretches[*index].1.content);
        let mut ranked: Vec<Ranked> = stretches
            .iter()
            .map(|(from, stretch)| {
                let to = from + stretch.length() as f64 / 1e9 + END;
                Ranked { from: *from, to, place: 0, rank: 0 }
            })
            .collect();
        let mut place = 0;
        for (rank, index) in (0..).zip(order) {
            (ranked[index].place, ranked[index].rank) = (place, rank);
            place += stretches[index].1.length();
        }
        Self { stretches: ranked.into() }
    }

    /// The place of the time `t`, s since the recording's first frame, in seconds.
    pub fn place(&self, t: f64) -> f64 {
        self.stretch(t).place(t)
    }

    /// The rank of the stretch at `t`, s, from 0.
    pub fn rank(&self, t: f64) -> u64 {
        self.stretch(t).rank
    }

    /// The stretches in the order of their ranks.
    pub fn stretches(&self) -> Vec<Ranked> {
        let mut ranked = self.stretches.to_vec();
        ranked.sort_by_key(|it| it.rank);
        ranked
    }

    /// The stretch at `t`, s since the recording's first frame, or the one before.
    pub fn stretch(&self, t: f64) -> Ranked {
        // A cycle may open a little before the first frame of a stretch.
        let half = 0.5 * PAUSE.as_seconds();
        let behind = self.stretches.partition_point(|it| it.from - half <= t);
        self.stretches[behind.saturating_sub(1)]
    }
}

/// Notices the pauses between the rows of one cylinder.
#[derive(Clone, Copy, Debug, Default)]
pub struct Lull {
    newest: Option<f64>,
}

impl Lull {
    /// Takes the time of a row, s; returns whether it is the first one after a pause, so that
    /// nothing of what came before may go on in it.
    pub fn ends(&mut self, t: f64) -> bool {
        let newest = self.newest.replace(t);
        newest.is_some_and(|newest| t - newest >= PAUSE.as_seconds())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tertius_core::frame::{Id, Kind};

    fn stretch(begin: i64, length: i64, content: u8) -> Stretch {
        let at = |seconds: i64| Timestamp::from_nanos(seconds * 1_000_000_000);
        let mut stretch = Stretch::new(at(begin));
        stretch.ends[1] = at(begin + length);
        let id = Id::standard(0x181).expect("it has 11 bits");
        stretch.read(&Frame::new(at(begin), id, Kind::Data, &[content, 1]));
        stretch
    }

    #[test]
    fn files_in_either_order_have_the_same_places() {
        let of = |order: &[(i64, u8)]| {
            let mut begin = 0;
            let mut stretches = Vec::new();
            let mut begins = std::collections::BTreeMap::new();
            for (length, content) in order {
                stretches.push((begin as f64, stretch(begin, *length, *content)));
                begins.insert(*content, begin as f64);
                begin += length + 30;
            }
            (Ranking::new(&stretches), begins)
        };
        let files = [(100, 7), (250, 8), (40, 9)];
        let (one, begins) = of(&files);
        let mut places = Vec::new();
        for order in [[2, 1, 0], [1, 0, 2], [0, 2, 1]] {
            let (other, moved) = of(&order.map(|index| files[index]));
            for (length, content) in files {
                for within in 0..=length {
                    let [t, u] = [&begins, &moved].map(|it| it[&content] + within as f64);
                    assert_eq!((one.place(t), one.rank(t)), (other.place(u), other.rank(u)));
                    places.push((one.place(t) as i64, one.rank(t)));
                }
            }
        }
        // Without the pauses, and with nothing in two places.
        places.sort_unstable();
        places.dedup();
        assert_eq!((places[0].0, places[places.len() - 1].0), (0, 390));
        assert_eq!(places.len(), 393);
    }

    #[test]
    fn without_a_pause_places_are_times() {
        let ranking = Ranking::new(&[(0.0, stretch(1000, 500, 1))]);
        for t in [0.0, 0.02, 59.98, 60.0, 500.0] {
            assert_eq!([ranking.place(t), Ranking::default().place(t)], [t; 2]);
        }
        assert_eq!(ranking.place(-0.5), 0.0);
    }

    #[test]
    fn a_pause_is_noticed_once() {
        let mut lull = Lull::default();
        let ends = [5.0, 5.02, 14.9, 25.0, 25.02, 90.0].map(|t| lull.ends(t));
        assert_eq!(ends, [false, false, false, true, false, true]);
    }
}
