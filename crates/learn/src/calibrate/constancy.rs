//! Whether C1 − Ĉ2 is the same from the beginning of a recording to its end.
//!
//! A lasting step spreads the differences of all of the recording, and makes them depend on each other for as long as it
//! lasts, so that a scatter learnt from them explains it.

/// Length of a block, s: several waves, so that its mean is over the stroke.
const BLOCK: f64 = 30.0;

/// Most blocks that are kept: three days.
const MOST: usize = 10_000;

/// Fewest blocks before and after a step.
const BESIDE: usize = 2;

/// Size from which on a step contradicts a calibration, m. The detectors that are learnt find smaller ones themselves.
const LEAST: f64 = 1e-3;

/// Part of the scatter of the blocks' means that a step has to explain; of a steady drift it explains three quarters.
const EXPLAINED: f64 = 0.85;

/// Means of C1 − Ĉ2 over blocks of time.
#[derive(Clone, Debug, Default)]
pub struct Constancy {
    blocks: Vec<Block>,
}

#[derive(Clone, Copy, Debug)]
struct Block {
    /// s.
    from: f64,
    /// m.
    sum: f64,
    count: u32,
    /// Whether it is the first one after a pause.
    begins: bool,
}

/// A step of C1 − Ĉ2 that lasts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LastingStep {
    /// Begin of the first block after it, s.
    pub at: f64,
    /// m.
    pub size: f64,
}

impl Constancy {
    /// Takes the difference `error` at `t`, m and s, and whether a pause precedes it.
    pub fn add(&mut self, t: f64, error: f64, begins: bool) {
        let newest = self.blocks.last_mut();
        if let Some(block) = newest.filter(|block| !begins && t < block.from + BLOCK) {
            (block.sum, block.count) = (block.sum + error, block.count + 1);
        } else if self.blocks.len() < MOST {
            self.blocks.push(Block { from: t, sum: error, count: 1, begins });
        }
    }

    /// The largest lasting step between two pauses, if there is one.
    pub fn step(&self) -> Option<LastingStep> {
        let stretches = self.blocks.chunk_by(|_, next| !next.begins);
        let steps = stretches.filter_map(step_in);
        steps.max_by(|one, other| one.size.abs().total_cmp(&other.size.abs()))
    }
}

/// The lasting step in `blocks` that follow each other.
fn step_in(blocks: &[Block]) -> Option<LastingStep> {
    let means: Vec<f64> = blocks.iter().map(|it| it.sum / f64::from(it.count)).collect();
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let all = mean(&means);
    let scatter: f64 = means.iter().map(|it| (it - all).powi(2)).sum();
    let places = BESIDE..(means.len() + 1).saturating_sub(BESIDE);
    let explained = |at: usize| {
        let (before, after) = means.split_at(at);
        let size = mean(after) - mean(before);
        let share = before.len() as f64 * after.len() as f64 / means.len() as f64;
        (at, size, share * size * size)
    };
    let (at, size, explains) = places.map(explained).max_by(|a, b| a.2.total_cmp(&b.2))?;
    let lasts = size.abs() >= LEAST && explains >= EXPLAINED * scatter;
    lasts.then(|| LastingStep { at: blocks[at].from, size })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is found in so many minutes of a difference, m, by its time, s.
    fn found(minutes: u32, difference: impl Fn(f64) -> f64) -> Option<LastingStep> {
        let mut constancy = Constancy::default();
        for k in 0..minutes * 60 * 10 {
            let t = 0.1 * f64::from(k);
            constancy.add(t, difference(t) + 3e-4 * (0.7 * t).sin(), k == 0);
        }
        constancy.step()
    }

    #[test]
    fn a_step_that_lasts_is_found_wherever_it_is() {
        for at in [70.0, 300.0, 560.0, 773.0, 1100.0] {
            for size in [2e-3, -5e-3] {
                let step = found(20, |t| if t < at { 0.0 } else { size });
                let step = step.unwrap_or_else(|| panic!("{at} s, {size} m"));
                assert!((step.at - at).abs() <= BLOCK && (step.size / size - 1.0).abs() < 0.2);
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
        assert_eq!(Constancy::default().step(), None);
    }

    /// From one day to the next C2 may have been adjusted.
    #[test]
    fn a_difference_between_two_recordings_is_none() {
        let mut constancy = Constancy::default();
        for k in 0..12_000 {
            let (t, second) = (0.1 * f64::from(k), k >= 6000);
            constancy.add(t, if second { 3e-3 } else { 0.0 }, k % 6000 == 0);
        }
        assert_eq!(constancy.step(), None);
    }
}
