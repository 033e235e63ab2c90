//! Blocks of a recording that are held back for the trial.

use tertius_learn::calibrate::{Cuts, Cutting, Division};
use tertius_learn::survey::{Ranked, Ranking, Recording, Surveyor, Window};

/// One block in this many is held back. The number is odd, so that both halves of a calibration,
/// which alternate, lose equally.
const ONE_IN: u64 = 3;

/// A remainder shorter than this part of a block is not used as a block.
const SHORTEST: f64 = 0.5;

/// Blocks of a recording that the trial uses and nothing is learnt from. They are counted through
/// the recording's [`Ranking`], so that which of its files came first changes none.
#[derive(Clone, Debug, PartialEq)]
pub struct Blocks {
    window: Window,
    ranking: Ranking,
    /// Length of a block, s.
    length: f64,
}

impl Blocks {
    /// Blocks of `window`, as long as those of a calibration.
    pub fn of(window: Window, ranking: Ranking) -> Self {
        let division = Division::new(window, window, ranking.clone());
        let length = division.block().unwrap_or(window.length());
        Self { window, ranking, length }
    }

    /// Length of a block, s.
    pub const fn length(&self) -> f64 {
        self.length
    }

    /// Whether the row at `t`, s, is held back.
    pub fn hold(&self, t: f64) -> bool {
        let block = (self.ranking.place(t) / self.length) as u64;
        self.window.holds(t) && self.span(block, self.ranking.stretch(t)).is_some()
    }

    /// Beginning and end of each block that is held back, s, in the order of the ranking.
    pub fn spans(&self) -> Vec<[f64; 2]> {
        let stretches = self.ranking.stretches().into_iter();
        stretches.flat_map(|stretch| self.spans_of(stretch)).collect()
    }

    fn spans_of(&self, stretch: Ranked) -> impl Iterator<Item = [f64; 2]> + '_ {
        let ends = [stretch.from, stretch.to.min(self.window.to)];
        let [first, last] = ends.map(|t| (stretch.place(t) / self.length) as u64);
        (first..=last).filter_map(move |block| self.span(block, stretch))
    }

    /// Beginning and end of what a `stretch` has of a `block`, s, if it is held back. At the ends of
    /// a stretch a block may be too short for a fault.
    fn span(&self, block: u64, stretch: Ranked) -> Option<[f64; 2]> {
        let from = stretch.time(block as f64 * self.length);
        let [begin, end] = [stretch.from.max(self.window.from), stretch.to.min(self.window.to)];
        let [from, to] = [from.max(begin), (from + self.length).min(end)];
        (block % ONE_IN == ONE_IN - 1 && to - from >= SHORTEST * self.length).then_some([from, to])
    }
}

/// A recording without the blocks that are held back.
#[derive(Debug)]
pub struct Without<'a, R> {
    pub recording: R,
    pub blocks: Option<Blocks>,
    pub cuts: &'a Cuts,
}

