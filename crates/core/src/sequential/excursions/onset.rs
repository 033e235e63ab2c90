//! Where C1 − C2 left its healthy level.
//!
//! An alarm is raised when a displacement has outlasted healthy excursions, up to a second after its onset. Only the onset shows which
//! transducer is faulty: there one of the readings departs from the course that commands and earlier readings predict.

use crate::sequential::parameters::OnsetParameters;
use crate::sequential::samples::NEWEST;

/// How the displacement began.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Beginning {
    Step,
    Ramp,
}

/// Begin of a displacement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Onset {
    /// Samples ago; 1 is the newest one.
    pub ago: usize,
    /// Displacement, m, signed.
    pub size: f64,
    pub beginning: Beginning,
}

/// A window of an alarm in the residuals.
#[derive(Clone, Copy, Debug)]
pub struct AlarmWindow {
    /// Samples of the window.
    pub width: usize,
    /// Samples since the alarm.
    pub age: usize,
    /// Longest excursion, samples.
    pub longest: usize,
    /// Standard deviation of the residuals outside of excursions, m.
    pub deviation: f64,
    /// s.
    pub sample_time: f64,
    /// Slowest ramp that can be located, m/s.
    pub followed: f64,
}

/// The onset of the displacement of an alarm in the `newest` residuals, newest first, m; `None` where it is not to be seen, is hidden by
/// another excursion, or a step has no edge and a ramp is too slow.
pub fn find(newest: &[f64], window: &AlarmWindow, p: &OnsetParameters) -> Option<Onset> {
    let AlarmWindow { width, age, deviation, .. } = *window;
    let size = size(newest, window, p)?;
    if size.abs() < p.least {
        return None;
    }
    let earliest = (age + width + p.before).min(newest.len());
    let step = step(&newest[..earliest], size, deviation, p)?;
    let ramp =
        if size.abs() >= p.large * deviation { ramp(newest, step, size, window, p) } else { None };
    let onset = match ramp {
        Some(Ramp { slow: true, .. }) => return None,
        Some(Ramp { ago, .. }) => Onset { ago, size, beginning: Beginning::Ramp },
        None if has_edge(newest, step, size, p) => {
            Onset { ago: step, size, beginning: Beginning::Step }
        }
        None => return None,
    };
    (!is_beside_another(newest, &onset, window, p)).then_some(onset)
}

/// Median of the samples that the displacement is read from, m.
fn size(newest: &[f64], window: &AlarmWindow, p: &OnsetParameters) -> Option<f64> {
    let [least, most] = p.sized;
    let count = (window.width / 2 + 1).clamp(least, most);
    let last = window.age.saturating_sub(p.after);
    let read = newest.get(last..last + count)?;
    let mut sorted = [0.0; NEWEST];
    let sorted = sorted.get_mut(..count)?;
    sorted.copy_from_slice(read);
    sorted.sort_unstable_by(f64::total_cmp);
    Some(0.5 * (sorted[(count - 1) / 2] + sorted[count / 2]))
}

/// The onset of a step of this `size`, m, that explains all samples since best, in samples ago; `None` where that is the oldest one.
fn step(newest: &[f64], size: f64, deviation: f64, p: &OnsetParameters) -> Option<usize> {
    let (mut best, mut ago, mut sum) = (0.0, None, 0.0);
    for (count, residual) in (1..).zip(newest) {
        sum += displaced(*residual, size, deviation, p);
        if sum > best {
            (best, ago) = (sum, Some(count));
        }
    }
    ago.filter(|ago| *ago < newest.len())
}

/// How much more likely a `size` makes a residual than none, nats, where residuals have this `deviation`, m.
pub fn displaced(residual: f64, size: f64, deviation: f64, p: &OnsetParameters) -> f64 {
    let freedom = p.sought_freedom;
    student(residual - size, deviation, freedom) - student(residual, deviation, freedom)
}

struct Ramp {
    ago: usize,
    slow: bool,
}

/// Whether the residual rose to the displacement instead of stepping to it: from the departure, the last two samples at the healthy
/// level, it does not fall, and is below half of the size at first.
fn ramp(
    newest: &[f64],
    step: usize,
    size: f64,
    window: &AlarmWindow,
    p: &OnsetParameters,
) -> Option<Ramp> {
    let healthy = |at: usize| newest[at].abs() < p.departed * window.deviation;
    let from = step.min(newest.len());
    let quiet = (from.saturating_sub(1)..newest.len().saturating_sub(1))
        .find(|at| healthy(*at) && healthy(at + 1))?;
    // Samples are counted from 1, and the quiet ones are before the departure.
    let departure = quiet;
    if departure <= from {
        return None;
    }
    let along = |at: usize| newest[at] * size.signum();
    let mut highest = f64::NEG_INFINITY;
    for at in (from - 1..departure).rev() {
        if along(at) < highest - p.fallen * window.deviation {
            return None;
        }
        highest = highest.max(along(at));
    }
    let mut first = [along(departure - 1), along(departure - 2), along(departure.max(3) - 3)];
    first.sort_unstable_by(f64::total_cmp);
    if first[1] >= p.begun * size.abs() {
        return None;
    }
    let speed = along(from - 1) / ((departure - from + 1) as f64 * window.sample_time);
    Some(Ramp { ago: departure, slow: speed < window.followed })
}

