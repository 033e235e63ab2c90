//! Whether C1 − C2 is the same from the beginning of a recording to its end.
//!
//! A lasting step spreads the differences of all of the recording, and makes them depend on each other for as long as it
//! lasts, so that a scatter learnt from them explains it. Where only its beginning is cut out, what is left on either side
//! is healthy by itself. It is therefore looked for in all of the recording, whatever is cut out or held back.
//!
//! What is compared is the difference at the same places of the stroke: rods that swing about another place, or rest
//! where the line is off, are no step.

use super::line::Line;
use crate::survey::{Ranking, Row, Surveyor};
use std::ops::Range;

/// Length of a block, s: several waves, so that its mean is over the stroke.
const BLOCK: f64 = 30.0;

/// Length of a place on the stroke, m.
const PLACE: f64 = 0.1;

/// Farthest place: no stroke is longer, whatever a reading says.
const FARTHEST: f64 = 1e3;

/// Most blocks that are kept: three days.
const MOST: usize = 10_000;

/// Fewest blocks before and after a step.
const BESIDE: usize = 2;

/// Most blocks on either side of a part that is left out which are compared: what the step is does not depend on others.
const NEAR: usize = 4;

/// Size from which on a step contradicts a calibration, m: a millimetre, less the rounding of readings and blocks. The
/// detectors that are learnt find smaller ones themselves.
const LEAST: f64 = 0.95e-3;

/// Part of the scatter of the blocks that a step has to explain; of a steady drift it explains three quarters.
const EXPLAINED: f64 = 0.85;

/// Time on either side of two blocks between which a step is, s: it may be as far within one of them.
const BORDER: f64 = 5.0;

/// Rounds in which the blocks and the places are told apart, each from the others.
const ROUNDS: u32 = 50;

/// C1 − Ĉ2 of all cylinders over all of a recording.
#[derive(Debug)]
pub struct Constancies {
    ranking: Ranking,
    cylinders: Vec<Option<(Line, Constancy)>>,
}

/// C1 − Ĉ2 in blocks of time, by the place on the stroke.
#[derive(Clone, Debug, Default)]
pub struct Constancy {
    blocks: Vec<Block>,
}

#[derive(Clone, Debug)]
struct Block {
    /// s.
    from: f64,
    /// Rank of the stretch between two pauses that it is in.
    stretch: u64,
    places: Vec<Place>,
}

/// What a block has of one place.
#[derive(Clone, Copy, Debug)]
struct Place {
    number: i32,
    count: f64,
    /// Of the differences, m.
    sum: f64,
}

/// What a block differs by from the others, wherever on the stroke it is.
#[derive(Clone, Copy, Debug)]
struct Level {
    /// s.
    from: f64,
    stretch: u64,
    /// m.
    level: f64,
    /// Number of its samples.
    weight: f64,
}

/// A step of C1 − Ĉ2 that lasts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LastingStep {
    /// From when on, and until when, it may have happened, s.
    pub between: [f64; 2],
    /// m.
    pub size: f64,
}

impl Constancies {
    /// A pass over a recording with this `ranking`; cylinders without a line are not looked at.
    pub fn new(ranking: Ranking, lines: impl IntoIterator<Item = Option<Line>>) -> Self {
        let fresh = |line: Line| (line, Constancy::default());
        Self { ranking, cylinders: lines.into_iter().map(|line| line.map(fresh)).collect() }
    }

    /// The largest lasting step of the cylinder of `index` (from 0), from which the spans `cut`, s, are left out.
    pub fn step(&self, index: usize, cut: &[[f64; 2]]) -> Option<LastingStep> {
        let (_, constancy) = self.cylinders[index].as_ref()?;
        constancy.step(cut)
    }
}

impl Surveyor for Constancies {
    fn row(&mut self, row: &Row) {
        let cylinder = self.cylinders[usize::from(row.cylinder) - 1].as_mut();
        if let (Some((line, constancy)), Some((c1, c2))) = (cylinder, row.c1.zip(row.c2)) {
            constancy.add(row.t, self.ranking.rank(row.t), c2, line.error(c2, c1));
        }
    }

    fn gap(&mut self, cylinder: u8) {
        _ = cylinder;
    }
}

impl Constancy {
    /// Takes the difference `error` at the time `t` in its `stretch`, where the rod is at `length`; m and s.
    fn add(&mut self, t: f64, stretch: u64, length: f64, error: f64) {
        let goes_on = |block: &Block| block.stretch == stretch && t < block.from + BLOCK;
        if !self.blocks.last().is_some_and(goes_on) {
            if self.blocks.len() == MOST {
                return;
            }
            self.blocks.push(Block { from: t, stretch, places: Vec::new() });
        }
        let Some(block) = self.blocks.last_mut() else { return };
        let number = (length / PLACE).floor().clamp(-FARTHEST, FARTHEST) as i32;
        match block.places.iter_mut().find(|place| place.number == number) {
            Some(place) => (place.count, place.sum) = (place.count + 1.0, place.sum + error),
            None => block.places.push(Place { number, count: 1.0, sum: error }),
        }
    }