impl<R: Recording> Recording for Without<'_, R> {
    type Error = R::Error;

    fn read(&self, window: Window, surveyor: impl Surveyor) -> Result<(), R::Error> {
        let Self { recording, blocks, cuts } = self;
        let held = |t| blocks.as_ref().is_some_and(|blocks| blocks.hold(t));
        let out = |cylinder, t| held(t) || cuts.hold(cylinder, t);
        recording.read(window, Cutting { out, surveyor })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;
    use tertius_core::frame::{Frame, Id, Kind};
    use tertius_core::time::Timestamp;
    use tertius_learn::survey::{Row, Timeline};

    #[test]
    fn every_third_block_is_held_back_and_both_halves_lose_the_same() {
        let window = Window { from: 0.0, to: 1200.0 };
        let blocks = Blocks::of(window, Ranking::default());
        assert_eq!(blocks.length(), 60.0);
        let spans = blocks.spans();
        assert_eq!(spans.len(), 6);
        assert_eq!(spans[..2], [[120.0, 180.0], [300.0, 360.0]]);
        for [from, to] in &spans {
            assert!(blocks.hold(*from) && blocks.hold(to - 1e-6) && !blocks.hold(*to));
            assert!(!blocks.hold(from - 1e-6));
        }
        let division = Division::new(window, window, Ranking::default());
        let halves: Vec<_> = spans.iter().map(|[from, _]| division.taught(*from)).collect();
        assert_eq!(halves, [0, 1, 0, 1, 0, 1].map(Some));
    }

    /// The last cycles of a recording are no block, in which faults would be over before they begin.
    #[test]
    fn what_is_left_of_a_block_is_none() {
        for (to, held, spans) in [(1200.003, 1200.001, 6), (1229.0, 1210.0, 6), (1231.0, 1210.0, 7)]
        {
            let blocks = Blocks::of(Window { from: 0.0, to }, Ranking::default());
            assert_eq!((blocks.spans().len(), blocks.hold(held)), (spans, spans == 7), "{to}");
        }
    }

    #[test]
    fn a_part_of_a_recording_has_whole_blocks_and_ends() {
        let blocks = Blocks::of(Window { from: 130.0, to: 1000.0 }, Ranking::default());
        let spans = blocks.spans();
        assert_eq!(spans[0], [130.0, 180.0]);
        assert!(spans.iter().all(|[from, to]| from < to && *to <= 1000.0));
        assert!(!blocks.hold(125.0) && blocks.hold(131.0));
    }

    /// A file and a second in it.
    type Second = (u8, i64);

    /// Two files, of so many seconds, in this order; returns the readings that are held back, by their
    /// file and second, and the files in which spans lie, in their order.
    fn held(order: [(i64, u8); 2]) -> (BTreeSet<Second>, Vec<Second>) {
        let at = |seconds: i64| Timestamp::from_nanos(seconds * 1_000_000_000);
        let (mut timeline, mut begin, mut files) = (Timeline::default(), 0, Vec::new());
        for (length, content) in order {
            timeline.span(at(begin), at(begin + length));
            let id = Id::standard(1).expect("it has 11 bits");
            timeline.read(&Frame::new(at(begin), id, Kind::Data, &[content]));
            files.push((begin, length, content));
            begin += length + 30;
        }
        let window = Window { from: 0.0, to: timeline.length() + 1e-9 };
        let blocks = Blocks::of(window, timeline.ranking());
        let mut held = BTreeSet::new();
        for (begin, length, content) in &files {
            let seconds = (0..*length).filter(|second| blocks.hold((begin + second) as f64 + 0.5));
            held.extend(seconds.map(|second| (*content, second)));
        }
        let file = |[from, _]: [f64; 2]| {
            let (begin, _, content) = files.iter().rfind(|it| it.0 as f64 <= from).expect("a file");
            (*content, (from - *begin as f64).round() as i64)
        };
        (held, blocks.spans().into_iter().map(file).collect())
    }

    #[test]
    fn the_same_readings_are_held_back_whichever_file_came_first() {
        let (one, other) = ((460, 3), (535, 4));
        let there = held([one, other]);
        assert_eq!(there, held([other, one]));
        assert!((300..=340).contains(&there.0.len()), "{}", there.0.len());
        assert!([3, 4].iter().all(|file| there.1.iter().any(|(of, _)| of == file)));
    }

    /// A row every second of two cylinders.
    struct Steady;

    impl Recording for Steady {
        type Error = std::convert::Infallible;

        fn read(&self, _: Window, mut surveyor: impl Surveyor) -> Result<(), Self::Error> {
            for t in 0..1200_i32 {
                for cylinder in [1, 2] {
                    let record = row(t, cylinder);
                    surveyor.row(&record);
                }
            }
            Ok(())
        }
    }

    fn row(t: i32, cylinder: u8) -> Row {
        Row {
            timestamp: Timestamp::default(),
            t: f64::from(t),
            cycle: t.unsigned_abs().into(),
            cylinder,
            c1: None,
            c2: None,
            v1: None,
            v2: None,
            u: None,
            pressure_bottom: None,
            pressure_rod: None,
            pressure_load: None,
            supply: None,
            spool: None,
            monitored: true,
            raw: [None; 2],
            qualities: [tertius_core::sample::Quality::Good; 2],
        }
    }

    #[derive(Default)]
    struct Taken {
        rows: Vec<(u8, f64)>,
        gaps: usize,
    }

    impl Surveyor for Taken {
        fn row(&mut self, row: &Row) {
            self.rows.push((row.cylinder, row.t));
        }

        fn gap(&mut self, _: u8) {
            self.gaps += 1;
        }
    }

    #[test]
    fn nobody_learns_from_what_is_left_out() {
        let window = Window { from: 0.0, to: 1200.0 };
        let blocks = Blocks::of(window, Ranking::default());
        let cuts = Cuts::from(vec![vec![], vec![[10.0, 20.0]]]);
        let mut taken = Taken::default();
        let without = Without { recording: Steady, blocks: Some(blocks.clone()), cuts: &cuts };
        let Ok(()) = without.read(window, &mut taken);
        assert!(taken.rows.iter().all(|(_, t)| !blocks.hold(*t)));
        let of = |n: u8| taken.rows.iter().filter(|(cylinder, _)| *cylinder == n).count();
        assert_eq!((of(1), of(2)), (840, 830));
        assert!(taken.gaps > 0);
    }
}
