//! The weights with the best score: a pattern search over their logarithms, which has no chance in
//! it and needs no derivatives.

use super::criterion::{Criterion, Score};
use super::store::Store;
use super::{CylinderModel, Weights};

/// Steps of the search, decades.
const STEPS: [f64; 4] = [2.0, 1.0, 0.5, 0.25];

/// Sweeps with one step.
const SWEEPS: u32 = 12;

/// A better score is better by this part, or it is chance.
const BETTER: f64 = 1e-3;

/// Weights are left for others that make the smallest faults smaller by this part. Less is the recording's
/// chance: another one of the same machine, or its files in another order, would find others.
const WORTH: f64 = 0.02;

/// How far weights may go from where they began, decades.
const FARTHEST: f64 = 8.0;

/// What was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Search {
    pub weights: Weights,
    pub score: Score,
    /// Where it began, and the score of that.
    pub begun: Weights,
    pub before: Score,
    /// Scores that were computed.
    pub tried: u32,
    /// Stored cycles of all cylinders that it was done on.
    pub cycles: usize,
}

/// Searches from `begun`. The first of R stays: only ratios matter. `None` where `begun` has no
/// score.
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

/// Of two that are not sharp the one that is over sooner.
fn is_better(one: &Score, other: &Score) -> bool {
    if one.times.is_infinite() && other.times.is_infinite() {
        return one.settled < other.settled;
    }
    one.times < (1.0 - BETTER) * other.times
}

/// Which of q and the second of r do anything.
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