    /// The largest lasting step between two pauses, if there is one.
    fn step(&self, cut: &[[f64; 2]]) -> Option<LastingStep> {
        let levels = self.levels();
        let stretches = levels.chunk_by(|one, next| one.stretch == next.stretch);
        let steps = stretches.flat_map(|blocks| {
            let across = cut.iter().filter_map(|span| step_across(blocks, *span, cut));
            across.chain(step_in(blocks))
        });
        steps.max_by(|one, other| one.size.abs().total_cmp(&other.size.abs()))
    }

    /// The level of each block: least squares of what each of its places has beyond the mean of that place. Places that
    /// no other block has say nothing of it; where all are such, it is the mean beyond the line.
    fn levels(&self) -> Vec<Level> {
        let all = || self.blocks.iter().flat_map(|block| &block.places);
        let first = all().map(|place| place.number).min().unwrap_or_default();
        let last = all().map(|place| place.number).max().unwrap_or_default();
        let at = |place: &Place| (place.number - first) as usize;
        let mut bends = vec![0.0; (last - first) as usize + 1];
        let beyond = |block: &Block, bends: &[f64]| {
            let sum = |place: &Place| place.sum - place.count * bends[at(place)];
            block.places.iter().map(sum).sum::<f64>() / block.weight()
        };
        let mut levels: Vec<f64> = self.blocks.iter().map(|block| beyond(block, &bends)).collect();
        for _ in 0..ROUNDS {
            let mut sums = vec![(0.0, 0.0); bends.len()];
            for (block, level) in self.blocks.iter().zip(&levels) {
                for place in &block.places {
                    let (count, sum) = &mut sums[at(place)];
                    *count += place.count;
                    *sum += place.sum - place.count * level;
                }
            }
            bends = sums.iter().map(|(count, sum)| sum / count.max(1.0)).collect();
            levels = self.blocks.iter().map(|block| beyond(block, &bends)).collect();
        }
        let level = |(block, level): (&Block, f64)| {
            let Block { from, stretch, .. } = *block;
            Level { from, stretch, level, weight: block.weight() }
        };
        self.blocks.iter().zip(levels).map(level).collect()
    }
}

impl Block {
    fn weight(&self) -> f64 {
        self.places.iter().map(|place| place.count).sum()
    }
}

/// Number of samples of `blocks`, and their mean level, m.
fn mean(blocks: &[Level]) -> (f64, f64) {
    let weight: f64 = blocks.iter().map(|it| it.weight).sum();
    (weight, blocks.iter().map(|it| it.weight * it.level).sum::<f64>() / weight)
}

/// The lasting step in `blocks` that follow each other: of all places the one that explains most of their scatter.
fn step_in(blocks: &[Level]) -> Option<LastingStep> {
    let count = blocks.len();
    let scatter = |blocks: &[Level], mean: f64| -> f64 {
        blocks.iter().map(|it| it.weight * (it.level - mean).powi(2)).sum()
    };
    let split = |without: Range<usize>| {
        let between = match &blocks[without.clone()] {
            [inside] => [inside.from, inside.from + BLOCK],
            // As much of a block as does not change its level.
            _ => [-BORDER, BORDER].map(|beside| blocks[without.start].from + beside),
        };
        let (before, after) = (&blocks[..without.start], &blocks[without.end..]);
        let ((n, low), (m, high)) = (mean(before), mean(after));
        let size = high - low;
        let within = scatter(before, low) + scatter(after, high);
        let explains = n * m / (n + m) * size * size;
        let share = explains / (explains + within);
        (share, LastingStep { between, size })
    };
    // Between two blocks, or in one, which is then left out.
    let between = (BESIDE..(count + 1).saturating_sub(BESIDE)).map(|at| at..at);
    let inside = (BESIDE..count.saturating_sub(BESIDE)).map(|at| at..at + 1);
    let steps = between.chain(inside).map(split);
    let steps = steps.filter(|(share, step)| *share >= EXPLAINED && step.size.abs() >= LEAST);
    steps.max_by(|(one, _), (other, _)| one.total_cmp(other)).map(|(_, step)| step)
}

