//! The smallest faults that a threshold finds in time.

use super::response;
use super::store::Store;
use crate::extremes::Sketch;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use tertius_core::observe::observer::ObserverDesign;

/// Part of all places in which a fault has to be found.
pub const FOUND: f64 = 0.95;

/// Number of noise trials.
const TRIALS: u32 = 1000;

/// The smallest step, m, up or down, that takes the residual of C1 (0) or C2 (1) of the cylinder of
/// `index` beyond `threshold` within `horizon` cycles, its own among them, in [`FOUND`] of all places of the stored
/// recording; `None` where there is none to try.
///
/// Since everything is linear, a residual with a fault is the healthy one plus the response to the
/// fault. Every place thus has its own smallest step, and this is a quantile of them.
pub fn step(
    store: &Store,
    index: usize,
    transducer: usize,
    design: &ObserverDesign,
    threshold: f64,
    horizon: usize,
) -> Option<f64> {
    let response = response::step(design, horizon);
    let mut smallest = Sketch::new();
    for stretch in store.stretches(index) {
        let residuals: Vec<Option<f64>> = Store::residuals(stretch, design, transducer).collect();
        for window in residuals.windows(horizon) {
            let healthy: Option<Vec<f64>> = window.iter().copied().collect();
            let Some(healthy) = healthy else { continue };
            for sign in [1.0, -1.0] {
                let least = healthy.iter().zip(&response).filter(|(_, g)| **g != 0.0).map(
                    // |f g + ν| > δ_h on the side to which the step goes.
                    |(healthy, g)| (threshold - sign * g.signum() * healthy) / g.abs(),
                );
                smallest.add(least.fold(f64::INFINITY, f64::min).max(0.0));
            }
        }
    }
    smallest.quantile(FOUND)
}

/// The smallest amplitude, m, of noise as in (5-17), an amplitude times −1, 0 or 1 in every cycle, that
/// takes a residual of zero beyond `threshold` within `horizon` cycles in [`FOUND`] of many trials; `None` if
/// none does.
pub fn noise(design: &ObserverDesign, threshold: f64, horizon: usize) -> Option<f64> {
    // The same trials every time: the result is a number, not a matter of luck.
    let mut random = ChaCha8Rng::seed_from_u64(517);
    let mut peaks: Vec<f64> = (0..TRIALS)
        .map(|_| {
            let faults: Vec<f64> =
                (0..horizon).map(|_| f64::from(random.random_range(-1_i32..=1))).collect();
            let residuals = response::respond(design, faults);
            residuals.iter().fold(0.0_f64, |peak, residual| peak.max(residual.abs()))
        })
        .collect();
    peaks.sort_unstable_by(f64::total_cmp);
    let weak = peaks[((1.0 - FOUND) * f64::from(TRIALS)) as usize];
    (weak > 0.0).then(|| threshold / weak)
}
