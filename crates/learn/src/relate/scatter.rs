//! The scatter of what a relation leaves, and how much its samples depend on each other.

use super::refusal::ProcessRefusal;
use crate::order_statistics::ranked;
use tertius_core::process::ProcessParameters;
use tertius_core::process::evidence::WIDEST;
use tertius_core::process::{EvidenceWindows, Weighing};
use tertius_core::sequential::windows::{VALUES, WIDTHS};

/// A sample of what a relation leaves, with what its standard deviation grows by.
#[derive(Clone, Copy, Debug)]
pub(super) struct Left {
    pub t: f64,
    pub residual: f64,
    /// What the scatter grows with: the movement within the cycle, or the square of a position.
    pub way: f64,
    /// Whether the sample before is that of the cycle before.
    pub follows: bool,
}

/// Groups of samples by their movement, from which the scatter's two parts are found.
const GROUPS: usize = 24;

/// Fewest windows of one width whose variance is known.
const LEAST_WINDOWS: f64 = 24.0;

/// Median and ninth decile of a squared normal value of variance 1.
const MEDIAN: f64 = 0.455;
const NINTH: f64 = 2.706;

/// σ and s of a scatter σ² + (s Δ)²: of groups with similar movements, by least squares of their variances.
pub(super) fn parts(left: &[Left]) -> [f64; 2] {
    let mut by_way: Vec<[f64; 2]> =
        left.iter().map(|it| [it.way * it.way, it.residual * it.residual]).collect();
    by_way.sort_unstable_by(|one, other| one[0].total_cmp(&other[0]));
    let size = by_way.len().div_ceil(GROUPS).max(1);
    let groups: Vec<[f64; 2]> = by_way.chunks(size).map(group).collect();
    // An error of a variance is in proportion to it.
    let (mut ww, mut wx, mut wxx, mut wy, mut wxy) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for [x, y] in &groups {
        let weight = 1.0 / (y * y).max(f64::MIN_POSITIVE);
        ww += weight;
        wx += weight * x;
        wxx += weight * x * x;
        wy += weight * y;
        wxy += weight * x * y;
    }
    let spread = ww * wxx - wx * wx;
    let slope = if spread > 1e-12 * ww * wxx { (ww * wxy - wx * wy) / spread } else { 0.0 };
    let slope = slope.max(0.0);
    let rest = (wy - slope * wx) / ww;
    // Where it all grows with the movement, at rest it is still that of the calmest group.
    let least = groups.iter().map(|[_, y]| *y).fold(f64::INFINITY, f64::min);
    [rest.max(0.5 * least).sqrt(), slope.sqrt()]
}

/// Mean squared movement, and mean square without what is far out, of a group.
fn group(samples: &[[f64; 2]]) -> [f64; 2] {
    let mut squares: Vec<f64> = samples.iter().map(|it| it[1]).collect();
    let median = ranked(&mut squares, 0.5, f64::total_cmp).unwrap_or(0.0);
    let most = ProcessParameters::DEFAULT.farthest.powi(2) * median / MEDIAN;
    let kept = squares.iter().filter(|square| **square <= most);
    let (count, sum) = kept.fold((0.0, 0.0), |(count, sum), square| (count + 1.0, sum + square));
    let way = samples.iter().map(|it| it[0]).sum::<f64>() / samples.len() as f64;
    [way, f64::max(sum / f64::max(count, 1.0), f64::MIN_POSITIVE)]
}

/// What is learnt of the scatter.
pub(super) struct Scatter {
    /// σ and s.
    pub parts: [f64; 2],
    pub dependence: [[f64; WIDTHS.len()]; 2],
}

/// Measures the scatter of `left`, and tries the detector on it, which takes it for at least `least`, with this dead
/// band and level, nats.
pub(super) fn measure(
    left: &[Left],
    least: f64,
    dead_band: f64,
    sample_time: f64,
    level: f64,
) -> Result<Scatter, ProcessRefusal> {
    let measured = parts(left);
    let parts = [measured[0].max(least), measured[1]];
    let dependence = dependence(left, parts);
    let weighing = Weighing::new(dead_band, dependence, sample_time);
    let mut evidence = EvidenceWindows::default();
    let (mut worst, mut at) = (0.0, 0.0);
    for one in left {
        if !one.follows {
            evidence.clear();
        }
        evidence.push(one.residual, variance(parts, one));
        let nats = evidence.peaks(&weighing).iter().map(|peak| peak.nats).fold(0.0, f64::max);
        if nats > worst {
            (worst, at) = (nats, one.t);
        }
    }
    if worst >= ProcessParameters::DEFAULT.doubtful * level {
        return Err(ProcessRefusal::Contradicted { at, nats: worst });
    }
    Ok(Scatter { parts: measured, dependence })
}

fn variance([rest, timing]: [f64; 2], one: &Left) -> f64 {
    let way = timing * one.way;
    rest * rest + way * way
}

/// How many dependent samples carry as much as one, in mean and mean square, by the width of the window: what the
/// variance over windows next to each other is of that of independent samples.
pub(super) fn dependence(left: &[Left], parts: [f64; 2]) -> [[f64; WIDTHS.len()]; 2] {
    let mut found = [[1.0_f64; WIDTHS.len()]; 2];
    let mut last = [1.0_f64; 2];
    for (index, width) in WIDTHS.into_iter().enumerate().filter(|(_, width)| *width <= WIDEST) {
        let windows = windows(left, parts, width);
        let count = windows.len() as f64;
        if count >= LEAST_WINDOWS {
            let n = width as f64;
            let means = windows.iter().map(|[sum, weight, ..]| sum * sum / weight);
            let spreads =
                windows.iter().map(|[_, _, square, _]| 0.5 * n * (square / n - 1.0).powi(2));
            // So few windows may have been lucky.
            let doubt = 1.0 + 2.0 * (2.0 / count).sqrt();
            last = [typical(means.collect()) * doubt, typical(spreads.collect()) * doubt];
        }
        for (of, last) in found.iter_mut().zip(last) {
            of[index] = last.max(1.0);
        }
    }
    found
}

/// The variance of values of which these are the squares, whatever a tenth of them are: a fault in the recording must
/// not hide itself.
fn typical(mut squares: Vec<f64>) -> f64 {
    squares.sort_unstable_by(f64::total_cmp);
    let at = |tenths: usize| squares[(squares.len() * tenths / 10).min(squares.len() - 1)];
    f64::max(at(5) / MEDIAN, at(9) / NINTH)
}

/// The sums of [`EvidenceWindows`] over windows of `width` next to each other.
fn windows(left: &[Left], parts: [f64; 2], width: usize) -> Vec<[f64; VALUES]> {
    let (mut all, mut evidence) = (Vec::new(), EvidenceWindows::default());
    for one in left {
        if !one.follows {
            evidence.clear();
        }
        evidence.push(one.residual, variance(parts, one));
        if let Some(sums) = evidence.sums(width) {
            all.push(sums);
            evidence.clear();
        }
    }
    all
}
