//! The weights with the best score, by a pattern search over their logarithms, which is
//! deterministic and needs no derivatives.

use super::criterion::{Criterion, Score};
use super::model::{CylinderModel, Weights};
use super::store::Store;

/// Step sizes of the search, decades.
const STEPS: [f64; 4] = [2.0, 1.0, 0.5, 0.25];

/// Most sweeps with one step size.
const SWEEPS: u32 = 12;

/// Part by which a score must be better not to be chance.
const BETTER: f64 = 1e-3;

/// Part by which other weights must reduce the smallest faults to be preferred. Less is a
/// coincidence of the recording: another one of the same machine, or its files in another order,
/// would give other weights.
const WORTH: f64 = 0.02;

/// Farthest distance of weights from their start, decades.
const FARTHEST: f64 = 8.0;

/// Result of the search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Search {
    pub weights: Weights,
    pub score: Score,
    /// Weights at the start.
    pub begun: Weights,
    /// Score of the weights at the start.
    pub before: Score,
    /// Number of scores computed.
    pub tried: u32,
    /// Number of stored cycles used, all cylinders together.
    pub cycles: usize,
}

/// Searches from `begun`. The first of R stays, since only ratios matter. `None` where `begun` has
/// no score.
pub fn search(
    criterion: &Criterion,
    cylinders: &[CylinderModel],
    store: &Store,
    begun: Weights,
) -> Option<Search> {
    let free = free(cylinders);
    let before = criterion.score(cylinders, store, begun)?;
    let (mut place, mut best) = ([0.0_f64; 4], before);
    let mut tried = 1;
    for step in STEPS {
        for _ in 0..SWEEPS {
            let mut improved = false;
            for dimension in (0..4).filter(|dimension| free[*dimension]) {
                for sign in [1.0, -1.0] {
                    let mut next = place;
                    next[dimension] += sign * step;
                    if next[dimension].abs() > FARTHEST {
                        continue;
                    }
                    tried += 1;
                    let score = criterion.score(cylinders, store, moved(begun, next));
                    if let Some(score) = score.filter(|score| is_better(score, &best)) {
                        (place, best, improved) = (next, score, true);
                        break;
                    }
                }
            }
            if !improved {
                break;
            }
        }
    }
    if best.times > (1.0 - WORTH) * before.times {
        (place, best) = ([0.0; 4], before);
    }
    let weights = moved(begun, place);
    Some(Search { weights, score: best, begun, before, tried, cycles: store.cycles() })
}

/// Whether `one` is better; of two that are not sharp, the one that settles sooner.
fn is_better(one: &Score, other: &Score) -> bool {
    if one.times.is_infinite() && other.times.is_infinite() {
        return one.settled < other.settled;
    }
    one.times < (1.0 - BETTER) * other.times
}

/// Which of q and of the second of r have an effect.
fn free(cylinders: &[CylinderModel]) -> [bool; 4] {
    let velocity = cylinders.iter().any(|cylinder| cylinder.velocities.contains(&true));
    let pressure = cylinders.iter().any(|cylinder| cylinder.model.a[(1, 2)] != 0.0);
    [true, true, pressure, velocity]
}

fn moved(begun: Weights, decades: [f64; 4]) -> Weights {
    let times = decades.map(|decades| 10_f64.powf(decades));
    let Weights { q, r } = begun;
    Weights { q: [q[0] * times[0], q[1] * times[1], q[2] * times[2]], r: [r[0], r[1] * times[3]] }
}
