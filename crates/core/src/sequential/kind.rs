//! Kind, size and onset of a fault, from the residuals since.

use super::parameters::KindParameters;
use super::samples::{History, Newest};
use crate::verdict::Fault;

/// Shape of a fault in its residuals.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shape {
    pub fault: Fault,
    /// Size, m, signed: the height of a step, or the present value of a ramp; the root mean square
    /// of a noise.
    pub size: f64,
    /// Onset, cycles ago.
    pub onset: usize,
    /// Whether a sample before the onset is held, so that the beginning was seen.
    pub seen: bool,
    /// Evidence of the better of step and ramp over the other, nats.
    pub advantage: f64,
}

/// The step or the ramp that explains the residuals best, where healthy samples have this standard
/// `deviation`, m: of the newest ones, or of those in motion, which go back farther.
pub fn shape(history: &History, deviation: f64, parameters: &KindParameters) -> Shape {
    let (newest, recent) = fit(&history.all, deviation, parameters);
    let (moving, lasting) = fit(&history.moving, deviation, parameters);
    if lasting > recent {
        Shape { onset: history.cycles_of_moving(moving.onset), ..moving }
    } else {
        newest
    }
}

/// The shape, its onset in samples, and the squares that it explains, m².
fn fit<const N: usize>(
    samples: &Newest<N>,
    deviation: f64,
    parameters: &KindParameters,
) -> (Shape, f64) {
    let mut best = [(0.0, 0.0, 0); 2];
    let (mut sum, mut aged) = (0.0, 0.0);
    for (count, value) in (1..).zip(samples.iter()) {
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
        if count >= parameters.shortest_ramp && ramp > best[1].0 {
            best[1] = (ramp, along / squares * n, count);
        }
    }
    let [step, ramp] = best;
    let more = (ramp.0 - step.0) / (2.0 * deviation * deviation);
    let (fault, (_, size, onset)) = if more > parameters.ramp_advantage {
        (Fault::Incipient, ramp)
    } else {
        (Fault::Abrupt, step)
    };
    let seen = onset < samples.held();
    (Shape { fault, size, onset, seen, advantage: more.abs() }, step.0.max(ramp.0))
}

/// Appearance of some samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Appearance {
    /// Every sample differs, with no mean, and with this root mean square, m.
    Noisy(f64),
    Steady,
    Neither,
}

/// Appearance of the newest `span` samples; `None` if there are not so many.
pub fn appearance(
    history: &History,
    span: usize,
    parameters: &KindParameters,
) -> Option<Appearance> {
    if span > history.all.held() {
        return None;
    }
    let newest = || history.all.iter().take(span);
    let (sum, squares) =
        newest().fold((0.0, 0.0), |(sum, squares), it| (sum + it, squares + it * it));
    let count = span as f64;
    let (square, mean) = (squares / count, sum / count);
    if mean * mean > parameters.steady * square {
        return Some(Appearance::Steady);
    }
    let mut before = None;
    let changes = newest().map(|value| {
        let change = before.map_or(0.0, |before: f64| value - before);
        before = Some(value);
        change * change
    });
    // Of white noise this is 2 (von Neumann), of what goes up and down slowly nearly 0.
    let wildness = changes.sum::<f64>() / (count * (square - mean * mean));
    let noisy = mean * mean < parameters.noisy * square && wildness > parameters.wild;
    Some(if noisy { Appearance::Noisy(libm::sqrt(square)) } else { Appearance::Neither })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sequential::clip::Clip;
    use crate::sequential::samples::{Independence, Sample};

    const P: &KindParameters = &KindParameters::DEFAULT;

    fn history(residual: impl Fn(usize) -> f64) -> History {
        let mut history = History::holding(64);
        for k in 0..300 {
            let healthy = 5e-5 * ((k * k * 7919) % 201) as f64 / 100.0 - 5e-5;
            history.push(
                Sample::at_rest(healthy + residual(k)),
                &Clip::NONE,
                Independence::InMotion,
            );
        }
        history
    }

    #[test]
    fn a_step_and_a_ramp_are_told_apart() {
        let step = shape(&history(|k| if k < 260 { 0.0 } else { -5e-4 }), 5e-5, P);
        assert_eq!((step.fault, step.onset), (Fault::Abrupt, 40));
        assert!((step.size + 5e-4).abs() < 2e-5, "{step:?}");
        let ramp = shape(&history(|k| 4e-6 * (k as f64 - 200.0).max(0.0)), 5e-5, P);
        assert_eq!(ramp.fault, Fault::Incipient);
        assert!((ramp.size - 4e-4).abs() < 4e-5 && (80..120).contains(&ramp.onset), "{ramp:?}");
    }

    /// The residual that a drift leaves with a baseline that began with it.
    #[test]
    fn what_was_there_first_was_not_seen_to_begin() {
        for (begin, seen) in [(0, false), (1, true), (20, true)] {
            let mut history = History::holding(64);
            let fault = |k: usize| if k < begin { 0.0 } else { 3e-4 };
            (0..40).for_each(|k| {
                history.push(Sample::at_rest(fault(k)), &Clip::NONE, Independence::InMotion)
            });
            let step = shape(&history, 5e-5, P);
            assert_eq!((step.onset, step.seen), (40 - begin, seen));
        }
    }

    /// The residual of a rod that sometimes rests: two samples of three are in motion.
    #[test]
    fn an_onset_is_told_in_cycles() {
        let mut history = History::holding(64);
        for k in 0..600_usize {
            let healthy = 5e-5 * ((k * k * 7919) % 201) as f64 / 100.0 - 5e-5;
            let independence =
                if k % 3 == 0 { Independence::AtRest } else { Independence::InMotion };
            let fault = if k < 450 { 0.0 } else { 5e-4 };
            history.push(Sample::at_rest(healthy + fault), &Clip::NONE, independence);
        }
        let step = shape(&history, 5e-5, P);
        assert_eq!((step.fault, step.onset), (Fault::Abrupt, 150));
    }

    #[test]
    fn noise_has_no_mean() {
        let noisy = history(|k| if k % 2 == 0 { 4e-4 } else { -4e-4 });
        let Some(Appearance::Noisy(rms)) = appearance(&noisy, 25, P) else {
            panic!("{:?}", appearance(&noisy, 25, P))
        };
        assert!((rms - 4e-4).abs() < 2e-5, "{rms}");
        assert_eq!(appearance(&history(|_| 4e-4), 25, P), Some(Appearance::Steady));
        assert_eq!(appearance(&history(|_| 4e-4), 65, P), None);
        let wave = history(|k| 4e-4 * (k as f64 * 0.25).sin());
        assert_eq!(appearance(&wave, 50, P), Some(Appearance::Neither));
    }
}