/// The step from before `span`, s, to after it, by the blocks nearest to it that nothing is `cut` out of.
fn step_across(blocks: &[Level], span: [f64; 2], cut: &[[f64; 2]]) -> Option<LastingStep> {
    let whole = |block: &&Level| {
        let [from, to] = [block.from, block.from + BLOCK];
        cut.iter().all(|[begin, end]| to <= *begin || *end <= from)
    };
    let whole: Vec<Level> = blocks.iter().filter(whole).copied().collect();
    let (before, after) = whole.split_at(whole.partition_point(|it| it.from < span[0]));
    if before.len().min(after.len()) < BESIDE {
        return None;
    }
    let before = &before[before.len().saturating_sub(NEAR)..];
    let after = &after[..after.len().min(NEAR)];
    let size = mean(after).1 - mean(before).1;
    (size.abs() >= LEAST).then_some(LastingStep { between: span, size })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// So many minutes of a difference, m, by its time, s, and by the place of a rod that swings about `middle`, m.
    fn over(
        minutes: u32,
        middle: impl Fn(f64) -> f64,
        difference: impl Fn(f64, f64) -> f64,
    ) -> Constancy {
        let mut constancy = Constancy::default();
        for k in 0..minutes * 60 * 10 {
            let t = 0.1 * f64::from(k);
            let length = middle(t) + 0.5 * (0.9 * t).sin();
            constancy.add(t, 0, length, difference(t, length) + 3e-4 * (0.7 * t).sin());
        }
        constancy
    }

    /// What is found in so many minutes of a difference, m, by its time, s.
    fn found(minutes: u32, difference: impl Fn(f64) -> f64) -> Option<LastingStep> {
        over(minutes, |_| 0.0, |t, _| difference(t)).step(&[])
    }

    #[test]
    fn a_step_that_lasts_is_found_wherever_it_is() {
        for at in [70.0, 300.0, 560.0, 773.0, 1100.0] {
            for size in [1e-3, 2e-3, -5e-3] {
                let step = found(20, |t| if t < at { 0.0 } else { size });
                let step = step.unwrap_or_else(|| panic!("{at} s, {size} m"));
                let [from, to] = step.between;
                assert!((from..=to).contains(&at) && to - from <= BLOCK, "{at}: {step:?}");
                assert!((step.size / size - 1.0).abs() < 0.1, "{at}: {step:?}");
            }
        }
    }

    #[test]
    fn what_is_small_or_drifts_or_goes_again_is_no_lasting_step() {
        assert_eq!(found(20, |_| 0.0), None);
        assert_eq!(found(20, |t| if t < 600.0 { 0.0 } else { 5e-4 }), None);
        assert_eq!(found(20, |t| 5e-6 * t), None, "a drift");
        assert_eq!(found(20, |t| if (500.0..700.0).contains(&t) { 3e-3 } else { 0.0 }), None);
        assert_eq!(found(2, |t| if t < 100.0 { 0.0 } else { 3e-3 }), None, "half a minute");
        assert_eq!(Constancy::default().step(&[]), None);
    }

    /// From one day to the next C2 may have been adjusted.
    #[test]
    fn a_difference_between_two_recordings_is_none() {
        let mut constancy = Constancy::default();
        for k in 0..12_000 {
            let (t, second) = (0.1 * f64::from(k), k >= 6000);
            constancy.add(t, u64::from(second), 0.0, if second { 3e-3 } else { 0.0 });
        }
        assert_eq!(constancy.step(&[]), None);
    }

    /// Two steps look like a drift, and one that goes again like none; where their beginnings are left out, what is on
    /// either side of these differs.
    #[test]
    fn a_step_of_which_only_the_beginning_is_left_out_is_found() {
        let stairs = |t: f64| 1.5e-3 * f64::from(u8::from(t >= 400.0) + u8::from(t >= 800.0));
        let passing = |t: f64| if (400.0..800.0).contains(&t) { -1.5e-3 } else { 0.0 };
        let cuts = [[385.0, 430.0], [785.0, 830.0]];
        for difference in [&stairs as &dyn Fn(f64) -> f64, &passing] {
            let constancy = over(20, |_| 0.0, |t, _| difference(t));
            let step = constancy.step(&cuts).expect("it is found");
            assert!((step.size.abs() - 1.5e-3).abs() < 2e-4, "{step:?}");
            assert!(cuts.contains(&step.between), "{step:?}");
        }
        // What has gone when the part left out ends is no step.
        let fault = |t: f64| if (400.0..415.0).contains(&t) { 5e-3 } else { 0.0 };
        assert_eq!(over(20, |_| 0.0, |t, _| fault(t)).step(&[[385.0, 430.0]]), None);
    }

    /// Where the rods swing about another place, or rest at one, the line may be off by more than a millimetre.
    #[test]
    fn another_place_of_the_stroke_is_no_step() {
        let moved = |t: f64| if t < 600.0 { -0.4 } else { 0.4 };
        let bend = |length: f64| 2e-3 * (2.0 * length).sin();
        assert_eq!(over(20, moved, |_, length| bend(length)).step(&[]), None);
        // Nor does the other place hide one, of the gain that would explain it.
        let constancy = over(20, moved, |t, length| {
            bend(length) - 1.2e-3 / 0.8 * length + if t < 600.0 { 0.0 } else { 1.2e-3 }
        });
        let step = constancy.step(&[]).expect("it is found");
        assert!((step.size - 1.2e-3).abs() < 1e-4, "{step:?}");
        // A rest of ten minutes at a place that was passed before.
        let mut constancy = over(20, |_| 0.0, |_, length| bend(length));
        for k in 0..6000 {
            constancy.add(1200.0 + 0.1 * f64::from(k), 0, 0.45, bend(0.45));
        }
        assert_eq!(constancy.step(&[]), None);
    }
}
