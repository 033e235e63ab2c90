//! Of what kind a fault is, how large and since when, from the residuals since.

use super::statistic::History;
use crate::verdict::Fault;

/// A ramp must explain this much more than a step: one sample alone fits both.
const RAMP_ADVANTAGE: f64 = 1.02;

/// Of fewer samples a ramp cannot be told.
const SHORTEST_RAMP: usize = 12;

/// The square of the mean by the mean square below which it is noise, and about no step.
const NOISY: f64 = 0.3;

/// A fault as its residuals show it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shape {
    pub fault: Fault,
    /// Of a step its height, of a ramp what it has come to, m, signed; of noise its root mean
    /// square.
    pub size: f64,
    /// Cycles ago.
    pub onset: usize,
}

/// The step or the ramp that explains the most of the samples that are held.
pub fn shape(history: &History) -> Shape {
    let span = history.moving.held();
    let mut best = [(0.0, 0.0, 0); 2];
    let (mut sum, mut aged, mut newer) = (0.0, 0.0, 0.0);
    for count in 1..=span {
        let Some([_, _, total, _]) = history.moving.over(count) else { break };
        let value = total - newer;
        newer = total;
        let n = count as f64;
        sum += value;
        aged += value * (n - 1.0);
        // Σ r·j with j = n − age, and Σ j².
        let along = n * sum - aged;
        let squares = n * (n + 1.0) * (2.0 * n + 1.0) / 6.0;
        let step = sum * sum / n;
        let ramp = along * along / squares;
        if step > best[0].0 {
            best[0] = (step, sum / n, count);
        }
        if count >= SHORTEST_RAMP && ramp > best[1].0 {
            best[1] = (ramp, along / squares * n, count);
        }
    }
    let [step, ramp] = best;
    let (fault, (_, size, onset)) = if ramp.0 > RAMP_ADVANTAGE * step.0 {
        (Fault::Incipient, ramp)
    } else {
        (Fault::Abrupt, step)
    };
    Shape { fault, size, onset }
}

/// Whether the newest `span` samples are noise about no mean; then their root mean square, m.
pub fn noise(history: &History, span: usize) -> Option<f64> {
    let [_, _, sum, squares] = history.all.over(span)?;
    let (square, mean) = (squares / span as f64, sum / span as f64);
    (mean * mean < NOISY * square).then(|| square.sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sequential::clip::Clip;

    fn history(residual: impl Fn(usize) -> f64) -> History {
        let clip = Clip { farthest: 5e-4, square: 36.0 };
        let mut history = History::default();
        for k in 0..300 {
            let healthy = 5e-5 * ((k * k * 7919) % 201) as f64 / 100.0 - 5e-5;
            history.push(healthy + residual(k), 1e-4, &clip, true);
        }
        history
    }

    #[test]
    fn a_step_and_a_ramp_are_told_apart() {
        let step = shape(&history(|k| if k < 260 { 0.0 } else { -5e-4 }));
        assert_eq!((step.fault, step.onset), (Fault::Abrupt, 40));
        assert!((step.size + 5e-4).abs() < 2e-5, "{step:?}");
        let ramp = shape(&history(|k| 4e-6 * (k as f64 - 200.0).max(0.0)));
        assert_eq!(ramp.fault, Fault::Incipient);
        assert!((ramp.size - 4e-4).abs() < 4e-5 && (80..120).contains(&ramp.onset), "{ramp:?}");
    }

    #[test]
    fn noise_has_no_mean() {
        let noisy = history(|k| if k % 2 == 0 { 4e-4 } else { -4e-4 });
        assert!(noise(&noisy, 25).is_some_and(|rms| (rms - 4e-4).abs() < 2e-5));
        assert_eq!(noise(&history(|_| 4e-4), 25), None);
    }
}