/// Whether another excursion may hide the onset. One beside it has edges of its own. One that ended before may have ended the sooner for
/// a fault of the other direction and of about its size, which then shows only when the excursion really ends.
fn is_beside_another(
    newest: &[f64],
    onset: &Onset,
    window: &AlarmWindow,
    p: &OnsetParameters,
) -> bool {
    let AlarmWindow { longest, deviation, .. } = *window;
    let from = (onset.ago + 1).min(newest.len());
    let to = (from + longest + 5).min(newest.len());
    let far = |residual: f64| residual.abs() > p.another * deviation;
    newest[from..to].windows(2).enumerate().any(|(distance, pair)| {
        let sum = onset.size + 0.5 * (pair[0] + pair[1]);
        far(pair[0]) && far(pair[1]) && (distance <= p.around || sum.abs() < p.departed * deviation)
    })
}

/// Whether the samples after the onset are elsewhere than those before it; the one beside it belongs to neither.
fn has_edge(newest: &[f64], ago: usize, size: f64, p: &OnsetParameters) -> bool {
    let mean = |samples: &[f64]| samples.iter().sum::<f64>() / samples.len().max(1) as f64;
    let after = &newest[ago.saturating_sub(3)..ago];
    let from = (ago + 1).min(newest.len());
    let before = &newest[from..(from + 3).min(newest.len())];
    !before.is_empty() && (mean(after) - mean(before)) * size.signum() > p.edge * size.abs()
}

/// The log-density of Student's t with `freedom` degrees of freedom and this `scale`, but for a constant.
pub fn student(error: f64, scale: f64, freedom: f64) -> f64 {
    let x = error / scale;
    -0.5 * (freedom + 1.0) * libm::log1p(x * x / freedom)
}

#[cfg(test)]
mod tests {
    use super::*;

    const P: &OnsetParameters = &OnsetParameters::DEFAULT;
    const DEVIATION: f64 = 8e-5;

    fn window(width: usize, age: usize) -> AlarmWindow {
        let (longest, deviation, sample_time, followed) = (11, DEVIATION, 0.02, 5e-3);
        AlarmWindow { width, age, longest, deviation, sample_time, followed }
    }

    /// Residuals, newest first, of `fault` by the sample's number, of 128.
    fn newest(fault: impl Fn(usize) -> f64) -> Vec<f64> {
        let one = |k: usize| 6e-5 * (((k * k * 7919) % 201) as f64 / 100.0 - 1.0) + fault(k);
        (0..128).rev().map(one).collect()
    }

    #[test]
    fn a_step_began_where_it_left_the_healthy_level() {
        for (size, width, age) in [(5e-4, 28, 0), (-7.5e-4, 12, 3), (1.25e-3, 4, 8)] {
            let begun = 128 - width - age;
            let found =
                find(&newest(|k| if k >= begun { size } else { 0.0 }), &window(width, age), P);
            let onset = found.expect("it has an edge");
            assert_eq!((onset.ago, onset.beginning), (width + age, Beginning::Step));
            assert!((onset.size - size).abs() < 5e-5, "{onset:?}");
        }
    }

    #[test]
    fn what_another_excursion_hides_has_no_onset() {
        let with = |size: f64, excursion: std::ops::Range<usize>| {
            let fault = move |k: usize| match k {
                100.. => size,
                _ if excursion.contains(&k) => -4.4e-4,
                _ => 0.0,
            };
            find(&newest(fault), &window(28, 0), P)
        };
        // It ends just before; or ended as a fault of its own size began, which shows when it really ends.
        assert_eq!(with(1e-3, 90..98), None);
        assert_eq!(with(5e-4, 84..94), None);
        // A fault of another size would have shown between them.
        assert!(with(1e-3, 84..94).is_some() && with(-5e-4, 84..94).is_some());
        assert!(with(5e-4, 60..70).is_some());
    }

    #[test]
    fn a_fast_ramp_begins_where_it_departs_and_a_slow_one_has_no_onset() {
        let ramp = |speed: f64| move |k: usize| speed * 0.02 * (k as f64 - 90.0).max(0.0);
        let fast = find(&newest(ramp(0.03)), &window(20, 0), P).expect("it is fast");
        assert_eq!(fast.beginning, Beginning::Ramp);
        assert!((36..=39).contains(&fast.ago), "{fast:?}");
        assert_eq!(find(&newest(ramp(0.001)), &window(20, 0), P), None);
    }

    /// Too small for its rise to be seen, it is no step either.
    #[test]
    fn a_small_rise_without_an_edge_has_no_onset() {
        let rise = |k: usize| 1.6e-5 * (k as f64 - 90.0).max(0.0);
        let window = window(20, 0);
        assert!(size(&newest(rise), &window, P).is_some_and(|it| (P.least..6e-4).contains(&it)));
        assert_eq!(find(&newest(rise), &window, P), None);
    }

    #[test]
    fn what_is_small_or_was_there_from_the_beginning_has_no_onset() {
        assert_eq!(find(&newest(|_| 5e-4), &window(100, 0), P), None);
        assert_eq!(find(&newest(|k| if k > 60 { 1e-4 } else { 0.0 }), &window(60, 0), P), None);
        assert_eq!(find(&[], &window(4, 0), P), None);
        assert_eq!(find(&[1e-3], &window(4, 0), P), None);
    }
}
