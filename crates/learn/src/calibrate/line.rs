//! A line through points, a few of which are wrong.

use crate::order_statistics::ranked;

/// Deviations beyond which an error loses weight (Huber 1964): 95 % as efficient as least squares
/// where all errors are normal.
const HUBER: f64 = 1.345;

/// Median magnitude of a normal distribution, as a part of its standard deviation.
const NORMAL_MEDIAN: f64 = 0.674_489_75;

const ROUNDS: u32 = 100;

/// The line y = gain·x + offset.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    pub gain: f64,
    pub offset: f64,
}

/// A line and the distance of points from it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Robust {
    pub line: Line,
    /// Standard deviation of the points that are not wrong, from the median of all magnitudes.
    pub deviation: f64,
}

impl Line {
    pub fn error(&self, x: f64, y: f64) -> f64 {
        y - (self.gain * x + self.offset)
    }

    /// The least squares of weighted points; `None` where they have no width.
    fn fit(points: &[(f64, f64)], weights: impl Fn(usize) -> f64) -> Option<Self> {
        let (mut total, mut x0, mut y0) = (0.0, 0.0, 0.0);
        for (i, (x, y)) in points.iter().enumerate() {
            let weight = weights(i);
            total += weight;
            x0 += weight * (x - x0) / total;
            y0 += weight * (y - y0) / total;
        }
        let (mut xx, mut xy) = (0.0, 0.0);
        for (i, (x, y)) in points.iter().enumerate() {
            xx += weights(i) * (x - x0) * (x - x0);
            xy += weights(i) * (x - x0) * (y - y0);
        }
        let gain = xy / xx;
        (xx > 0.0 && gain.is_finite()).then_some(Self { gain, offset: y0 - gain * x0 })
    }
}

impl Robust {
    /// The line through `points` (x, y) by Huber's weights, iterated until they converge; `None`
    /// where the points have no width. Where points on a lattice lie mostly on the line itself,
    /// their median magnitude says nothing, so the deviation is at least `least`.
    pub fn fit(points: &[(f64, f64)], least: f64) -> Option<Self> {
        let mut line = Line::fit(points, |_| 1.0)?;
        let mut deviation = deviation(points, line).max(least);
        for _ in 0..ROUNDS {
            let limit = HUBER * deviation;
            let weights: Vec<f64> = points
                .iter()
                .map(|(x, y)| {
                    let error = line.error(*x, *y).abs();
                    if error <= limit { 1.0 } else { limit / error }
                })
                .collect();
            let next = Line::fit(points, |i| weights[i]).unwrap_or(line);
            let change = (next.gain - line.gain).abs() + (next.offset - line.offset).abs();
            line = next;
            deviation = self::deviation(points, line).max(least);
            if change < 1e-13 {
                break;
            }
        }
        Some(Self { line, deviation })
    }
}

fn deviation(points: &[(f64, f64)], line: Line) -> f64 {
    let mut errors: Vec<f64> = points.iter().map(|(x, y)| line.error(*x, *y).abs()).collect();
    ranked(&mut errors, 0.5, f64::total_cmp).unwrap_or(0.0) / NORMAL_MEDIAN
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Noise of ±0.2 mm with no common divisor.
    fn points(outlier: f64) -> Vec<(f64, f64)> {
        let noise = |k: u32| 2e-4 * (f64::from(k) * 12.9898).sin();
        let x = |k: u32| (f64::from(k) * 0.01).sin();
        let fault = |k: u32| if k.is_multiple_of(50) { outlier } else { 0.0 };
        (0..5000).map(|k| (x(k), 1.002 * x(k) - 3e-3 + noise(k) + fault(k))).collect()
    }

    #[test]
    fn a_few_wrong_points_hardly_move_the_line() {
        for outlier in [0.0, 0.05, -0.05, 1.0] {
            let Robust { line, deviation } =
                Robust::fit(&points(outlier), 0.0).expect("it has width");
            assert!((line.gain - 1.002).abs() < 2e-5, "{outlier}: {line:?}");
            assert!((line.offset + 3e-3).abs() < 1e-5, "{outlier}: {line:?}");
            assert!((1.5e-4..2.5e-4).contains(&deviation), "{outlier}: {deviation}");
        }
    }

    #[test]
    fn points_of_one_place_have_no_line() {
        assert_eq!(Robust::fit(&[(1.0, 2.0), (1.0, 3.0), (1.0, 4.0)], 0.0), None);
    }
}
